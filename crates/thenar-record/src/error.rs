//! Why a recording cannot be read or written.

use crate::frame::VERSION;
use std::io;
use std::path::PathBuf;

/// Why a file cannot be read as a recording at all.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The file cannot be read.
    #[error("cannot read {}: {cause}", file.display())]
    Read {
        /// File that was read or written.
        file: PathBuf,
        /// Error of the system.
        cause: io::Error,
    },
    /// The file is not a recording.
    #[error("{} is not a Thenar recording", file.display())]
    Foreign {
        /// File that was read.
        file: PathBuf,
    },
    /// A later program wrote it.
    #[error(
        "{} is a recording of format version {version}; this program reads version {VERSION}: a \
         later version of Thenar reads it", file.display()
    )]
    Version {
        /// File that was read.
        file: PathBuf,
        /// Version in the file.
        version: u32,
    },
    /// The version in its prologue never was.
    #[error(
        "{} is damaged: it says that its format version is 0, and versions begin with 1; this program reads version \
         {VERSION}", file.display()
    )]
    NoVersion {
        /// File that was read.
        file: PathBuf,
    },
    /// Nothing of it can be used.
    #[error("{}: nothing can be recovered: {damage}", file.display())]
    Damaged {
        /// File that was read.
        file: PathBuf,
        /// Place and kind of the damage.
        damage: crate::Damage,
    },
}

/// Why a recording cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file exists already.
    #[error("{} is there already; a recording never replaces a file", .0.display())]
    Exists(PathBuf),
    /// The file cannot be created or written.
    #[error("cannot write {}: {cause}", file.display())]
    Write {
        /// File that was written.
        file: PathBuf,
        /// Error of the writer.
        cause: io::Error,
    },
    /// The writing thread cannot be started.
    #[error("cannot start the recording's thread: {0}")]
    Thread(io::Error),
}
