//! How bytes travel.

pub mod serial;
pub mod socket;

pub use serial::SerialTransport;
pub use socket::StreamTransport;

use std::time::Duration;

/// A device that takes nothing for so long is lost.
pub const SEND_PATIENCE: Duration = Duration::from_millis(5);
