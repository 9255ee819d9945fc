//! Touch (Sec. 5): what runs at the device's rate, between a tracked hand and a slower simulation.
//!
//! Whoever audits what pushes on a person reads this crate. It knows no scene and no device:
//! trackers and displays are traits ([`Tracker`], [`ForceDisplay`]), and so is the simulation
//! ([`haptic_loop::Simulation`]). Two floors:
//!
//! - pure below: couplings, proxies, contact on frames ([`shared`]), delays, [`safety`]. Time,
//!   samples and the newest simulation frame are arguments, forces are results;
//! - above, in [`haptic_loop`]: the thread that ticks, its watchdog and its monitor.
//!
//! A hand's samples become poses in `thenar-track`; bytes leave for devices in `thenar-link`,
//! behind one more check.
//!
//! Three words: the **hand** is what is tracked, the **bones** are what is simulated, and between
//! the two each bone has a **proxy**, held by the device coupling and by the bone coupling.
//!
//! ```
//! use thenar_touch::safety::{Guard, Limits, Signal};
//! use thenar_touch::{
//!     BoneFrame, CouplingDesign, HandSettings, HapticHand, Pad, ProxyTargets, RigidState, Touch,
//! };
//! use thenar_core::model::Digit;
//! use thenar_core::{Mat3, Pose, Vec3};
//!
//! // Build: one bone here; `CouplingDesign::hand` and `Pad::of_hand` do it for a hand model.
//! let start = [RigidState::at_rest(Pose::identity())];
//! let proxy = CouplingDesign::default().proxy(0.004, &Mat3::from_diagonal_element(1e-7));
//! let mut hand = HapticHand::new(HandSettings::default(), vec![proxy], &start, 0)?;
//! let mut pad = Pad::new(Digit::Index, 0, Vec3::z() * -0.01);
//! let mut guard = Guard::<1>::new(Limits::cybergrasp(), 4000)?;
//! guard.arm();
//! let (mut frame, mut back) = (BoneFrame::new(&start, 0), ProxyTargets::new(&start));
//!
//! let mut force = [0.0];
//! for ms in 1..=3000u64 {
//!     let now_ns = ms * 1_000_000;
//!     // The finger closes by 4 mm; its simulated bone stays where it is, blocked.
//!     let down = 0.004 * (ms as f64 / 2000.0).min(1.0);
//!     hand.lead(0, RigidState::at_rest(Pose::translation(0.0, -down, 0.0)));
//!     frame.time_ns = now_ns;                      // from the simulation's slot
//!     let report = hand.tick(now_ns, &frame);
//!     hand.write_targets(now_ns, &mut back);       // to the simulation's slot
//!     let reading = pad.read(&hand, report.step);
//!     force = guard.tick(now_ns, &Signal {
//!         force: [reading.pad_force],
//!         velocity: [reading.opening_velocity],
//!         simulation_ns: frame.time_ns,
//!         tracking_ns: now_ns,
//!         device_ns: now_ns,
//!         enabled: true,
//!     });                                          // to the device
//! }
//! assert!((force[0] - 400.0 * 0.004).abs() < 0.01, "two springs of 800 N/m, one after the other");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`SingleRate`], where the whole simulation steps within the haptic tick, needs no proxies: the
//! tracked poses are the targets of the bones' drives, and `drive_reaction` is the force on the
//! wearer. Both it and [`HapticHand`] are [`Touch`], which is all that the loop around must know.

mod arcs;
mod clock;
mod coupling;
mod delay;
mod device;
mod display;
mod empty_air;
mod felt;
mod hand;
pub mod haptic_loop;
mod lanes;
mod late_frames;
mod led_hand;
mod output;
mod pads;
mod prediction;
mod proxies;
#[cfg(test)]
mod proxies_tests;
mod proxy_targets;
pub mod realtime;
pub mod safety;
pub mod shared;
mod single_rate;
mod smooth;
mod stability;
mod touch;
mod turn;
pub mod virtual_user;
mod ways_out;

pub use arcs::BoneJoint;
pub use clock::now_ns;
pub use coupling::{CouplingDesign, drive_reaction, series_stiffness};
pub use delay::{DelayMeter, GRIP, MARGIN};
pub use device::{ForceDisplay, MessageSource, Presence, PresenceCheck, Tracker};
pub use display::{
    CYBERGRASP_FORCE_MAX, PAD_NORMAL_B, StopLatch, brake_force, pad_force, servo_stop, tendon_pull,
};
pub use empty_air::EmptyAirHand;
pub use felt::{FeltBounds, FeltStiffness};
pub use hand::{HandSettings, HapticHand, ProxyMode, TickReport};
pub use led_hand::LedHand;
pub use output::{DIGITS, DigitOutput, HandOutput, Rendering};
pub use pads::{Pad, PadReading};
pub use prediction::{Prediction, hold_then_fade, seconds_between};
pub use proxies::{Proxies, Proxy, ProxyError, ProxyReport};
pub use proxy_targets::ProxyTargets;
pub use single_rate::{SingleRate, SingleRateSettings, series_drive};
pub use smooth::BLEND;
pub use stability::{CouplingRule, CouplingWarning, LoopProfile};
pub use thenar_core::condensed::{BoneFrame, RigidState};
pub use thenar_track::{HandSample, Observation, TrackerTiming};
pub use touch::Touch;
pub use ways_out::lock_soon;
