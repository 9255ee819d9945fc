//! Motions of a hand: keyframes that a person writes, and recordings of tracked hands.
//!
//! Both give, at any time, a pose and a velocity for every bone of a hand: smooth, within joint
//! limits (but for a fist, which is squeezed), always finite, and consistent (the velocity is the
//! derivative of the pose). Nothing here reads a clock or allocates once a motion is made.

mod error;
mod fist;
mod interpolate;
mod keyframes;
mod preset;
mod shapes;

#[cfg(test)]
#[allow(dead_code)] // the tests of tracking use all of it
#[path = "../../../thenar-track/src/fixture.rs"]
pub(crate) mod fixture;

pub use error::MotionError;
pub use keyframes::{JointKey, Key, Keyframes, KeyframesDesc, LimitPolicy, WristKey};
pub use preset::Preset;
pub use shapes::Shapes;
pub use thenar_track::{
    ANGLES, Anatomy, AngleRange, Articulation, BoneLengths, FitError, JointRole, Knuckles,
    LINE_BYTES_MAX, RECORDING_BYTES_MAX, Recorded, RecordedDesc, Recording, RecordingError,
    Retarget, TRACKED_JOINTS, TrackedSample, Tracking, hand_angles, mirrored, size_ratio,
};

use thenar_core::Pose;
use thenar_core::world::Target;

/// A motion made ready for one hand.
#[derive(Clone, Debug)]
pub enum HandMotion {
    /// Written by hand.
    Keyframes(Box<Keyframes>),
    /// Recorded from a tracked hand.
    Recorded(Box<Recorded>),
}

impl HandMotion {
    /// Targets of all bones at `time` \[s\] from the motion's start; before the start and after
    /// the end the hand is still. Entries of `out` beyond the hand's bones are left alone.
    pub fn sample(&mut self, time: f64, out: &mut [Option<Target>]) {
        match self {
            Self::Keyframes(motion) => motion.sample(time, out),
            Self::Recorded(motion) => motion.sample(time, out),
        }
    }

    /// Time of the last change \[s\].
    pub fn duration(&self) -> f64 {
        match self {
            Self::Keyframes(motion) => motion.duration(),
            Self::Recorded(motion) => motion.duration(),
        }
    }

    /// Returns the pose `pose_WM` of the model frame of the hand at rest that puts its wrist where
    /// the motion starts.
    pub fn start_placement(&self) -> Pose {
        match self {
            Self::Keyframes(motion) => motion.start_placement(),
            Self::Recorded(motion) => motion.start_placement(),
        }
    }
}
