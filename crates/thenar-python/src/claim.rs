//! Who has a world: one thread at a time, and whoever comes second is told so at once.

use std::sync::atomic::{AtomicBool, Ordering};

/// Whether somebody has it.
#[derive(Debug, Default)]
pub struct Claims(AtomicBool);

/// Held by whoever has it; let go when dropped.
#[derive(Debug)]
pub struct Claim<'a>(&'a AtomicBool);

impl Claims {
    /// Takes it; `None` when somebody has it.
    pub fn take(&self) -> Option<Claim<'_>> {
        let free = self.0.compare_exchange(false, true, Ordering::Acquire, Ordering::Relaxed);
        free.ok().map(|_| Claim(&self.0))
    }
}

impl Drop for Claim<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}
