//! Touch (Sec. 5): what runs at the device's rate, between a tracked hand and a slower simulation.
//!
//! Pure like the rest of this crate: time, samples and the newest simulation frame are arguments,
//! forces are results. Threads, clocks and devices belong to the program around it.

mod coupling;
mod display;
mod exchange;
mod extrapolate;
mod hand;
mod pads;
mod proxies;
mod rigid_state;
pub mod safety;
pub mod shared;
mod stability;
pub mod virtual_user;

pub use coupling::{CouplingDesign, series_stiffness};
pub use display::{
    CYBERGRASP_FORCE_MAX, PAD_NORMAL_B, StopLatch, brake_force, pad_force, servo_stop, tendon_pull,
};
pub use exchange::{FastToSlow, SlowToFast};
pub use extrapolate::{Prediction, Sample, Track, Tracked, hold_then_fade, seconds_between};
pub use hand::{HandReport, HandSettings, HapticHand, Mode};
pub use pads::{Pad, PadReading};
pub use proxies::{Proxies, Proxy, ProxyError, ProxyReport};
pub use rigid_state::RigidState;
pub use stability::{CouplingRule, CouplingWarning, LoopProfile};
