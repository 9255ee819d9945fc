//! Tracked hands: from what a tracker says to where the bones of a simulated hand go.
//!
//! Two ways lead there, and both carry joints over to our hand in the same manner ([`Retarget`]):
//!
//! - [`live`]: poses that arrive while a simulation runs are checked, observed, carried forward and
//!   followed. This is the one place where a tracked hand's velocity is estimated, where it is
//!   predicted, and where jumps are answered;
//! - [`Recorded`]: a recording of a tracked hand becomes a motion, a function of time alone.
//!
//! Nothing here knows scenes, rigs, devices or forces. No clock is read, and nothing is allocated
//! once a hand is made.

mod anatomy;
mod angles;
mod articulation;
mod calibration;
mod error;
mod filter;
pub mod live;
mod meeting;
mod muscles;
pub mod reach;
mod recorded;
mod recording;
mod retarget;
mod sample;
pub mod source_clock;
mod timing;
pub mod tracker_clock;

#[cfg(test)]
mod fixture;
#[cfg(test)]
mod tracker;

pub use anatomy::{Anatomy, JointRole};
pub use angles::{ANGLES, AngleRange, hand_angles};
pub use articulation::Articulation;
pub use calibration::{BoneLengths, Knuckles};
pub use error::FitError;
pub use muscles::Muscles;
pub use recorded::{Recorded, RecordedDesc, Tracking};
pub use recording::{
    LINE_BYTES_MAX, RECORDING_BYTES_MAX, Recording, RecordingError, TRACKED_JOINTS, TrackedSample,
    mirrored,
};
pub use retarget::{Retarget, size_ratio};
pub use sample::HandSample;
pub use timing::{Observation, TrackerTiming};
