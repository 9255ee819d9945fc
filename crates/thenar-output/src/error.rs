//! Why an output cannot be written.

use std::io;
use std::path::{Path, PathBuf};

/// An output that cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {cause}", file.display())]
pub struct OutputError {
    /// Name of the file, as given.
    pub file: PathBuf,
    /// Cause of the failure.
    pub cause: Cause,
}

/// Why an output cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum Cause {
    /// The path ends in a separator, or in nothing.
    #[error("this is not the name of a file")]
    NoName,
    /// A folder has this name.
    #[error("it is a folder")]
    Folder,
    /// The target is neither file, pipe nor character device.
    #[error("it is a {0}")]
    Refused(&'static str),
    /// The target is an input, and would be lost.
    #[error("it is an input of this command; give the output another name")]
    Input,
    /// The later of two outputs would replace the earlier.
    #[error("two outputs of this command have this name")]
    Twice,
    /// A named pipe has no other end.
    #[error("nobody reads from this pipe")]
    NoReader,
    /// The system refuses.
    #[error("{0}")]
    Io(#[from] io::Error),
}

impl OutputError {
    pub(crate) fn new(file: &Path, cause: impl Into<Cause>) -> Self {
        Self { file: file.into(), cause: cause.into() }
    }

    /// True where another name has to be given, false where the system refuses.
    pub fn is_usage(&self) -> bool {
        !matches!(self.cause, Cause::Io(_) | Cause::NoReader)
    }
}

impl From<OutputError> for io::Error {
    /// The cause alone, for errors that name the file themselves.
    fn from(error: OutputError) -> Self {
        match error.cause {
            Cause::Io(cause) => cause,
            cause => Self::other(cause),
        }
    }
}
