//! The program's end of the line to a keeper. A message is one byte of length and as many that set
//! the device free; the length 0 says that the device is free. The keeper answers a byte when it
//! has taken over.

use super::{ARGUMENT, BEAT_NS, GONE_NS, program};
use std::io::{self, ErrorKind, Read, Write};
use std::net::Shutdown;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Time that a keeper has to end; one that hangs is killed.
const ENDING: Duration = Duration::from_millis(50);

/// A keeper at work, as the program sees it. Dropping it kills the keeper.
pub struct KeeperProcess {
    /// The keeper's process; `None` once it is left to end.
    keeper: Option<Child>,
    line: UnixStream,
    beat_ns: Option<u64>,
}

impl KeeperProcess {
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
        Ok(Some(Self { keeper: Some(keeper), line, beat_ns: None }))
    }

    /// Says that the program lives, when that is due; `release` gives the bytes that set the device
    /// free now. True if the keeper has taken over meanwhile: then the device holds nothing.
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

impl KeeperProcess {
    /// Ends the keeper: at once where the device is `free`; else it releases the device for its
    /// second. Waits for nothing.
    pub fn end(mut self, free: bool) {
        // A keeper that does not hear this sees the line break, and releases.
        let heard = free && self.line.write(&[0]).is_ok_and(|sent| sent == 1);
        let _ = self.line.shutdown(Shutdown::Both);
        let outliving = Duration::from_nanos(GONE_NS);
        self.leave(if heard { ENDING } else { outliving + ENDING });
    }

    /// Leaves the keeper to a thread that collects its end, and kills it when that is late: a
    /// process that hangs in the system may end never.
    fn leave(&mut self, patience: Duration) {
        let Some(mut keeper) = self.keeper.take() else { return };
        let collect = move || {
            let start = Instant::now();
            while start.elapsed() < patience {
                match keeper.try_wait() {
                    Ok(None) => std::thread::sleep(Duration::from_millis(1)),
                    _ => return,
                }
            }
            let _ = keeper.kill();
            let _ = keeper.wait();
        };
        // Without a thread it ends all the same, for the line is closed.
        let _ = std::thread::Builder::new().name("keeper's end".into()).spawn(collect);
    }
}

impl Drop for KeeperProcess {
    fn drop(&mut self) {
        self.leave(Duration::ZERO);
    }
}

/// Nothing to read for now.
fn passing(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
