//! Opening what is no plain file.

#[cfg(unix)]
use crate::error::Cause;
use crate::place::{LINKS_MAX, folder_of};
use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
#[cfg(unix)]
use std::time::Duration;

/// The reader of a pipe is often started together with us: this is the number of turns in which we
/// wait for it.
#[cfg(unix)]
const READER_TURNS: u32 = 100;
/// One of these turns.
#[cfg(unix)]
const READER_TURN: Duration = Duration::from_millis(10);

/// The descriptor of a process that a name leads to, such as `/proc/self/fd/1` for `/dev/stdout`.
pub fn descriptor(target: &Path) -> Option<PathBuf> {
    let mut path = target.to_path_buf();
    for _ in 0..LINKS_MAX {
        let next = fs::read_link(&path).ok()?;
        let folder = folder_of(&path).ok()?;
        if folder.starts_with("/proc") && folder.ends_with("fd") {
            return Some(folder.join(path.file_name()?));
        }
        path = folder.join(next);
    }
    None
}

/// Opens a descriptor of a process. Writing goes on behind what is there: the standard outputs
/// are shared with the rest of the program.
#[cfg(unix)]
pub fn behind(link: &Path) -> io::Result<File> {
    use std::os::fd::AsFd;
    let own = fs::canonicalize("/proc/self/fd")?;
    let descriptor = match link.file_name().and_then(|name| name.to_str()) {
        Some("1") if link.starts_with(&own) => io::stdout().as_fd().try_clone_to_owned()?,
        Some("2") if link.starts_with(&own) => io::stderr().as_fd().try_clone_to_owned()?,
        _ => return OpenOptions::new().append(true).open(link),
    };
    Ok(File::from(descriptor))
}

/// Other systems have no such names.
#[cfg(not(unix))]
pub fn behind(link: &Path) -> io::Result<File> {
    OpenOptions::new().append(true).open(link)
}

/// Opens a character device, which may be a terminal.
#[cfg(unix)]
pub fn device(target: &Path) -> io::Result<File> {
    use rustix::fs::OFlags;
    use std::os::unix::fs::OpenOptionsExt;
    let flags = OFlags::NOCTTY.bits() as i32;
    OpenOptions::new().write(true).custom_flags(flags).open(target)
}

/// Opens a named pipe that somebody reads from.
#[cfg(unix)]
pub fn pipe(target: &Path) -> Result<File, Cause> {
    use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
    use std::os::unix::fs::OpenOptionsExt;
    let flags = OFlags::NONBLOCK.bits() as i32;
    for _ in 0..READER_TURNS {
        match OpenOptions::new().write(true).custom_flags(flags).open(target) {
            Ok(file) => {
                let flags = fcntl_getfl(&file).map_err(io::Error::from)?;
                fcntl_setfl(&file, flags - OFlags::NONBLOCK).map_err(io::Error::from)?;
                return Ok(file);
            }
            Err(error) if error.raw_os_error() == Some(rustix::io::Errno::NXIO.raw_os_error()) => {
                std::thread::sleep(READER_TURN);
            }
            Err(error) => return Err(error.into()),
        }
    }
    Err(Cause::NoReader)
}
