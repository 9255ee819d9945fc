//! Datagrams.

use super::wait::read_within;
use crate::Transport;
use crate::worker::Connect;
use std::io::{self, ErrorKind};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

/// Silence of the peer after which another may speak.
const PEER_SILENCE: Duration = Duration::from_secs(1);

/// One peer at a time: either a given one, or whoever speaks first. A second one is not heard until
/// the first was silent for a second, so that two senders cannot move one hand in turns.
#[derive(Debug)]
pub struct UdpTransport {
    socket: UdpSocket,
    /// The only address that is heard.
    only: Option<IpAddr>,
    /// The address that spoke last, and when.
    peer: Option<(SocketAddr, Instant)>,
    /// The peer is given: the system leaves out others.
    connected: bool,
    /// Datagrams of others, not yet asked for.
    refused: u64,
}

impl UdpTransport {
    /// Talks with `peer`.
    ///
    /// # Errors
    /// The system gives no socket, or knows no way there.
    pub fn connect(peer: SocketAddr) -> io::Result<Self> {
        let any: IpAddr = match peer {
            SocketAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
            SocketAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
        };
        let socket = UdpSocket::bind((any, 0))?;
        socket.connect(peer)?;
        socket.set_nonblocking(true)?;
        Ok(Self { socket, only: None, peer: None, connected: true, refused: 0 })
    }

    /// Listens at `at`, perhaps only to one address.
    ///
    /// # Errors
    /// The port is taken or may not be used.
    pub fn listen(at: SocketAddr, only: Option<IpAddr>) -> io::Result<Self> {
        let socket = UdpSocket::bind(at)?;
        socket.set_nonblocking(true)?;
        Ok(Self { socket, only, peer: None, connected: false, refused: 0 })
    }

    /// Address at which it listens.
    ///
    /// # Errors
    /// The system does not say.
    pub fn local_address(&self) -> io::Result<SocketAddr> {
        self.socket.local_addr()
    }
}

/// Listens at `at`, perhaps only to one address: at once, so that a port that is taken is reported,
/// and again whenever the socket is lost.
///
/// # Errors
/// As for [`UdpTransport::listen`].
pub fn listening(at: SocketAddr, only: Option<IpAddr>) -> io::Result<Connect> {
    let mut first = Some(UdpTransport::listen(at, only)?);
    Ok(Box::new(move || match first.take() {
        Some(transport) => Ok(Box::new(transport)),
        None => Ok(Box::new(UdpTransport::listen(at, only)?)),
    }))
}

/// True if this sender is heard now; then it is the peer.
fn hears(
    peer: &mut Option<(SocketAddr, Instant)>,
    only: Option<IpAddr>,
    from: SocketAddr,
    now: Instant,
) -> bool {
    let busy = |(at, heard): &(SocketAddr, Instant)| {
        *at != from && now.saturating_duration_since(*heard) < PEER_SILENCE
    };
    let heard = only.is_none_or(|ip| ip == from.ip()) && !peer.as_ref().is_some_and(busy);
    if heard {
        *peer = Some((from, now));
    }
    heard
}

impl Transport for UdpTransport {
    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        let Self { socket, only, peer, connected, refused } = self;
        let received = read_within(socket, timeout, |socket| {
            let (length, from) = socket.recv_from(buffer)?;
            let heard = *connected || hears(peer, *only, from, Instant::now());
            *refused += u64::from(!heard);
            Ok((heard && length > 0).then_some(length))
        })?;
        Ok(received.unwrap_or(0))
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let sent = match (self.connected, self.peer) {
            (true, _) => self.socket.send(bytes),
            (false, Some((peer, _))) => self.socket.send_to(bytes, peer),
            (false, None) => return Ok(()),
        };
        match sent {
            // A network that is full loses datagrams.
            Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(()),
            result => result.map(|_| ()),
        }
    }

    /// Only a socket with a given peer has one: others do not know whom to write to.
    #[cfg(unix)]
    fn handle(&mut self) -> io::Result<Option<std::os::fd::OwnedFd>> {
        self.connected.then(|| Ok(self.socket.try_clone()?.into())).transpose()
    }

    fn refused(&mut self) -> u64 {
        std::mem::take(&mut self.refused)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_peer_is_heard_at_a_time() {
        let start = Instant::now();
        let [a, b]: [SocketAddr; 2] = ["10.0.0.1:5", "10.0.0.2:5"].map(|a| a.parse().unwrap());
        let at = |ms| start + Duration::from_millis(ms);
        let mut peer = None;
        let mut hears = |from, ms| hears(&mut peer, None, from, at(ms));
        assert!(hears(a, 0) && !hears(b, 10) && hears(a, 900) && !hears(b, 1800));
        assert!(hears(b, 1900) && !hears(a, 1901));
        let mut peer = None;
        assert!(!super::hears(&mut peer, Some(a.ip()), b, start) && peer.is_none());
        assert!(super::hears(&mut peer, Some(a.ip()), a, start));
    }

    #[test]
    fn datagrams_arrive_whole_and_answers_go_back() {
        let mut here = UdpTransport::listen(SocketAddr::from(([127, 0, 0, 1], 0)), None).unwrap();
        assert!(here.send(b"to nobody").is_ok());
        let mut there = UdpTransport::connect(here.local_address().unwrap()).unwrap();
        let mut buffer = [0; 100];
        assert_eq!(here.receive(&mut buffer, Duration::from_micros(200)).unwrap(), 0);
        there.send(b"one").unwrap();
        there.send(b"two").unwrap();
        let long = Duration::from_secs(20);
        assert_eq!(here.receive(&mut buffer, long).unwrap(), 3);
        assert_eq!(&buffer[..3], b"one");
        assert_eq!(here.receive(&mut buffer, long).unwrap(), 3);
        here.send(b"answer").unwrap();
        assert_eq!(there.receive(&mut buffer, long).unwrap(), 6);
        // The bridge ends: that is noticed.
        drop(here);
        let lost = (0..1000).any(|_| {
            there.send(b"x").is_err()
                || there.receive(&mut buffer, Duration::from_millis(1)).is_err()
        });
        assert!(lost || !cfg!(target_os = "linux"));
    }
}
