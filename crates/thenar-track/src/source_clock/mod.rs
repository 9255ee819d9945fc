//! The clock of a device, seen through a network.
//!
//! A sample arrives after it was measured, never before: the smallest difference between our clock
//! and the device's, over the recent past, is the offset of the two and the shortest way between
//! them. Times so carried over have little of the network's jitter. A device whose clock runs fast
//! or slow, by 2e-3 at most, is followed at its rate, so that its samples become neither older nor
//! younger.

mod offsets;

#[cfg(test)]
mod step_tests;
#[cfg(test)]
mod tests;

use offsets::Offsets;

/// A step of the device's clock back by this is a new start, not a datagram overtaken \[ns\].
const BACK: i64 = 200_000_000;
/// A step ahead by this is a jump; a smaller one is a shorter way than was known \[ns\].
const AHEAD: i64 = 250_000_000;
/// A device all of whose samples seem this late ... \[ns\]
const LATENESS: i64 = 100_000_000;
/// ... for so long has put its clock back \[ns\].
const LATENESS_DURATION: u64 = 1_000_000_000;
/// A device that goes on speaking, and whose clock shows the same for so long, has a clock that
/// stands still \[ns\].
const STILL_DURATION: u64 = 1_000_000_000;
/// Times beyond are no times of a clock (292 years, halved) \[ns\].
const CLOCK_MAX: i64 = i64::MAX / 2;

/// Follows one device's clock.
#[derive(Clone, Debug, Default)]
pub struct SourceClock {
    known: Option<ClockState>,
}

#[derive(Clone, Debug)]
struct ClockState {
    /// Ours minus the device's.
    offsets: Offsets,
    /// The device's newest time \[ns\].
    newest: i64,
    /// The device's time of the sample before, and since when it shows that \[ns\].
    last: (i64, u64),
    late_since: Option<u64>,
}

/// A time carried over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CarriedTime {
    /// On our clock \[ns\]; never later than now.
    pub time_ns: u64,
    /// The device's clock has jumped just now.
    pub jumped: bool,
    /// True if the source's clock stands still: a sample is old, however often it is repeated.
    pub stands_still: bool,
}

impl SourceClock {
    /// Forgets the device's clock: another may speak.
    pub fn clear(&mut self) {
        self.known = None;
    }

    /// Carries the device's time `source_ns`, arriving now, over to our clock.
    pub fn carry(&mut self, now_ns: u64, source_ns: i64) -> CarriedTime {
        let source = source_ns.clamp(-CLOCK_MAX, CLOCK_MAX);
        let now = i64::try_from(now_ns).unwrap_or(CLOCK_MAX).min(CLOCK_MAX);
        let difference = now - source;
        let last = (source, now_ns);
        let fresh = || {
            let offsets = Offsets::new(now_ns, difference);
            Some(ClockState { offsets, newest: source, last, late_since: None })
        };
        let Some(known) = &mut self.known else {
            self.known = fresh();
            return CarriedTime { time_ns: now_ns, jumped: false, stands_still: false };
        };
        // The same again, such as the other hand's, says nothing about the clock.
        if source == known.last.0 {
            let time = source.saturating_add(known.offsets.at(now_ns)).clamp(0, now) as u64;
            let stands_still = now_ns.saturating_sub(known.last.1) > STILL_DURATION;
            return CarriedTime { time_ns: time, jumped: false, stands_still };
        }
        let expected = known.offsets.at(now_ns);
        let late = difference.saturating_sub(expected) > LATENESS;
        let late_since = late.then(|| known.late_since.unwrap_or(now_ns));
        let back = known.newest.saturating_sub(source) > BACK;
        let ahead = expected.saturating_sub(difference) > AHEAD;
        let stays_late =
            late_since.is_some_and(|since| now_ns.saturating_sub(since) > LATENESS_DURATION);
        if back || ahead || stays_late {
            self.known = fresh();
            return CarriedTime { time_ns: now_ns, jumped: true, stands_still: false };
        }
        let offset = known.offsets.take(now_ns, difference, late);
        known.newest = known.newest.max(source);
        (known.last, known.late_since) = (last, late_since);
        let time = source.saturating_add(offset).clamp(0, now);
        CarriedTime { time_ns: time as u64, jumped: false, stands_still: false }
    }
}
