//! What can be wrong with a motion.

use super::recording::RecordingError;
use std::path::PathBuf;
use thenar::kinematics::TreeError;

/// Why a motion cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum MotionError {
    /// The text of a motion file is not as expected.
    #[error("{file}: {cause}", file = file.display())]
    Syntax {
        /// File that was read.
        file: PathBuf,
        /// What is wrong, with line and column.
        cause: toml::de::Error,
    },
    /// A file cannot be read.
    #[error("{file}: {cause}", file = file.display())]
    Read {
        /// File that was read.
        file: PathBuf,
        /// Error of the system.
        cause: std::io::Error,
    },
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
    /// The recording itself is wrong.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A key of a keyframed motion is wrong.
    #[error("key {number} (time {time} s): {cause}")]
    Key {
        /// Counted from 1.
        number: usize,
        /// Time of the key \[s\].
        time: f64,
        /// Cause in words.
        cause: String,
    },
    /// There is nothing to interpolate.
    #[error("a motion needs at least one key")]
    NoKeys,
}
