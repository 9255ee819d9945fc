//! Place and velocity from samples: a critically damped g-h filter (Benedict and Bordner 1962)
//! whose memory follows the noise.
//!
//! Between samples the motion goes on at the velocity found; a sample `r` away from where it was
//! expected moves the place by `g r` and the velocity by `h r / gap`, with `g = 1 - θ²`,
//! `h = (1 - θ)²`, `θ = exp(-gap / memory)`. Steady motion is followed without lag.
//!
//! A filter that remembers as long as it should leaves residuals without memory (Mehra 1970). Where
//! successive ones are unlike, as about a hand that is still and noisy, it remembers longer, as
//! long as noise is felt (`noise.rs`); where they are alike motion runs ahead of it, and it forgets
//! sooner, down to 14 ms, at once when two in a row are large. At 14 ms and 90 Hz white noise is
//! led on at 0.83 of its size (place), at 50 ms at 0.47. At an acceleration `a` the place lags by
//! 8e-5 s² a, the velocity by 0.024 s a.
//!
//! What is remembered long is late, and a spring to it takes that off the damping of whoever holds
//! it. A hand that is still needs no velocity, and without one a filter of the same noise is late
//! by a quarter less: the velocity's gain falls with the square of the memory. (Followed at 16 Hz,
//! 1 mm of white noise at 90 Hz leaves 0.37 mm below and 10 µm above 40 Hz, 44 ms late at the worst
//! sway. With its gain kept and 80 ms of memory it leaves 0.40 mm and 10 µm, 59 ms late.)

use serde::{Deserialize, Serialize};
use thenar_core::{Quat, Vec3};

/// Time in which a sample loses its weight \[s\]: the least, and the most where nothing is felt.
pub const MEMORY: [f64; 2] = [0.0139, 0.05];
/// Weight of the newest residual in the correlation of residuals.
const RESIDUAL_GAIN: f64 = 0.06;
/// Correlation that they may have by chance: 2.3 times the deviation of the mean of white numbers,
/// `√(RESIDUAL_GAIN/(2 - RESIDUAL_GAIN))`; less of what has several.
const CORRELATION_MIN: f64 = 0.4;
/// Rate at which memory shrinks with what is beyond that, per sample.
const SHRINK_RATE: f64 = 1.0;
/// A sample keeps `exp(-1.2)` of its weight until the next at least: slow trackers are noisier.
const FADE_MAX: f64 = 1.2;

/// Gains for a time between samples \[s\].
#[derive(Clone, Copy, Debug)]
struct Gains {
    place: f64,
    /// Over the gap \[1/s\]; zero when the gap is not known.
    rate: f64,
}

impl Gains {
    /// Gains after `gap` \[s\]; without one the velocity is left as it is.
    fn after(gap: Option<f64>, memory: f64) -> Self {
        let fade = (-(gap.unwrap_or(0.011) / memory).min(FADE_MAX)).exp();
        let still = (MEMORY[0] / memory) * (MEMORY[0] / memory);
        let rate = gap.map_or(0.0, |gap| still * (1.0 - fade) * (1.0 - fade) / gap);
        Self { place: 1.0 - fade * fade, rate }
    }
}

/// Likeness of successive residuals, and the memory that goes with it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scatter<T> {
    before: T,
    /// Mean product of successive residuals, and mean square.
    alike: f64,
    square: f64,
    memory: f64,
}

impl<T: Linear> Scatter<T> {
    fn new(none: T) -> Self {
        Self { before: none, alike: 0.0, square: 0.0, memory: MEMORY[0] }
    }

    /// The gains for this residual; memory follows what it tells, up to `longest` \[s\].
    fn gains(&mut self, residual: T, gap: Option<f64>, longest: f64) -> Gains {
        let (square, product) = (residual.dot(&residual), residual.dot(&self.before));
        let both = residual + self.before;
        let is_large = both.dot(&both) > 2.0 * T::MOTION * self.square;
        if is_large && product > 0.0 && self.before.dot(&self.before) > self.square {
            self.memory = MEMORY[0];
        }
        let gains = Gains::after(gap, self.memory);
        self.alike += RESIDUAL_GAIN * (product - self.alike);
        self.square += RESIDUAL_GAIN * (square - self.square);
        self.before = residual;
        if self.square > 0.0 {
            let alike = (self.alike / self.square).clamp(-1.0, 1.0);
            let shrinks = SHRINK_RATE * (CORRELATION_MIN / T::AXES.sqrt() - alike).min(0.0);
            // It grows, and comes down to what is less noisy, as fast as residuals are forgotten.
            let nears = (longest / self.memory).ln().clamp(-RESIDUAL_GAIN, RESIDUAL_GAIN);
            let change = if shrinks < 0.0 { shrinks.min(nears) } else { nears };
            self.memory = (self.memory * change.exp()).max(MEMORY[0]);
        }
        gains
    }

    /// Mean square of the noise of samples: residuals are beyond it by what memory leads on, and
    /// by motion, which makes successive ones alike.
    fn noise_square(&self, gap: f64) -> f64 {
        let unlike = (self.square - self.alike.max(0.0)).max(0.0);
        (1.0 - 0.5 * Gains::after(Some(gap), self.memory).place) * unlike
    }

    fn quiet(&self) -> f64 {
        MEMORY[0] / self.memory
    }

    fn noisy(&self, least: f64) -> f64 {
        let square = self.square.max(0.0);
        longer(self.memory) * square / (square + least * least)
    }
}

/// Part of the delay of a memory of 50 ms that this one \[s\] has: 0 for the least, and more than 1
/// beyond.
pub fn longer(memory: f64) -> f64 {
    let [least, most] = MEMORY;
    // What is remembered for M is late by half of it.
    let still_longer = 0.5 * (memory - most).max(0.0) / super::OBSERVATION.noisy;
    (memory.min(most) - least) / (most - least) + still_longer
}

/// Quantity that can be added and scaled: a number or a vector.
pub trait Linear:
    Copy
    + std::ops::Add<Output = Self>
    + std::ops::Sub<Output = Self>
    + std::ops::Mul<f64, Output = Self>
{
    /// Number of its components.
    const AXES: f64;
    /// Two white residuals in a row exceed the usual square, on the mean of these numbers, by this
    /// factor once in two million samples (χ² of 25 and of 31.8). What is usual is known to a
    /// quarter.
    const MOTION: f64;
    /// Absolute value or length.
    fn size(&self) -> f64;
    /// Product along another.
    fn dot(&self, other: &Self) -> f64;
}

impl Linear for f64 {
    const AXES: f64 = 1.0;
    const MOTION: f64 = 25.0;

    fn size(&self) -> f64 {
        self.abs()
    }

    fn dot(&self, other: &Self) -> f64 {
        self * other
    }
}

impl Linear for Vec3 {
    const AXES: f64 = 3.0;
    const MOTION: f64 = 31.8 / 3.0;

    fn size(&self) -> f64 {
        self.norm()
    }

    fn dot(&self, other: &Self) -> f64 {
        Vec3::dot(self, other)
    }
}

/// No longer than `most`.
pub fn bounded<T: Linear>(v: T, most: f64) -> T {
    let size = v.size();
    if size <= most { v } else { v * (most / size) }
}

/// A place and its velocity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Observed<T> {
    /// At the last sample.
    pub place: T,
    /// Per second.
    pub rate: T,
    scatter: Scatter<T>,
}

impl<T: Linear> Observed<T> {
    /// At rest.
    pub fn at(place: T) -> Self {
        let none = place * 0.0;
        Self { place, rate: none, scatter: Scatter::new(none) }
    }

    /// Returns how far a sample is from where it was expected, `gap` \[s\] after the last.
    pub fn surprise(&self, sample: T, gap: Option<f64>) -> f64 {
        (sample - self.ahead(gap.unwrap_or(0.0))).size()
    }

    /// Takes in a sample, `gap` \[s\] after the last; the velocity stays below `rate_max`, and
    /// noise is remembered for `longest` \[s\] at most.
    pub fn take(&mut self, sample: T, gap: Option<f64>, rate_max: f64, longest: f64) {
        let expected = self.ahead(gap.unwrap_or(0.0));
        let residual = sample - expected;
        let gains = self.scatter.gains(residual, gap, longest);
        self.place = expected + residual * gains.place;
        self.rate = bounded(self.rate + residual * gains.rate, rate_max);
    }

    /// Mean square of its samples' noise, `gap` \[s\] apart.
    pub fn noise_square(&self, gap: f64) -> f64 {
        self.scatter.noise_square(gap)
    }

    /// Returns how quiet its samples are: 1 where they are as sure as motion, less where noise is
    /// remembered longer.
    pub fn quiet(&self) -> f64 {
        self.scatter.quiet()
    }

    /// Returns how long its samples are remembered for their noise: 0 as motion is, 1 for 50 ms,
    /// and more in proportion to the delay beyond; next to 0 where residuals are below `least`,
    /// such as round-off: what sways by more than noise is soon remembered no longer than motion
    /// is.
    pub fn noisy(&self, least: f64) -> f64 {
        self.scatter.noisy(least)
    }

    /// Place `ahead` seconds later.
    pub fn ahead(&self, ahead: f64) -> T {
        self.place + self.rate * ahead
    }
}

/// An observer of a rotation: residuals are rotation vectors in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObservedRotation {
    /// At the last sample.
    pub place: Quat,
    /// Angular velocity, world \[rad/s\].
    pub rate: Vec3,
    scatter: Scatter<Vec3>,
}

impl ObservedRotation {
    /// At rest.
    pub fn at(place: Quat) -> Self {
        Self { place, rate: Vec3::zeros(), scatter: Scatter::new(Vec3::zeros()) }
    }

    fn residual(&self, sample: &Quat, gap: Option<f64>) -> (Quat, Vec3) {
        let expected = self.ahead(gap.unwrap_or(0.0));
        (expected, (sample * expected.inverse()).scaled_axis())
    }

    /// Returns how far a sample is from where it was expected \[rad\], `gap` \[s\] after the last.
    pub fn surprise(&self, sample: &Quat, gap: Option<f64>) -> f64 {
        self.residual(sample, gap).1.norm()
    }

    /// Takes in a sample: see [`Observed::take`].
    pub fn take(&mut self, sample: &Quat, gap: Option<f64>, rate_max: f64, longest: f64) {
        let (expected, residual) = self.residual(sample, gap);
        let gains = self.scatter.gains(residual, gap, longest);
        let turned = Quat::from_scaled_axis(residual * gains.place) * expected;
        self.place = Quat::new_normalize(turned.into_inner());
        self.rate = bounded(self.rate + residual * gains.rate, rate_max);
    }

    /// Mean square of its samples' noise: see [`Observed::noise_square`].
    pub fn noise_square(&self, gap: f64) -> f64 {
        self.scatter.noise_square(gap)
    }

    /// Returns how quiet its samples are: see [`Observed::quiet`].
    pub fn quiet(&self) -> f64 {
        self.scatter.quiet()
    }

    /// Returns how long its samples are remembered: see [`Observed::noisy`].
    pub fn noisy(&self, least: f64) -> f64 {
        self.scatter.noisy(least)
    }

    /// Rotation `ahead` seconds later.
    pub fn ahead(&self, ahead: f64) -> Quat {
        Quat::from_scaled_axis(self.rate * ahead) * self.place
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_core::random::Random;

    const GAP: f64 = 1.0 / 90.0;

    #[test]
    fn steady_motion_is_followed_without_lag() {
        let mut place = Observed::at(0.0);
        let mut turn = ObservedRotation::at(Quat::identity());
        let spin = Vec3::new(1.0, -2.0, 0.5);
        for k in 1..200 {
            let t = f64::from(k) * GAP;
            place.take(1.5 * t, Some(GAP), 4.0, MEMORY[1]);
            turn.take(&Quat::from_scaled_axis(spin * t), Some(GAP), 20.0, MEMORY[1]);
        }
        let t = 199.0 * GAP;
        assert!((place.place - 1.5 * t).abs() < 1e-9 && (place.rate - 1.5).abs() < 1e-7);
        assert!(turn.place.angle_to(&Quat::from_scaled_axis(spin * t)) < 1e-7);
        assert!((turn.rate - spin).norm() < 1e-6);
    }

    #[test]
    fn steady_acceleration_is_followed_by_the_known_lag() {
        // Benedict and Bordner: lag (1 - g)/h × acceleration × gap².
        let gains = Gains::after(Some(GAP), MEMORY[0]);
        let mut place = Observed::at(0.0);
        let at = |k: i32| 0.5 * 10.0 * (f64::from(k) * GAP).powi(2);
        for k in 1..60 {
            place.take(at(k), Some(GAP), 40.0, MEMORY[1]);
        }
        let (g, h) = (gains.place, gains.rate * GAP);
        let want = (1.0 - g) / h * 10.0 * GAP * GAP;
        assert!((at(59) - place.place - want).abs() < 1e-6, "{} {want}", at(59) - place.place);
    }

    #[test]
    fn rounding_to_a_millimetre_is_smoothed() {
        let gains = Gains::after(Some(GAP), MEMORY[0]);
        let mut place = Observed::at(0.0);
        let (mut error, mut rate_error, mut n) = (0.0, 0.0, 0.0);
        for k in 0..20_000 {
            let truth = 0.0137 * f64::from(k) * GAP;
            place.take((truth * 1e3).round() * 1e-3, Some(GAP), 4.0, MEMORY[1]);
            if k > 100 {
                error += (place.place - truth).powi(2);
                rate_error += (place.rate - 0.0137).powi(2);
                n += 1.0;
            }
        }
        // No worse than at the shortest memory; the rounding errors of a slow ramp are not quite
        // white.
        let sample = 1e-3 / 12f64.sqrt();
        let [want, rate_want] = noise(&gains).map(|part| part * sample);
        let (rms, rate_rms) = ((error / n).sqrt(), (rate_error / n).sqrt());
        assert!(rms < 1.35 * want, "{rms} {want}");
        assert!(rate_rms < 1.5 * rate_want && rate_want < 9e-3, "{rate_rms} {rate_want}");
    }

    /// Benedict and Bordner: noise of place and rate over that of white samples. The variances are
    /// (2g² + 2h - 3gh) / (g (4 - 2g - h)) and 2h² / (g gap² (4 - 2g - h)).
    fn noise(gains: &Gains) -> [f64; 2] {
        let (g, h) = (gains.place, gains.rate * GAP);
        let below = g * (4.0 - 2.0 * g - h);
        [((2.0 * g * g + 2.0 * h - 3.0 * g * h) / below).sqrt(), (2.0 * h * h / below).sqrt() / GAP]
    }

    /// About a still hand white noise is remembered for as long as may be, and a reach that then
    /// begins is followed as if there had been none.
    #[test]
    fn memory_follows_noise_and_lets_go_when_it_moves() {
        let most = noise(&Gains::after(Some(GAP), MEMORY[1]));
        let least = noise(&Gains::after(Some(GAP), MEMORY[0]));
        assert!(most[0] < 0.58 * least[0] && most[1] < 0.02 * least[1], "{most:?} {least:?}");
        let mut random = Random::new(7);
        let mut place = Observed::at(0.0);
        let (mut error, mut rate_error, count) = (0.0, 0.0, 4000);
        for k in 0..count + 200 {
            place.take(1e-3 * random.normal(), Some(GAP), 4.0, MEMORY[1]);
            if k >= 200 {
                error += place.place.powi(2) / f64::from(count);
                rate_error += place.rate.powi(2) / f64::from(count);
            }
        }
        let (rms, rate_rms) = (error.sqrt(), rate_error.sqrt());
        // It wavers between its bounds: the mean is nearer to the longer.
        assert!(rms < 0.7e-3 * least[0] && rms > 0.8e-3 * most[0], "{rms} m");
        assert!(rate_rms < 0.5e-3 * least[1], "{rate_rms} m/s");
        // 20 cm in 0.4 s, with the least jerk: never farther off than the shortest memory by more
        // than noise.
        let mut short = Observed::at(place.place);
        let (mut far, mut far_short) = (0.0_f64, 0.0_f64);
        for k in 1..60 {
            let u = (f64::from(k) * GAP / 0.4).min(1.0);
            let truth = 0.2 * u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u);
            let sample = truth + 1e-3 * random.normal();
            place.take(sample, Some(GAP), 4.0, MEMORY[1]);
            short.scatter = Scatter::new(0.0);
            short.take(sample, Some(GAP), 4.0, MEMORY[1]);
            far = far.max((place.place - truth).abs());
            far_short = far_short.max((short.place - truth).abs());
        }
        assert!(far < far_short + 4e-3, "{far} m, {far_short} m");
    }
}
