//! A critically damped follower of a moving goal: continuous in place and velocity, without lag
//! in steady motion, and of bounded speed.
//!
//! Over a step the goal moves at its own velocity, and the distance to it obeys
//! `ë = -ω² e - 2ω ė`, solved exactly. Where that would be too fast the step is cut short.

use super::observer::{Linear, bounded};
use crate::filter::{left_jacobian, left_jacobian_inverse, relax};
use thenar_core::{Quat, Vec3};

/// Law by which the goal is followed.
#[derive(Clone, Copy, Debug)]
pub struct Law {
    /// Natural frequency \[rad/s\].
    pub omega: f64,
    /// Largest speed, per second.
    pub speed: f64,
}

/// Place and velocity after a step of `h` \[s\], at whose end the goal is at `goal` and moves with
/// `goal_rate`.
pub fn follow<T: Linear>(
    [place, rate]: [T; 2],
    [goal, goal_rate]: [T; 2],
    law: Law,
    h: f64,
) -> [T; 2] {
    let offset = place - (goal - goal_rate * h);
    let [offset, offset_rate] = relax(law.omega, h, offset, rate - goal_rate);
    let step = bounded(goal + offset - place, law.speed * h);
    [place + step, bounded(goal_rate + offset_rate, law.speed)]
}

/// Follows a rotation and its angular velocity, world \[rad/s\], as `follow` does a place.
pub fn follow_rotation(
    (place, spin): (Quat, Vec3),
    (goal, goal_spin): (Quat, Vec3),
    law: Law,
    h: f64,
) -> (Quat, Vec3) {
    // The rotation is exp(e) times the goal's.
    let start = Quat::from_scaled_axis(goal_spin * -h) * goal;
    let left = place * start.inverse();
    let e = left.scaled_axis();
    let e_rate = left_jacobian_inverse(&e) * (spin - left * goal_spin);
    let [e, e_rate] = relax(law.omega, h, e, e_rate);
    let left = Quat::from_scaled_axis(e);
    let spin = left_jacobian(&e) * e_rate + left * goal_spin;
    let turn = (left * goal * place.inverse()).scaled_axis();
    let turned = Quat::from_scaled_axis(bounded(turn, law.speed * h)) * place;
    (Quat::new_normalize(turned.into_inner()), bounded(spin, law.speed))
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: f64 = 5e-3;
    const LAW: Law = Law { omega: 90.0, speed: 4.0 };

    #[test]
    fn a_steady_goal_is_met_without_lag() {
        let mut now = [0.0, 0.0];
        for k in 1..100 {
            now = follow(now, [1.2 * f64::from(k) * H, 1.2], LAW, H);
        }
        assert!((now[0] - 1.2 * 99.0 * H).abs() < 1e-12 && (now[1] - 1.2).abs() < 1e-12);
        let spin = Vec3::new(0.0, 3.0, -1.0);
        let mut turned = (Quat::identity(), Vec3::zeros());
        for k in 1..100 {
            let goal = Quat::from_scaled_axis(spin * (f64::from(k) * H));
            turned = follow_rotation(turned, (goal, spin), LAW, H);
        }
        let goal = Quat::from_scaled_axis(spin * (99.0 * H));
        assert!(turned.0.angle_to(&goal) < 1e-7 && (turned.1 - spin).norm() < 1e-9);
    }

    #[test]
    fn a_far_goal_is_reached_at_the_speed_limit_without_overshoot() {
        let mut now = [Vec3::zeros(); 2];
        let goal = Vec3::new(0.6, -0.8, 0.0);
        for _ in 0..200 {
            let next = follow(now, [goal, Vec3::zeros()], LAW, H);
            assert!((next[0] - now[0]).norm() <= LAW.speed * H * (1.0 + 1e-12));
            assert!(next[0].norm() <= 1.0 + 1e-9 && next[0].cross(&goal).norm() < 1e-12);
            now = next;
        }
        assert!((now[0] - goal).norm() < 1e-9);
    }

    #[test]
    fn a_rotation_about_one_axis_is_followed_as_its_angle() {
        let axis = Vec3::new(1.0, 2.0, -2.0) / 3.0;
        let (mut angle, mut turned) =
            ([0.3, 0.0], (Quat::from_scaled_axis(axis * 0.3), Vec3::zeros()));
        for k in 0..300 {
            let t = f64::from(k) * H;
            let (goal, rate) = ((3.0 * t).sin(), 3.0 * (3.0 * t).cos());
            angle = follow(angle, [goal, rate], LAW, H);
            let goal = (Quat::from_scaled_axis(axis * goal), axis * rate);
            turned = follow_rotation(turned, goal, LAW, H);
            assert!((turned.0.scaled_axis() - axis * angle[0]).norm() < 1e-9);
            assert!((turned.1 - axis * angle[1]).norm() < 1e-7);
        }
    }

    #[test]
    fn spin_is_the_derivative_of_the_rotation() {
        let mut now = (Quat::from_scaled_axis(Vec3::new(0.4, 1.0, -1.0)), Vec3::new(1.0, 0.0, 2.0));
        let h = 1e-5;
        for k in 1..2000 {
            let t = f64::from(k) * h;
            let spin = Vec3::new(2.0, -1.0, 0.5);
            let goal = (Quat::from_scaled_axis(spin * t), spin);
            let next = follow_rotation(now, goal, Law { omega: 90.0, speed: 1e9 }, h);
            let mean = (next.0 * now.0.inverse()).scaled_axis() / h;
            assert!((mean - (now.1 + next.1) * 0.5).norm() < 1e-4, "{t}");
            now = next;
        }
    }
}
