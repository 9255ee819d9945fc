//! Error that sweeps have left, estimated from the last of them.
//!
//! Near the end their changes shrink as a geometric series, so what is left after a change c is
//! `c ρ / (1 - ρ)`. ρ is the slowest rate of late; it may be near 1 where many contacts share a
//! load, and the last change is then a small part of the error. Where changes do not shrink at all
//! the estimate says only that sweeps have not converged, not by how much.

/// Bodies move by more than their contacts do: a box 12 mm wide turns by three times as much at the
/// 5 cm where turning counts.
pub const SAFETY: f64 = 4.0;
/// Sweeps that the estimate looks back on.
const WINDOW: usize = 16;
/// Changes are not trusted to shrink faster than this until the window is full of rates.
const RATE_START: f64 = 0.96;
/// Nor slower than this, lest round-off, which does not shrink, counts.
const RATE_MAX: f64 = 0.9999;

/// The changes that successive sweeps made.
#[derive(Clone, Copy, Debug)]
pub struct Decay {
    last: f64,
    rates: [f64; WINDOW],
    next: usize,
}

impl Default for Decay {
    fn default() -> Self {
        Self { last: f64::INFINITY, rates: [RATE_START; WINDOW], next: 0 }
    }
}

impl Decay {
    /// Notes that the next change does not continue the last: their ratio means nothing.
    pub fn interrupt(&mut self) {
        self.last = f64::INFINITY;
    }

    /// Takes in that one more sweep has changed the solution by at most `change`. Returns by how
    /// much it is likely to be off.
    pub fn error_after(&mut self, change: f64) -> f64 {
        if change == 0.0 {
            return 0.0;
        }
        if self.last < f64::INFINITY {
            self.rates[self.next] = change / self.last;
            self.next = (self.next + 1) % WINDOW;
        }
        self.last = change;
        let rate = self.rates.iter().fold(0.0_f64, |a, b| a.max(*b)).min(RATE_MAX);
        SAFETY * change * rate / (1.0 - rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two series at once, the slower hidden behind the faster at first: the sum of what is still
    /// to come is never more than told.
    #[test]
    fn what_is_still_to_come_is_not_more_than_told() {
        for slow in [0.0_f64, 0.5, 0.9, 0.99] {
            for share in [1.0, 0.1] {
                let mut decay = Decay::default();
                let change = |k: i32| 0.3_f64.powi(k) + share * slow.powi(k);
                for k in 0..200 {
                    let told = decay.error_after(change(k));
                    let rest = |rate: f64| rate.powi(k + 1) / (1.0 - rate);
                    let left = rest(0.3) + share * rest(slow);
                    let ready = k >= WINDOW as i32;
                    assert!(left <= told || !ready, "sweep {k}, rate {slow}: {left} of {told}");
                    assert!(
                        told < 4.1 * left || k < 40,
                        "sweep {k}, rate {slow}: {left} of {told}"
                    );
                }
                assert_eq!(decay.error_after(0.0), 0.0);
            }
        }
    }
}
