//! Smooth curves through keys, twice continuously differentiable.

use thenar_core::{Quat, Vec3};

/// One number over time.
///
/// Each piece is the quintic with the knots' values and slopes and no acceleration at the knots.
/// Slopes are the harmonic mean of the neighbouring secants [Fritsch and Butland 1984], zero at
/// extrema and at both ends, and at most 1.25 times either secant. That keeps the Bernstein
/// coefficients of every piece's derivative of one sign, so a piece never leaves the range of its
/// two knots.
#[derive(Clone, Debug, Default)]
pub struct ScalarTrack {
    times: Vec<f64>,
    values: Vec<f64>,
    slopes: Vec<f64>,
}

/// Largest slope in units of the flatter secant.
const SLOPE_RATIO_MAX: f64 = 1.25;

impl ScalarTrack {
    /// The curve through `(time, value)`, times strictly increasing; empty is zero.
    pub fn new(keys: &[(f64, f64)]) -> Self {
        let secant = |k: usize| (keys[k + 1].1 - keys[k].1) / (keys[k + 1].0 - keys[k].0);
        let inner = |k: usize| (1..keys.len().saturating_sub(1)).contains(&k);
        let slopes = (0..keys.len())
            .map(|k| if inner(k) { monotone_slope(secant(k - 1), secant(k)) } else { 0.0 })
            .collect();
        let (times, values) = keys.iter().copied().unzip();
        Self { times, values, slopes }
    }

    /// Value and rate at `time`.
    pub fn at(&self, time: f64) -> [f64; 2] {
        match piece(&self.times, time) {
            Piece::Empty => [0.0; 2],
            Piece::Still(k) => [self.values[k], 0.0],
            Piece::Between { from, length, part } => {
                let [v0, v1] = [self.values[from], self.values[from + 1]];
                let [m0, m1] = [self.slopes[from] * length, self.slopes[from + 1] * length];
                let [p, dp] = quintic(v1 - v0, m0, m1, part);
                [v0 + p, dp / length]
            }
        }
    }
}

/// Three numbers over time.
#[derive(Clone, Debug, Default)]
pub struct VectorTrack([ScalarTrack; 3]);

impl VectorTrack {
    /// The curve through `(time, value)`, times strictly increasing.
    pub fn new(keys: &[(f64, Vec3)]) -> Self {
        Self([0, 1, 2].map(|axis| {
            let keys: Vec<_> = keys.iter().map(|(t, v)| (*t, v[axis])).collect();
            ScalarTrack::new(&keys)
        }))
    }

    /// Value and rate at `time`.
    pub fn at(&self, time: f64) -> [Vec3; 2] {
        let [x, y, z] = [0, 1, 2].map(|axis| self.0[axis].at(time));
        [Vec3::new(x[0], y[0], z[0]), Vec3::new(x[1], y[1], z[1])]
    }
}

/// A rotation over time: the shorter great arc between two keys, run through with the
/// minimum-jerk law [Flash and Hogan 1985], so that it stands still for an instant at every key.
#[derive(Clone, Debug, Default)]
pub struct RotationTrack {
    times: Vec<f64>,
    values: Vec<Quat>,
    /// Rotation vector from each key to the next, in the world \[rad\].
    arcs: Vec<Vec3>,
}

impl RotationTrack {
    /// The curve through `(time, rotation)`, times strictly increasing.
    pub fn new(keys: &[(f64, Quat)]) -> Self {
        let (times, values): (Vec<_>, Vec<Quat>) = keys.iter().copied().unzip();
        let arcs = values.windows(2).map(|q| (q[1] * q[0].inverse()).scaled_axis()).collect();
        Self { times, values, arcs }
    }

    /// Rotation and angular velocity in the world at `time`.
    pub fn at(&self, time: f64) -> (Quat, Vec3) {
        match piece(&self.times, time) {
            Piece::Empty => (Quat::identity(), Vec3::zeros()),
            Piece::Still(k) => (self.values[k], Vec3::zeros()),
            Piece::Between { from, length, part } => {
                let [s, ds] = quintic(1.0, 0.0, 0.0, part);
                let arc = self.arcs[from];
                (Quat::from_scaled_axis(arc * s) * self.values[from], arc * (ds / length))
            }
        }
    }
}

/// Value and slope at `s` in 0..1 of the quintic from 0 to `rise` with end slopes `m0`, `m1` and
/// no end accelerations. With zero slopes it is the minimum-jerk law 10s³ - 15s⁴ + 6s⁵.
pub fn quintic(rise: f64, m0: f64, m1: f64, s: f64) -> [f64; 2] {
    let c3 = 10.0 * rise - 6.0 * m0 - 4.0 * m1;
    let c4 = -15.0 * rise + 8.0 * m0 + 7.0 * m1;
    let c5 = 6.0 * rise - 3.0 * m0 - 3.0 * m1;
    let value = s * (m0 + s * s * (c3 + s * (c4 + s * c5)));
    let slope = m0 + s * s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5));
    [value, slope]
}

fn monotone_slope(before: f64, after: f64) -> f64 {
    if before * after <= 0.0 {
        return 0.0;
    }
    let mean = 2.0 * before * after / (before + after);
    let bound = SLOPE_RATIO_MAX * before.abs().min(after.abs());
    mean.clamp(-bound, bound)
}

/// Position of a time among knots.
enum Piece {
    Empty,
    Still(usize),
    Between { from: usize, length: f64, part: f64 },
}

fn piece(times: &[f64], time: f64) -> Piece {
    let after = times.partition_point(|t| *t <= time);
    match after {
        _ if times.is_empty() => Piece::Empty,
        0 => Piece::Still(0),
        k if k == times.len() => Piece::Still(k - 1),
        k => {
            let length = times[k] - times[k - 1];
            Piece::Between { from: k - 1, length, part: (time - times[k - 1]) / length }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEYS: [(f64, f64); 6] =
        [(0.0, 1.0), (0.5, 2.0), (0.7, 2.1), (1.5, 4.0), (2.0, 3.0), (2.1, 3.0)];

    #[test]
    fn the_curve_passes_its_keys_and_stays_between_them() {
        let track = ScalarTrack::new(&KEYS);
        for (time, value) in KEYS {
            assert!((track.at(time)[0] - value).abs() < 1e-14);
        }
        for pair in KEYS.windows(2) {
            let (low, high) = (pair[0].1.min(pair[1].1), pair[0].1.max(pair[1].1));
            for i in 0..=100 {
                let time = pair[0].0 + (pair[1].0 - pair[0].0) * f64::from(i) / 100.0;
                let value = track.at(time)[0];
                assert!(value >= low - 1e-14 && value <= high + 1e-14, "{time} {value}");
            }
        }
    }

    #[test]
    fn rate_is_the_derivative_and_acceleration_is_continuous() {
        let track = ScalarTrack::new(&KEYS);
        let h = 1e-6;
        for i in -100..2300 {
            let time = f64::from(i) * 1e-3 + 0.37e-3;
            let numeric = (track.at(time + h)[0] - track.at(time - h)[0]) / (2.0 * h);
            assert!((numeric - track.at(time)[1]).abs() < 1e-7, "{time}");
        }
        for (time, _) in KEYS {
            let before = (track.at(time)[1] - track.at(time - h)[1]) / h;
            let after = (track.at(time + h)[1] - track.at(time)[1]) / h;
            // The third derivative here is below 1e4, hence 2 h 1e4.
            assert!((before - after).abs() < 2e-2, "{time} {before} {after}");
        }
    }

    #[test]
    fn rest_to_rest_is_the_minimum_jerk_law() {
        let track = ScalarTrack::new(&[(1.0, 0.0), (3.0, 1.0)]);
        // Peak rate 15/8 of the mean, at the middle (Flash and Hogan 1985).
        assert!((track.at(2.0)[0] - 0.5).abs() < 1e-15);
        assert!((track.at(2.0)[1] - 15.0 / 16.0).abs() < 1e-15);
        assert!((track.at(1.5)[0] - 0.103515625).abs() < 1e-15);
    }

    #[test]
    fn rotation_takes_the_shorter_arc_at_its_angular_velocity() {
        let a = Quat::from_scaled_axis(Vec3::new(0.1, 0.2, 0.3));
        let b = Quat::from_scaled_axis(Vec3::new(-1.0, 0.5, 2.0));
        // The other sign of b is the same rotation and must give the same path.
        let minus_b = Quat::new_unchecked(-b.into_inner());
        let track = RotationTrack::new(&[(0.0, a), (1.0, b), (2.0, a)]);
        let other = RotationTrack::new(&[(0.0, a), (1.0, minus_b), (2.0, a)]);
        let mut travelled = 0.0;
        for i in 0..1000 {
            let time = f64::from(i) * 1e-3;
            let (q, _) = track.at(time);
            assert!(q.angle_to(&other.at(time).0) < 1e-7);
            let next = track.at(time + 1e-3).0;
            travelled += q.angle_to(&next);
            let h = 1e-6;
            let turned = track.at(time + h).0 * track.at(time - h).0.inverse();
            let numeric = turned.scaled_axis() / (2.0 * h);
            assert!((numeric - track.at(time).1).norm() < 1e-5, "{time}");
        }
        assert!((travelled - a.angle_to(&b)).abs() < 1e-6);
    }
}
