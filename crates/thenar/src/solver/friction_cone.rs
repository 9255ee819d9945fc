//! The contact law at one point: `λ_n ≥ 0`, `d_n ≥ 0`, `λ_n d_n = 0`, and Coulomb friction.

use crate::math::{Mat3, Vec3};
use crate::model::Cone;

/// A direction that yields less than this part of the others does not move at all: both sides are
/// held there, and no impulse can do anything.
const IMMOVABLE: f64 = 1e-12;

/// True where neither side can move along the normal.
pub fn is_immovable(W: &Mat3) -> bool {
    W.m11.is_nan() || W.m11 <= IMMOVABLE * W.trace()
}

/// One projected Gauss-Seidel update of the impulse `lambda` = (normal, two tangents) of a point
/// whose constraint value is `d` and whose own response is `W` (d changes by `W Δλ`).
///
/// At a fixed point the normal impulse is complementary to `d_n`; the tangential one lies in
/// the disc of radius `μ λ_n` (or, linearised, in the square inscribed in it, so that friction falls
/// short of Coulomb's by up to 1 - cos 45° and never exceeds it), and where it lies on
/// the rim, sliding opposes it. Where neither side can move, the impulse is zero.
pub fn project(cone: Cone, friction: f64, W: &Mat3, d: &Vec3, lambda: &Vec3) -> Vec3 {
    let least = IMMOVABLE * W.trace();
    if is_immovable(W) {
        return Vec3::zeros();
    }
    let normal = (lambda.x - d.x / W.m11).max(0.0);
    let bound = friction * normal;
    if bound == 0.0 {
        return Vec3::new(normal, 0.0, 0.0);
    }
    let dn = normal - lambda.x;
    let slide = [d.y + W.m21 * dn, d.z + W.m31 * dn];
    let from = |t: f64, slide: f64, stiff: f64| if stiff > least { t - slide / stiff } else { 0.0 };
    match cone {
        Cone::Circular => {
            // Larger eigenvalue of the tangential block: the step that surely does not overshoot.
            let mean = 0.5 * (W.m22 + W.m33);
            let stiff = mean + (0.25 * (W.m22 - W.m33).powi(2) + W.m23 * W.m32).sqrt();
            let t = [from(lambda.y, slide[0], stiff), from(lambda.z, slide[1], stiff)];
            let length = t[0].hypot(t[1]);
            let scale = if length > bound { bound / length } else { 1.0 };
            Vec3::new(normal, t[0] * scale, t[1] * scale)
        }
        Cone::Linearised => {
            let bound = bound * std::f64::consts::FRAC_1_SQRT_2;
            let t1 = from(lambda.y, slide[0], W.m22).max(-bound).min(bound);
            let slide2 = slide[1] + W.m32 * (t1 - lambda.y);
            let t2 = from(lambda.z, slide2, W.m33).max(-bound).min(bound);
            Vec3::new(normal, t1, t2)
        }
    }
}

/// A force on the rim of the cone within this part of its radius slides.
const RIM: f64 = 1e-6;

/// Whether friction gives all it can to a contact that presses, so that it slides (or is about to).
pub fn is_on_rim(cone: Cone, friction: f64, lambda: &Vec3) -> bool {
    let rim = friction * lambda.x * (1.0 - RIM);
    lambda.x > 0.0
        && match cone {
            Cone::Circular => lambda.y.hypot(lambda.z) >= rim,
            Cone::Linearised => {
                lambda.y.abs().max(lambda.z.abs()) >= rim * std::f64::consts::FRAC_1_SQRT_2
            }
        }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    /// Iterates one point to its fixed point and checks the law there.
    #[test]
    fn the_fixed_point_obeys_coulomb() {
        let mut random = Random::new(3);
        for _ in 0..200 {
            let a = Mat3::from_fn(|_, _| random.range(-1.0, 1.0));
            let W = a * a.transpose() + Mat3::identity() * 0.5;
            let free = random.vec3(1.0);
            let mu = random.range(0.1, 1.2);
            let mut lambda = Vec3::zeros();
            for _ in 0..20_000 {
                lambda = project(Cone::Circular, mu, &W, &(free + W * lambda), &lambda);
            }
            let d = free + W * lambda;
            assert!(lambda.x >= 0.0 && d.x > -1e-9 && (lambda.x * d.x).abs() < 1e-9);
            let (t, slide) = (lambda.yz(), d.yz());
            if t.norm() < mu * lambda.x - 1e-9 {
                assert!(slide.norm() < 1e-8, "sticking yet sliding: {slide}");
            } else if lambda.x > 1e-9 {
                let along = t.dot(&slide) + t.norm() * slide.norm();
                assert!(along < 1e-7, "friction must oppose sliding: {along}");
            }
        }
    }

    /// Sliding in any direction, the pyramid of four sides gives between cos 45° and all of
    /// Coulomb's friction.
    #[test]
    fn the_linearised_cone_lies_within_the_circular_one() {
        for k in 0..64 {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 64.0).sin_cos();
            let slide = Vec3::new(-1.0, -10.0 * cos, -10.0 * sin);
            let lambda = project(Cone::Linearised, 0.7, &Mat3::identity(), &slide, &Vec3::zeros());
            let ratio = lambda.yz().norm() / (0.7 * lambda.x);
            let least = std::f64::consts::FRAC_1_SQRT_2;
            assert!((least - 1e-12..=1.0 + 1e-12).contains(&ratio), "direction {k}: {ratio}");
        }
    }
}
