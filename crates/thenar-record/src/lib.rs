//! Recordings: an append-only file of small frames, each with its length and checksum, written by
//! a thread of its own.
//!
//! Whoever has something to record holds a [`FrameWriter`] or a [`Channel`]: one end of a bounded
//! ring. Writing to it takes a copy into memory that is there already: it allocates nothing, locks
//! nothing, makes no system call and never waits. Where the disk is too slow the ring fills, what
//! comes then is counted and dropped, and a gap frame says so in the file.
//!
//! A file that was cut off, by `kill -9` or a full disk, is read up to the cut. Where one was
//! damaged within, reading goes on at the next frame that can be trusted: see [`Frames`]. This
//! crate knows nothing of simulations; what a session writes is in `thenar-scene`, the bytes of all
//! of it are in `docs/recording.md`.

mod channel;
mod clock;
mod error;
mod frame;
mod frame_writer;
mod header;
mod reader;
mod recorder;
mod resync;

pub use channel::{Channel, ChannelInfo, Field, Record};
pub use clock::Clock;
pub use error::{OpenError, RecordError};
pub use frame::{FRAME_BYTES_MAX, Frame, FrameKind, VERSION};
pub use frame_writer::{FrameWriter, Gap, Weight};
pub use header::{Build, Header};
pub use reader::{Damage, Fault, FramePlace, Frames, open};
pub use recorder::{Recorder, Written};
