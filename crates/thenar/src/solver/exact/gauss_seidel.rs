//! Contact impulses by block Gauss-Seidel: each contact in turn gets the impulse that satisfies the
//! contact law given all others.

use crate::math::{Mat3, Vec3};
use crate::model::Cone;
use crate::solver::friction_cone::{is_immovable, project};

/// Alternations between normal and tangential part within one visit of a sliding contact.
const ALTERNATIONS: usize = 4;
/// Bisections and Newton steps that find the impulse on the rim of the friction disc.
const RIM_STEPS: usize = 30;

/// How one contact answers its own impulse, prepared for many visits.
#[derive(Clone, Copy, Debug, Default)]
pub struct Response {
    /// The response, symmetric \[1/kg\].
    pub W: Mat3,
    /// Its inverse, where it has one.
    pub inverse: Option<Mat3>,
    /// Eigenvalues of its tangential part, the larger first.
    high: f64,
    low: f64,
    /// Direction of the larger one.
    cos: f64,
    sin: f64,
}

impl Response {
    /// Prepares visits.
    pub fn new(W: &Mat3) -> Self {
        let (mean, half) = (0.5 * (W.m22 + W.m33), 0.5 * (W.m22 - W.m33));
        let spread = half.hypot(W.m23);
        let (sin, cos) = (0.5 * W.m23.atan2(half)).sin_cos();
        let (high, low) = (mean + spread, (mean - spread).max(0.0));
        Self { W: *W, inverse: W.try_inverse(), high, low, cos, sin }
    }

    /// The impulse λ so that `d = b + W λ` obeys the contact law: `0 ≤ λ_n ⊥ d_n ≥ 0`,
    /// `|λ_t| ≤ μ λ_n`, and on the rim of that disc λ_t opposes d_t. Exact when the contact opens or
    /// sticks; a sliding one comes nearer with each visit.
    pub fn impulse(&self, cone: Cone, friction: f64, b: &Vec3, start: &Vec3) -> Vec3 {
        let W = &self.W;
        if is_immovable(W) || b.x >= 0.0 {
            return Vec3::zeros();
        }
        if cone == Cone::Linearised {
            let mut lambda = *start;
            for _ in 0..ALTERNATIONS {
                lambda = project(cone, friction, W, &(b + W * lambda), &lambda);
            }
            return lambda;
        }
        if let Some(inverse) = &self.inverse {
            let stick = -(inverse * b);
            let bound = friction * stick.x;
            if stick.x >= 0.0 && stick.y * stick.y + stick.z * stick.z <= bound * bound {
                return stick;
            }
        }
        let mut t = [start.y, start.z];
        let mut normal = 0.0;
        for _ in 0..ALTERNATIONS {
            normal = (-(b.x + W.m12 * t[0] + W.m13 * t[1]) / W.m11).max(0.0);
            let pull = [b.y + W.m21 * normal, b.z + W.m31 * normal];
            t = self.in_disc(pull, friction * normal);
        }
        Vec3::new(normal, t[0], t[1])
    }

    /// The t in the disc of this radius with the least `½ tᵀ W t + c·t`.
    fn in_disc(&self, c: [f64; 2], radius: f64) -> [f64; 2] {
        let size = (c[0] * c[0] + c[1] * c[1]).sqrt();
        if radius <= 0.0 || size == 0.0 {
            return [0.0; 2];
        }
        // In the axes of W.
        let Self { high, low, cos, sin, .. } = *self;
        let (p, q) = (c[0] * cos + c[1] * sin, c[1] * cos - c[0] * sin);
        let back = |p: f64, q: f64| [p * cos - q * sin, p * sin + q * cos];
        if low > 0.0 && (p / high).powi(2) + (q / low).powi(2) <= radius * radius {
            return back(-p / high, -q / low);
        }
        // On the rim: (W + s) t = -c. The length of t falls with s, and s lies between these.
        let (mut least, mut most) =
            ((size / radius - high).max(0.0), (size / radius - low).max(0.0));
        let mut s = most;
        for _ in 0..RIM_STEPS {
            let (a, b) = (p / (high + s), q / (low + s));
            let length = (a * a + b * b).sqrt();
            if (length - radius).abs() <= 1e-13 * radius {
                break;
            }
            *(if length > radius { &mut least } else { &mut most }) = s;
            // Newton on 1/|t| - 1/radius, which is nearly a straight line.
            let slope = (a * a / (high + s) + b * b / (low + s)) / length.powi(3);
            let next = s - (1.0 / length - 1.0 / radius) / slope;
            s = if next > least && next < most { next } else { 0.5 * (least + most) };
        }
        back(-p / (high + s), -q / (low + s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    fn responses(random: &mut Random) -> (Mat3, Vec3, f64) {
        let a = Mat3::from_fn(|_, _| random.range(-1.0, 1.0));
        (a * a.transpose() + Mat3::identity() * 0.3, random.vec3(1.0), random.range(0.05, 1.0))
    }

    #[test]
    fn visits_end_at_coulombs_law() {
        let mut random = Random::new(17);
        let (mut stuck, mut slid) = (0, 0);
        for _ in 0..500 {
            let (W, b, mu) = responses(&mut random);
            let mut lambda = Vec3::zeros();
            let response = Response::new(&W);
            for _ in 0..200 {
                lambda = response.impulse(Cone::Circular, mu, &b, &lambda);
            }
            let d = b + W * lambda;
            assert!(lambda.x >= 0.0 && d.x > -1e-9 && (lambda.x * d.x).abs() < 1e-9);
            let (t, slide) = (lambda.yz(), d.yz());
            assert!(t.norm() <= mu * lambda.x + 1e-12);
            if lambda.x > 0.0 && t.norm() < mu * lambda.x - 1e-9 {
                assert!(slide.norm() < 1e-9, "sticks yet slides at {slide}");
                stuck += 1;
            } else if lambda.x > 0.0 {
                let along = t.dot(&slide) + t.norm() * slide.norm();
                assert!(along.abs() < 1e-9, "friction must oppose sliding: {along}");
                slid += 1;
            }
        }
        assert!(stuck > 10 && slid > 50, "{stuck} stuck, {slid} slid");
    }

    /// No other point of the disc has less energy.
    #[test]
    fn the_disc_minimum_is_least() {
        let mut random = Random::new(18);
        for _ in 0..200 {
            let (W, c, radius) = responses(&mut random);
            let energy = |t: [f64; 2]| {
                0.5 * (W.m22 * t[0] * t[0] + 2.0 * W.m23 * t[0] * t[1] + W.m33 * t[1] * t[1])
                    + c.y * t[0]
                    + c.z * t[1]
            };
            let found = Response::new(&W).in_disc([c.y, c.z], radius);
            assert!(found[0].hypot(found[1]) <= radius * (1.0 + 1e-9));
            for k in 0..360 {
                let (sin, cos) = f64::from(k).to_radians().sin_cos();
                for r in [0.3, 0.7, 1.0] {
                    let other = [radius * r * cos, radius * r * sin];
                    assert!(energy(found) <= energy(other) + 1e-12);
                }
            }
        }
    }
}
