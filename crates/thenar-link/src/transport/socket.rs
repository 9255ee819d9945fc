//! Streams over TCP, where the device or we call.

use super::SEND_PATIENCE;
use super::wait::read_within;
use crate::Transport;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

/// A connection.
pub struct StreamTransport {
    stream: TcpStream,
}

impl StreamTransport {
    /// Takes over a connection.
    ///
    /// # Errors
    /// It broke at once.
    pub fn new(stream: TcpStream) -> io::Result<Self> {
        stream.set_nodelay(true)?;
        notice_its_end(&stream)?;
        stream.set_nonblocking(true)?;
        Ok(Self { stream })
    }
}

/// A peer whose network went away says nothing any more, not even that: the system asks it, and
/// gives the connection up after some five seconds.
///
/// # Errors
/// The system cannot do so.
pub fn notice_its_end(stream: &TcpStream) -> io::Result<()> {
    let ask = socket2::TcpKeepalive::new()
        .with_time(Duration::from_secs(2))
        .with_interval(Duration::from_secs(1))
        .with_retries(3);
    socket2::SockRef::from(stream).set_tcp_keepalive(&ask)
}

/// Time that the other end has to take the last words, which set its actuators free.
const PARTING: Duration = Duration::from_millis(50);

impl Drop for StreamTransport {
    /// A connection that is closed while bytes of the other end wait to be read is broken off, and
    /// what was sent last may be lost with it: they are read until the other end hangs up as well.
    fn drop(&mut self) {
        let start = Instant::now();
        let mut leave = self.stream.shutdown(Shutdown::Write).is_err();
        while !leave && start.elapsed() < PARTING {
            leave = match self.stream.read(&mut [0; 4096]) {
                Ok(received) => received == 0,
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    std::thread::sleep(Duration::from_millis(1));
                    false
                }
                Err(error) => error.kind() != ErrorKind::Interrupted,
            };
        }
    }
}

impl Transport for StreamTransport {
    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        let received =
            read_within(&mut self.stream, timeout, |stream| match stream.read(buffer)? {
                0 => Err(ErrorKind::UnexpectedEof.into()),
                length => Ok(Some(length)),
            })?;
        Ok(received.unwrap_or(0))
    }

    fn send(&mut self, mut bytes: &[u8]) -> io::Result<()> {
        let start = Instant::now();
        while !bytes.is_empty() {
            match self.stream.write(bytes) {
                Ok(sent) => bytes = &bytes[sent..],
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    if start.elapsed() >= SEND_PATIENCE {
                        return Err(io::Error::new(ErrorKind::TimedOut, "it takes no more bytes"));
                    }
                    std::thread::sleep(Duration::from_micros(200));
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    #[cfg(unix)]
    fn handle(&mut self) -> io::Result<Option<std::os::fd::OwnedFd>> {
        Ok(Some(self.stream.try_clone()?.into()))
    }
}
