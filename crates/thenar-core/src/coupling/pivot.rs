//! Targets by the pose of two bones: their rotations are blended about the joint that they share,
//! so that a twist keeps its radius and a bend its depth. Linear blending keeps `cos θ/2` of either
//! at equal weights.
//!
//! With two adjacent bones the centre of rotation that Le and Hodgins (2016) compute for a vertex
//! is the joint. Both bones carry the node, as in Eq. 6, and the derivative fills the same blocks
//! as that of Eq. 8.

use crate::coupling::SkinTarget;
use crate::math::{Mat3, Pose, Quat, Vec3};
use crate::solver::{RelativeTerm, Turning};

/// Joint about which a node turns, and the node's arm from it.
#[derive(Clone, Copy, Debug)]
pub struct Pivot {
    /// The joint in the frame of each bone \[m\].
    pub anchors_B: [Vec3; 2],
    /// From the joint to the node at rest, in the first bone's frame \[m\].
    pub arm_B: Vec3,
    /// Takes the second bone's frame to the first's at rest: `R_1⁻¹ R_0`.
    pub rest: Quat,
}

impl Pivot {
    /// Makes the pivot of a node at rest in `x_W`, where bones that lie at `poses_WB` are joined at
    /// `anchors_B`.
    pub fn new(poses_WB: [&Pose; 2], anchors_B: [Vec3; 2], weights: [f64; 2], x_W: &Vec3) -> Self {
        let joint_W = centre(poses_WB, anchors_B, weights).0;
        let rest = poses_WB[1].rotation.inverse() * poses_WB[0].rotation;
        Self { anchors_B, arm_B: poses_WB[0].inverse_vector(&(x_W - joint_W)), rest }
    }

    /// `f = c + R̄ (X − C)` with its derivative. c is the joint, by weight where the bones have it
    /// apart. R̄ turns as `q̄ = (w_0 q_0 + w_1 q_1) / n` does, the shorter way. A bone that turns
    /// by ω turns q̄ by `(w/n) (c I − [e]×) ω`, where (c, e) are scalar and vector of `q q̄*`; e of
    /// the one bone is `κ n / w_0`, that of the other `−κ n / w_1`, with
    /// `κ = w_0 w_1 vec(q_0 q_1*) / n²`. Hence
    ///
    /// ```text
    ///   ∂f = Σ w_j (v_j + ω_j × R_j C_j) + (μ_0 ω_0 + μ_1 ω_1 − κ × (ω_0 − ω_1)) × r,    r = R̄ (X − C)
    /// ```
    ///
    /// with `μ_j = w_j c_j / n` of sum 1, so that a motion of both bones as one moves the target
    /// with them.
    ///
    /// `posed` is an offset of X in the first bone's frame with its slope, by which the derivative
    /// grows: `R̄ slope (ω_0 − ω_1)`.
    #[inline]
    pub fn target(
        &self,
        poses_WB: [&Pose; 2],
        weights: [f64; 2],
        posed: Option<(Vec3, Mat3)>,
    ) -> SkinTarget {
        let [w_0, w_1] = weights;
        let q_0 = poses_WB[0].rotation;
        let q_1 = poses_WB[1].rotation * self.rest;
        let dot = q_0.coords.dot(&q_1.coords);
        let (near, sign) = (dot.abs(), 1.0_f64.copysign(dot));
        let n2 = w_0 * w_0 + w_1 * w_1 + 2.0 * w_0 * w_1 * near;
        let blended = (q_0.coords * w_0 + q_1.coords * (w_1 * sign)) / n2.sqrt();
        let turn = Quat::new_unchecked(blended.into());
        let r = turn * posed.map_or(self.arm_B, |(offset, _)| self.arm_B + offset);
        let (joint_W, mut levers) = centre(poses_WB, self.anchors_B, weights);
        let mu = w_0 * (w_0 + w_1 * near) / n2;
        levers[0] += r * mu;
        levers[1] += r * (1.0 - mu);
        let (v_0, v_1) = (q_0.imag(), q_1.imag());
        let between = v_0 * q_1.w - v_1 * q_0.w - v_0.cross(&v_1);
        let axis = between * (w_0 * w_1 * sign / n2);
        let blended = RelativeTerm::Blended { axis, arm: r };
        let apart = match posed {
            None => blended,
            Some((_, slope)) => {
                RelativeTerm::Posed(blended.matrix() + turn.to_rotation_matrix().matrix() * slope)
            }
        };
        SkinTarget { position_W: joint_W + r, turning: Turning { levers, apart: Some(apart) } }
    }
}

/// The joint by weight of the bones, world \[m\], and its weighted lever on each.
#[inline]
fn centre(poses_WB: [&Pose; 2], anchors_B: [Vec3; 2], weights: [f64; 2]) -> (Vec3, [Vec3; 2]) {
    let levers = [0, 1].map(|j| poses_WB[j].vector(&anchors_B[j]) * weights[j]);
    let of = |j: usize| poses_WB[j].position * weights[j] + levers[j];
    (of(0) + of(1), levers)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::coupling::{BoundNode, OffsetModel, SkinTarget, skin_target};
    use crate::random::Random;
    use crate::testing::{assert_close, jacobian};
    use std::f64::consts::{FRAC_PI_2, PI};

    /// The target of a node with these offsets.
    pub(crate) fn posed(bound: &BoundNode, poses: &[Pose], offsets: &OffsetModel) -> SkinTarget {
        skin_target(bound, poses, &offsets.pose(poses, &mut Vec::new()))
    }

    fn target(bound: &BoundNode, poses: &[Pose]) -> SkinTarget {
        posed(bound, poses, &OffsetModel::default())
    }

    /// `∂f/∂q` of a node on bodies 0 and 1 as the solver has it, and by central differences.
    pub(crate) fn derivatives(
        bound: &BoundNode,
        poses: &[Pose],
        offsets: &OffsetModel,
    ) -> [Vec<Vec<f64>>; 2] {
        let at = |q: &[f64]| {
            let moved: Vec<Pose> = (0..2)
                .map(|j| {
                    let q = &q[6 * j..6 * j + 6];
                    let turn = Quat::from_scaled_axis(Vec3::new(q[3], q[4], q[5]));
                    let shift = Vec3::new(q[0], q[1], q[2]);
                    Pose::new(poses[j].position + shift, turn * poses[j].rotation)
                })
                .collect();
            posed(bound, &moved, offsets).position_W.as_slice().to_vec()
        };
        let target = posed(bound, poses, offsets);
        let mut analytic = vec![vec![0.0; 12]; 3];
        for (r, c, j) in (0..18).map(|k| (k % 3, k / 3 % 3, k / 9)) {
            analytic[r][6 * j + c] = if r == c { bound.weights[j] } else { 0.0 };
            analytic[r][6 * j + 3 + c] = target.turning.matrix(j)[(r, c)];
        }
        [analytic, jacobian(at, &[0.0; 12], 1e-6)]
    }

    /// Two bones of any rest pose with a common joint, and a node near it.
    pub(crate) fn random_pair(random: &mut Random) -> ([Pose; 2], BoundNode) {
        let poses = [0, 1].map(|_| Pose::new(random.vector(0.1), random.rotation(PI)));
        let (joint, x) = (random.vector(0.1), random.vector(0.1));
        let w = random.range(0.02, 0.98);
        let weights = [w, 1.0 - w];
        let anchors = [0, 1].map(|j| poses[j].inverse_point(&joint));
        let offsets = [0, 1].map(|j| poses[j].inverse_point(&x));
        let pivot = Some(Pivot::new([&poses[0], &poses[1]], anchors, weights, &x));
        (poses, BoundNode { node: 0, bones: [0, 1], weights, offsets, pivot, posed: None })
    }

    fn joined_at_origin(weights: [f64; 2], x: Vec3) -> BoundNode {
        let still = Pose::identity();
        let pivot = Some(Pivot::new([&still, &still], [Vec3::zeros(); 2], weights, &x));
        BoundNode { node: 0, bones: [0, 1], weights, offsets: [x, x], pivot, posed: None }
    }

    /// The child turned by an angle about an axis through the joint.
    fn turned(axis: Vec3, angle: f64) -> [Pose; 2] {
        [Pose::identity(), Pose::new(Vec3::zeros(), Quat::from_scaled_axis(axis * angle))]
    }

    #[test]
    fn at_rest_the_target_is_the_node() {
        let mut random = Random::new(3);
        for _ in 0..200 {
            let (poses, bound) = random_pair(&mut random);
            let x = poses[0].point(&bound.offsets[0]);
            let target = target(&bound, &poses);
            assert!((target.position_W - x).norm() < 1e-15);
            let apart = target.turning.apart.unwrap().matrix();
            assert!(apart.norm() < 1e-14, "nothing is turned apart: {apart}");
        }
    }

    /// Bones turned by up to 179° to each other and pulled 10 mm apart: no derivative leaves out
    /// anything.
    #[test]
    fn derivative_matches_finite_differences_up_to_half_a_turn() {
        let mut random = Random::new(31);
        for _ in 0..200 {
            let (rest, bound) = random_pair(&mut random);
            let whole = Pose::new(random.vector(1.0), random.rotation(PI));
            let bend = Pose::new(random.vector(0.01), random.rotation(179.0_f64.to_radians()));
            let poses = [whole * rest[0], whole * bend * rest[1]];
            let [analytic, numeric] = derivatives(&bound, &poses, &OffsetModel::default());
            assert_close(&analytic, &numeric, 1e-8);
        }
    }

    #[test]
    fn a_motion_of_both_bones_moves_the_target_with_them() {
        let mut random = Random::new(7);
        for _ in 0..200 {
            let (rest, bound) = random_pair(&mut random);
            let bend = Pose::new(random.vector(0.01), random.rotation(2.5));
            let bent = [rest[0], bend * rest[1]];
            let motion = Pose::new(random.vector(1.0), random.rotation(PI));
            let before = target(&bound, &bent).position_W;
            let after = target(&bound, &bent.map(|p| motion * p)).position_W;
            assert!((motion.point(&before) - after).norm() < 1e-14);
        }
    }

    /// A force on the target and what it puts on the bones have no net force and no net torque
    /// (D4).
    #[test]
    fn forces_on_target_and_bones_are_in_balance() {
        let mut random = Random::new(9);
        for _ in 0..200 {
            let (rest, bound) = random_pair(&mut random);
            let bend = Pose::new(random.vector(0.01), random.rotation(3.0));
            let poses = [rest[0], bend * rest[1]];
            let target = target(&bound, &poses);
            let force = random.vector(10.0);
            let mut torque = -target.position_W.cross(&force);
            for j in 0..2 {
                torque += poses[j].position.cross(&(force * bound.weights[j]));
                torque += target.turning.torque(j, &force);
            }
            assert!(torque.norm() < 1e-14, "{torque}");
        }
    }

    /// Figure D3 and its neighbours: linear blending keeps cos θ/2 of the radius at equal weights.
    #[test]
    fn a_twist_keeps_its_radius() {
        for degrees in [0.0_f64, 45.0, 90.0, 135.0, 170.0, -90.0] {
            for w in [0.01, 0.3, 0.5, 0.9] {
                let bound = joined_at_origin([w, 1.0 - w], Vec3::new(0.01, 0.0, 0.004));
                let poses = turned(Vec3::z(), degrees.to_radians());
                let at = target(&bound, &poses).position_W;
                assert!((at.xy().norm() / 0.01 - 1.0).abs() < 1e-12, "{degrees}°, {w}");
                assert!((at.z - 0.004).abs() < 1e-15);
            }
        }
        // With equal weights it turns by half the angle.
        let bound = joined_at_origin([0.5, 0.5], Vec3::new(0.01, 0.0, 0.0));
        let at = target(&bound, &turned(Vec3::z(), FRAC_PI_2)).position_W;
        assert!((at.y.atan2(at.x) - FRAC_PI_2 / 2.0).abs() < 1e-12);
    }

    /// A bend of 90°: linear blending leaves 0.7071 of the depth over the joint.
    #[test]
    fn a_bend_keeps_its_depth() {
        let bound = joined_at_origin([0.5, 0.5], Vec3::new(0.0, 0.01, 0.0));
        let at = target(&bound, &turned(Vec3::z(), FRAC_PI_2)).position_W;
        assert!((at.norm() / 0.01 - 1.0).abs() < 1e-12);
    }

    /// Figure B4: the child turned to 350°. Below half a turn the target never moves by more than
    /// the child's own arc; there it changes to the shorter way, by up to twice the radius, and
    /// nowhere else.
    #[test]
    fn only_half_a_turn_is_a_jump() {
        let (radius, steps) = (0.01, 3499);
        let step = 350.0_f64.to_radians() / f64::from(steps);
        for w in [0.05, 0.5, 0.8] {
            let bound = joined_at_origin([w, 1.0 - w], Vec3::new(radius, 0.0, 0.0));
            let at = |k: i32| target(&bound, &turned(Vec3::z(), step * f64::from(k))).position_W;
            for k in 1..=steps {
                let moved = (at(k) - at(k - 1)).norm();
                let passes = step * f64::from(k - 1) < PI && step * f64::from(k) >= PI;
                assert!(at(k).iter().all(|x| x.is_finite()));
                assert!((at(k).norm() / radius - 1.0).abs() < 1e-12);
                if passes {
                    assert!(moved <= 2.0 * radius + 1e-12, "{moved}");
                } else {
                    assert!(moved <= step * radius, "{k}: {moved}");
                }
            }
        }
    }
}
