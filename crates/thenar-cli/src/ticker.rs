//! A thread that looks after a work which says nothing itself.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// Time between two looks.
const PACE: Duration = Duration::from_millis(100);

/// Ends, and is waited for, when dropped.
pub struct Ticker {
    ends: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Ticker {
    /// Looks ten times a second. Where no thread can be had nobody looks.
    pub fn new(mut look: impl FnMut() + Send + 'static) -> Self {
        let (ends, ended) = channel();
        let work = move || {
            while ended.recv_timeout(PACE) == Err(RecvTimeoutError::Timeout) {
                look();
            }
        };
        let thread = std::thread::Builder::new().name("ticker".into()).spawn(work).ok();
        Self { ends: Some(ends), thread }
    }
}

impl Drop for Ticker {
    fn drop(&mut self) {
        self.ends = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn looks_until_it_is_dropped() {
        let looks = Arc::new(AtomicU32::new(0));
        let seen = Arc::clone(&looks);
        let ticker = Ticker::new(move || {
            seen.fetch_add(1, Ordering::SeqCst);
        });
        while looks.load(Ordering::SeqCst) < 2 {
            std::thread::yield_now();
        }
        drop(ticker);
        let after = looks.load(Ordering::SeqCst);
        std::thread::sleep(3 * PACE);
        assert_eq!(looks.load(Ordering::SeqCst), after);
    }
}
