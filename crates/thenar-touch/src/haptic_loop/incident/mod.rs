//! The felt chain, kept for an incident: all that entered it in the last seconds, and its state at
//! their beginning, so that it can be made again to the same bits.
//!
//! ```text
//!  loop ── inputs, samples ──► rings ──► monitor: the last seconds ──┐
//!    └── once a second: its whole state ──► a pool of buffers ───────┤ a trip: thenar-trip-TIME.touch
//!  simulation ── frames ──► one buffer, the oldest overwritten ──────┘
//! ```
//!
//! The loop's part ([`IncidentWriter`]) allocates nothing and waits for nobody: where a ring has no
//! room, recording breaks off and begins anew with the next state. [`replay`] runs the product's
//! own chain over an [`Incident`]. In single-rate, whose state is a whole simulation, nothing is
//! kept.

mod file;
mod frames;
mod reader;
mod replay;
mod writer;

pub use file::{Incident, IncidentError, VERSION};
pub use frames::Frames;
pub use reader::IncidentReader;
pub use replay::{Difference, Replayed, replay};
pub use writer::{IncidentWriter, Input, RecordedSample};

use super::TickRecord;

/// Time between two states \[ns\].
const STATE_EVERY_NS: u64 = 1_000_000_000;
/// The least that is kept before a trip \[ns\].
const KEPT_NS: u64 = 2_000_000_000;

/// The bytes of a record that the chain alone decides: not those of when the thread ran.
fn decided(record: &TickRecord) -> Vec<u8> {
    let record = TickRecord { late_ns: 0, cost_ns: 0, missed: 0, ..*record };
    // Into memory that grows, this cannot fail.
    postcard::to_allocvec(&record).unwrap_or_default()
}
