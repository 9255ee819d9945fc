//! How stiff a hand is felt: as its couplings are, and no stiffer than the delay of this tracker and this display
//! bears in a loose grip.

use thenar::haptic::{DelayMeter, LoopProfile, MARGIN, TrackerTiming};

/// How fast what is felt of a hand follows its delay, per second: twice as much within a second at most.
const FOLLOWS: f64 = 0.7;

/// What bounds the stiffness that is felt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Damping of the loosest grip \[N s/m\]; `None` bounds nothing.
    pub grip: Option<f64>,
    /// The loop and the slowest of its displays.
    pub profile: LoopProfile,
}

/// Stiffness that one hand is felt with, by what its trackers do.
#[derive(Clone, Debug)]
pub struct Felt {
    bounds: Bounds,
    /// What a blocked bone is felt like through its couplings alone \[N/m\].
    couplings: Vec<f64>,
    meter: DelayMeter,
    stated: Option<TrackerTiming>,
    /// The present tracker was heard, and what is felt follows it from there.
    heard: bool,
    /// Stiffness that may be felt \[N/m\]; infinite before the first sample.
    most: f64,
}

impl Felt {
    /// A hand whose tracker is not known yet.
    pub fn new(bounds: Bounds, couplings: Vec<f64>) -> Self {
        let (meter, stated) = Default::default();
        Self { bounds, couplings, meter, stated, heard: false, most: f64::INFINITY }
    }

    /// A sample measured at `time_ns` came at `now_ns`, from a tracker that states this of itself.
    pub fn hear(&mut self, time_ns: u64, now_ns: u64, stated: Option<TrackerTiming>) {
        self.meter.take(time_ns, now_ns);
        self.stated = stated;
    }

    /// Another tracker moves the hand.
    pub fn forget(&mut self) {
        (self.meter, self.heard) = (DelayMeter::default(), false);
    }

    /// How late the wearer's motion is seen, and answered by what is sent \[s\].
    pub fn seen_late(&self) -> f64 {
        self.bounds.profile.delay + self.meter.delay(self.stated.as_ref())
    }

    /// From motion to force, frames blended in \[s\].
    pub fn delay(&self) -> f64 {
        self.profile().delay
    }

    fn profile(&self) -> LoopProfile {
        self.bounds.profile.behind_tracker(self.meter.delay(self.stated.as_ref()))
    }

    /// Goes on by `h` \[s\]: what may be felt follows the delay, without a step.
    pub fn step(&mut self, h: f64) {
        let Some(grip) = self.bounds.grip else { return };
        let bound = MARGIN * self.profile().felt_stiffness_max(grip);
        let change = (FOLLOWS * h).exp();
        self.most = if self.heard && self.most.is_finite() {
            bound.clamp(self.most / change, self.most * change)
        } else {
            bound
        };
        self.heard |= self.stated.is_some() || self.meter != DelayMeter::default();
    }

    /// Part of a bone's force that is felt.
    pub fn part(&self, bone: usize) -> f64 {
        let coupling = self.couplings.get(bone).copied().unwrap_or(0.0);
        if coupling > self.most { self.most / coupling } else { 1.0 }
    }

    /// Stiffness of a bone, blocked, as it is felt \[N/m\].
    pub fn stiffness(&self, bone: usize) -> f64 {
        self.couplings.get(bone).copied().unwrap_or(0.0).min(self.most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds(grip: Option<f64>) -> Bounds {
        let [delay, damping, friction, resolution] = [0.0; 4];
        let rated_stiffness = f64::INFINITY;
        let profile =
            LoopProfile { period: 1e-3, delay, damping, friction, resolution, rated_stiffness };
        Bounds { grip, profile }
    }

    /// 90 Hz and 40 ms late: within 80 and 100 % of `b / (T/2 + t_d)` with all of the delay, and softer couplings as
    /// they are. A tracker that becomes faster is felt stiffer little by little.
    #[test]
    fn stiffness_is_cut_to_the_rule() {
        let mut felt = Felt::new(bounds(Some(1.0)), vec![400.0, 3.0]);
        for k in 0..300_u64 {
            let time_ns = k * 1_000_000_000 / 90;
            felt.hear(time_ns, time_ns + 40_000_000, None);
            (0..11).for_each(|_| felt.step(1e-3));
        }
        let delay = 0.04 + 0.5 / 90.0 + thenar::haptic::BLEND;
        assert!((felt.delay() - delay).abs() < 1e-5);
        let rule = 1.0 / (0.5e-3 + delay);
        assert!((0.8 * rule..=rule).contains(&felt.stiffness(0)), "{} N/m", felt.stiffness(0));
        assert!((felt.part(0) * 400.0 - felt.stiffness(0)).abs() < 1e-9);
        assert_eq!((felt.part(1), felt.stiffness(1)), (1.0, 3.0));
        let mut before = felt.part(0);
        for k in 0..2000_u64 {
            let time_ns = 9_000_000_000 + k * 1_000_000;
            felt.hear(time_ns, time_ns, None);
            felt.step(1e-3);
            assert!(felt.part(0) - before <= 1e-3 * felt.part(0));
            before = felt.part(0);
        }
        assert!(felt.stiffness(0) > 2.0 * rule);
        let mut all = Felt::new(bounds(None), vec![400.0]);
        all.hear(0, 40_000_000, Some(TrackerTiming::HEADSET));
        all.step(1e-3);
        assert_eq!(all.part(0), 1.0);
    }
}
