//! Named pipes.

use std::path::Path;
use std::process::Command;

/// Makes a named pipe at `path`, in the place of a file or pipe that an earlier run left there.
///
/// # Panics
/// The system makes none.
pub fn make_pipe(path: &Path) {
    let _ = std::fs::remove_file(path);
    let made = Command::new("mkfifo").arg(path).status();
    assert!(made.is_ok_and(|status| status.success()), "no pipe at {}", path.display());
}
