//! A bound on what a peer may cost.

/// A bucket that refills: a number per second, and a number at once.
#[derive(Clone, Debug)]
pub struct Rate {
    per_second: f64,
    at_once: f64,
    left: f64,
    /// Time of the last refill \[ns\].
    at_ns: u64,
}

impl Rate {
    /// A full bucket: `per_second` on average, `at_once` in a burst.
    pub fn new(per_second: f64, at_once: f64) -> Self {
        Self { per_second, at_once, left: at_once, at_ns: 0 }
    }

    /// Takes this much, if it is there.
    pub fn take(&mut self, now_ns: u64, cost: f64) -> bool {
        let passed = now_ns.saturating_sub(self.at_ns) as f64 * 1e-9;
        self.at_ns = self.at_ns.max(now_ns);
        self.left = (self.left + passed * self.per_second).min(self.at_once);
        let enough = self.left >= cost;
        if enough {
            self.left -= cost;
        }
        enough
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_than_the_rate_passes() {
        let mut rate = Rate::new(100.0, 10.0);
        // Ten thousand per second for two seconds: the bucket and what refills it.
        let passed = (0..20_000u64).filter(|k| rate.take(k * 100_000, 1.0)).count();
        assert!((208..=211).contains(&passed), "{passed}");
        // A clock that goes back gives nothing.
        assert_eq!((0..1000u64).filter(|k| rate.take(*k, 1.0)).count(), 0);
    }
}
