//! A hand moved by poses that arrive while the simulation runs.
//!
//! A pose is, in turn:
//!
//! 1. *checked*: what is not finite, no unit quaternion or too far away is refused;
//! 2. *carried over* to our hand: wrist pose and joint angles within their limits (see
//!    [`Retarget`](crate::Retarget)). The tracker's wrist frame is calibrated on the first good
//!    pose, then refined over the first 90, by a fifth of a degree per pose at most. Rotations are
//!    carried over and the wrist's place is; fingers of another length end elsewhere, so that a
//!    hand should be built as long as its wearer's: see [`LiveHand::length`];
//! 3. *observed*: a critically damped g-h filter gives place and velocity, without lag in steady
//!    motion, from samples rounded to a millimetre and to a thousandth of a quaternion;
//! 4. *carried forward* from the time of the pose to the end of the step, 25 ms at most;
//! 5. *followed*: a critically damped follower makes place and velocity continuous, never faster
//!    than [`SPEED_MAX`], [`SPIN_MAX`] and [`JOINT_RATE_MAX`]. Whenever it must go to another
//!    place (script to live, live to script, back after a loss, a teleport) its speed starts at
//!    zero and opens within [`OPENING`].
//!
//! Time is the simulation's: in slow motion the speed limits are limits of slow motion. The
//! client's clock only tells how far apart poses are. A pose older than [`STALE`] counts as lost:
//! the hand holds still. The same calls give the same bits. Nothing is allocated once a hand is
//! made.

mod check;
mod clock;
mod follower;
mod hand;
mod kinematic_state;
mod memory;
mod noise;
mod observer;
mod outlier_gate;

#[cfg(test)]
mod tests;

pub use check::{LiveError, RADIUS_MAX, REACH, checked};
pub use follower::{Law, follow};
pub use hand::LiveHand;
pub use memory::{LiveMemory, LiveMemoryRef};
pub use noise::FeltSpring;

use crate::ANGLES;
use crate::Observation;
use thenar_core::Pose;

/// Fastest wrist \[m/s\].
pub const SPEED_MAX: f64 = 4.0;
/// Fastest turn of the wrist \[rad/s\].
pub const SPIN_MAX: f64 = 20.0;
/// Fastest joint \[rad/s\].
pub const JOINT_RATE_MAX: f64 = 26.0;
/// Time in which the speed opens up on the way to another place \[s\]. Half of it takes the hand
/// 0.13 m far, all of it 1.1 m.
pub const OPENING: f64 = 0.8;
/// Older poses count as lost \[s\].
pub const STALE: f64 = 0.1;

/// Delay that a hand that follows at 80 Hz adds to its tracker's, measured for 60 Hz to 1 kHz and 0
/// to 50 ms: 9.9 ms at 1 kHz at once, 6.0 ms at 90 Hz at once, 5.9 and 2.2 ms at 1 kHz and 90 Hz,
/// 20 ms late, nothing at 50 ms. With noise that is remembered for 50 ms, 36 ms at 60 Hz to 43 ms
/// at 1 kHz, however late.
pub const OBSERVATION: Observation = Observation { adds: 0.01, makes_up: 0.2, noisy: 0.039 };

/// A tracked hand at an instant, in the world.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[allow(clippy::large_enum_variant)] // one at a time, by reference: a box would cost more
pub enum LivePose {
    /// The joints of WebXR Hand Input, in the order of
    /// [`TRACKED_JOINTS`](crate::TRACKED_JOINTS).
    Joints {
        /// Frames: -z along the bone away from the wrist, +y out of the back of the hand.
        joints: [Pose; 25],
        /// Radii \[m\].
        radii: [f64; 25],
    },
    /// The wrist's frame (same axes) and joint angles.
    Angles {
        /// Pose of the wrist frame, world.
        wrist: Pose,
        /// In the order of [`hand_angles`](crate::hand_angles) \[rad\]; what is out of
        /// range is brought to its end. Angles that the hand lacks are ignored.
        angles: [f64; ANGLES],
    },
}

impl LivePose {
    /// A flat hand: all angles zero, and the wrist's frame there in the world.
    pub fn flat(wrist: Pose) -> Self {
        Self::Angles { wrist, angles: [0.0; ANGLES] }
    }
}

/// Source of a hand's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mover {
    /// The scene.
    Script,
    /// Poses given live.
    Live,
    /// Poses were given live, and none comes any more: the hand holds still.
    Lost,
}
