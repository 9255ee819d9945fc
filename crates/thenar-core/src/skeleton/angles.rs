//! One joint: from angles to the rotation `R_JK` and back.
//!
//! Half-angle algebra makes the way back exact. With `q = (w, x, y, z)` the quaternion of `R_JK`,
//! the quaternion of `Ry(a) Rx(b)` is
//!
//! ```text
//! ( cos a/2 cos b/2,  cos a/2 sin b/2,  sin a/2 cos b/2,  -sin a/2 sin b/2 )
//! ```
//!
//! so its product with `q` is `uᵀ M v` with `u = (cos a/2, sin a/2)`, `v = (cos b/2, sin b/2)` and
//! `M = [w x; y -z]`: the nearest universal rotation is the leading singular pair of a 2×2 matrix.

use crate::math::{Quat, Vec3};
use crate::model::{AngleLimit, JointKind};
use std::f64::consts::{PI, TAU};

/// Rotation `R_JK` at these angles \[rad\]; see [`JointKind`] for their meaning. Joints without
/// angles are at rest.
pub fn joint_rotation(kind: JointKind, q: [f64; 2]) -> Quat {
    match kind {
        JointKind::Hinge => Quat::from_axis_angle(&Vec3::x_axis(), q[0]),
        JointKind::Universal => {
            Quat::from_axis_angle(&Vec3::y_axis(), q[0])
                * Quat::from_axis_angle(&Vec3::x_axis(), q[1])
        }
        JointKind::Fixed | JointKind::Ball | JointKind::Free => Quat::identity(),
    }
}

/// Angular velocity of K against J, in J \[rad/s\], at angles `q` \[rad\] and rates \[rad/s\].
pub fn joint_spin(kind: JointKind, q: [f64; 2], rates: [f64; 2]) -> Vec3 {
    match kind {
        JointKind::Hinge => Vec3::new(rates[0], 0.0, 0.0),
        JointKind::Universal => {
            let (sin, cos) = q[0].sin_cos();
            Vec3::new(rates[1] * cos, rates[0], -rates[1] * sin)
        }
        JointKind::Fixed | JointKind::Ball | JointKind::Free => Vec3::zeros(),
    }
}

/// `R_JK` after a joint has turned for `h` \[s\] by the angular velocity of K against J, in J
/// \[rad/s\]: about its own axes alone, each at a constant rate. What of the rotation and of the
/// velocity the joint does not allow is left out.
pub fn turn_joint(kind: JointKind, R_JK: &Quat, spin_J: &Vec3, h: f64) -> Quat {
    let q = joint_angles(kind, R_JK);
    let (sin, cos) = q[0].sin_cos();
    match kind {
        JointKind::Hinge => joint_rotation(kind, [q[0] + h * spin_J.x, 0.0]),
        JointKind::Universal => {
            let flexion = cos * spin_J.x - sin * spin_J.z;
            joint_rotation(kind, [q[0] + h * spin_J.y, q[1] + h * flexion])
        }
        JointKind::Fixed => Quat::identity(),
        JointKind::Ball | JointKind::Free => Quat::from_scaled_axis(spin_J * h) * R_JK,
    }
}

/// Angles in (-π, π] whose [`joint_rotation`] is nearest to `R_JK` (smallest remaining rotation);
/// exact when the joint can reach it. Joints without angles give zeros.
pub fn joint_angles(kind: JointKind, R_JK: &Quat) -> [f64; 2] {
    let [w, x, y, z] = parts(R_JK);
    match kind {
        JointKind::Hinge => [wrap(2.0 * x.atan2(w)), 0.0],
        JointKind::Universal => {
            let sum = (x + y).atan2(w + z);
            let difference = (y - x).atan2(w - z);
            [wrap(sum + difference), wrap(sum - difference)]
        }
        JointKind::Fixed | JointKind::Ball | JointKind::Free => [0.0; 2],
    }
}

/// Like [`joint_angles`], among the angles within `limits` (`None`: unlimited).
pub fn closest_angles(kind: JointKind, R_JK: &Quat, limits: &[Option<AngleLimit>; 2]) -> [f64; 2] {
    let free = joint_angles(kind, R_JK);
    match kind {
        JointKind::Hinge => [closest_on_circle(free[0], &limits[0]), 0.0],
        JointKind::Universal => closest_universal(R_JK, free, limits),
        JointKind::Fixed | JointKind::Ball | JointKind::Free => free,
    }
}

/// The best point of a box of angles: the free optimum when inside, else the best of the edges,
/// along each of which the optimum is known.
fn closest_universal(R_JK: &Quat, free: [f64; 2], limits: &[Option<AngleLimit>; 2]) -> [f64; 2] {
    if admits(&limits[0], free[0]) && admits(&limits[1], free[1]) {
        return free;
    }
    let [w, x, y, z] = parts(R_JK);
    let clamped = [closest_on_circle(free[0], &limits[0]), closest_on_circle(free[1], &limits[1])];
    let mut best = (f64::NEG_INFINITY, clamped);
    let mut offer = |q: [f64; 2]| {
        let fit = fit_of(&[w, x, y, z], q);
        if fit > best.0 {
            best = (fit, q);
        }
    };
    offer(clamped);
    for a in edges(&limits[0]) {
        let (s, c) = (0.5 * a).sin_cos();
        let b = wrap(2.0 * (c * x - s * z).atan2(c * w + s * y));
        offer([a, closest_on_circle(b, &limits[1])]);
    }
    for b in edges(&limits[1]) {
        let (s, c) = (0.5 * b).sin_cos();
        let a = wrap(2.0 * (c * y - s * z).atan2(c * w + s * x));
        offer([closest_on_circle(a, &limits[0]), b]);
    }
    best.1
}

/// Cosine of half the rotation left between `R_JK` and the joint at angles `q`.
fn fit_of(parts: &[f64; 4], q: [f64; 2]) -> f64 {
    let [w, x, y, z] = parts;
    let ((sa, ca), (sb, cb)) = ((0.5 * q[0]).sin_cos(), (0.5 * q[1]).sin_cos());
    (w * ca * cb + x * ca * sb + y * sa * cb - z * sa * sb).abs()
}

fn parts(q: &Quat) -> [f64; 4] {
    [q.w, q.i, q.j, q.k]
}

fn edges(limit: &Option<AngleLimit>) -> impl Iterator<Item = f64> {
    limit.iter().flat_map(|l| [l.min, l.max])
}

fn admits(limit: &Option<AngleLimit>, angle: f64) -> bool {
    limit.is_none_or(|l| l.min <= angle && angle <= l.max)
}

/// The admissible angle with the shortest way round the circle.
fn closest_on_circle(angle: f64, limit: &Option<AngleLimit>) -> f64 {
    let Some(l) = limit else { return angle };
    // An angle that lies inside one turn further is the same rotation.
    for turn in [0.0, TAU, -TAU] {
        if admits(limit, angle + turn) {
            return angle + turn;
        }
    }
    if wrap(angle - l.min).abs() <= wrap(angle - l.max).abs() { l.min } else { l.max }
}

/// Turns an angle by whole turns into (-π, π] \[rad\].
fn wrap(angle: f64) -> f64 {
    let turned = angle - TAU * (angle / TAU).round();
    if turned <= -PI { turned + TAU } else { turned }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn limit(min: f64, max: f64) -> Option<AngleLimit> {
        Some(AngleLimit { min, max })
    }

    #[test]
    fn angles_come_back_from_the_rotation_they_make() {
        let mut noise = Random::new(1);
        for _ in 0..2000 {
            // Flexion within ±90° as in fingers; a full turn of the first axis.
            let q = [3.1 * noise.symmetric(), 1.5 * noise.symmetric()];
            for kind in [JointKind::Hinge, JointKind::Universal] {
                let back = joint_angles(kind, &joint_rotation(kind, q));
                for k in 0..kind.angles() {
                    assert!((back[k] - q[k]).abs() < 1e-12, "{kind:?} {q:?} {back:?}");
                }
            }
        }
    }

    #[test]
    fn the_universal_rotation_is_about_parent_y_then_child_x() {
        let (a, b) = (0.3_f64, 0.7_f64);
        let turned = joint_rotation(JointKind::Universal, [a, b]) * -Vec3::z();
        // Rx lifts -z by b towards +y, Ry then swings it about y.
        let want = Vec3::new(-a.sin() * b.cos(), b.sin(), -a.cos() * b.cos());
        assert!((turned - want).norm() < 1e-14);
    }

    #[test]
    fn no_other_angles_come_nearer_than_the_closest() {
        let mut noise = Random::new(2);
        for _ in 0..60 {
            let R = noise.pose(1.0).rotation;
            let boxes = [
                [None, None],
                [limit(-0.35, 0.35), limit(-0.8, 1.6)],
                [limit(0.2, 0.5), None],
                [None, limit(-1.6, -0.3)],
            ];
            for limits in boxes {
                for kind in [JointKind::Hinge, JointKind::Universal] {
                    let found = closest_angles(kind, &R, &limits);
                    let left = R.angle_to(&joint_rotation(kind, found));
                    for k in 0..kind.angles() {
                        assert!(admits(&limits[k], found[k]));
                    }
                    for i in 0..=90 {
                        for j in 0..=90 {
                            let at = |n: i32, l: &Option<AngleLimit>| {
                                let (lo, hi) = l.map_or((-PI, PI), |l| (l.min, l.max));
                                lo + (hi - lo) * f64::from(n) / 90.0
                            };
                            let tried = [at(i, &limits[0]), at(j, &limits[1])];
                            let other = R.angle_to(&joint_rotation(kind, tried));
                            assert!(left <= other + 1e-9, "{kind:?} {found:?} {tried:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn spin_is_the_derivative_of_the_rotation() {
        let mut noise = Random::new(3);
        let h = 1e-6;
        for _ in 0..200 {
            let q = [2.0 * noise.symmetric(), 2.0 * noise.symmetric()];
            let rates = [5.0 * noise.symmetric(), 5.0 * noise.symmetric()];
            for kind in [JointKind::Hinge, JointKind::Universal, JointKind::Ball] {
                let at = |t: f64| joint_rotation(kind, [q[0] + t * rates[0], q[1] + t * rates[1]]);
                let numeric = (at(h) * at(-h).inverse()).scaled_axis() / (2.0 * h);
                assert!((numeric - joint_spin(kind, q, rates)).norm() < 1e-8);
            }
        }
    }
}
