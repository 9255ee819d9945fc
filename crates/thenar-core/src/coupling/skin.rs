//! Skinning targets (Eq. 6) and their derivatives.

use crate::coupling::{NodeOffset, Pivot, PosedOffsets};
use crate::math::{Mat3, Pose, Vec3};
use crate::solver::{RelativeTerm, Turning};

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
    /// Pivot of the node where the rotations of its two bones are blended.
    pub pivot: Option<Pivot>,
    /// Offsets by the pose of its bones' joint, if it has some.
    pub posed: Option<NodeOffset>,
}

/// The target f_i of a node with its derivative: `∂f_i/∂q_j = [w I, turning]`.
#[derive(Clone, Copy, Debug)]
pub struct SkinTarget {
    /// f_i, world \[m\].
    pub position_W: Vec3,
    /// Motion of the target as bones turn: by linear blending with levers `w_ij R_j x_ij`.
    pub turning: Turning,
}

/// Eq. 6, `f_i(q) = Σ_j w_ij (x_j + R_j x_ij)`, or [`Pivot::target`], with x_ij as the pose has it
/// ([`PosedOffsets`]).
#[inline]
pub fn skin_target(bound: &BoundNode, poses_WB: &[Pose], posed: &PosedOffsets<'_>) -> SkinTarget {
    if let Some(pivot) = &bound.pivot {
        let of_pose = bound.posed.as_ref().map(|at| (posed.offset(at, 0), posed.slope(at, 0)));
        return pivot.target(bound.bones.map(|b| &poses_WB[b as usize]), bound.weights, of_pose);
    }
    let mut target = SkinTarget { position_W: Vec3::zeros(), turning: Turning::NONE };
    for j in 0..2 {
        let weight = bound.weights[j];
        if weight != 0.0 {
            let pose = &poses_WB[bound.bones[j] as usize];
            let offset = match &bound.posed {
                None => bound.offsets[j],
                Some(at) => bound.offsets[j] + posed.offset(at, j),
            };
            target.turning.levers[j] = pose.vector(&offset) * weight;
            target.position_W += pose.position * weight + target.turning.levers[j];
        }
    }
    if let Some(at) = &bound.posed {
        let slope = |j: usize| {
            let rotation = poses_WB[bound.bones[j] as usize].rotation.to_rotation_matrix();
            rotation.matrix() * posed.slope(at, j) * bound.weights[j]
        };
        let whole: Mat3 = slope(0) + slope(1);
        target.turning.apart = Some(RelativeTerm::Posed(whole));
    }
    target
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coupling::OffsetModel;
    use crate::coupling::pivot::tests::{derivatives, posed};
    use crate::math::Quat;
    use crate::random::Random;
    use crate::testing::assert_close;

    #[test]
    fn derivative_matches_finite_differences_up_to_90_degrees() {
        let mut random = Random::new(31);
        for _ in 0..50 {
            let poses: Vec<Pose> =
                (0..2).map(|_| Pose::new(random.vector(0.1), random.rotation(1.57))).collect();
            let w = random.range(0.0, 1.0);
            let bound = BoundNode {
                node: 0,
                bones: [0, 1],
                weights: [w, 1.0 - w],
                offsets: [random.vector(0.05), random.vector(0.05)],
                pivot: None,
                posed: None,
            };
            let [analytic, numeric] = derivatives(&bound, &poses, &OffsetModel::default());
            assert_close(&analytic, &numeric, 1e-6);
        }
    }

    /// Validation D3: a 90° twist with equal weights shrinks the radius to cos 45°.
    #[test]
    fn linear_blend_loses_radius_in_a_twist() {
        let quarter = Quat::from_scaled_axis(Vec3::z() * std::f64::consts::FRAC_PI_2);
        let poses = [Pose::identity(), Pose::new(Vec3::zeros(), quarter)];
        let offset = Vec3::new(0.01, 0.0, 0.0);
        let (weights, offsets) = ([0.5, 0.5], [offset, offset]);
        let bound =
            BoundNode { node: 0, bones: [0, 1], weights, offsets, pivot: None, posed: None };
        let radius = posed(&bound, &poses, &OffsetModel::default()).position_W.norm() / 0.01;
        assert!((radius - std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-12);
    }
}
