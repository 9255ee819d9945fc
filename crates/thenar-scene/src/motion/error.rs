//! Errors of motions.

use std::path::PathBuf;
use thenar_track::{FitError, RecordingError};

/// Why a motion cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum MotionError {
    /// The text of a motion file is not as expected.
    #[error("{file}: {cause}", file = file.display())]
    Syntax {
        /// File that was read.
        file: PathBuf,
        /// Error of the parser, with line and column.
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
    /// The hand cannot be moved so.
    #[error(transparent)]
    Fit(#[from] FitError),
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
    /// The motion has no keys to interpolate.
    #[error("a motion needs at least one key")]
    NoKeys,
}
