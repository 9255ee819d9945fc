//! Turns as rotation vectors, nearly all of them small; those of all bones at once are in
//! `lanes`.

use thenar_core::math::{Quat, Vec3};

/// Squared sine of half the angle up to which the series is used: 3.6 degrees.
const SMALL: f64 = 1e-3;

/// The rotation vector of a rotation \[rad\], the shorter way round:
/// [`thenar_core::math::rotation_vector`] to round-off. Of small turns by the series of
/// `2 asin(s)/s` in s², without a root and an arc tangent.
pub(crate) fn rotation_vector(q: &Quat) -> Vec3 {
    let v = q.imag();
    let s2 = v.norm_squared();
    if s2 < SMALL && q.w.abs() > 0.5 {
        let half =
            1.0 + s2 * (1.0 / 6.0 + s2 * (3.0 / 40.0 + s2 * (5.0 / 112.0 + s2 * (35.0 / 1152.0))));
        return v * (2.0 * half).copysign(q.w);
    }
    thenar_core::math::rotation_vector(q)
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_core::math::rotation_vector as exact;
    use thenar_core::random::Random;

    /// About any axis, by angles from nothing to half a turn, on both sides of where the series
    /// ends, and with either sign of the quaternion: the vector that made the rotation.
    #[test]
    fn turns_are_those_that_made_them() {
        let mut random = Random::new(5);
        let end = 2.0 * SMALL.sqrt().asin();
        let angles = [0.0, 1e-12, 1e-4, 0.01, end - 1e-9, end + 1e-9, 0.5, 3.1];
        for angle in angles {
            for _ in 0..50 {
                let vector = random.vector(1.0).normalize() * angle;
                let q = Quat::from_scaled_axis(vector);
                for q in [q, Quat::new_unchecked(-q.into_inner())] {
                    let got = rotation_vector(&q);
                    assert!(
                        (got - vector).norm() <= 2e-15 * (angle + angle.powi(2)),
                        "{angle}: {got}"
                    );
                    assert!((got - exact(&q)).norm() <= 2e-15 * angle, "{angle}: {got}");
                }
            }
        }
    }
}
