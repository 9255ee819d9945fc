//! Transports of bytes.

mod pipe;
mod place;
pub mod serial;
pub mod socket;
pub mod tcp;
mod udp;
mod wait;
pub mod websocket;

pub use pipe::PipeTransport;
pub use place::host_and_port;
pub use serial::SerialTransport;
pub use socket::StreamTransport;
pub use tcp::TcpServer;
pub use udp::{UdpTransport, listening};
#[cfg(unix)]
pub(crate) use wait::read_within;
pub use websocket::WebSocketTransport;

use std::time::Duration;

/// A device that takes nothing for so long is lost.
pub const SEND_PATIENCE: Duration = Duration::from_millis(5);
