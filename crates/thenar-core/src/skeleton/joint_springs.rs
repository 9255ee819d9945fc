//! Springs, dampers and limits about joint axes.

use crate::math::Vec3;
use crate::model::{AngleLimit, Axis, JointDesc, JointKind, JointLimits};
use crate::skeleton::JointFrames;
use std::f64::consts::TAU;

/// One measured axis of a joint.
#[derive(Clone, Copy, Debug)]
pub struct AxisState {
    /// Direction about which the child turns against the parent, world.
    pub direction_W: Vec3,
    /// Angle \[rad\].
    pub angle: f64,
}

/// The axes of a joint with their present angles; entries past `kind.angles()` are `None`.
pub fn axis_states(kind: JointKind, frames: &JointFrames) -> [Option<AxisState>; 2] {
    let (J, K) = frames.axes();
    let R = J.tr_mul(&K);
    let state = |direction_W: Vec3, angle: f64| Some(AxisState { direction_W, angle });
    match kind {
        // R = Rx(q0)
        JointKind::Hinge => [state(K.column(0).into(), R.m32.atan2(R.m22)), None],
        // R = Ry(q0) Rx(q1)
        JointKind::Universal => [
            state(J.column(1).into(), (-R.m31).atan2(R.m11)),
            state(K.column(0).into(), (-R.m23).atan2(R.m22)),
        ],
        _ => [None, None],
    }
}

/// Elastic torque on the child about the axis at this angle \[N m\], and the stiffness \[N m/rad\]
/// and damping \[N m s/rad\] to be taken implicitly. Past a limit that is kept by springs a stiff
/// one adds itself (Sec. 3.1).
pub fn spring_torque(
    axis: &Axis,
    joint: &JointDesc,
    limits: JointLimits,
    angle: f64,
) -> (f64, f64, f64) {
    let mut torque = -axis.stiffness * stretch(axis, angle);
    let (mut stiffness, mut damping) = (axis.stiffness, axis.damping);
    let past = if limits == JointLimits::Springs { past_limit(axis, angle) } else { 0.0 };
    if past != 0.0 {
        torque -= joint.limit_stiffness * past;
        stiffness += joint.limit_stiffness;
        damping += joint.limit_damping;
    }
    (torque, stiffness, damping)
}

/// Energy of the spring, and of a limit's where limits are kept by springs, at this angle \[J\].
pub fn spring_energy(axis: &Axis, joint: &JointDesc, limits: JointLimits, angle: f64) -> f64 {
    let stretch = stretch(axis, angle);
    let past = if limits == JointLimits::Springs { past_limit(axis, angle) } else { 0.0 };
    0.5 * (axis.stiffness * stretch * stretch + joint.limit_stiffness * past * past)
}

/// Torque on the child by the springs and dampers of an axis's limits at this angle \[rad\] and
/// rate \[rad/s\].
pub fn limit_spring_torque(axis: &Axis, joint: &JointDesc, angle: f64, rate: f64) -> f64 {
    match past_limit(axis, angle) {
        0.0 => 0.0,
        past => -joint.limit_stiffness * past - joint.limit_damping * rate,
    }
}

/// Returns the angle by which an axis is turned from where its spring is relaxed \[rad\]. The angle
/// is known but for whole turns. Within a range shorter than a turn it is that near the range, and
/// the spring is wound up as far as its rest angle says. Otherwise the spring acts the shorter way
/// round, by half a turn at most: its energy is a function of the pose alone, so that no motion
/// round the axis can draw on it.
pub fn stretch(axis: &Axis, angle: f64) -> f64 {
    match axis.limit {
        Some(limit) if limit.max - limit.min < TAU => {
            turned_towards(&limit, angle) - axis.rest_angle
        }
        _ => {
            let stretch = angle - axis.rest_angle;
            stretch - TAU * (stretch / TAU).round()
        }
    }
}

/// Signed distance past the admissible range, 0 within \[rad\].
fn past_limit(axis: &Axis, angle: f64) -> f64 {
    match axis.limit {
        Some(limit) => {
            let angle = turned_towards(&limit, angle);
            angle - angle.clamp(limit.min, limit.max)
        }
        None => 0.0,
    }
}

/// Angle turned by whole turns as near as can be to the middle of the range \[rad\]: past π an
/// angle goes on from -π, while the range may not.
pub fn turned_towards(limit: &AngleLimit, angle: f64) -> f64 {
    let middle = 0.5 * (limit.min + limit.max);
    angle + TAU * ((middle - angle) / TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Pose, Quat};
    use crate::model::AngleLimit;
    use crate::testing::jacobian;

    fn hinge(axis: Axis) -> JointDesc {
        JointDesc {
            name: String::new(),
            kind: JointKind::Hinge,
            parent: None,
            child: 0,
            pose_PJ: Pose::identity(),
            pose_CK: Pose::identity(),
            axes: [axis, Axis::default()],
            limit_stiffness: 3.0,
            limit_damping: 0.7,
        }
    }

    #[test]
    fn torque_is_minus_the_energy_gradient_and_limits_push_back() {
        let ranges = [None, Some((-0.2, 1.0)), Some((2.5, 4.0)), Some((-9.0, 9.0))];
        for (range, rest_angle) in ranges.into_iter().flat_map(|r| [(r, 0.3), (r, 3.3), (r, -2.9)])
        {
            let limit = range.map(|(min, max)| AngleLimit { min, max });
            let axis = Axis { limit, stiffness: 0.04, rest_angle, damping: 0.1 };
            let joint = hinge(axis);
            for limits in [JointLimits::Springs, JointLimits::Rows] {
                for angle in [-3.1, -2.6, -0.5, -0.1, 0.3, 0.9, 1.4, 2.6, 3.1] {
                    let energy = |q: f64| spring_energy(&axis, &joint, limits, q);
                    let torque = |q: f64| spring_torque(&axis, &joint, limits, q).0;
                    let numeric = jacobian(|q| vec![-energy(q[0])], &[angle], 1e-6)[0][0];
                    let slope = jacobian(|q| vec![-torque(q[0])], &[angle], 1e-6)[0][0];
                    let (value, stiffness, damping) = spring_torque(&axis, &joint, limits, angle);
                    assert!((value - numeric).abs() < 1e-8, "{axis:?} at {angle}");
                    assert!((stiffness - slope).abs() < 1e-8, "{axis:?} at {angle}");
                    // Whole turns make no difference, and springs of limits are damped.
                    assert!((energy(angle + TAU) - energy(angle)).abs() < 1e-12);
                    assert!((torque(angle + TAU) - torque(angle)).abs() < 1e-12);
                    let past = stiffness > 1.0;
                    assert!((damping - if past { 0.8 } else { 0.1 }).abs() < 1e-12);
                }
            }
        }
    }

    /// Without a range the spring acts the shorter way round; with one it is wound up.
    #[test]
    fn a_spring_acts_the_shorter_way_or_as_wound() {
        let free = Axis { stiffness: 1.0, rest_angle: 3.0, ..Axis::default() };
        let torque =
            |axis: &Axis, angle| spring_torque(axis, &hinge(*axis), JointLimits::Rows, angle).0;
        assert!((torque(&free, 3.15 - TAU) + 0.15).abs() < 1e-12);
        assert!((torque(&free, -0.1) - 3.1).abs() < 1e-12);
        assert!((torque(&free, -0.2) - (3.2 - TAU)).abs() < 1e-12);
        let wound =
            Axis { limit: Some(AngleLimit { min: 0.0, max: 1.0 }), rest_angle: -8.0, ..free };
        assert!((torque(&wound, 0.5) + 8.5).abs() < 1e-12);
    }

    #[test]
    fn angles_are_read_back() {
        let pose_WJ = Pose::new(Vec3::zeros(), Quat::from_scaled_axis(Vec3::new(0.3, -1.0, 0.7)));
        for (q0, q1) in [(0.4, -1.2), (-0.3, 1.5), (1.1, 0.0)] {
            let turn =
                Quat::from_scaled_axis(Vec3::y() * q0) * Quat::from_scaled_axis(Vec3::x() * q1);
            let frames = JointFrames {
                pose_WJ,
                pose_WK: Pose::new(Vec3::zeros(), pose_WJ.rotation * turn),
                parent: Vec3::zeros(),
                child: Vec3::zeros(),
            };
            let [a, b] = axis_states(JointKind::Universal, &frames);
            assert!((a.unwrap().angle - q0).abs() < 1e-12 && (b.unwrap().angle - q1).abs() < 1e-12);
        }
    }
}
