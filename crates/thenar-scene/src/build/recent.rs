//! Values made before in this process, by all that they were made from, so that no entry can be
//! stale: a scene that is opened again or swept does not make its bodies again.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Values that were used last.
pub(super) struct Recent<K, V> {
    /// Key, value and size, the last used first.
    kept: Mutex<VecDeque<(K, V, usize)>>,
    /// Largest sum of sizes.
    room: usize,
}

impl<K: PartialEq, V: Clone> Recent<K, V> {
    /// Empty, with room for values of this size together.
    pub const fn new(room: usize) -> Self {
        Self { kept: Mutex::new(VecDeque::new()), room }
    }

    /// The value of a key. One that is not kept is made; meanwhile nobody waits for a lock.
    ///
    /// # Errors
    /// Those of `make`, which are not kept.
    pub fn get_or_make<E>(
        &self,
        key: K,
        make: impl FnOnce(&K) -> Result<V, E>,
        size: impl FnOnce(&V) -> usize,
    ) -> Result<V, E> {
        if let Some(value) = self.get(&key) {
            return Ok(value);
        }
        let value = make(&key)?;
        let size = size(&value);
        if size > self.room {
            return Ok(value);
        }
        let mut kept = self.lock();
        // Another thread may have made it, too.
        kept.retain(|(other, ..)| *other != key);
        kept.push_front((key, value.clone(), size));
        let mut sum = 0;
        kept.retain(|(_, _, size)| {
            sum += size;
            sum <= self.room
        });
        Ok(value)
    }

    /// The value of a key, if it is kept, which then is the one used last.
    pub fn get(&self, key: &K) -> Option<V> {
        let mut kept = self.lock();
        let at = kept.iter().position(|(other, ..)| other == key)?;
        let entry = kept.remove(at)?;
        let value = entry.1.clone();
        kept.push_front(entry);
        Some(value)
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<(K, V, usize)>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes ten times the key, of the size of the key.
    fn ask(recent: &Recent<usize, usize>, key: usize) -> usize {
        recent.get_or_make(key, |key| Ok::<_, ()>(10 * key), |_| key).unwrap()
    }

    #[test]
    fn what_was_used_last_stays_as_long_as_there_is_room() {
        let recent = Recent::new(10);
        assert_eq!([4, 5].map(|key| ask(&recent, key)), [40, 50]);
        // The four is used again, so that the five goes for the three.
        assert_eq!(recent.get(&4), Some(40));
        assert_eq!(ask(&recent, 3), 30);
        assert_eq!([3, 4, 5].map(|key| recent.get(&key)), [Some(30), Some(40), None]);
        // What has no room at all takes none from others.
        assert_eq!(ask(&recent, 11), 110);
        assert_eq!([3, 4, 11].map(|key| recent.get(&key)), [Some(30), Some(40), None]);
    }

    #[test]
    fn what_is_kept_is_not_made_again_and_errors_are() {
        let recent = Recent::new(10);
        ask(&recent, 2);
        assert_eq!(recent.get_or_make(2, |_| Err("made again"), |_| 1), Ok(20));
        assert_eq!(recent.get_or_make(3, |_| Err("an error"), |_| 1), Err("an error"));
        assert_eq!(recent.get(&3), None);
        assert_eq!(ask(&recent, 3), 30);
    }
}
