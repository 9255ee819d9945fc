//! A causal low-pass filter with a bounded speed, for numbers, points and rotations.
//!
//! Two stages. The *limiter* lets the held input `u` move towards the raw input at a bounded
//! speed, so that a teleport becomes a fast walk. The *filter* is the critically damped
//! `ẍ = ω²(u - x) - 2ω ẋ`, solved exactly over a step in which `u` is constant. Its impulse
//! response `ω² t exp(-ωt)` is never negative and has area 1: the output is a weighted mean of past
//! inputs, hence never overshoots, never leaves the inputs' range and never exceeds the limiter's
//! speed. It follows a ramp 2/ω seconds late.

use thenar_core::math::skew;
use thenar_core::{Mat3, Quat, Vec3};

/// Distance from the input and its rate after `dt`, for a critically damped filter at natural
/// frequency `omega` \[rad/s\] whose input stands still.
pub fn relax<T>(omega: f64, dt: f64, offset: T, rate: T) -> [T; 2]
where
    T: Copy
        + std::ops::Add<Output = T>
        + std::ops::Sub<Output = T>
        + std::ops::Mul<f64, Output = T>,
{
    let decay = (-omega * dt).exp();
    let slope = rate + offset * omega;
    [(offset + slope * dt) * decay, (rate - slope * (omega * dt)) * decay]
}

/// A filtered number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scalar {
    input: f64,
    value: f64,
    rate: f64,
}

impl Scalar {
    /// Still at `value`.
    pub fn still(value: f64) -> Self {
        Self { input: value, value, rate: 0.0 }
    }

    /// Lets the input go towards `raw`, at most `step` far; returns what is left to go.
    pub fn aim(&mut self, raw: f64, step: f64) -> f64 {
        let left = raw - self.input;
        self.input += left.clamp(-step, step);
        (left.abs() - step).max(0.0)
    }

    /// Value and rate `dt` \[s\] later.
    pub fn after(&self, omega: f64, dt: f64) -> [f64; 2] {
        let [offset, rate] = relax(omega, dt, self.value - self.input, self.rate);
        [self.input + offset, rate]
    }

    /// Goes there.
    pub fn advance(&mut self, omega: f64, dt: f64) {
        [self.value, self.rate] = self.after(omega, dt);
    }
}

/// A filtered point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilteredPoint {
    input: Vec3,
    value: Vec3,
    rate: Vec3,
}

impl FilteredPoint {
    /// Still at `value`.
    pub fn still(value: Vec3) -> Self {
        Self { input: value, value, rate: Vec3::zeros() }
    }

    /// Lets the input go towards `raw`, at most `step` \[m\] far; returns what is left to go.
    pub fn aim(&mut self, raw: Vec3, step: f64) -> f64 {
        let left = raw - self.input;
        let distance = left.norm();
        self.input = if distance <= step { raw } else { self.input + left * (step / distance) };
        (distance - step).max(0.0)
    }

    /// Value and rate `dt` \[s\] later.
    pub fn after(&self, omega: f64, dt: f64) -> [Vec3; 2] {
        let [offset, rate] = relax(omega, dt, self.value - self.input, self.rate);
        [self.input + offset, rate]
    }

    /// Goes there.
    pub fn advance(&mut self, omega: f64, dt: f64) {
        [self.value, self.rate] = self.after(omega, dt);
    }
}

/// A filtered rotation: the filter acts on the rotation vector from input to output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    input: Quat,
    value: Quat,
    /// Angular velocity, world \[rad/s\].
    spin: Vec3,
}

impl Rotation {
    /// Still at `value`.
    pub fn still(value: Quat) -> Self {
        Self { input: value, value, spin: Vec3::zeros() }
    }

    /// Turns the input towards `raw` by the shorter way, at most `step` \[rad\] far; returns what
    /// is left to turn.
    pub fn aim(&mut self, raw: Quat, step: f64) -> f64 {
        let left = (raw * self.input.inverse()).scaled_axis();
        let angle = left.norm();
        self.input = if angle <= step {
            raw
        } else {
            Quat::new_normalize(
                (Quat::from_scaled_axis(left * (step / angle)) * self.input).into_inner(),
            )
        };
        (angle - step).max(0.0)
    }

    /// Rotation and angular velocity (world \[rad/s\]) `dt` \[s\] later.
    pub fn after(&self, omega: f64, dt: f64) -> (Quat, Vec3) {
        let e = (self.input.inverse() * self.value).scaled_axis();
        let e_rate = left_jacobian_inverse(&e) * (self.input.inverse() * self.spin);
        let [e, e_rate] = relax(omega, dt, e, e_rate);
        let value = self.input * Quat::from_scaled_axis(e);
        (value, self.input * (left_jacobian(&e) * e_rate))
    }

    /// Goes there.
    pub fn advance(&mut self, omega: f64, dt: f64) {
        let (value, spin) = self.after(omega, dt);
        self.value = Quat::new_normalize(value.into_inner());
        self.spin = spin;
    }
}

/// `J(e)` with angular velocity = `J(e) ė` when the rotation is `exp(e)`.
pub fn left_jacobian(e: &Vec3) -> Mat3 {
    let (angle2, E) = (e.norm_squared(), skew(e));
    let angle = angle2.sqrt();
    let (b, c) = if angle < 1e-4 {
        (0.5 - angle2 / 24.0, 1.0 / 6.0 - angle2 / 120.0)
    } else {
        ((1.0 - angle.cos()) / angle2, (angle - angle.sin()) / (angle2 * angle))
    };
    Mat3::identity() + E * b + E * E * c
}

/// Inverse of [`left_jacobian`], for angles below 2π.
pub fn left_jacobian_inverse(e: &Vec3) -> Mat3 {
    let (angle2, E) = (e.norm_squared(), skew(e));
    let angle = angle2.sqrt();
    let c = if angle < 1e-3 {
        1.0 / 12.0 + angle2 / 720.0
    } else {
        let half = 0.5 * angle;
        (1.0 - half * half.cos() / half.sin()) / angle2
    };
    Mat3::identity() - E * 0.5 + E * E * c
}

#[cfg(test)]
mod tests {
    use super::*;

    const OMEGA: f64 = 50.0;
    const DT: f64 = 1e-3;

    #[test]
    fn a_step_follows_the_closed_form() {
        let mut filter = Scalar::still(0.0);
        filter.aim(1.0, 10.0);
        for k in 1..200 {
            filter.advance(OMEGA, DT);
            let t = f64::from(k) * DT;
            let want = 1.0 - (1.0 + OMEGA * t) * (-OMEGA * t).exp();
            assert!((filter.after(OMEGA, 0.0)[0] - want).abs() < 1e-12);
        }
    }

    #[test]
    fn a_ramp_is_followed_two_over_omega_late() {
        let mut filter = Scalar::still(0.0);
        for k in 0..2000 {
            // The input holds the ramp's value in the middle of the step.
            filter.aim((f64::from(k) + 0.5) * DT, 1.0);
            filter.advance(OMEGA, DT);
        }
        let [value, rate] = filter.after(OMEGA, 0.0);
        // Holding over a step lets the rate ripple by (ω dt)²/8 of its height, 3e-4.
        assert!((2.0 - value - 2.0 / OMEGA).abs() < 2e-5, "{value}");
        assert!((rate - 1.0).abs() < 1e-3, "{rate}");
    }

    #[test]
    fn a_jump_never_exceeds_the_speed_limit_nor_overshoots() {
        let mut point = FilteredPoint::still(Vec3::zeros());
        let goal = Vec3::new(0.3, -0.4, 1.2);
        let mut last = Vec3::zeros();
        for _ in 0..2000 {
            point.aim(goal, 2.0 * DT);
            let [before, _] = point.after(OMEGA, 0.0);
            point.advance(OMEGA, DT);
            let [value, rate] = point.after(OMEGA, 0.0);
            assert!(rate.norm() <= 2.0 + 1e-12 && (value - before).norm() <= 2.0 * DT + 1e-12);
            assert!((goal - value).norm() <= (goal - last).norm() + 1e-12);
            last = value;
        }
        assert!((goal - last).norm() < 1e-9);
    }

    #[test]
    fn a_rotation_about_one_axis_is_filtered_as_its_angle() {
        let axis = Vec3::new(2.0, -1.0, 2.0) / 3.0;
        let mut scalar = Scalar::still(0.0);
        let mut rotation = Rotation::still(Quat::identity());
        for k in 0..400 {
            let raw = 1.4 * (f64::from(k) * 0.02).sin();
            scalar.aim(raw, 0.05);
            rotation.aim(Quat::from_scaled_axis(axis * raw), 0.05);
            scalar.advance(OMEGA, DT);
            rotation.advance(OMEGA, DT);
            let [angle, rate] = scalar.after(OMEGA, 0.0);
            let (value, spin) = rotation.after(OMEGA, 0.0);
            assert!((value.scaled_axis() - axis * angle).norm() < 1e-9);
            assert!((spin - axis * rate).norm() < 1e-7);
        }
    }

    #[test]
    fn spin_is_the_derivative_of_the_rotation() {
        let mut rotation = Rotation::still(Quat::from_scaled_axis(Vec3::new(0.4, 2.0, -1.0)));
        for k in 0..300 {
            let t = f64::from(k) * 0.01;
            let raw = Vec3::new(t.sin() * 2.0, (1.7 * t).cos(), 2.0 * t);
            rotation.aim(Quat::from_scaled_axis(raw), 0.03);
            let h = 1e-6;
            for at in [1e-5, 4e-4, 9.9e-4] {
                let turned =
                    rotation.after(OMEGA, at + h).0 * rotation.after(OMEGA, at - h).0.inverse();
                let numeric = turned.scaled_axis() / (2.0 * h);
                assert!((numeric - rotation.after(OMEGA, at).1).norm() < 1e-6);
            }
            // No jump where steps meet.
            let (_, before) = rotation.after(OMEGA, DT);
            rotation.advance(OMEGA, DT);
            assert!((rotation.after(OMEGA, 0.0).1 - before).norm() < 1e-9);
        }
    }
}
