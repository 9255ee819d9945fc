//! The outside of touch: trackers that tell where a hand is, and force displays that let it feel.
//!
//! A device is a [`Protocol`] over a [`Transport`]. The protocol is pure: bytes in, poses out;
//! forces in, bytes out; time is an argument. The transport moves bytes and knows nothing of what
//! they mean. Whatever a device sends, garbage included, only ever becomes poses, notes or nothing.
//!
//! Programs see neither, but [`Tracker`] and [`ForceDisplay`], which a [`Driver`] finds and opens.
//! Both only exchange newest values with the device's own thread, so that the haptic loop calls
//! them in every tick without waiting.
//!
//! Frames are those of WebXR: metres, +y up; along a bone -z away from the wrist, +y out of the
//! back of the hand. Times are nanoseconds of one monotonic clock of this process.

pub mod bhaptics;
pub mod calibration;
pub mod cyberglove;
pub mod cybergrasp;
mod driver;
mod error;
pub mod failover;
pub mod fault;
pub mod force_device;
pub mod hand_tracking_streamer;
pub mod joints;
pub mod keeper;
pub mod latency;
mod lines;
pub mod lucidgloves;
mod nesting;
pub mod null;
#[cfg(feature = "openxr")]
pub mod openxr;
mod options;
mod paired;
pub mod pose_stream;
pub mod profile;
mod protocol;
mod rate;
mod registry;
pub mod replay;
#[cfg(test)]
mod testing;
pub mod transport;
pub mod twin;
pub mod wearer;
pub mod worker;

pub use driver::{Driver, FoundDevice, Opened};
pub use error::LinkError;
pub use protocol::{Event, Protocol, Transport};
pub use registry::{drivers, open};
pub use thenar_touch::{
    DIGITS, DigitOutput, ForceDisplay, HandOutput, MessageSource, Presence, PresenceCheck,
    Rendering, Tracker, haptic_loop, now_ns, realtime,
};
pub use thenar_track::{HandSample, source_clock};
pub use worker::release_all;
