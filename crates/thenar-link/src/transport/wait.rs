//! Waiting for a socket, no longer and hardly less precisely than asked.

use std::io::{self, ErrorKind};
use std::time::{Duration, Instant};

/// Sources that can be waited for.
#[cfg(target_os = "linux")]
pub trait Waitable: std::os::fd::AsFd {}
#[cfg(target_os = "linux")]
impl<T: std::os::fd::AsFd> Waitable for T {}

/// Sources that can be waited for.
#[cfg(not(target_os = "linux"))]
pub trait Waitable {}
#[cfg(not(target_os = "linux"))]
impl<T> Waitable for T {}

/// Until there is something to read, or for `timeout`. A socket's own time limit counts in clock
/// ticks of up to 10 ms; this is right to some 50 µs.
#[cfg(target_os = "linux")]
fn readable(socket: &impl Waitable, timeout: Duration) -> io::Result<()> {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    let timeout = Timespec {
        tv_sec: timeout.as_secs().min(60) as i64,
        tv_nsec: i64::from(timeout.subsec_nanos()),
    };
    match poll(&mut [PollFd::new(socket, PollFlags::IN)], Some(&timeout)) {
        Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
        Err(error) => Err(error.into()),
    }
}

/// Looks often.
#[cfg(not(target_os = "linux"))]
fn readable(_: &impl Waitable, timeout: Duration) -> io::Result<()> {
    std::thread::sleep(timeout.min(Duration::from_micros(200)));
    Ok(())
}

/// Tries to read from a socket that does not block, again when there is something, until it gives
/// something or `timeout` is over.
pub fn read_within<S: Waitable, T>(
    socket: &mut S,
    timeout: Duration,
    mut read: impl FnMut(&mut S) -> io::Result<Option<T>>,
) -> io::Result<Option<T>> {
    let start = Instant::now();
    loop {
        match read(socket) {
            Ok(Some(found)) => return Ok(Some(found)),
            Ok(None) => {}
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                let left = timeout.saturating_sub(start.elapsed());
                if left.is_zero() {
                    return Ok(None);
                }
                readable(socket, left)?;
                continue;
            }
            Err(error) => return Err(error),
        }
        // What is left out must not keep us for ever.
        if start.elapsed() >= timeout {
            return Ok(None);
        }
    }
}
