//! Destinations of outputs.

use crate::error::Cause;
use crate::open;
use std::fs::{self, File, FileType, Metadata};
use std::io;
use std::path::{Path, PathBuf, is_separator};

/// Links that are followed, as Linux does.
pub const LINKS_MAX: usize = 40;

/// Destination of an output.
#[derive(Debug)]
pub enum Destination {
    /// A plain file at the end of all links, and what is known of it where it is there.
    Plain(PathBuf, Option<Metadata>),
    /// Written as it goes.
    Straight(File),
}

impl Destination {
    /// Finds where a name leads, and opens it where it is no plain file.
    pub fn find(target: &Path) -> Result<Self, Cause> {
        if let Some(link) = open::descriptor(target) {
            return Ok(Self::Straight(open::behind(&link)?));
        }
        match fs::metadata(target) {
            Ok(there) if there.is_dir() => Err(Cause::Folder),
            Ok(there) if there.is_file() => {
                // Replacing needs no right to write the file, but a file that may not be written
                // is there to be kept.
                fs::OpenOptions::new().write(true).open(target)?;
                Ok(Self::Plain(fs::canonicalize(target)?, Some(there)))
            }
            Ok(there) => special(target, there.file_type()),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let bytes = target.as_os_str().as_encoded_bytes();
                if bytes.last().is_none_or(|c| is_separator(*c as char)) {
                    return Err(Cause::NoName);
                }
                Ok(Self::Plain(end_of_links(target)?, None))
            }
            Err(error) => Err(error.into()),
        }
    }
}

/// The canonical path of a plain file that is there or could be made, through links of which the
/// last may lead to nothing.
pub fn end_of_links(target: &Path) -> io::Result<PathBuf> {
    let mut path = target.to_path_buf();
    for _ in 0..LINKS_MAX {
        let folder = folder_of(&path)?;
        let name = path.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
        let file = folder.join(name);
        match fs::read_link(&file) {
            Ok(next) => path = folder.join(next),
            Err(_) => return Ok(file),
        }
    }
    Err(io::Error::other("links lead round in a circle"))
}

/// The canonical folder that a name is in.
pub fn folder_of(path: &Path) -> io::Result<PathBuf> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    fs::canonicalize(folder.unwrap_or(Path::new(".")))
}

#[cfg(unix)]
fn special(target: &Path, kind: FileType) -> Result<Destination, Cause> {
    use std::os::unix::fs::FileTypeExt;
    match kind {
        _ if kind.is_char_device() => Ok(Destination::Straight(open::device(target)?)),
        _ if kind.is_fifo() => Ok(Destination::Straight(open::pipe(target)?)),
        _ if kind.is_block_device() => Err(Cause::Refused("block device")),
        _ if kind.is_socket() => Err(Cause::Refused("socket")),
        _ => Err(Cause::Refused("thing that is not a file")),
    }
}

#[cfg(not(unix))]
fn special(_: &Path, _: FileType) -> Result<Destination, Cause> {
    Err(Cause::Refused("thing that is not a file"))
}
