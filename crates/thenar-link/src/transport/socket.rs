//! Streams over TCP, where the device or we call.

use super::SEND_PATIENCE;
use crate::Transport;
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
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
        stream.set_nonblocking(true)?;
        Ok(Self { stream })
    }
}

impl Transport for StreamTransport {
    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        // A socket's own time limit counts in clock ticks of up to 10 ms.
        let start = Instant::now();
        loop {
            match self.stream.read(buffer) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    if start.elapsed() >= timeout {
                        return Ok(0);
                    }
                    std::thread::sleep(Duration::from_micros(200).min(timeout));
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                result => return result,
            }
        }
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
}
