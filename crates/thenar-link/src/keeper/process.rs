//! Work of the keeper's process.

use super::{KeeperActions, KeeperState};
use crate::now_ns;
use crate::realtime::{PriorityClass, lock_memory, raise_priority, touch_stack};
use crate::transport::read_within;
use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::time::Duration;

/// Keeps the device behind standard output for the program at the other end of standard input,
/// until neither needs it.
///
/// # Errors
/// Standard input is not such a line: somebody else has started this.
pub fn run() -> io::Result<()> {
    // What the system refuses the program has reported.
    let _ = raise_priority(PriorityClass::Keeper);
    touch_stack();
    let _ = lock_memory();
    // A name of its own: what is done to all processes of the program's name is not done to it.
    #[cfg(target_os = "linux")]
    let _ = rustix::thread::set_name(c"device-keeper");
    let mut line = UnixStream::from(io::stdin().as_fd().try_clone_to_owned()?);
    let mut device = File::from(io::stdout().as_fd().try_clone_to_owned()?);
    line.peer_addr()?;
    line.set_nonblocking(true)?;
    keep(&mut line, &mut device)
}

/// Until there is nothing left to do.
fn keep(line: &mut UnixStream, device: &mut impl Write) -> io::Result<()> {
    let (mut watch, mut release, mut messages) =
        (KeeperState::default(), Vec::new(), Messages::default());
    let mut wait_ns = 0;
    let mut gone = false;
    loop {
        let mut bytes = [0; 4096];
        if gone {
            std::thread::sleep(Duration::from_nanos(wait_ns));
        } else {
            let read = |line: &mut UnixStream| line.read(&mut bytes).map(Some);
            match read_within(line, Duration::from_nanos(wait_ns), read) {
                Ok(None) => {}
                Ok(Some(length)) if length > 0 => messages.take(&bytes[..length], &mut |message| {
                    if message.is_empty() {
                        watch.end();
                    } else {
                        watch.hear(now_ns());
                        release.clear();
                        release.extend_from_slice(message);
                    }
                }),
                // It has hung up; a broken line says no more than that.
                Ok(Some(_)) | Err(_) => gone = true,
            }
            if gone {
                watch.gone(now_ns());
            }
        }
        let KeeperActions { release: due, tell, end, wait_ns: next } = watch.turn(now_ns());
        if end {
            return Ok(());
        }
        if due && is_lost(device.write(&release)) {
            // Nobody is reached there any more.
            return Ok(());
        }
        if tell && !gone {
            // A program that has gone meanwhile is seen with the next look.
            let _ = line.write(&[1]);
        }
        wait_ns = next;
    }
}

/// True if the device's port or socket is gone for good; what it does not take now it is sent
/// again, as when a network is down for a while.
fn is_lost(sent: io::Result<usize>) -> bool {
    use rustix::io::Errno;
    let gone = [ErrorKind::BrokenPipe, ErrorKind::ConnectionReset, ErrorKind::NotConnected];
    let ports = [Errno::IO, Errno::NXIO, Errno::NODEV, Errno::BADF];
    sent.is_err_and(|error| {
        gone.contains(&error.kind())
            || Errno::from_io_error(&error).is_some_and(|errno| ports.contains(&errno))
    })
}

/// Splits what comes into messages.
#[derive(Default)]
struct Messages {
    bytes: Vec<u8>,
}

impl Messages {
    fn take(&mut self, bytes: &[u8], message: &mut dyn FnMut(&[u8])) {
        self.bytes.extend_from_slice(bytes);
        while let Some(length) = self.bytes.first().map(|n| usize::from(*n)) {
            let Some(whole) = self.bytes.get(1..=length) else { return };
            message(whole);
            self.bytes.drain(..=length);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Split anywhere, messages are the same.
    #[test]
    fn messages_come_whole() {
        let wire = [3, b'a', b'b', b'c', 1, b'x', 0, 2, b'y', b'z'];
        for cut in 0..=wire.len() {
            let (mut messages, mut found) = (Messages::default(), Vec::new());
            for part in [&wire[..cut], &wire[cut..]] {
                messages.take(part, &mut |message| found.push(message.to_vec()));
            }
            assert_eq!(found, [&b"abc"[..], b"x", b"", b"yz"], "cut at {cut}");
        }
    }

    /// A line whose other end is dropped after a beat: the device gets the newest release, for a
    /// second, then nothing.
    #[test]
    fn the_newest_release_is_sent_when_the_line_breaks() {
        let (mut program, mut line) = UnixStream::pair().unwrap();
        line.set_nonblocking(true).unwrap();
        program.write_all(&[3, b'o', b'l', b'd', 3, b'n', b'e', b'w']).unwrap();
        drop(program);
        let mut device = Vec::new();
        keep(&mut line, &mut device).unwrap();
        assert!(device.len() > 30 && device.chunks(3).all(|sent| sent == b"new"), "{device:?}");
    }

    /// Told that the device is free, it sends nothing.
    #[test]
    fn a_program_that_ends_in_order_leaves_nothing_to_do() {
        let (mut program, mut line) = UnixStream::pair().unwrap();
        line.set_nonblocking(true).unwrap();
        program.write_all(&[3, b'n', b'e', b'w', 0]).unwrap();
        drop(program);
        let mut device = Vec::new();
        keep(&mut line, &mut device).unwrap();
        assert_eq!(device, b"");
    }

    /// The device is gone.
    #[test]
    fn a_device_that_is_gone_is_left() {
        struct Gone;
        impl Write for Gone {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(ErrorKind::BrokenPipe.into())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let (mut program, mut line) = UnixStream::pair().unwrap();
        line.set_nonblocking(true).unwrap();
        program.write_all(&[1, b'x']).unwrap();
        // The program stays, and is silent.
        keep(&mut line, &mut Gone).unwrap();
        let mut told = [0; 4];
        program.set_nonblocking(true).unwrap();
        assert!(program.read(&mut told).is_err());
    }
}
