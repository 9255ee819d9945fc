//! Why a recording cannot be replayed any further.

use crate::SceneError;
use std::io;
use std::path::PathBuf;
use thenar_record::OpenError;

/// Why a recording cannot be replayed any further.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The recording cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// Reading fails.
    #[error("cannot read the recording: {0}")]
    Read(#[from] io::Error),
    /// The scene cannot be built.
    #[error("the recorded scene cannot be built: {0}")]
    Scene(#[from] SceneError),
    /// The scene's files cannot be unpacked.
    #[error("cannot unpack the scene's files: {0}")]
    Asset(io::Error),
    /// A file was too large for the recording, and is gone or different.
    #[error("the recording needs {}, which is missing or has changed", .0.display())]
    NotThere(PathBuf),
    /// A replay was to begin where there is nothing any more.
    #[error("nothing is left to replay from {from} s on: the recording ends at {:.3} s", (.end * 1e3).floor() * 1e-3)]
    Beyond {
        /// Beginning that was asked for \[s\].
        from: String,
        /// End of the recording \[s\].
        end: f64,
    },
    /// A frame is whole, but not understood.
    #[error("the frame before byte {offset} is invalid: {what}")]
    Content {
        /// Offset of the frame's end \[bytes\].
        offset: u64,
        /// Thing that is missing.
        what: &'static str,
    },
}
