//! Joint constraints C(q) = 0 and their derivative (Eq. 2-4).
//!
//! Point rows hold the origins of J (on the parent) and K (on the child) together. Their lever
//! arms end at the midpoint of the two origins, so that the joint's impulse conserves angular
//! momentum exactly even while a gap is being closed. Axis rows keep directions perpendicular:
//!
//! ```text
//!   hinge      y_J · x_K = 0,  z_J · x_K = 0
//!   universal  y_J · x_K = 0
//!   fixed      the rotation vector from J to K is zero
//! ```

use crate::math::{Mat3, Pose, Vec3, rotation_vector, skew};
use crate::model::JointKind;
use crate::solver::JointBlock;

/// A joint's two frames and the centres of mass they turn about, all in the world.
#[derive(Clone, Copy, Debug)]
pub struct JointFrames {
    /// Frame fixed in the parent.
    pub pose_WJ: Pose,
    /// Frame fixed in the child.
    pub pose_WK: Pose,
    /// Parent's centre of mass (any point when the parent is the world).
    pub parent: Vec3,
    /// Child's centre of mass.
    pub child: Vec3,
}

impl JointFrames {
    /// Distance of the two origins, child minus parent \[m\].
    pub fn gap(&self) -> Vec3 {
        self.pose_WK.position - self.pose_WJ.position
    }

    /// Axes of J and K as columns.
    pub fn axes(&self) -> (Mat3, Mat3) {
        (
            self.pose_WJ.rotation.to_rotation_matrix().into_inner(),
            self.pose_WK.rotation.to_rotation_matrix().into_inner(),
        )
    }
}

/// The rows of one joint at this configuration.
pub fn joint_block(kind: JointKind, frames: &JointFrames) -> JointBlock {
    let mut block = JointBlock { rows: kind.rows(), ..JointBlock::empty() };
    if kind == JointKind::Free {
        return block;
    }
    let middle = (frames.pose_WJ.position + frames.pose_WK.position) * 0.5;
    let identity = Mat3::identity();
    block.J_child.fixed_view_mut::<3, 3>(0, 0).copy_from(&identity);
    block.J_child.fixed_view_mut::<3, 3>(0, 3).copy_from(&-skew(&(middle - frames.child)));
    block.J_parent.fixed_view_mut::<3, 3>(0, 0).copy_from(&-identity);
    block.J_parent.fixed_view_mut::<3, 3>(0, 3).copy_from(&skew(&(middle - frames.parent)));
    block.C.fixed_rows_mut::<3>(0).copy_from(&frames.gap());

    let mut add_axis_row = |row: usize, direction: &Vec3, value: f64| {
        block.J_child.fixed_view_mut::<1, 3>(row, 3).copy_from(&direction.transpose());
        block.J_parent.fixed_view_mut::<1, 3>(row, 3).copy_from(&-direction.transpose());
        block.C[row] = value;
    };
    let (J, K) = frames.axes();
    let x_K: Vec3 = K.column(0).into();
    match kind {
        JointKind::Hinge | JointKind::Universal => {
            for row in 3..kind.rows() {
                let axis: Vec3 = J.column(row - 2).into();
                add_axis_row(row, &x_K.cross(&axis), axis.dot(&x_K));
            }
        }
        JointKind::Fixed => {
            let turn =
                rotation_vector(&(frames.pose_WK.rotation * frames.pose_WJ.rotation.inverse()));
            for axis in 0..3 {
                add_axis_row(3 + axis, &identity.column(axis).into(), turn[axis]);
            }
        }
        JointKind::Ball | JointKind::Free => {}
    }
    block
}

/// Returns the angle between the joint's axes and where its rows want them \[rad\].
pub fn misalignment(kind: JointKind, frames: &JointFrames) -> f64 {
    let (J, K) = frames.axes();
    let x_K = K.column(0);
    match kind {
        JointKind::Hinge => x_K.cross(&J.column(0)).norm().atan2(x_K.dot(&J.column(0))),
        JointKind::Universal => x_K.dot(&J.column(1)).clamp(-1.0, 1.0).asin().abs(),
        JointKind::Fixed => frames.pose_WK.rotation.angle_to(&frames.pose_WJ.rotation),
        JointKind::Ball | JointKind::Free => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Quat, Vec6};
    use crate::random::Random;
    use crate::testing::{assert_close, jacobian};

    /// J against central differences of C over small motions of both bodies, at configurations
    /// that satisfy the joint (where the midpoint lever is exact).
    #[test]
    fn rows_are_the_derivative_of_the_constraint() {
        let mut random = Random::new(21);
        let kinds = [JointKind::Hinge, JointKind::Universal, JointKind::Ball, JointKind::Fixed];
        for kind in kinds {
            for _ in 0..20 {
                let turn = match kind {
                    JointKind::Hinge => Quat::from_scaled_axis(Vec3::x() * random.range(-1.5, 1.5)),
                    JointKind::Universal => {
                        Quat::from_scaled_axis(Vec3::y() * random.range(-1.5, 1.5))
                            * Quat::from_scaled_axis(Vec3::x() * random.range(-1.5, 1.5))
                    }
                    JointKind::Ball => random.rotation(3.0),
                    _ => Quat::identity(),
                };
                let pose_WJ = Pose::new(random.vector(0.1), random.rotation(3.0));
                let pose_WK = Pose::new(pose_WJ.position, pose_WJ.rotation * turn);
                let centres = [random.vector(0.1), random.vector(0.1)];
                let frames = |q: &[f64]| {
                    let moved = |pose: Pose, centre: Vec3, q: &[f64]| {
                        let turn = Quat::from_scaled_axis(Vec3::new(q[3], q[4], q[5]));
                        let shift = Vec3::new(q[0], q[1], q[2]);
                        let position = centre + shift + turn * (pose.position - centre);
                        Pose::new(position, turn * pose.rotation)
                    };
                    JointFrames {
                        pose_WJ: moved(pose_WJ, centres[0], &q[..6]),
                        pose_WK: moved(pose_WK, centres[1], &q[6..]),
                        parent: centres[0],
                        child: centres[1],
                    }
                };
                let value = |q: &[f64]| joint_block(kind, &frames(q)).C.as_slice().to_vec();
                let numeric = jacobian(value, &[0.0; 12], 1e-6);
                let block = joint_block(kind, &frames(&[0.0; 12]));
                assert!(block.C.norm() < 1e-12);
                let analytic: Vec<Vec<f64>> = (0..6)
                    .map(|i| {
                        let p = block.J_parent.row(i);
                        p.iter().chain(block.J_child.row(i).iter()).copied().collect()
                    })
                    .collect();
                assert_close(&analytic, &numeric, 1e-6);
            }
        }
    }

    #[test]
    fn a_joint_impulse_has_no_net_force_or_torque_even_across_a_gap() {
        let mut random = Random::new(22);
        let frames = JointFrames {
            pose_WJ: Pose::new(random.vector(0.1), random.rotation(1.0)),
            pose_WK: Pose::new(random.vector(0.1), random.rotation(1.0)),
            parent: random.vector(0.1),
            child: random.vector(0.1),
        };
        let block = joint_block(JointKind::Fixed, &frames);
        let lambda = Vec6::from_fn(|_, _| random.range(-1.0, 1.0));
        let on = |J: &crate::math::Mat6, centre: Vec3| {
            let w = J.transpose() * lambda;
            let (force, torque) = (Vec3::new(w[0], w[1], w[2]), Vec3::new(w[3], w[4], w[5]));
            (force, torque + centre.cross(&force))
        };
        let (fp, tp) = on(&block.J_parent, frames.parent);
        let (fc, tc) = on(&block.J_child, frames.child);
        assert!((fp + fc).norm() < 1e-14 && (tp + tc).norm() < 1e-14);
    }
}
