//! Timing of trackers: how late a hand is seen.

/// Timing and noise of a tracker.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TrackerTiming {
    /// Samples per second \[Hz\].
    pub rate: f64,
    /// From a motion to the arrival of the sample that has it \[s\].
    pub latency: f64,
    /// Standard deviation of a place that stands still \[m\].
    pub noise: f64,
}

impl TrackerTiming {
    /// A headset that sees hands by its cameras: 90 Hz and 45 ms (Abdlkarim et al. 2023, Quest 2),
    /// a millimetre of noise.
    pub const HEADSET: Self = Self { rate: 90.0, latency: 0.045, noise: 1e-3 };
    /// A wired glove of bend sensors: 100 Hz, a sample on its way for 10 ms.
    pub const GLOVE: Self = Self { rate: 100.0, latency: 0.01, noise: 1e-4 };

    /// Delay from motion to tracked pose \[s\]: on the way, and half a period until the next.
    pub fn delay(&self) -> f64 {
        self.latency + 0.5 / self.rate
    }
}

/// Delay that observing a tracker's samples adds to theirs, as far as a spring is concerned: the
/// part of its stiffness that it takes off the damping of whoever holds it, `-Im G(ω)/ω` of what is
/// observed over what is there, at the worst ω. Observers carry motion on, which makes up for
/// delay; and they remember noisy samples longer, which is late.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Observation {
    /// Without a delay and without noise \[s\].
    pub adds: f64,
    /// Less of it per second of delay.
    pub makes_up: f64,
    /// Added to samples that are remembered for 50 ms, whatever their delay \[s\].
    pub noisy: f64,
}

impl Observation {
    /// To samples that are late by so much \[s\] and `noisy`: 0 as sure as motion, 1 remembered for
    /// 50 ms, and beyond in proportion.
    pub fn adds(&self, delay: f64, noisy: f64) -> f64 {
        let sure = (self.adds - self.makes_up * delay).max(0.0);
        sure * (1.0 - noisy).max(0.0) + noisy * self.noisy
    }
}
