//! The delay from a wearer's motion to the force that answers it, and how stiff a hand may then be
//! felt.
//!
//! A spring that acts late by t_d takes `K t_d` off the damping of whoever holds it, at the low
//! frequencies at which a hand sways. Gil et al. 2009: it oscillates by itself above
//! `K = b / (T/2 + t_d)`, with b the damping of hand and device and T the period of the loop. A
//! grip may be loose, so the rule is kept for an assumed least one.

use crate::{LoopProfile, TrackerTiming};

/// Damping of a loosely held finger or hand \[N s/m\]: fingers resting on a handle have some 1 to 5
/// (Hajian and Howe 1997), and the least of it is assumed.
pub const GRIP: f64 = 1.0;
/// Part of what the rule allows that is used: the rest is what a disturbance dies out by.
pub const MARGIN: f64 = 0.85;

/// Follows how often samples of a tracker, or frames, come and how old they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct DelayMeter {
    /// A pause is the delay of what comes after it.
    pauses_count: bool,
    /// Mean time between samples, and their mean age on arrival \[s\].
    means: Option<[f64; 2]>,
    last_ns: Option<u64>,
}

/// Time in which a sample loses its weight in the means \[s\], at any rate: 50 samples at 90 Hz, 14
/// frames at 25 Hz.
const FORGETS: f64 = 0.55;
/// Least weight of a value that is worse than the mean: four in a row weigh three quarters.
const AT_ONCE: f64 = 0.3;
/// Samples farther apart are not of one motion \[s\]. Frames are, but longer pauses count as this
/// one: what is felt behind them is next to nothing.
const PAUSE: f64 = 0.2;

impl DelayMeter {
    /// A meter of frames, which are waited for however late they are.
    pub fn of_frames() -> Self {
        Self { pauses_count: true, ..Self::default() }
    }

    /// Takes in a sample measured at `time_ns` that arrived at `now_ns`.
    pub fn take(&mut self, time_ns: u64, now_ns: u64) {
        let seconds = |from: u64, to: u64| to.saturating_sub(from) as f64 * 1e-9;
        let Some(last_ns) = self.last_ns.replace(time_ns) else { return };
        let (gap, age) = (seconds(last_ns, time_ns), seconds(time_ns, now_ns));
        if gap <= 0.0 || !self.pauses_count && (gap > PAUSE || age > PAUSE) {
            return;
        }
        let newest = [gap, age].map(|x| x.min(PAUSE));
        let means = self.means.get_or_insert(newest);
        let weight = 1.0 - (-gap / FORGETS).exp();
        for (mean, newest) in means.iter_mut().zip(newest) {
            // What is worse counts at once, as far as it is no single late one.
            let weight = if newest > *mean { weight.max(AT_ONCE) } else { weight };
            *mean += weight * (newest - *mean);
        }
    }

    /// Mean time between samples and mean age on arrival \[s\], once there were two.
    pub fn seen(&self) -> Option<[f64; 2]> {
        self.means
    }

    /// The worse of what is stated and what is seen; what is no number is as late as can be.
    /// Samples whose device tells no time seem to be of the present, and one that states nothing is
    /// taken as it seems.
    pub fn delay(&self, stated: Option<&TrackerTiming>) -> f64 {
        let seen = self.means.map_or(0.0, |[gap, age]| age + 0.5 * gap);
        let stated = stated.map_or(0.0, TrackerTiming::delay);
        if stated.is_nan() { f64::INFINITY } else { stated.max(seen) }
    }
}

impl LoopProfile {
    /// A loop with so much more delay \[s\], of a tracker or of frames, and else the same.
    pub fn later(&self, delay: f64) -> Self {
        Self { delay: self.delay + delay, ..*self }
    }

    /// Stiffness that a hand of this damping \[N s/m\] may be shown, by Gil's rule \[N/m\].
    pub fn felt_stiffness_max(&self, grip: f64) -> f64 {
        grip / (0.5 * self.period + self.delay)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOOP: LoopProfile = LoopProfile {
        period: 1e-3,
        delay: 0.0,
        damping: 0.0,
        friction: 0.0,
        resolution: 0.0,
        rated_stiffness: f64::INFINITY,
    };

    /// 1 N s/m over 50 ms and half a millisecond: 19.8 N/m.
    #[test]
    fn the_rule_is_gils() {
        let late = LoopProfile { delay: 0.05, ..LOOP };
        assert!((late.felt_stiffness_max(1.0) - 1.0 / 0.0505).abs() < 1e-12);
        let behind = late.later(TrackerTiming::HEADSET.delay());
        let delay = 0.05 + 0.045 + 1.0 / 180.0;
        assert!((behind.delay - delay).abs() < 1e-15);
    }

    /// Frames that go from 100 to 25 and to 4 Hz, a period old, are noticed within half a second,
    /// or four of them, those of 4 Hz as the latest that the meter knows apart; from the start as
    /// well. A tracker's pauses are passed over.
    #[test]
    fn frames_that_become_late_are_told_soon() {
        for from in [100_u64, 25, 4] {
            for to in [25_u64, 4] {
                let mut meter = DelayMeter::of_frames();
                let (mut now, mut told) = (0, 0.0);
                for (rate, seconds) in [(from, 2), (to, 1)] {
                    let period = 1_000_000_000 / rate;
                    let late = rate == to && seconds == 1;
                    let end =
                        now + if late { (4 * period).max(500_000_000) } else { 2_000_000_000 };
                    while now < end {
                        meter.take(now, now + period);
                        now += period;
                    }
                    told = meter.delay(None);
                }
                let wanted = 1.5 * (1.0 / to as f64).min(PAUSE);
                assert!(told > 0.8 * wanted, "{from} to {to} Hz: {told} of {wanted} s");
            }
        }
        let mut tracker = DelayMeter::default();
        (0..3).for_each(|k| tracker.take(k * 300_000_000, k * 300_000_000));
        assert_eq!(tracker.seen(), None);
    }

    /// Samples at 60 Hz, 40 ms old: half a period more. A tracker that states less is not believed,
    /// one that states more is.
    #[test]
    fn what_is_seen_counts_beside_what_is_stated() {
        let mut meter = DelayMeter::default();
        assert_eq!(meter.delay(None), 0.0);
        for k in 0..200_u64 {
            let time_ns = k * 1_000_000_000 / 60;
            meter.take(time_ns, time_ns + 40_000_000);
        }
        let seen = 0.04 + 0.5 / 60.0;
        assert!((meter.delay(None) - seen).abs() < 1e-6);
        let stated = TrackerTiming { rate: 120.0, latency: 0.0, noise: 0.0 };
        assert!((meter.delay(Some(&stated)) - seen).abs() < 1e-6);
        assert_eq!(meter.delay(Some(&TrackerTiming::HEADSET)), TrackerTiming::HEADSET.delay());
        // A pause says nothing.
        meter.take(9_000_000_000, 9_040_000_000);
        assert!((meter.delay(None) - seen).abs() < 1e-6);
    }
}
