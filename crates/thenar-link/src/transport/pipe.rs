//! Named pipes, for programs on the same computer that write lines to a file.

use crate::Transport;
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Read};
use std::path::Path;
use std::time::{Duration, Instant};

/// The reading end of a named pipe. Writers may come and go.
#[derive(Debug)]
pub struct PipeTransport {
    pipe: File,
}

impl PipeTransport {
    /// Opens a named pipe, whether or not somebody writes to it.
    ///
    /// # Errors
    /// There is none.
    pub fn open(path: &Path) -> io::Result<Self> {
        let mut options = OpenOptions::new();
        options.read(true);
        #[cfg(unix)]
        {
            use std::os::unix::fs::OpenOptionsExt;
            options.custom_flags(nix::fcntl::OFlag::O_NONBLOCK.bits());
        }
        Ok(Self { pipe: options.open(path)? })
    }
}

impl Transport for PipeTransport {
    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        let start = Instant::now();
        loop {
            match self.pipe.read(buffer) {
                // No writer, or none that has something.
                Ok(0) => {}
                Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
                result => return result,
            }
            let left = timeout.saturating_sub(start.elapsed());
            if left.is_zero() {
                return Ok(0);
            }
            std::thread::sleep(left.min(Duration::from_micros(500)));
        }
    }

    fn send(&mut self, _: &[u8]) -> io::Result<()> {
        Ok(())
    }
}
