//! The turning of a rigid body that no torque acts on, gyroscopic effects included.

use crate::math::{Mat3, Quat, Vec3};

/// Advances orientation and angular velocity (world) by `h` with the angular momentum fixed in
/// the world.
///
/// Implicit midpoint on the body-frame momentum Π: `Π₁ - Π₀ = h Π_m × I⁻¹ Π_m`. It keeps |Π| and
/// the kinetic energy exactly (both are quadratic), and turning by the Cayley map of the same
/// midpoint velocity keeps the world momentum `R Π` exactly. A step of the world adds forces and
/// constraints before, so this replaces the term `-ω × I ω` of the Newton-Euler equations (Eq. 1).
pub fn turn_freely(
    rotation: &Quat,
    omega_W: &Vec3,
    inertia_B: &Mat3,
    inverse_inertia_B: &Mat3,
    h: f64,
) -> (Quat, Vec3) {
    let start = inertia_B * rotation.inverse_transform_vector(omega_W);
    let mut mid = start;
    for _ in 0..30 {
        // Newton on f(Π_m) = Π_m - Π₀ - h/2 Π_m × I⁻¹ Π_m.
        let omega = inverse_inertia_B * mid;
        let f = mid - start - mid.cross(&omega) * (0.5 * h);
        let cross = crate::math::skew(&mid) * inverse_inertia_B - crate::math::skew(&omega);
        let Some(inverse) = (Mat3::identity() - cross * (0.5 * h)).try_inverse() else { break };
        let change = inverse * f;
        mid -= change;
        if change.norm_squared() <= 1e-32 * start.norm_squared() {
            break;
        }
    }
    let omega = inverse_inertia_B * mid;
    let half = omega * (0.5 * h);
    let turn = Quat::new_normalize(nalgebra::Quaternion::from_parts(1.0, half));
    let rotation = Quat::new_normalize((rotation * turn).into_inner());
    let end = turn.inverse_transform_vector(&start);
    (rotation, rotation * (inverse_inertia_B * end))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The intermediate axis flips; |L| and T stay (validation A6).
    #[test]
    fn keeps_momentum_and_energy_through_the_flip() {
        let inertia = Mat3::from_diagonal(&Vec3::new(1e-4, 2e-4, 3e-4));
        let inverse = Mat3::from_diagonal(&Vec3::new(1e4, 5e3, 1e4 / 3.0));
        let (mut q, mut w) = (Quat::identity(), Vec3::new(0.01, 10.0, 0.01));
        let momentum = |q: &Quat, w: &Vec3| q * (inertia * q.inverse_transform_vector(w));
        let energy = |q: &Quat, w: &Vec3| momentum(q, w).dot(w);
        let (l0, e0) = (momentum(&q, &w), energy(&q, &w));
        let mut crossings = Vec::new();
        let h = 1e-3;
        for i in 0..10_000 {
            let before = q.inverse_transform_vector(&w).y;
            (q, w) = turn_freely(&q, &w, &inertia, &inverse, h);
            let after = q.inverse_transform_vector(&w).y;
            if before.signum() != after.signum() {
                crossings.push(h * (i as f64 + before / (before - after)));
            }
        }
        assert!((momentum(&q, &w) - l0).norm() < 1e-10 * l0.norm());
        assert!((energy(&q, &w) - e0).abs() < 1e-10 * e0);
        assert!((crossings[0] - 1.490594).abs() < 1e-3, "{crossings:?}");
        assert!((crossings[1] - crossings[0] - 2.753084).abs() < 1e-3, "{crossings:?}");
    }
}
