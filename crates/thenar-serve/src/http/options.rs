//! Options of a server, and limits on its clients.

use std::net::IpAddr;
use std::time::Duration;

/// The computers that can reach the server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// This computer only: plain HTTP on the loopback address, no token.
    Loopback,
    /// Everyone on the network who has the pairing token: HTTPS only.
    Lan,
}

/// The port to listen on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Port {
    /// This port, or none; 0 lets the system choose.
    Exactly(u16),
    /// This port or, where it is taken, one of the next few.
    From(u16),
}

/// Options for serving.
#[derive(Clone, Debug)]
pub struct Options {
    /// The computers that can reach the server.
    pub reach: Reach,
    /// The address to listen on, instead of the one that goes with the reach.
    pub address: Option<IpAddr>,
    /// The port to listen on.
    pub port: Port,
    /// Limits on what clients may do.
    pub limits: RequestLimits,
}

/// Bounds on what clients may cost. Beyond them a client is refused or cut off; the simulation
/// never waits for one.
#[derive(Clone, Debug)]
pub struct RequestLimits {
    /// Sessions at a time.
    pub clients: usize,
    /// Other connections at a time: a connection that has become a session no longer counts.
    pub connections: usize,
    /// Largest number of connections from one address.
    pub connections_per_address: usize,
    /// For the TLS handshake, for the head of each request, and between requests.
    pub head: Duration,
    /// Without any byte from the client.
    pub idle: Duration,
    /// Without the client taking a byte that waits for it.
    pub stuck: Duration,
    /// For one whole message to a client.
    pub send: Duration,
    /// Between two signs of life that are asked of a client.
    pub ping: Duration,
    /// Bytes a second from a connection; four seconds' worth may come at once.
    pub bytes: f64,
    /// Messages a second of any kind from a session; two seconds' worth may come at once.
    pub messages: f64,
    /// Text messages a second; a second's worth may come at once.
    pub texts: f64,
    /// Poses a second; a tenth of a second's worth may come at once.
    pub poses: f64,
    /// Refused messages within [`RequestLimits::refusal_window`] that end a session.
    pub refusals: usize,
    /// Time within which refusals are counted: see [`RequestLimits::refusals`].
    pub refusal_window: Duration,
}

impl Default for RequestLimits {
    fn default() -> Self {
        Self {
            clients: 64,
            connections: 256,
            connections_per_address: 128,
            head: Duration::from_secs(10),
            idle: Duration::from_secs(60),
            stuck: Duration::from_secs(15),
            send: Duration::from_secs(20),
            ping: Duration::from_secs(15),
            bytes: 1e6,
            messages: 2000.0,
            texts: 100.0,
            poses: 400.0,
            refusals: 10,
            refusal_window: Duration::from_secs(10),
        }
    }
}
