//! Messages over WebSocket; we call.

use super::socket::notice_its_end;
use super::wait::read_within;
use super::{SEND_PATIENCE, tcp};
use crate::Transport;
use std::io::{self, ErrorKind};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, HandshakeError, Message, WebSocket};

/// Longest message \[bytes\].
const MESSAGE_BYTES_MAX: usize = 64 << 10;
/// Longest silence of the server while it greets.
const GREETING: Duration = Duration::from_secs(1);

/// A connection to a server. One message is one receive.
pub struct WebSocketTransport {
    socket: WebSocket<TcpStream>,
}

impl WebSocketTransport {
    /// Calls `ws://host:port/path`.
    ///
    /// # Errors
    /// This is no such address, nobody is there, or what is there is no WebSocket server.
    pub fn call(url: &str) -> io::Result<Self> {
        let place = authority(url)?;
        let stream = tcp::call(&place)?;
        stream.set_nodelay(true)?;
        notice_its_end(&stream)?;
        stream.set_read_timeout(Some(GREETING))?;
        stream.set_write_timeout(Some(GREETING))?;
        let config = WebSocketConfig::default()
            .max_message_size(Some(MESSAGE_BYTES_MAX))
            .max_frame_size(Some(MESSAGE_BYTES_MAX))
            .write_buffer_size(0)
            .max_write_buffer_size(4 * MESSAGE_BYTES_MAX);
        let (socket, _) = tungstenite::client::client_with_config(url, stream, Some(config))
            .map_err(|error| match error {
                HandshakeError::Failure(error) => io_error(error),
                HandshakeError::Interrupted(_) => {
                    io::Error::new(ErrorKind::TimedOut, "the server does not greet")
                }
            })?;
        socket.get_ref().set_nonblocking(true)?;
        Ok(Self { socket })
    }
}

/// Host and port of an address.
///
/// # Errors
/// It is none that we can call.
pub fn authority(url: &str) -> io::Result<String> {
    let bad = || io::Error::new(ErrorKind::InvalidInput, "expected ws://HOST:PORT/PATH");
    let uri: tungstenite::http::Uri = url.parse().map_err(|_| bad())?;
    let (Some("ws"), Some(host)) = (uri.scheme_str(), uri.host()) else { return Err(bad()) };
    // A port that is none would otherwise be taken for the usual one.
    let port = uri.authority().and_then(|authority| authority.as_str().rsplit_once(':'));
    let named = port.is_some_and(|(_, port)| !port.ends_with(']'));
    match uri.port_u16() {
        Some(port) if port > 0 => Ok(format!("{host}:{port}")),
        None if !named => Ok(format!("{host}:80")),
        _ => Err(bad()),
    }
}

fn io_error(error: Error) -> io::Error {
    match error {
        Error::Io(error) => error,
        Error::ConnectionClosed | Error::AlreadyClosed => ErrorKind::ConnectionAborted.into(),
        other => io::Error::other(other.to_string()),
    }
}

impl Transport for WebSocketTransport {
    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        let mut read = |socket: &mut WebSocket<TcpStream>| {
            let message = socket.read().map_err(io_error)?;
            let bytes: &[u8] = match &message {
                Message::Text(text) => text.as_bytes(),
                Message::Binary(bytes) => bytes,
                Message::Close(_) => return Err(ErrorKind::ConnectionAborted.into()),
                // Pings have been answered.
                Message::Ping(_) | Message::Pong(_) | Message::Frame(_) => return Ok(None),
            };
            let room = buffer.get_mut(..bytes.len()).ok_or(ErrorKind::InvalidData)?;
            room.copy_from_slice(bytes);
            Ok((!bytes.is_empty()).then_some(bytes.len()))
        };
        let received = read_within(&mut Waiting(&mut self.socket), timeout, |w| read(w.0))?;
        Ok(received.unwrap_or(0))
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let message = match std::str::from_utf8(bytes) {
            Ok(text) => Message::text(text),
            Err(_) => Message::binary(bytes.to_vec()),
        };
        let start = Instant::now();
        let mut result = self.socket.send(message);
        loop {
            match result.map_err(io_error) {
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    if start.elapsed() >= SEND_PATIENCE {
                        let cause = "it takes no more messages";
                        return Err(io::Error::new(ErrorKind::TimedOut, cause));
                    }
                    std::thread::sleep(Duration::from_micros(200));
                }
                result => return result,
            }
            result = self.socket.flush();
        }
    }
}

/// The socket below, to be waited for.
struct Waiting<'a>(&'a mut WebSocket<TcpStream>);

#[cfg(target_os = "linux")]
impl std::os::fd::AsFd for Waiting<'_> {
    fn as_fd(&self) -> std::os::fd::BorrowedFd<'_> {
        self.0.get_ref().as_fd()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;

    #[test]
    fn addresses_are_read() {
        assert_eq!(authority("ws://127.0.0.1:15881/v2?x=y").unwrap(), "127.0.0.1:15881");
        assert_eq!(authority("ws://headset.local/poses").unwrap(), "headset.local:80");
        for bad in ["", "http://a", "wss://a:1/", "ws:", "ws:///x", "127.0.0.1:80"] {
            assert_eq!(authority(bad).unwrap_err().kind(), ErrorKind::InvalidInput, "{bad}");
        }
    }

    #[test]
    fn messages_go_both_ways_until_one_hangs_up() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("ws://{}/", listener.local_addr().unwrap());
        let server = std::thread::spawn(move || {
            let mut socket = tungstenite::accept(listener.accept().unwrap().0).unwrap();
            socket.send(Message::text("one")).unwrap();
            socket.send(Message::Ping(Default::default())).unwrap();
            socket.send(Message::binary(vec![1, 2])).unwrap();
            let heard = loop {
                match socket.read().unwrap() {
                    Message::Text(text) => break text.to_string(),
                    _ => continue,
                }
            };
            socket.close(None).unwrap();
            let _ = socket.flush();
            heard
        });
        let mut socket = WebSocketTransport::call(&url).unwrap();
        let (mut buffer, long) = ([0; 100], Duration::from_secs(20));
        assert_eq!(socket.receive(&mut buffer, long).unwrap(), 3);
        assert_eq!(&buffer[..3], b"one");
        let next = (0..100).find_map(|_| match socket.receive(&mut buffer, long).unwrap() {
            0 => None,
            some => Some(some),
        });
        assert_eq!((next, buffer[0], buffer[1]), (Some(2), 1, 2));
        socket.send(b"hello").unwrap();
        assert_eq!(server.join().unwrap(), "hello");
        assert!((0..100).any(|_| socket.receive(&mut buffer, long).is_err()));
    }

    /// A peer that answers with anything but a greeting, or with nothing, is reported.
    #[test]
    fn other_servers_are_no_websocket() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("ws://{}/", listener.local_addr().unwrap());
        let server = std::thread::spawn(move || {
            use std::io::{Read, Write};
            let (mut stream, _) = listener.accept().unwrap();
            let _ = stream.read(&mut [0; 4096]);
            stream.write_all(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n").unwrap();
            drop(stream);
            let (stream, _) = listener.accept().unwrap();
            std::thread::sleep(Duration::from_millis(1500));
            drop(stream);
        });
        assert!(WebSocketTransport::call(&url).is_err());
        assert!(WebSocketTransport::call(&url).is_err());
        server.join().unwrap();
    }
}
