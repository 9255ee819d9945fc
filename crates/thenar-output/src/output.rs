//! One output.

use crate::claim::{Claim, ledger};
use crate::error::OutputError;
use crate::place::Destination;
use std::ffi::OsString;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Names of partial files that are tried: others were left by processes that were killed.
const ATTEMPTS_MAX: u32 = 1000;
/// Bytes of a target's name that its partial file begins with: with the rest it stays under the 255
/// that file systems take.
const NAME_BYTES_MAX: usize = 200;

/// An output that is complete or not there; see the [crate](crate).
#[derive(Debug)]
pub struct Output {
    target: PathBuf,
    out: Option<BufWriter<File>>,
    partial: Option<PartialFile>,
}

/// Partial file that becomes a plain file.
#[derive(Debug)]
struct PartialFile {
    path: PathBuf,
    claim: Claim,
}

impl Output {
    /// Begins an output. Until the process ends no other may have the same target.
    ///
    /// # Errors
    /// The target cannot be written, or must not be.
    pub fn create(target: &Path) -> Result<Self, OutputError> {
        let fail = |cause| OutputError::new(target, cause);
        let (file, partial) = match Destination::find(target).map_err(fail)? {
            Destination::Straight(file) => (file, None),
            Destination::Plain(file, old) => {
                let claim = Claim::at(file).map_err(fail)?;
                let (file, path) = begin(claim.file(), old.as_ref()).map_err(|e| fail(e.into()))?;
                (file, Some(PartialFile { path, claim }))
            }
        };
        Ok(Self { target: target.into(), out: Some(BufWriter::new(file)), partial })
    }

    /// The target, as it was named.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Completes it and gives it its name.
    ///
    /// # Errors
    /// The system refuses; nothing is left then, and what was there stays.
    pub fn finish(mut self) -> Result<(), OutputError> {
        self.complete()?;
        if let Some(partial) = self.partial.take() {
            partial.claim.keep();
        }
        Ok(())
    }

    /// Like [`Output::finish`], but the target may be written again.
    fn finish_once(mut self) -> Result<(), OutputError> {
        self.complete()
    }

    fn complete(&mut self) -> Result<(), OutputError> {
        let Some(mut out) = self.out.take() else { return Ok(()) };
        let done = out.flush().and_then(|()| match &self.partial {
            None => Ok(()),
            Some(partial) => {
                out.get_ref().sync_all()?;
                let mut ledger = ledger();
                fs::rename(&partial.path, partial.claim.file())?;
                ledger.unfinished.remove(&partial.path);
                Ok(())
            }
        });
        done.map_err(|cause| {
            // What could not be written is not tried again.
            drop(out.into_parts());
            self.discard();
            OutputError::new(&self.target, cause)
        })
    }

    fn discard(&mut self) {
        if let Some(partial) = self.partial.take() {
            let mut ledger = ledger();
            // It is gone already where the folder is.
            let _ = fs::remove_file(&partial.path);
            ledger.unfinished.remove(&partial.path);
            drop(ledger);
        }
    }

    /// Says which file it is.
    fn named(&self, cause: &io::Error) -> io::Error {
        io::Error::new(cause.kind(), format!("{}: {cause}", self.target.display()))
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.as_mut().map_or(Ok(0), |out| out.write(bytes));
        written.map_err(|e| self.named(&e))
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = self.out.as_mut().map_or(Ok(()), Write::flush);
        flushed.map_err(|e| self.named(&e))
    }
}

impl Drop for Output {
    fn drop(&mut self) {
        if let Some(out) = self.out.take() {
            // Half of it is of no use to anybody, nor are its last bytes.
            drop(out.into_parts());
            self.discard();
        }
    }
}

/// Writes all of an output, which may be written again later.
///
/// # Errors
/// As [`Output::create`] and [`Output::finish`].
pub fn write_whole(target: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let mut output = Output::create(target)?;
    if let Some(out) = &mut output.out {
        out.write_all(bytes).map_err(|cause| OutputError::new(target, cause))?;
    }
    output.finish_once()
}

/// Begins a partial file beside a file, with the permissions of the old one.
fn begin(file: &Path, old: Option<&Metadata>) -> io::Result<(File, PathBuf)> {
    let mut ledger = ledger();
    for number in 0..ATTEMPTS_MAX {
        let path = beside(file, number);
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
            Ok(partial) => {
                ledger.unfinished.insert(path.clone());
                if let Some(old) = old {
                    inherit(&partial, old);
                }
                return Ok((partial, path));
            }
        }
    }
    Err(io::Error::other("its folder is full of unfinished files"))
}

/// Gives a partial file owner and permissions of the file whose place it takes.
fn inherit(partial: &File, old: &Metadata) {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, fchown};
        // Only root may give files away; a group of one's own anybody.
        if fchown(partial, Some(old.uid()), Some(old.gid())).is_err() {
            let _ = fchown(partial, None, Some(old.gid()));
        }
    }
    // Where the file system has no permissions there is nothing to keep.
    let _ = partial.set_permissions(old.permissions());
}

/// `NAME.PID.part` in the same folder, or `NAME.PID-1.part`.
fn beside(file: &Path, number: u32) -> PathBuf {
    let name = file.file_name().unwrap_or_default();
    let mut partial = match name.len() {
        ..=NAME_BYTES_MAX => name.to_owned(),
        _ => OsString::from(cut(&name.to_string_lossy())),
    };
    let id = std::process::id();
    partial.push(match number {
        0 => format!(".{id}.part"),
        _ => format!(".{id}-{number}.part"),
    });
    file.with_file_name(partial)
}

/// The beginning of a name, up to a whole character.
fn cut(name: &str) -> &str {
    let end = (0..=NAME_BYTES_MAX).rev().find(|end| name.is_char_boundary(*end));
    &name[..end.unwrap_or(0)]
}
