//! Times of a tracker, held to what trackers promise.
//!
//! A tracker gives times of this process's clock, none in the future and none going back. What is
//! made of several trackers compares such times, so one that breaks the promise would hold the
//! others up: a time of tomorrow makes all that follows old, and a clock put back for good stands
//! for ever. Here such times are carried over: at once when they are of the future, since no true
//! time is; when they are of the past, only after half a second in which they ran on beside our
//! clock, since until then they may be what they say: samples that come late.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use thenar_core::model::Side;

/// A time that is no older than this is one of our clock \[ns\].
const BELIEVED: i128 = 250_000_000;
/// Times of the past must run on for so long to be another clock's \[ns\] ...
const PROVEN_NS: u64 = 500_000_000;
/// ... with no more unevenness than this \[ns\]. Late samples that come in a burst are more uneven.
const UNEVEN: i128 = 100_000_000;

/// Follows the times of a tracker, and keeps for a person that its clock has jumped.
#[derive(Clone, Debug, Default)]
pub struct TrackerClock {
    /// Left, right.
    hands: [SampleTimes; 2],
    news: ClockJump,
}

impl TrackerClock {
    /// Returns the tracker's `time_ns`, reported now, on our clock \[ns\]; never later than now.
    pub fn follow(&mut self, side: Side, now_ns: u64, time_ns: u64) -> u64 {
        let (time_ns, jumped) = self.hands[side as usize].follow(now_ns, time_ns);
        if jumped {
            self.news.0.store(true, Ordering::Relaxed);
        }
        time_ns
    }

    /// Returns the news of the clock, for whoever reports it.
    pub fn news(&self) -> ClockJump {
        self.news.clone()
    }
}

/// Set while a jump of the clock waits to be reported.
#[derive(Clone, Debug, Default)]
pub struct ClockJump(Arc<AtomicBool>);

impl ClockJump {
    /// A message about the tracker called `who`, once.
    pub fn take(&self, who: &str) -> Option<String> {
        let text = || format!("the clock of {who} has jumped; it is followed");
        self.0.swap(false, Ordering::Relaxed).then(text)
    }
}

/// The times of one hand.
#[derive(Clone, Copy, Debug, Default)]
struct SampleTimes {
    /// The tracker's time of the sample before, and the time made of it \[ns\].
    last: Option<[u64; 2]>,
    /// Ours minus its \[ns\]; 0 when it is on our clock.
    offset: i128,
    /// A run of times of the past: ours minus its, and since when \[ns\].
    past: Option<(i128, u64)>,
}

impl SampleTimes {
    fn follow(&mut self, now_ns: u64, time_ns: u64) -> (u64, bool) {
        // The same sample again is as old as it was.
        if let Some([_, became]) = self.last.filter(|[last, _]| *last == time_ns) {
            return (became.min(now_ns), false);
        }
        let difference = i128::from(now_ns) - i128::from(time_ns);
        let before = self.offset;
        let believed = |offset: &i128| (0..=BELIEVED).contains(&(difference - offset));
        let ahead = || (difference < before).then_some(difference);
        let offset = [0, before].into_iter().find(believed).or_else(ahead);
        if let Some(offset) = offset.or_else(|| self.ran_on(now_ns, time_ns, difference)) {
            (self.offset, self.past) = (offset, None);
        }
        // Else it is as old as it says.
        let became = (i128::from(time_ns) + self.offset).clamp(0, i128::from(now_ns)) as u64;
        self.last = Some([time_ns, became]);
        (became, (self.offset - before).abs() > BELIEVED)
    }

    /// The offset of another clock, when times of the past have run on for long enough.
    fn ran_on(&mut self, now_ns: u64, time_ns: u64, difference: i128) -> Option<i128> {
        let goes_on = self.last.is_none_or(|[last, _]| time_ns > last);
        let even = |(was, _): &(i128, u64)| goes_on && (difference - was).abs() <= UNEVEN;
        let (was, since) = self.past.filter(even).unwrap_or((difference, now_ns));
        self.past = Some((was, since));
        (now_ns.saturating_sub(since) >= PROVEN_NS).then_some(difference)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;
    const DAY: i64 = 86_400_000_000_000;

    /// Ages \[ms\] of samples every 10 ms that tell `tells(k)`, and the numbers of those that
    /// jumped.
    fn ages(n: u64, tells: impl Fn(u64, u64) -> u64) -> (Vec<u64>, Vec<u64>) {
        let (mut times, mut jumps) = (SampleTimes::default(), Vec::new());
        let mut age = |k| {
            let now = 2 * DAY as u64 + 10 * MS * k;
            let (time, jumped) = times.follow(now, tells(k, now));
            jumps.extend(jumped.then_some(k));
            (now - time) / MS
        };
        let ages = (0..n).map(&mut age).collect();
        (ages, jumps)
    }

    #[test]
    fn times_of_our_clock_stay_as_they_are() {
        let (ages, jumps) = ages(1000, |k, now| now - (k * 7 % 250) * MS);
        assert!((0..1000).all(|k| ages[k as usize] == k * 7 % 250) && jumps.is_empty());
    }

    /// Ahead at once, back after half a second, and home again at once; for good or once.
    #[test]
    fn a_clock_that_jumps_is_followed() {
        for (shift, late) in
            [(DAY, 0), (-DAY, 50), (2_000 * MS as i64, 0), (-2_000 * MS as i64, 50)]
        {
            for home in [300, u64::MAX] {
                let away = |k: u64| (100..home).contains(&k);
                let (ages, jumps) =
                    ages(500, |k, now| now.saturating_add_signed(if away(k) { shift } else { 0 }));
                for (k, age) in ages.iter().enumerate() {
                    let k = k as u64;
                    let held = away(k) && k < 100 + late;
                    assert_eq!(*age > 0, held, "{shift} {k}: {age} ms");
                }
                let back = (home < 500).then_some(home);
                assert_eq!(
                    jumps,
                    [Some(100 + late), back].into_iter().flatten().collect::<Vec<_>>()
                );
            }
        }
    }

    /// From one wrong clock to another: nothing is lost on the way ahead, half a second on the way
    /// back.
    #[test]
    fn jumps_between_wrong_clocks_are_followed() {
        let shifts = [-DAY, DAY, 0, DAY, -DAY / 2, -DAY, 0];
        let (ages, jumps) =
            ages(1400, |k, now| now.saturating_add_signed(shifts[k as usize / 200]));
        assert_eq!(jumps, [50, 200, 400, 600, 850, 1050, 1200]);
        for (k, age) in ages.iter().enumerate() {
            let held = [0..50, 800..850, 1000..1050].iter().any(|run| run.contains(&k));
            assert_eq!(*age > 0, held, "{k}: {age}");
        }
    }

    /// A sample that is reported again and again is never fresh, whatever clock it is of; nor are
    /// late ones that come in a burst.
    #[test]
    fn what_is_old_stays_old() {
        for told in [2 * DAY as u64 + 1000 * MS, DAY as u64, 4 * DAY as u64] {
            let (ages, jumps) = ages(1000, |k, now| if k < 100 { now } else { told });
            let since =
                |k: u64| if told == DAY as u64 { DAY as u64 / MS + 10 * k } else { 10 * (k - 100) };
            assert!((100..1000).all(|k| ages[k as usize] == since(k)), "{told}");
            assert_eq!(jumps.len(), usize::from(told == 4 * DAY as u64));
        }
        // Stalled for 5 s, then 500 samples at four times the speed.
        let (ages, jumps) = ages(170, |k, now| now - (5000 - 30 * k.min(166)) * MS);
        assert!((0..150).all(|k| ages[k as usize] == 5000 - 30 * k) && jumps.is_empty());
    }

    #[test]
    fn no_number_breaks_it() {
        let mut times = SampleTimes::default();
        let odd = [0, 1, u64::MAX, 1 << 63, 7 * MS, u64::MAX - 1];
        for now in odd {
            for time in odd {
                assert!(times.follow(now, time).0 <= now);
            }
        }
    }
}
