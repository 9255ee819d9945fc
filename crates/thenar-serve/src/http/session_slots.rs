//! Sessions, and which of them has to go when there is no place for another.
//!
//! A ping follows whatever a client is sent, and only who has read up to it can answer it. A
//! session that answers has its place as long as it likes. One that lets a ping wait takes in
//! nothing of what the server is for: when all places are taken, the one that has waited longest
//! goes.

use std::hash::{BuildHasher, RandomState};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::Duration;
use tokio::sync::{Notify, OwnedSemaphorePermit, Semaphore};
use tokio::time::Instant;

/// A ping that waits for so long is not on its way any more: ten times what a slow network takes.
const STALE: Duration = Duration::from_secs(2);

/// All sessions.
#[derive(Debug)]
pub struct SessionSlots {
    free: Arc<Semaphore>,
    slots: Mutex<Vec<Weak<SessionSlot>>>,
    stale: Duration,
}

/// A session's place, given back when dropped.
#[derive(Debug)]
pub struct SessionSlot {
    permit: Mutex<Option<OwnedSemaphorePermit>>,
    /// Since when a ping has waited for its answer.
    waits_since: Mutex<Option<Instant>>,
    /// Told when the place is another's.
    pub taken: Notify,
    tags: RandomState,
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl SessionSlots {
    /// A number of places.
    pub fn new(clients: usize) -> Self {
        Self { free: Arc::new(Semaphore::new(clients)), slots: Mutex::default(), stale: STALE }
    }

    /// A place, if need be that of a session that takes in nothing.
    pub fn acquire(&self) -> Option<Arc<SessionSlot>> {
        let permit = self.free.clone().try_acquire_owned().ok().or_else(|| self.clear())?;
        let slot = Arc::new(SessionSlot {
            permit: Mutex::new(Some(permit)),
            waits_since: Mutex::new(None),
            taken: Notify::new(),
            tags: RandomState::new(),
        });
        let mut slots = lock(&self.slots);
        slots.retain(|slot| slot.strong_count() > 0);
        slots.push(Arc::downgrade(&slot));
        Some(slot)
    }

    /// Ends the session that has let a ping wait longest, too long, and takes its place.
    fn clear(&self) -> Option<OwnedSemaphorePermit> {
        let slots: Vec<Arc<SessionSlot>> =
            lock(&self.slots).iter().filter_map(Weak::upgrade).collect();
        let stale = slots.iter().filter_map(|slot| {
            let since = (*lock(&slot.waits_since))?;
            (since.elapsed() >= self.stale && lock(&slot.permit).is_some()).then_some((since, slot))
        });
        let (_, slot) = stale.min_by_key(|(since, _)| *since)?;
        slot.taken.notify_one();
        lock(&slot.permit).take()
    }

    /// Waits until all sessions have ended.
    pub async fn empty(&self, clients: usize) {
        let all = u32::try_from(clients).unwrap_or(u32::MAX);
        let _ = self.free.acquire_many(all).await;
    }
}

impl SessionSlot {
    /// Payload of the ping of this number: who has not read it cannot know it.
    pub fn ping(&self, number: u32) -> [u8; 12] {
        let mut bytes = [0; 12];
        bytes[..4].copy_from_slice(&number.to_le_bytes());
        bytes[4..].copy_from_slice(&self.tags.hash_one(number).to_le_bytes());
        bytes
    }

    /// The number of the ping that this answers.
    pub fn answered(&self, pong: &[u8]) -> Option<u32> {
        let number = u32::from_le_bytes(*pong.first_chunk()?);
        (pong == self.ping(number)).then_some(number)
    }

    /// Says how many pings wait, and whether one of them was answered just now.
    pub fn wait(&self, pings: u32, answered: bool) {
        let mut since = lock(&self.waits_since);
        *since = match (pings, answered, *since) {
            (0, ..) => None,
            (_, false, Some(since)) => Some(since),
            _ => Some(Instant::now()),
        };
    }

    /// Since when a ping has waited.
    pub fn waits_since(&self) -> Option<Instant> {
        *lock(&self.waits_since)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_ping_that_was_read_can_be_answered() {
        let session_slots = SessionSlots::new(2);
        let [one, other] = [0, 1].map(|_| session_slots.acquire().unwrap());
        assert_eq!(one.answered(&one.ping(7)), Some(7));
        assert_eq!(one.answered(&other.ping(7)), None);
        assert_eq!(one.answered(&7_u32.to_le_bytes()), None);
        assert_eq!(one.answered(&[]), None);
        let mut wrong = one.ping(7);
        wrong[0] = 8;
        assert_eq!(one.answered(&wrong), None);
    }

    #[tokio::test(flavor = "current_thread")]
    async fn the_place_of_who_waits_longest_is_taken() {
        let session_slots =
            SessionSlots { stale: Duration::from_millis(20), ..SessionSlots::new(3) };
        let slots = [0, 1, 2].map(|_| session_slots.acquire().unwrap());
        assert!(session_slots.acquire().is_none(), "all of them may be reading");
        slots[1].wait(1, false);
        tokio::time::sleep(Duration::from_millis(5)).await;
        slots[2].wait(3, false);
        assert!(session_slots.acquire().is_none(), "a ping may be on its way");
        tokio::time::sleep(Duration::from_millis(40)).await;
        // Answered in time, though others wait.
        slots[2].wait(2, true);
        let new = session_slots.acquire().unwrap();
        slots[1].taken.notified().await;
        assert!(session_slots.acquire().is_none());
        // Whoever lost its place gives none back.
        let [first, second, _third] = slots;
        drop(second);
        assert!(session_slots.acquire().is_none());
        drop((first, new));
        assert!(session_slots.acquire().is_some());
    }
}
