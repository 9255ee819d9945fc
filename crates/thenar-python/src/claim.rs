//! Exclusive use of a world: one thread has it, and a second one is refused at once.

use std::sync::atomic::{AtomicBool, Ordering};

/// Marks a world as taken or free.
#[derive(Debug, Default)]
pub struct Claims(AtomicBool);

/// Held by the thread that has the world; dropping it frees the world.
#[derive(Debug)]
pub struct Claim<'a>(&'a AtomicBool);

impl Claims {
    /// Takes the world; `None` when it is taken.
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
