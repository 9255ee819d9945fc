//! The recording's clock.

use std::time::{Duration, Instant};

/// Nanoseconds since a recording began. Cheap to copy; all sources of one recording share it.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    begun: Instant,
}

impl Clock {
    /// Begins now.
    pub fn start() -> Self {
        Self { begun: Instant::now() }
    }

    /// Time since then \[ns\].
    pub fn now_ns(&self) -> u64 {
        self.begun.elapsed().as_nanos() as u64
    }

    /// Time of an instant that was read before \[ns\]; 0 for one before the beginning.
    pub fn at_ns(&self, instant: Instant) -> u64 {
        instant.checked_duration_since(self.begun).unwrap_or(Duration::ZERO).as_nanos() as u64
    }
}
