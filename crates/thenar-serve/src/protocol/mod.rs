//! The messages of `docs/protocol.md`: models and snapshots out, poses and commands in. Pure: no
//! sockets, no threads, no clocks.

mod arrays;
mod command;
mod contact;
mod hand;
mod model;
mod pose;
mod rigid;
mod snapshot;
mod soft;
pub mod text;

pub use command::{Command, Lengths};
pub use model::{ModelError, model, set_epoch};
pub use pose::{ANGLES_BYTES, JOINTS_BYTES, LOST_BYTES, PoseBody, PoseError, PoseMessage};
pub use snapshot::{Pace, Snapshots, flags};

/// Version of the protocol, in every binary message. A client of another one is refused.
pub const VERSION: u8 = 3;

/// Longest text message from a client \[bytes\].
pub const TEXT_BYTES_MAX: usize = 4096;

/// Kinds of binary messages.
pub mod kind {
    /// Model of the scene.
    pub const MODEL: u8 = 1;
    /// Snapshot of the places of everything.
    pub const SNAPSHOT: u8 = 2;
    /// 25 tracked joints of a hand.
    pub const JOINTS: u8 = 16;
    /// A wrist and the angles of our joints.
    pub const ANGLES: u8 = 17;
    /// A hand is not tracked any more.
    pub const LOST: u8 = 18;
}
