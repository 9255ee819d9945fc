//! Locks on work that two processes must not do at a time.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};

/// A lock file that is held, with the number of this process in it. The system lets go of it when
/// it is dropped and when the process ends, however that ends, so that no lock is left of a process
/// that was killed: its file is, and is taken over.
#[derive(Debug)]
pub struct Lock {
    _file: File,
}

/// Why a lock is not held.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another process, or another part of this one, holds it.
    #[error("process {} holds {}", told(*holder), file.display())]
    Held {
        /// The lock file.
        file: PathBuf,
        /// Process that holds the lock, where the file says so.
        holder: Option<u32>,
    },
    /// The file cannot be opened or written.
    #[error("cannot write {}: {cause}", file.display())]
    Write {
        /// The lock file.
        file: PathBuf,
        /// Error of the system.
        cause: io::Error,
    },
    /// The file system has no locks, as some of clusters have none.
    #[error("cannot lock {}: {cause}", file.display())]
    NoLocks {
        /// The lock file.
        file: PathBuf,
        /// Error of the system.
        cause: io::Error,
    },
}

fn told(holder: Option<u32>) -> String {
    holder.map_or("of a number unknown".into(), |id| id.to_string())
}

impl Lock {
    /// Takes the lock of a file, which is made where it is not there.
    ///
    /// # Errors
    /// Somebody holds it, the file cannot be written, or its file system has no locks.
    pub fn take(path: &Path) -> Result<Self, LockError> {
        let write = |cause| LockError::Write { file: path.into(), cause };
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        let mut file = options.open(path).map_err(write)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut text = String::new();
                // Where locks keep others from reading, nobody is named.
                let _ = file.take(32).read_to_string(&mut text);
                return Err(LockError::Held {
                    file: path.into(),
                    holder: text.trim().parse().ok(),
                });
            }
            Err(TryLockError::Error(cause)) => {
                return Err(LockError::NoLocks { file: path.into(), cause });
            }
        }
        file.set_len(0).and_then(|()| file.rewind()).map_err(write)?;
        writeln!(file, "{}", std::process::id()).map_err(write)?;
        Ok(Self { _file: file })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TemporaryFolder;
    use std::fs;

    #[test]
    fn one_holds_it_until_it_lets_go() {
        let folder = TemporaryFolder::new("thenar-lock").unwrap();
        let path = folder.path().join("a.lock");
        let held = Lock::take(&path).unwrap();
        match Lock::take(&path) {
            Err(LockError::Held { file, holder }) => {
                assert_eq!(file, path);
                assert_eq!(holder, cfg!(unix).then(std::process::id));
            }
            other => panic!("{other:?}"),
        }
        drop(held);
        Lock::take(&path).unwrap();
    }

    #[test]
    fn what_a_killed_process_left_is_taken_over() {
        let folder = TemporaryFolder::new("thenar-lock").unwrap();
        let path = folder.path().join("a.lock");
        fs::write(&path, "4000000000 and more than the next number\n").unwrap();
        let held = Lock::take(&path).unwrap();
        if cfg!(unix) {
            let text = fs::read_to_string(&path).unwrap();
            assert_eq!(text.trim(), std::process::id().to_string());
        }
        drop(held);
    }

    #[test]
    fn a_folder_is_no_lock() {
        let folder = TemporaryFolder::new("thenar-lock").unwrap();
        let error = Lock::take(folder.path()).unwrap_err();
        assert!(error.to_string().starts_with("cannot write "), "{error}");
    }
}
