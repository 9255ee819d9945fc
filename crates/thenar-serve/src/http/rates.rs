//! Limits on how often something may happen.

use std::collections::VecDeque;
use std::time::Duration;
use tokio::time::Instant;

/// Fills at a steady rate up to a bound; what is taken out must be in it.
#[derive(Debug)]
pub struct Bucket {
    rate: f64,
    capacity: f64,
    level: f64,
    seen: Instant,
}

impl Bucket {
    /// A full one: `rate` per second, at most `rate * seconds` at once.
    pub fn new(rate: f64, seconds: f64, now: Instant) -> Self {
        let capacity = (rate * seconds).max(1.0);
        Self { rate, capacity, level: capacity, seen: now }
    }

    /// Takes `amount` out, or nothing if there is less.
    pub fn take(&mut self, amount: f64, now: Instant) -> bool {
        let gained = now.saturating_duration_since(self.seen).as_secs_f64() * self.rate;
        self.level = (self.level + gained).min(self.capacity);
        self.seen = self.seen.max(now);
        let enough = self.level >= amount;
        if enough {
            self.level -= amount;
        }
        enough
    }

    /// Time at which the bucket will hold one more, as of the last look.
    pub fn ready(&self) -> Instant {
        self.seen + Duration::from_secs_f64((1.0 - self.level).max(0.0) / self.rate)
    }
}

/// Remembers the last few refusals.
#[derive(Debug)]
pub struct Refusals {
    most: usize,
    window: Duration,
    times: VecDeque<Instant>,
}

impl Refusals {
    /// None yet; `most` of them within `window` are too many.
    pub fn new(most: usize, window: Duration) -> Self {
        Self { most, window, times: VecDeque::with_capacity(most + 1) }
    }

    /// One more; true if that is too many.
    pub fn count(&mut self, now: Instant) -> bool {
        self.times.push_back(now);
        while self.times.front().is_some_and(|t| now.duration_since(*t) > self.window) {
            self.times.pop_front();
        }
        self.times.len() >= self.most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At 100 a second from a store of 100, ten seconds of asking 1000 times a second give
    /// 100 + 10 · 100.
    #[test]
    fn a_bucket_gives_its_store_and_its_rate() {
        let start = Instant::now();
        let mut bucket = Bucket::new(100.0, 1.0, start);
        let given =
            (0..=10_000).filter(|ms| bucket.take(1.0, start + Duration::from_millis(*ms))).count();
        assert!((1099..=1100).contains(&given), "{given}");
    }

    #[test]
    fn an_empty_bucket_tells_when_to_come_back() {
        let start = Instant::now();
        let mut bucket = Bucket::new(400.0, 0.1, start);
        while bucket.take(1.0, start) {}
        let ready = bucket.ready();
        assert!(!bucket.take(1.0, ready - Duration::from_micros(10)));
        assert!(bucket.take(1.0, ready + Duration::from_micros(10)));
    }

    #[test]
    fn ten_refusals_in_ten_seconds_are_too_many_and_slower_ones_are_not() {
        let start = Instant::now();
        let at = |s: f64| start + Duration::from_secs_f64(s);
        let mut refusals = Refusals::new(10, Duration::from_secs(10));
        assert!((0..100).all(|i| !refusals.count(at(f64::from(i) * 1.2))));
        let mut refusals = Refusals::new(10, Duration::from_secs(10));
        assert!((0..9).all(|i| !refusals.count(at(f64::from(i)))));
        assert!(refusals.count(at(9.5)));
    }
}
