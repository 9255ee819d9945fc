//! Ways out of the program must not wait for ever.

use std::sync::{Mutex, MutexGuard, TryLockError};
use std::time::Duration;

/// Locks what others hold for a moment at most, in ways out that must not wait for ever: `None`
/// when this very thread holds it, as in a panic hook. A panic elsewhere while it was held does it
/// no harm.
pub fn lock_soon<T>(what: &Mutex<T>) -> Option<MutexGuard<'_, T>> {
    for _ in 0..100 {
        match what.try_lock() {
            Ok(held) => return Some(held),
            Err(TryLockError::Poisoned(poisoned)) => return Some(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_micros(200)),
        }
    }
    None
}
