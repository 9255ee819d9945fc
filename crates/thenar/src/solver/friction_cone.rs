//! The contact law at one point: `λ_n ≥ 0`, `d_n ≥ 0`, `λ_n d_n = 0`, and Coulomb friction.

use crate::math::{Mat3, Vec3};
use crate::model::Cone;

/// One projected Gauss-Seidel update of the impulse `lambda` = (normal, two tangents) of a point
/// whose constraint value is `d` and whose own response is `W` (d changes by `W Δλ`).
///
/// At a fixed point the normal impulse is complementary to `d_n`; the tangential one lies in
/// the disc of radius `μ λ_n` (or, linearised, in its inscribing square), and where it lies on
/// the rim, sliding opposes it.
pub fn project(cone: Cone, friction: f64, W: &Mat3, d: &Vec3, lambda: &Vec3) -> Vec3 {
    let normal = (lambda.x - d.x / W.m11).max(0.0);
    let bound = friction * normal;
    if bound == 0.0 {
        return Vec3::new(normal, 0.0, 0.0);
    }
    let dn = normal - lambda.x;
    let slide = [d.y + W.m21 * dn, d.z + W.m31 * dn];
    match cone {
        Cone::Circular => {
            // Larger eigenvalue of the tangential block: the step that surely does not overshoot.
            let mean = 0.5 * (W.m22 + W.m33);
            let stiff = mean + (0.25 * (W.m22 - W.m33).powi(2) + W.m23 * W.m32).sqrt();
            let t = [lambda.y - slide[0] / stiff, lambda.z - slide[1] / stiff];
            let length = t[0].hypot(t[1]);
            let scale = if length > bound { bound / length } else { 1.0 };
            Vec3::new(normal, t[0] * scale, t[1] * scale)
        }
        Cone::Linearised => {
            let t1 = (lambda.y - slide[0] / W.m22).clamp(-bound, bound);
            let slide2 = slide[1] + W.m32 * (t1 - lambda.y);
            let t2 = (lambda.z - slide2 / W.m33).clamp(-bound, bound);
            Vec3::new(normal, t1, t2)
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
}
