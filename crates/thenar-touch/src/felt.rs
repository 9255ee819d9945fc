//! Stiffness with which a hand is felt: that of its couplings, and no more than the delay of this
//! tracker, these frames and this display allows in a loose grip.

use crate::{DelayMeter, LoopProfile, MARGIN, Observation, TrackerTiming};
use thenar_track::live::FeltSpring;

/// Rate at which the felt stiffness grows when delays shrink, per second: it doubles within a
/// second.
const GROWS: f64 = 0.7;
/// Rate at which the felt stiffness falls when delays grow, per second: it halves within a quarter
/// of a second.
const FALLS: f64 = 2.8;

/// Time constants with which the tracker's known noise follows more of it and less \[s\]: memory
/// wavers from sample to sample, and a loose hand responds to it within a tenth of a second.
const NOISE: [f64; 2] = [0.1, 0.5];

/// Growth begins at so much \[N/m\], which the rule allows a loose grip behind almost a second:
/// from nothing it would never begin.
const LEAST: f64 = 1.0;

/// Bounds on the stiffness that is felt.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FeltBounds {
    /// Damping of the loosest grip \[N s/m\]; `None` bounds nothing.
    pub grip: Option<f64>,
    /// The loop and the slowest of its displays.
    pub profile: LoopProfile,
    /// Observation between the tracker's samples and the hand.
    pub observation: Observation,
    /// Displays that only hold a finger, which no stiffness is felt of.
    pub holds_only: bool,
}

/// Stiffness that one hand is felt with, by what its trackers and its frames do.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct FeltStiffness {
    bounds: FeltBounds,
    /// Stiffness felt of each blocked bone through its couplings alone \[N/m\].
    couplings: Vec<f64>,
    meter: DelayMeter,
    stated: Option<TrackerTiming>,
    /// Recent noise of the tracker: see [`Observation::noisy`].
    noisy: f64,
    /// Delay that observation and frames add for each bone \[s\].
    added: Vec<f64>,
    /// The present tracker was heard, and what is felt follows it from there.
    heard: bool,
    /// Stiffness that may be felt \[N/m\]; infinite before the first sample.
    most: Vec<f64>,
    /// Spring of the bone that would be felt stiffest if the tracker had no noise.
    spring: FeltSpring,
}

impl FeltStiffness {
    /// A hand whose tracker is not known yet.
    pub fn new(bounds: FeltBounds, couplings: Vec<f64>) -> Self {
        let (meter, stated) = Default::default();
        let (added, most) = (vec![0.0; couplings.len()], vec![f64::INFINITY; couplings.len()]);
        Self {
            bounds,
            couplings,
            meter,
            stated,
            noisy: 0.0,
            added,
            heard: false,
            most,
            spring: FeltSpring::default(),
        }
    }

    /// A sample measured at `time_ns` came at `now_ns`, from a tracker that states this of itself.
    pub fn hear(&mut self, time_ns: u64, now_ns: u64, stated: Option<TrackerTiming>) {
        self.meter.take(time_ns, now_ns);
        self.stated = stated;
    }

    /// Another tracker moves the hand.
    pub fn forget(&mut self) {
        (self.meter, self.heard, self.noisy) = (DelayMeter::default(), false, 0.0);
    }

    /// Returns the delay until the wearer's motion is seen and answered by an output \[s\].
    /// Observers make up for what they add where hands sway slowly, but not for what noise does.
    pub fn seen_late(&self) -> f64 {
        let delay = self.meter.delay(self.stated.as_ref());
        let noise = self.noisy * self.bounds.observation.noisy;
        self.bounds.profile.delay + delay + noise
    }

    /// From motion to the force on a bone, observation and frames included \[s\].
    pub fn delay(&self, bone: usize) -> f64 {
        self.profile(bone).delay
    }

    fn profile(&self, bone: usize) -> LoopProfile {
        let added = self.added.get(bone).copied().unwrap_or(0.0);
        self.bounds.profile.later(self.meter.delay(self.stated.as_ref()) + added)
    }

    /// Goes on by `h` \[s\] with a hand that is seen this `noisy` (1 remembered for 50 ms): what
    /// may be felt follows the delay, without a step. `added` is what frames add to each bone's on
    /// top of, or instead of, what observation adds \[s\]: see
    /// [`Touch::added_delay`](crate::Touch::added_delay).
    pub fn step(&mut self, h: f64, noisy: f64, added: impl Fn(usize, f64) -> f64) {
        let within = NOISE[usize::from(noisy < self.noisy)];
        self.noisy += (1.0 - (-h / within).exp()) * (noisy - self.noisy);
        let delay = self.meter.delay(self.stated.as_ref());
        let observed = self.bounds.observation.adds(delay, self.noisy);
        let without_noise = self.bounds.observation.adds(delay, 0.0);
        self.spring = FeltSpring::default();
        let (grows, falls) = ((GROWS * h).exp(), (-FALLS * h).exp());
        for bone in 0..self.couplings.len() {
            if !self.bounds.holds_only {
                let LoopProfile { period, delay: own, .. } = self.bounds.profile;
                let spring = FeltSpring {
                    coupling: self.couplings[bone],
                    damping: self.bounds.grip.map_or(f64::INFINITY, |grip| MARGIN * grip),
                    delay: 0.5 * period + own + delay + added(bone, without_noise),
                };
                if spring.quiet() > self.spring.quiet() {
                    self.spring = spring;
                }
            }
            self.added[bone] = added(bone, observed);
            let Some(grip) = self.bounds.grip else { continue };
            let bound = MARGIN * self.profile(bone).felt_stiffness_max(grip);
            // A delay that is no number bears nothing, until there is one.
            let bound = if bound.is_nan() { 0.0 } else { bound };
            let most = self.most[bone];
            self.most[bone] = if self.heard && most.is_finite() {
                bound.clamp(most * falls, (most * grows).max(LEAST))
            } else {
                bound
            };
        }
        self.heard |= self.stated.is_some() || self.meter != DelayMeter::default();
    }

    /// Returns the spring of the bone that would be felt stiffest, blocked, if the tracker had no
    /// noise.
    pub fn spring(&self) -> FeltSpring {
        self.spring
    }

    /// Part of a bone's force that is felt.
    pub fn part(&self, bone: usize) -> f64 {
        let coupling = self.couplings.get(bone).copied().unwrap_or(0.0);
        let most = self.most.get(bone).copied().unwrap_or(f64::INFINITY);
        if coupling > most { most / coupling } else { 1.0 }
    }

    /// Stiffness of a bone, blocked, as it is felt \[N/m\].
    pub fn stiffness(&self, bone: usize) -> f64 {
        let most = self.most.get(bone).copied().unwrap_or(f64::INFINITY);
        self.couplings.get(bone).copied().unwrap_or(0.0).min(most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds(grip: Option<f64>) -> FeltBounds {
        let [delay, damping, friction, resolution] = [0.0; 4];
        let rated_stiffness = f64::INFINITY;
        let profile =
            LoopProfile { period: 1e-3, delay, damping, friction, resolution, rated_stiffness };
        FeltBounds {
            grip,
            profile,
            observation: Observation { adds: 0.01, makes_up: 0.3, noisy: 0.03 },
            holds_only: false,
        }
    }

    /// 90 Hz and 40 ms late: within 80 and 100 % of `b / (T/2 + t_d)` with all of the delay, and
    /// softer couplings as they are. A tracker that becomes faster is felt stiffer little by
    /// little.
    #[test]
    fn stiffness_is_cut_to_the_rule() {
        let mut felt = FeltStiffness::new(bounds(Some(1.0)), vec![400.0, 3.0]);
        for k in 0..300_u64 {
            let time_ns = k * 1_000_000_000 / 90;
            felt.hear(time_ns, time_ns + 40_000_000, None);
            (0..11).for_each(|_| felt.step(1e-3, 0.0, |_, observed| observed + 6e-3));
        }
        // Observation makes up for so late a tracker, and adds nothing.
        let delay = 0.04 + 0.5 / 90.0 + 6e-3;
        assert!((felt.delay(0) - delay).abs() < 1e-5);
        let rule = 1.0 / (0.5e-3 + delay);
        assert!((0.8 * rule..=rule).contains(&felt.stiffness(0)), "{} N/m", felt.stiffness(0));
        assert!((felt.part(0) * 400.0 - felt.stiffness(0)).abs() < 1e-9);
        assert_eq!((felt.part(1), felt.stiffness(1)), (1.0, 3.0));
        let mut before = felt.part(0);
        for k in 0..6000_u64 {
            let time_ns = 9_000_000_000 + k * 1_000_000;
            felt.hear(time_ns, time_ns, None);
            felt.step(1e-3, 0.0, |_, observed| observed + 6e-3);
            assert!(felt.part(0) - before <= 1e-3 * felt.part(0));
            before = felt.part(0);
        }
        assert!(felt.stiffness(0) > 2.0 * rule);
        // To one at once nearly all of its 10 ms.
        assert!((felt.delay(0) - 0.5e-3 - (0.01 - 0.3 * 0.5e-3) - 6e-3).abs() < 1e-5);
        let mut all = FeltStiffness::new(bounds(None), vec![400.0]);
        all.hear(0, 40_000_000, Some(TrackerTiming::HEADSET));
        all.step(1e-3, 0.0, |_, _| 0.1);
        assert_eq!(all.part(0), 1.0);
    }

    /// The guards' account meets motion as it is seen with what was sent: frames and observation
    /// are in the delay that bounds stiffness, and not in that.
    #[test]
    fn guards_do_not_reckon_with_frames() {
        let mut felt = FeltStiffness::new(bounds(Some(1.0)), vec![400.0]);
        felt.hear(0, 0, Some(TrackerTiming { rate: 100.0, latency: 0.01, noise: 0.0 }));
        felt.step(1e-3, 0.0, |_, observed| observed + 0.05);
        assert!((felt.seen_late() - 0.015).abs() < 1e-12, "{} s", felt.seen_late());
        assert!((felt.delay(0) - (0.015 + 0.01 - 0.3 * 0.015 + 0.05)).abs() < 1e-12);
    }

    /// Nobody was tracked for a while: what is felt begins as the first tracker's delay has it, not
    /// from what no delay would allow; and likewise for the next tracker of the hand.
    #[test]
    fn what_is_felt_begins_with_the_trackers_delay() {
        let mut felt = FeltStiffness::new(bounds(Some(1.0)), vec![400.0]);
        (0..500).for_each(|_| felt.step(1e-3, 0.0, |_, _| 6e-3));
        for timing in [TrackerTiming::HEADSET, TrackerTiming::GLOVE, TrackerTiming::HEADSET] {
            felt.forget();
            felt.hear(0, 0, Some(timing));
            felt.step(1e-3, 0.0, |_, _| 6e-3);
            let most = MARGIN / (0.5e-3 + timing.delay() + 6e-3);
            assert!((felt.stiffness(0) - most).abs() < 1e-9, "{} of {most} N/m", felt.stiffness(0));
        }
    }

    /// A profile that states no number for a delay, or for a rate, is felt with nothing.
    #[test]
    fn a_delay_that_is_no_number_bears_nothing() {
        let mut bounds = bounds(Some(1.0));
        let mut felt = FeltStiffness::new(bounds, vec![400.0]);
        felt.hear(0, 0, Some(TrackerTiming { rate: 0.0, latency: 0.0, noise: 0.0 }));
        felt.step(1e-3, 0.0, |_, _| 6e-3);
        assert_eq!(felt.part(0), 0.0);
        // Once there is a delay, it is felt again.
        felt.hear(10_000_000, 10_000_000, Some(TrackerTiming::GLOVE));
        (0..6000).for_each(|_| felt.step(1e-3, 0.0, |_, _| 6e-3));
        let most = MARGIN / (0.5e-3 + TrackerTiming::GLOVE.delay() + 6e-3);
        assert!((felt.stiffness(0) / most - 1.0).abs() < 1e-9, "{} N/m", felt.stiffness(0));
        bounds.profile.delay = f64::NAN;
        let mut felt = FeltStiffness::new(bounds, vec![400.0]);
        felt.hear(0, 0, Some(TrackerTiming::GLOVE));
        felt.step(1e-3, 0.0, |_, _| 6e-3);
        assert_eq!(felt.part(0), 0.0);
        let nonsense = TrackerTiming { latency: f64::NAN, ..TrackerTiming::GLOVE };
        assert_eq!(DelayMeter::default().delay(Some(&nonsense)), f64::INFINITY);
    }

    /// A simulation that falls from 100 to 20 frames a second is felt as much softer within half a
    /// second, and each bone by its own delay.
    #[test]
    fn frames_that_become_late_are_felt_softer_at_once() {
        let mut felt = FeltStiffness::new(bounds(Some(1.0)), vec![400.0, 400.0]);
        let late = |bone: usize, slow: bool| [6e-3, 0.1][usize::from(slow)] * [1.0, 2.0][bone];
        felt.hear(0, 0, Some(TrackerTiming { rate: 100.0, latency: 0.0, noise: 0.0 }));
        (0..100).for_each(|_| felt.step(1e-3, 0.0, |bone, _| late(bone, false)));
        let most = |delay: f64| MARGIN / (0.5e-3 + 5e-3 + delay);
        assert!((felt.stiffness(0) - most(6e-3)).abs() < 1e-9);
        assert!((felt.stiffness(1) - most(12e-3)).abs() < 1e-9);
        for _ in 0..800 {
            let before = felt.stiffness(0);
            felt.step(1e-3, 0.0, |bone, _| late(bone, true));
            assert!(felt.stiffness(0) >= before * (1.0 - 3e-3), "a step from {before} N/m");
        }
        assert!((felt.stiffness(0) - most(0.1)).abs() < 1e-9, "{} N/m", felt.stiffness(0));
        assert!((felt.delay(1) - 0.205).abs() < 1e-12);
    }

    /// Noise that begins is felt softer within half a second, and the guards' account reckons with
    /// what it delays; once it is gone, what is felt grows again.
    #[test]
    fn noise_is_felt_softer() {
        let mut felt = FeltStiffness::new(bounds(Some(1.0)), vec![400.0]);
        felt.hear(0, 0, Some(TrackerTiming { rate: 100.0, latency: 0.0, noise: 0.0 }));
        (0..100).for_each(|_| felt.step(1e-3, 0.0, |_, observed| observed));
        let most = |delay: f64| MARGIN / (0.5e-3 + delay);
        assert!((felt.stiffness(0) - most(0.0135)).abs() < 1e-9, "{} N/m", felt.stiffness(0));
        assert!((felt.seen_late() - 0.005).abs() < 1e-12);
        for _ in 0..600 {
            let before = felt.stiffness(0);
            felt.step(1e-3, 1.0, |_, observed| observed);
            assert!(felt.stiffness(0) >= before * (1.0 - 3e-3), "a step from {before} N/m");
        }
        assert!((felt.stiffness(0) / most(0.035) - 1.0).abs() < 0.01, "{} N/m", felt.stiffness(0));
        assert!((felt.seen_late() - 0.035).abs() < 2e-4, "{} s", felt.seen_late());
        (0..5000).for_each(|_| felt.step(1e-3, 0.0, |_, observed| observed));
        assert!((felt.stiffness(0) / most(0.0135) - 1.0).abs() < 0.01, "{} N/m", felt.stiffness(0));
    }
}
