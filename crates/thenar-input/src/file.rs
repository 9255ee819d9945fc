//! Reading of files with a bound.

use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::Path;

/// Why a file was not read. The caller names the file.
#[derive(Debug)]
pub enum InputError {
    /// The system's own error.
    System(io::Error),
    /// The path leads to something else than a plain file.
    NotAFile {
        /// Kind of the thing there, with its article.
        kind: &'static str,
    },
    /// The file is larger than it may be.
    TooLarge {
        /// Bytes that it may have.
        bytes_max: u64,
    },
    /// The file was to hold text.
    NotText {
        /// The first byte that is not UTF-8.
        offset: usize,
    },
}

impl std::fmt::Display for InputError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::System(cause) => write!(f, "{cause}"),
            Self::NotAFile { kind } => write!(f, "this is {kind}, not a plain file"),
            Self::TooLarge { bytes_max } => {
                write!(f, "the file is larger than the {bytes_max} bytes that are read")
            }
            Self::NotText { offset } => write!(f, "not text: byte {offset} is not UTF-8"),
        }
    }
}

impl std::error::Error for InputError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::System(cause) => Some(cause),
            _ => None,
        }
    }
}

impl From<InputError> for io::Error {
    fn from(error: InputError) -> Self {
        match error {
            InputError::System(cause) => cause,
            other => Self::new(io::ErrorKind::InvalidInput, other),
        }
    }
}

/// The bytes of a plain file of at most `bytes_max` bytes, or of what was piped into the program
/// (see [`open_plain`]).
///
/// # Errors
/// See [`InputError`].
pub fn read(path: impl AsRef<Path>, bytes_max: u64) -> Result<Vec<u8>, InputError> {
    let (file, size) = open_plain(path)?;
    if size.is_some_and(|size| size > bytes_max) {
        return Err(InputError::TooLarge { bytes_max });
    }
    // What says that it is empty is not asked for more: some files of the system (`/proc/kmsg`)
    // then wait.
    let most = size.map_or(bytes_max + 1, |size| size.saturating_add(1).min(bytes_max + 1));
    let mut bytes = Vec::new();
    if most > 1 || size.is_none() {
        file.take(most).read_to_end(&mut bytes).map_err(InputError::System)?;
    }
    if bytes.len() as u64 > bytes_max {
        return Err(InputError::TooLarge { bytes_max });
    }
    Ok(bytes)
}

/// The text of a plain file of at most `bytes_max` bytes.
///
/// # Errors
/// See [`InputError`].
pub fn read_text(path: impl AsRef<Path>, bytes_max: u64) -> Result<String, InputError> {
    String::from_utf8(read(path, bytes_max)?)
        .map_err(|error| InputError::NotText { offset: error.utf8_error().valid_up_to() })
}

/// Opens a plain file, and its size \[bytes\]. A pipe is opened, without a size, only where a shell
/// hands it to the program: `/dev/stdin` and `/dev/fd/N`, as in `program | thenar run /dev/stdin`.
///
/// # Errors
/// The system refuses, or something else is there: a folder, a pipe, a socket, a device.
pub fn open_plain(path: impl AsRef<Path>) -> Result<(File, Option<u64>), InputError> {
    let path = path.as_ref();
    // Asked before it is opened, since opening a pipe waits for who writes into it, ...
    let found = path.metadata().map_err(InputError::System)?;
    let piped = is_handed_over(path) && is_pipe(&found);
    refuse_others(&found, piped)?;
    let file = File::open(path).map_err(InputError::System)?;
    // ... and again of what was opened.
    let opened = file.metadata().map_err(InputError::System)?;
    refuse_others(&opened, piped)?;
    Ok((file, opened.is_file().then_some(opened.len())))
}

fn refuse_others(found: &Metadata, piped: bool) -> Result<(), InputError> {
    if found.is_file() || (piped && is_pipe(found)) {
        return Ok(());
    }
    Err(InputError::NotAFile { kind: kind(found) })
}

/// True if a path names one of the program's own open files.
fn is_handed_over(path: &Path) -> bool {
    let text = path.to_string_lossy();
    text == "/dev/stdin" || text.starts_with("/dev/fd/") || text.starts_with("/proc/self/fd/")
}

#[cfg(unix)]
fn is_pipe(found: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    found.file_type().is_fifo()
}

#[cfg(not(unix))]
fn is_pipe(_: &Metadata) -> bool {
    false
}

#[cfg(unix)]
fn kind(found: &Metadata) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    let kind = found.file_type();
    match () {
        () if kind.is_dir() => "a folder",
        () if kind.is_fifo() => "a pipe",
        () if kind.is_socket() => "a socket",
        () if kind.is_char_device() || kind.is_block_device() => "a device",
        () => "something else",
    }
}

#[cfg(not(unix))]
fn kind(found: &Metadata) -> &'static str {
    if found.is_dir() { "a folder" } else { "something else" }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    fn folder(name: &str) -> PathBuf {
        let folder =
            std::env::temp_dir().join(format!("thenar-input-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn a_file_is_read_up_to_its_bound_and_no_further() {
        let folder = folder("bound");
        let file = folder.join("ten");
        std::fs::write(&file, b"0123456789").unwrap();
        assert_eq!(read(&file, 10).unwrap(), b"0123456789");
        assert_eq!(read_text(&file, u64::MAX - 1).unwrap(), "0123456789");
        assert!(matches!(read(&file, 9), Err(InputError::TooLarge { bytes_max: 9 })));
        let empty = folder.join("empty");
        std::fs::write(&empty, b"").unwrap();
        assert_eq!(read(&empty, 0).unwrap(), b"");
        std::fs::write(&file, b"ab\xff").unwrap();
        let error = read_text(&file, 10).unwrap_err().to_string();
        assert_eq!(error, "not text: byte 2 is not UTF-8");
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn what_is_missing_or_a_folder_is_an_error() {
        let folder = folder("missing");
        assert!(matches!(read(folder.join("none"), 10), Err(InputError::System(_))));
        let error = read(&folder, 10).unwrap_err().to_string();
        assert_eq!(error, "this is a folder, not a plain file");
        std::fs::remove_dir_all(folder).unwrap();
    }

    /// Devices that give bytes for ever, pipes that nobody writes into, and links to both.
    #[cfg(unix)]
    #[test]
    fn devices_and_pipes_are_refused_at_once() {
        let folder = folder("devices");
        let refused = |path: &Path, kind: &str| {
            let error = read(path, u64::MAX - 1).unwrap_err().to_string();
            assert_eq!(error, format!("this is {kind}, not a plain file"), "{}", path.display());
        };
        for device in ["/dev/zero", "/dev/null", "/dev/urandom"] {
            refused(Path::new(device), "a device");
            let link = folder.join(device.replace('/', "-"));
            std::os::unix::fs::symlink(device, &link).unwrap();
            refused(&link, "a device");
        }
        let pipe = folder.join("pipe");
        if std::process::Command::new("mkfifo").arg(&pipe).status().is_ok_and(|s| s.success()) {
            refused(&pipe, "a pipe");
        }
        let socket = folder.join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        refused(&socket, "a socket");
        std::fs::remove_dir_all(folder).unwrap();
    }

    /// A file of the system that says that it has no bytes and gives some, or makes its reader
    /// wait.
    #[cfg(target_os = "linux")]
    #[test]
    fn files_without_a_size_are_empty() {
        assert_eq!(read("/proc/version", 1 << 20).unwrap(), b"");
    }
}
