//! The one clock of this process.

use std::sync::OnceLock;
use std::time::Instant;

/// Nanoseconds since the clock was first read in this process; never goes back, never stops. All
/// times of samples and outputs are of this clock.
pub fn now_ns() -> u64 {
    static START: OnceLock<Instant> = OnceLock::new();
    // Starts at a millisecond, so that 0 is before everything.
    START.get_or_init(Instant::now).elapsed().as_nanos() as u64 + 1_000_000
}
