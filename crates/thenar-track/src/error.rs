//! Errors that keep a tracked hand from moving ours.

use thenar_core::kinematics::TreeError;

/// Why a hand cannot be moved by what was tracked.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// The hand is no tree of bones.
    #[error("hand `{hand}`: {cause}")]
    Tree {
        /// Name of the hand.
        hand: String,
        /// Fault of its tree of bones.
        cause: TreeError,
    },
    /// The hand has no bones.
    #[error("hand `{hand}` has no bones")]
    NoBones {
        /// Name of the hand.
        hand: String,
    },
    /// The root bone has no tracked wrist.
    #[error("hand `{hand}`: its root bone must name the tracked joint `wrist`")]
    NoWrist {
        /// Name of the hand.
        hand: String,
    },
    /// The recording does not hold the hand asked for.
    #[error("the recording holds no {side} hand")]
    NoHand {
        /// Side that is asked for.
        side: &'static str,
    },
    /// A setting of a recorded motion is out of range.
    #[error("{key} must be {expected}, got {value}")]
    Setting {
        /// Key of the value.
        key: &'static str,
        /// Range that is allowed.
        expected: &'static str,
        /// Value that was given.
        value: f64,
    },
}
