//! The program's end of the line to a keeper. A message is one byte of length and as many that set the device free; the
//! length 0 says that the device is free. The keeper answers a byte when it has taken over.

use super::{ARGUMENT, BEAT_NS, program};
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// How long a keeper has to end \[ns\]; one that hangs is killed.
const ENDING: Duration = Duration::from_millis(50);

/// A keeper at work, as the program sees it. Dropping it ends the keeper, which lets the device be.
pub struct Keeping {
    keeper: Child,
    line: UnixStream,
    beat_ns: Option<u64>,
}

impl Keeping {
    /// Starts a keeper of the device behind `handle`, if the program says how.
    ///
    /// # Errors
    /// The system starts none.
    pub fn begin(handle: OwnedFd) -> io::Result<Option<Self>> {
        let Some(program) = program() else { return Ok(None) };
        let (line, its) = UnixStream::pair()?;
        line.set_nonblocking(true)?;
        let keeper = Command::new(program)
            .arg(ARGUMENT)
            .current_dir("/")
            .process_group(0)
            .stdin(Stdio::from(OwnedFd::from(its)))
            .stdout(Stdio::from(handle))
            .stderr(Stdio::null())
            .spawn()?;
        Ok(Some(Self { keeper, line, beat_ns: None }))
    }

    /// Says that the program lives, when that is due; `release` gives the bytes that set the device free now. True if the
    /// keeper has taken over meanwhile: then the device holds nothing.
    ///
    /// # Errors
    /// The keeper is gone, or does not listen.
    pub fn beat(
        &mut self,
        now_ns: u64,
        release: impl FnOnce(&mut dyn FnMut(&[u8])),
    ) -> io::Result<bool> {
        let mut told = [0; 16];
        let taken_over = match self.line.read(&mut told) {
            Ok(0) => return Err(ErrorKind::BrokenPipe.into()),
            Ok(_) => true,
            Err(error) if passing(&error) => false,
            Err(error) => return Err(error),
        };
        if self.beat_ns.is_none_or(|beat| now_ns.saturating_sub(beat) >= BEAT_NS) {
            self.beat_ns = Some(now_ns);
            let mut message = [0; 256];
            let mut length = 0;
            release(&mut |bytes| {
                // Longer ones are no release; their protocol's test would show that.
                let fits = bytes.len() < message.len() - length;
                if let Some(place) = message[1..][length..].get_mut(..bytes.len()).filter(|_| fits)
                {
                    place.copy_from_slice(bytes);
                    length += bytes.len();
                }
            });
            message[0] = length as u8;
            // A line that takes nothing any more has nobody at its other end who reads.
            let sent = self.line.write(&message[..=length])?;
            if sent <= length {
                return Err(ErrorKind::TimedOut.into());
            }
        }
        Ok(taken_over)
    }
}

impl Drop for Keeping {
    fn drop(&mut self) {
        // Only a keeper that hears this lets the device be at once.
        let _ = self.line.write(&[0]);
        let start = Instant::now();
        while start.elapsed() < ENDING {
            match self.keeper.try_wait() {
                Ok(None) => std::thread::sleep(Duration::from_micros(500)),
                _ => return,
            }
        }
        let _ = self.keeper.kill();
        let _ = self.keeper.wait();
    }
}

/// Nothing to read for now.
fn passing(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
