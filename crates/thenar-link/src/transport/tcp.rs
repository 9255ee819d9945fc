//! Streams over TCP: we call, or are called.

use super::StreamTransport;
use crate::Transport;
use std::io::{self, ErrorKind};
use std::net::{IpAddr, SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Longest time that a call may take.
const CALL: Duration = Duration::from_secs(1);
/// A peer that was silent for so long may lose its place to anybody.
const PEER_SILENCE: Duration = Duration::from_secs(1);
/// Time between two checks for a call that takes a served peer's place.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Calls `host:port`.
///
/// # Errors
/// Nobody is there, or the name is not known.
pub fn call(address: &str) -> io::Result<TcpStream> {
    let mut last = io::Error::new(ErrorKind::NotFound, "the name is not known");
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, CALL) {
            Ok(stream) => return Ok(stream),
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// Serves one peer at a time. The newest wins: what is left of a broken connection often looks
/// alive for minutes, and a headset that comes back must not wait for that. Where strangers can
/// reach the port, `only` keeps them out, or [`faithful`](Self::faithful) while a peer is served.
#[derive(Clone, Debug)]
pub struct TcpServer {
    listener: Arc<TcpListener>,
    only: Option<IpAddr>,
    faithful: bool,
    /// The caller that waits while another is served.
    next: Arc<Mutex<Option<Caller>>>,
    /// Calls of others that were hung up on, not yet reported.
    refused: Arc<AtomicU64>,
}

/// A connection, and who called.
type Caller = (TcpStream, IpAddr);

impl TcpServer {
    /// Listens at `at`, perhaps only to one address.
    ///
    /// # Errors
    /// The port is taken or may not be used.
    pub fn listen(at: SocketAddr, only: Option<IpAddr>) -> io::Result<Self> {
        let listener = TcpListener::bind(at)?;
        listener.set_nonblocking(true)?;
        let listener = Arc::new(listener);
        let (next, refused) = (Arc::default(), Arc::default());
        Ok(Self { listener, only, faithful: false, next, refused })
    }

    /// A peer that speaks loses its place only to a call from its own address.
    pub fn faithful(self) -> Self {
        Self { faithful: true, ..self }
    }

    /// Address at which it listens.
    ///
    /// # Errors
    /// The system does not say.
    pub fn local_address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// The peer that called last, if one did.
    ///
    /// # Errors
    /// Nobody has called.
    pub fn accept(&self) -> io::Result<ServedPeer> {
        let waiting = self.next.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some((stream, from)) = waiting.or_else(|| self.newest(self.only)) else {
            // Not yet told of: then the cause of its absence is somebody else.
            return Err(match (self.refused.load(Ordering::Relaxed), self.only) {
                (1.., Some(only)) => {
                    let cause = format!("others than {only} have called and are refused");
                    io::Error::new(ErrorKind::PermissionDenied, cause)
                }
                _ => io::Error::new(ErrorKind::NotConnected, "nobody has called yet"),
            });
        };
        let stream = StreamTransport::new(stream)?;
        Ok(ServedPeer { stream, from, server: self.clone(), looked: Instant::now(), heard: None })
    }

    /// The newest of those that wait, if they may. Others are hung up on.
    fn newest(&self, only: Option<IpAddr>) -> Option<Caller> {
        let mut newest = None;
        // A flood of calls is looked through in parts.
        for _ in 0..16 {
            let Ok((stream, from)) = self.listener.accept() else { break };
            if only.is_none_or(|ip| ip == from.ip()) {
                newest = Some((stream, from.ip()));
            } else {
                self.refused.fetch_add(1, Ordering::Relaxed);
            }
        }
        newest
    }
}

/// A peer that called. It is lost when another calls.
pub struct ServedPeer {
    stream: StreamTransport,
    from: IpAddr,
    server: TcpServer,
    looked: Instant,
    /// Time when the peer last spoke.
    heard: Option<Instant>,
}

impl Transport for ServedPeer {
    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        let received = self.stream.receive(buffer, timeout)?;
        if received > 0 {
            self.heard = Some(Instant::now());
        }
        if self.looked.elapsed() >= LOOK_EVERY {
            self.looked = Instant::now();
            let speaks = self.heard.is_some_and(|heard| heard.elapsed() < PEER_SILENCE);
            let keeps = self.server.faithful && speaks;
            let only = if keeps { Some(self.from) } else { self.server.only };
            if let Some(caller) = self.server.newest(only) {
                let mut next = self.server.next.lock().unwrap_or_else(PoisonError::into_inner);
                *next = Some(caller);
                return Err(io::Error::new(ErrorKind::ConnectionAborted, "another has called"));
            }
        }
        Ok(received)
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.stream.send(bytes)
    }

    #[cfg(unix)]
    fn handle(&mut self) -> io::Result<Option<std::os::fd::OwnedFd>> {
        self.stream.handle()
    }

    fn refused(&mut self) -> u64 {
        self.server.refused.swap(0, Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn the_newest_peer_wins() {
        let server = TcpServer::listen(SocketAddr::from(([127, 0, 0, 1], 0)), None).unwrap();
        let address = server.local_address().unwrap().to_string();
        assert_eq!(server.accept().err().unwrap().kind(), ErrorKind::NotConnected);
        let serve = || -> ServedPeer {
            (0..1000)
                .find_map(|_| {
                    std::thread::sleep(Duration::from_millis(5));
                    server.accept().ok()
                })
                .expect("a peer")
        };
        let mut first = call(&address).unwrap();
        first.write_all(b"first").unwrap();
        let mut peer = serve();
        let (mut buffer, long) = ([0; 100], Duration::from_secs(20));
        assert_eq!(peer.receive(&mut buffer, long).unwrap(), 5);
        let mut second = call(&address).unwrap();
        second.write_all(b"second!").unwrap();
        let end =
            (0..10_000).find_map(|_| peer.receive(&mut buffer, Duration::from_millis(1)).err());
        assert_eq!(end.expect("the first is lost").kind(), ErrorKind::ConnectionAborted);
        let mut peer = serve();
        assert_eq!(peer.receive(&mut buffer, long).unwrap(), 7);
        assert_eq!(&buffer[..7], b"second!");
    }

    #[test]
    fn strangers_are_not_served() {
        let only = Some("10.1.2.3".parse().unwrap());
        let server = TcpServer::listen(SocketAddr::from(([127, 0, 0, 1], 0)), only).unwrap();
        let _call = call(&server.local_address().unwrap().to_string()).unwrap();
        for _ in 0..20 {
            std::thread::sleep(Duration::from_millis(5));
            assert!(server.accept().is_err());
        }
    }
}
