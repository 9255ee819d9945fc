//! Linear blend skinning (Eq. 6) and its derivative.

use crate::math::{Pose, Vec3};

/// A node bound to at most two bones.
#[derive(Clone, Copy, Debug)]
pub struct BoundNode {
    /// Node, numbered through all deformable bodies.
    pub node: u32,
    /// Rigid bodies; equal when one carries the node.
    pub bones: [u32; 2],
    /// Weights of sum 1; the second is zero when one bone carries the node.
    pub weights: [f64; 2],
    /// Rest position in each bone's frame \[m\], the paper's x_ij.
    pub offsets: [Vec3; 2],
}

/// The target f_i of a node with its derivative `∂f_i/∂q_j = [w I, -(w R_j x_ij)×]`.
#[derive(Clone, Copy, Debug)]
pub struct SkinTarget {
    /// f_i, world \[m\].
    pub position_W: Vec3,
    /// `w_ij R_j x_ij`, world \[m\]: the lever of the node's force on each bone.
    pub levers_W: [Vec3; 2],
}

/// `f_i(q) = Σ_j w_ij (x_j + R_j x_ij)`.
#[inline]
pub fn skin_target(bound: &BoundNode, poses_WB: &[Pose]) -> SkinTarget {
    let mut target = SkinTarget { position_W: Vec3::zeros(), levers_W: [Vec3::zeros(); 2] };
    for j in 0..2 {
        let weight = bound.weights[j];
        if weight != 0.0 {
            let pose = &poses_WB[bound.bones[j] as usize];
            target.levers_W[j] = pose.vector(&bound.offsets[j]) * weight;
            target.position_W += pose.position * weight + target.levers_W[j];
        }
    }
    target
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Quat, skew};
    use crate::testing::{Random, assert_close, jacobian};

    #[test]
    fn derivative_matches_finite_differences_up_to_90_degrees() {
        let mut random = Random::new(31);
        for _ in 0..50 {
            let poses: Vec<Pose> =
                (0..2).map(|_| Pose::new(random.vec3(0.1), random.rotation(1.57))).collect();
            let w = random.range(0.0, 1.0);
            let bound = BoundNode {
                node: 0,
                bones: [0, 1],
                weights: [w, 1.0 - w],
                offsets: [random.vec3(0.05), random.vec3(0.05)],
            };
            let at = |q: &[f64]| {
                let moved: Vec<Pose> = (0..2)
                    .map(|j| {
                        let q = &q[6 * j..6 * j + 6];
                        let turn = Quat::from_scaled_axis(Vec3::new(q[3], q[4], q[5]));
                        let shift = Vec3::new(q[0], q[1], q[2]);
                        Pose::new(poses[j].position + shift, turn * poses[j].rotation)
                    })
                    .collect();
                skin_target(&bound, &moved).position_W.as_slice().to_vec()
            };
            let numeric = jacobian(at, &[0.0; 12], 1e-6);
            let target = skin_target(&bound, &poses);
            let analytic: Vec<Vec<f64>> = (0..3)
                .map(|r| {
                    (0..2)
                        .flat_map(|j| {
                            let linear =
                                (0..3).map(move |c| if r == c { bound.weights[j] } else { 0.0 });
                            let turn = -skew(&target.levers_W[j]);
                            linear.chain((0..3).map(move |c| turn[(r, c)])).collect::<Vec<_>>()
                        })
                        .collect()
                })
                .collect();
            assert_close(&analytic, &numeric, 1e-6);
        }
    }

    /// Validation D3: a 90° twist with equal weights shrinks the radius to cos 45°.
    #[test]
    fn linear_blend_loses_radius_in_a_twist() {
        let quarter = Quat::from_scaled_axis(Vec3::z() * std::f64::consts::FRAC_PI_2);
        let poses = [Pose::identity(), Pose::new(Vec3::zeros(), quarter)];
        let offset = Vec3::new(0.01, 0.0, 0.0);
        let bound =
            BoundNode { node: 0, bones: [0, 1], weights: [0.5, 0.5], offsets: [offset, offset] };
        let radius = skin_target(&bound, &poses).position_W.norm() / 0.01;
        assert!((radius - std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-12);
    }
}
