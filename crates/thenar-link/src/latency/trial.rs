//! Trackers whose delay, rate and noise are known, for tests.

use super::{Trace, TraceSample};
use thenar_core::Vec3;
use thenar_core::random::Random;

/// State of a hand at an instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moment {
    pub flexion: [f64; 5],
    pub wrist: Vec3,
    pub tips: [Vec3; 5],
}

impl Moment {
    /// All fingers bent alike \[rad\].
    pub fn bent(angle: f64) -> Self {
        Self { flexion: [angle; 5], ..Self::default() }
    }
}

/// A tracker.
#[derive(Clone, Copy, Debug)]
pub struct SimulatedTracker {
    /// Samples per second \[Hz\].
    pub rate: f64,
    /// From a motion to the arrival of its sample, on average \[s\].
    pub latency: f64,
    /// Standard deviation of places \[m\].
    pub noise: f64,
    /// Part of the samples that never arrives.
    pub lost: f64,
    /// Samples are early or late by up to this \[s\].
    pub jitter: f64,
}

/// A number that is nearly normal: mean 0, standard deviation 1.
fn normal(random: &mut Random) -> f64 {
    (0..12).map(|_| random.unit()).sum::<f64>() - 6.0
}

impl SimulatedTracker {
    /// Trace that the tracker makes of a motion from 0 on.
    pub fn watch(&self, seed: u64, seconds: f64, motion: &dyn Fn(f64) -> Moment) -> Trace {
        let mut random = Random::new(seed);
        let mut trace = Trace::default();
        // It began at some time of its own.
        let phase = random.unit();
        for k in 0..(seconds * self.rate) as u64 {
            let at = (k as f64 + phase) / self.rate;
            let arrived = at + self.latency + self.jitter * random.symmetric();
            if random.unit() < self.lost || trace.seen.last().is_some_and(|s| s.arrived >= arrived)
            {
                continue;
            }
            let Moment { flexion, wrist, tips } = motion(at);
            let mut off = |lever: f64| self.noise / lever * normal(&mut random);
            let flexion = flexion.map(|angle| angle + off(0.1));
            let mut place = |p: Vec3| p + Vec3::new(off(1.0), off(1.0), off(1.0));
            trace.seen.push(TraceSample {
                arrived,
                flexion,
                wrist: place(wrist),
                tips: tips.map(&mut place),
            });
        }
        trace
    }
}

/// A hand that opens, closes and goes about at no even tempo.
pub fn wander(t: f64) -> Moment {
    let waves = |shift: f64| -> f64 {
        [(0.31, 0.5), (0.53, 0.4), (0.89, 0.3), (1.27, 0.2), (1.71, 0.1)]
            .into_iter()
            .map(|(hz, size): (f64, f64)| {
                size * (std::f64::consts::TAU * hz * t + shift * 7.0 * hz).sin()
            })
            .sum()
    };
    let wrist = Vec3::new(0.15 * waves(1.0), 0.1 * waves(2.0), 0.1 * waves(3.0));
    Moment { flexion: [1.6 * (1.0 + waves(0.0)); 5], wrist, tips: [wrist; 5] }
}

/// A hand held still, which sways by so much \[m\] in so long \[s\].
pub fn still(by: f64, period: f64) -> impl Fn(f64) -> Moment {
    move |t| {
        let place = Vec3::new(0.5 * by * (std::f64::consts::TAU * t / period).sin(), 1.0, 0.0);
        Moment { flexion: [0.3; 5], wrist: place, tips: [place; 5] }
    }
}
