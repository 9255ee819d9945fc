//! A folder for what is needed for a while.

use crate::claim::ledger;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// A new folder among the system's temporary files, which nobody else can read; removed with all
/// that is in it when dropped, or by [`seal`](crate::seal).
#[derive(Debug)]
pub struct TemporaryFolder(PathBuf);

static COUNT: AtomicU32 = AtomicU32::new(0);

impl TemporaryFolder {
    /// Makes one, whose name begins with this word.
    ///
    /// # Errors
    /// The system refuses.
    pub fn new(word: &str) -> io::Result<Self> {
        let mut ledger = ledger();
        loop {
            let number = COUNT.fetch_add(1, Ordering::Relaxed);
            let name = format!("{word}-{}-{number}", std::process::id());
            let folder = std::env::temp_dir().join(name);
            match make(&folder) {
                // Left by a process that was killed, or put there by somebody else.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
                Ok(()) => {
                    ledger.unfinished.insert(folder.clone());
                    return Ok(Self(folder));
                }
            }
        }
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

#[cfg(unix)]
fn make(folder: &Path) -> io::Result<()> {
    use std::os::unix::fs::DirBuilderExt;
    fs::DirBuilder::new().mode(0o700).create(folder)
}

#[cfg(not(unix))]
fn make(folder: &Path) -> io::Result<()> {
    fs::create_dir(folder)
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        // What cannot be removed is the system's to clear up.
        let _ = fs::remove_dir_all(&self.0);
        ledger().unfinished.remove(&self.0);
    }
}
