//! The clock of a device, seen through a network.
//!
//! A sample arrives after it was measured, never before: the smallest difference between our clock
//! and the device's, over the recent past, is the offset of the two and the shortest way between
//! them. Times so carried over have little of the network's jitter.

/// How fast the offset may grow again, so that a device whose clock runs slow is followed.
const DRIFT: f64 = 2e-4;
/// A step of the device's clock back by this is a new start, not a datagram overtaken \[ns\].
const BACK: i64 = 200_000_000;
/// A step ahead by this is a jump; a smaller one is a shorter way than was known \[ns\].
const AHEAD: i64 = 250_000_000;
/// A device all of whose samples seem this late ... \[ns\]
const LATE: i64 = 100_000_000;
/// ... for so long has put its clock back \[ns\].
const LATE_FOR: u64 = 1_000_000_000;
/// A device that goes on speaking, and whose clock shows the same for so long, has a clock that
/// stands still \[ns\].
const STILL_FOR: u64 = 1_000_000_000;
/// Times beyond are no times of a clock (292 years, halved) \[ns\].
const CLOCK_MAX: i64 = i64::MAX / 2;

/// Follows one device's clock.
#[derive(Clone, Debug, Default)]
pub struct SourceClock {
    /// Ours minus the device's \[ns\], when it was set on our clock, and the device's newest time.
    known: Option<Known>,
}

#[derive(Clone, Copy, Debug)]
struct Known {
    offset: i64,
    at_ns: u64,
    newest: i64,
    /// The device's time of the sample before, and since when it shows that \[ns\].
    last: (i64, u64),
    late_since: Option<u64>,
}

/// A time carried over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Carried {
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

    /// What the device calls `source_ns`, arriving now.
    pub fn carry(&mut self, now_ns: u64, source_ns: i64) -> Carried {
        let source = source_ns.clamp(-CLOCK_MAX, CLOCK_MAX);
        let now = i64::try_from(now_ns).unwrap_or(CLOCK_MAX).min(CLOCK_MAX);
        let difference = now - source;
        let last = (source, now_ns);
        let fresh =
            Known { offset: difference, at_ns: now_ns, newest: source, last, late_since: None };
        let Some(known) = &mut self.known else {
            self.known = Some(fresh);
            return Carried { time_ns: now_ns, jumped: false, stands_still: false };
        };
        // The same again, such as the other hand's, says nothing about the clock.
        if source == known.last.0 {
            let time = source.saturating_add(known.offset).clamp(0, now) as u64;
            let stands_still = now_ns.saturating_sub(known.last.1) > STILL_FOR;
            return Carried { time_ns: time, jumped: false, stands_still };
        }
        let passed = now_ns.saturating_sub(known.at_ns);
        let grown = known.offset.saturating_add((passed as f64 * DRIFT) as i64);
        let offset = grown.min(difference);
        let late = difference - offset > LATE;
        let late_since = late.then(|| known.late_since.unwrap_or(now_ns));
        let back = known.newest.saturating_sub(source) > BACK;
        let ahead = known.offset.saturating_sub(difference) > AHEAD;
        let stays_late = late_since.is_some_and(|since| now_ns.saturating_sub(since) > LATE_FOR);
        if back || ahead || stays_late {
            self.known = Some(fresh);
            return Carried { time_ns: now_ns, jumped: true, stands_still: false };
        }
        let newest = known.newest.max(source);
        *known = Known { offset, at_ns: now_ns, newest, last, late_since };
        let time = source.saturating_add(offset).clamp(0, now);
        Carried { time_ns: time as u64, jumped: false, stands_still: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    /// The device's clock is 5 s ahead and 100 ppm slow, the network takes 2 ms to 9 ms: after a
    /// second, times are carried over to within a millisecond of the shortest way.
    #[test]
    fn jitter_of_the_network_goes() {
        let mut clock = SourceClock::default();
        let mut worst = 0u64;
        for k in 0..6000u64 {
            let measured = 10_000 * MS + k * 11 * MS;
            let source = (measured as f64 * (1.0 - 1e-4)) as i64 + 5_000_000_000;
            let delay = 2 * MS + (k * 7919 % 8) * MS;
            let carried = clock.carry(measured + delay, source);
            assert!(!carried.jumped && carried.time_ns <= measured + delay);
            if k > 100 {
                worst = worst.max((carried.time_ns).abs_diff(measured + 2 * MS));
            }
        }
        assert!(worst < MS, "{worst}");
    }

    #[test]
    fn jumps_are_noticed_and_followed() {
        let mut clock = SourceClock::default();
        let hour = 3_600_000_000_000i64;
        let mut run = |from: u64, shift: i64| -> Vec<bool> {
            (0..20u64)
                .map(|k| {
                    let now = (from + 10 * k) * MS;
                    let carried = clock.carry(now, now as i64 + shift);
                    // Whatever the device's clock does, fresh samples are fresh but after a jump
                    // forward of our own doing.
                    assert!(now - carried.time_ns < 300 * MS);
                    carried.jumped
                })
                .collect()
        };
        let once = |told: &[bool]| told.iter().filter(|j| **j).count() == 1 && told[0];
        assert!(run(1000, 0).iter().all(|jumped| !jumped));
        assert!(once(&run(2000, hour)), "an hour ahead");
        assert!(once(&run(3000, -hour)), "and back");
        assert!(run(4000, -hour).iter().all(|jumped| !jumped));
    }

    /// By as little as clocks are set back over a network: old for a second, then followed.
    #[test]
    fn a_small_step_back_for_good_is_followed_after_a_second() {
        for back_ms in [120, 150, 199] {
            let mut clock = SourceClock::default();
            (0..100).for_each(|k| _ = clock.carry(k * 10 * MS, (k * 10 * MS) as i64));
            let mut jumps = Vec::new();
            for k in 100..400u64 {
                let now = k * 10 * MS;
                let carried = clock.carry(now, (now - back_ms * MS) as i64);
                jumps.extend(carried.jumped.then_some(k));
                let age = now - carried.time_ns;
                match jumps.is_empty() {
                    // The offset may have drifted by 0.4 ms meanwhile.
                    true => assert!(age.abs_diff(back_ms * MS) < MS, "{k} {age}"),
                    false => assert!(age < MS, "{k} {age}"),
                }
            }
            assert_eq!(jumps, [201], "back by {back_ms} ms");
        }
    }

    /// However long the same is repeated, it gets no fresher, and it is told; two hands of one frame
    /// have the same time and are no trouble.
    #[test]
    fn a_clock_that_stands_still_makes_nothing_fresh() {
        let mut clock = SourceClock::default();
        for k in 0..1000u64 {
            let now = (5000 + 10 * k) * MS;
            let carried = clock.carry(now, 77);
            assert_eq!(carried.time_ns, 5000 * MS);
            assert_eq!((carried.jumped, carried.stands_still), (false, k > 100), "{k}");
        }
        let mut clock = SourceClock::default();
        for k in 0..1000u64 {
            let now = (15_000 + 10 * k) * MS;
            for _hand in 0..2 {
                let carried = clock.carry(now, (10 * k * MS) as i64);
                assert!(!carried.stands_still);
                assert_eq!(carried.time_ns, now, "{k}");
            }
        }
    }

    /// Wi-Fi stalls: samples come late, all at once, and are known to be old.
    #[test]
    fn a_burst_of_late_samples_is_late() {
        let mut clock = SourceClock::default();
        (0..100).for_each(|k| _ = clock.carry(k * 10 * MS, (k * 10 * MS) as i64));
        let now = 1500 * MS;
        for k in 100..140u64 {
            let carried = clock.carry(now, (k * 10 * MS) as i64);
            assert!(!carried.jumped && carried.time_ns.abs_diff(k * 10 * MS) < MS);
        }
    }

    #[test]
    fn no_number_breaks_it() {
        let mut clock = SourceClock::default();
        let odd = [0, 1, -1, i64::MAX, i64::MIN, i64::MAX - 1, 1 << 62, -(1 << 62), 5];
        for now in [0, 1, u64::MAX, 7 * MS, 1 << 63] {
            for source in odd {
                assert!(clock.carry(now, source).time_ns <= now);
            }
        }
    }
}
