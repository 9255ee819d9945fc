//! Offsets of targets by the pose of joints: `X → X + Δ(q)`, with q the joint's rotation from rest.
//!
//! Between poses q_s, rest among them, Δ is interpolated by radial functions of rotations,
//!
//! ```text
//!   Δ(q) = Σ_s c_s k(q, q_s),    k(p, q) = cos²ⁿ(ρ/2) = (p·q)²ⁿ,
//! ```
//!
//! where ρ is the angle from p to q. A power of a product of quaternions is a positive kernel,
//! smooth everywhere, half a turn included; with n large enough coefficients exist for any poses of
//! which no two are the same. Only the relative rotation of two bones enters: a motion of both as
//! one moves a target with them, and the derivative `T_Δ = ± R̄ Σ c_s γ_sᵀ`, with
//! `∂k = γ_s·(ω_child − ω_parent)`, fills the blocks of those two bones alone.

use crate::math::{Mat3, Pose, Quat, Vec3};
use crate::model::PoseOffsets;
use nalgebra::{Cholesky, DMatrix, Dyn};

/// Largest of n: poses 1° apart. Nearer ones are the same.
const EXPONENT_MAX: i32 = 3300;
/// Largest condition of the kernel's matrix: of 16 digits 8 are left, 10 nm of a metre.
const CONDITION_MAX: f64 = 1e8;

/// The offsets of all bodies.
#[derive(Clone, Debug, Default)]
pub struct OffsetModel {
    drivers: Vec<Driver>,
    /// Poses of all drivers, rest first: rotations of the child from rest, in the parent's frame.
    samples: Vec<Quat>,
    /// c of each node and sample, in the frame of either of its bones \[m\].
    coefficients: Vec<[Vec3; 2]>,
}

/// One joint that offsets follow.
#[derive(Clone, Debug)]
struct Driver {
    child: u32,
    parent: u32,
    /// Takes the parent's frame to the child's at rest, `R_child⁻¹ R_parent`.
    rest: Quat,
    /// Exponent n of the kernel.
    exponent: i32,
    /// Number of samples of its own; they follow those of the drivers before.
    samples: usize,
}

/// The two bodies of a joint at rest, child first, and the flesh between them.
#[derive(Clone, Copy, Debug)]
pub struct PairAtRest {
    /// Rigid bodies.
    pub bodies: [u32; 2],
    /// Rotations of the bodies in the world.
    pub rotations_WB: [Quat; 2],
    /// Rotation of the flesh's model frame in the world.
    pub model_WM: Quat,
}

/// Place of a node's offsets in the lists.
#[derive(Clone, Copy, Debug)]
pub struct NodeOffset {
    sample: u32,
    samples: u32,
    coefficient: u32,
    /// 1 if the node's first bone is the joint's child, else −1: γ acts on `ω_0 − ω_1` by this
    /// sign.
    sign: f64,
}

/// The part that a sample has at a pose, and its slope.
#[derive(Clone, Copy, Debug)]
pub struct KernelValue {
    /// Value k of the kernel.
    amount: f64,
    /// Slope γ of the kernel, world.
    slope_W: Vec3,
}

/// Offsets with what the samples have at one pose of the bones.
#[derive(Clone, Copy, Debug)]
pub struct PosedOffsets<'a> {
    offsets: &'a OffsetModel,
    shares: &'a [KernelValue],
}

impl OffsetModel {
    /// Adds the offsets of one joint: where each of its nodes finds its own. `child_first` tells
    /// for each node whether its first bone is the joint's child. None where two poses are the
    /// same, or nearly so.
    pub fn push(
        &mut self,
        given: &PoseOffsets,
        pair: &PairAtRest,
        child_first: &[bool],
    ) -> Option<Vec<NodeOffset>> {
        let poses: Vec<Quat> = [Quat::identity()].iter().chain(&given.poses).copied().collect();
        let (exponent, kernel) = interpolation(&poses)?;
        let (sample, samples) = (self.samples.len() as u32, poses.len() as u32);
        let mut places = Vec::with_capacity(child_first.len());
        let of_nodes = given.offsets.chunks_exact(given.poses.len());
        for (offsets, &child_first) in of_nodes.zip(child_first) {
            let [child, parent] = pair.rotations_WB.map(|rotation| rotation.inverse());
            let (to_bones, sign) =
                if child_first { ([child, parent], 1.0) } else { ([parent, child], -1.0) };
            let coefficient = self.coefficients.len() as u32;
            places.push(NodeOffset { sample, samples, coefficient, sign });
            let wanted: Vec<Vec3> = offsets.iter().map(|offset| pair.model_WM * offset).collect();
            let of_bones = |c_W: Vec3| to_bones.map(|to_bone| to_bone * c_W);
            self.coefficients.extend(coefficients(&kernel, &wanted).map(of_bones));
        }
        self.samples.extend(poses);
        let [child, parent] = pair.bodies;
        let rest = pair.rotations_WB[0].inverse() * pair.rotations_WB[1];
        self.drivers.push(Driver { child, parent, rest, exponent, samples: samples as usize });
        Some(places)
    }

    /// Samples of all drivers.
    pub fn sample_count(&self) -> usize {
        self.samples.len()
    }

    /// The offsets with what the samples have.
    pub fn with<'a>(&'a self, shares: &'a [KernelValue]) -> PosedOffsets<'a> {
        PosedOffsets { offsets: self, shares }
    }

    /// Sets what the samples have where the bones are. Allocates nothing if `shares` has room.
    pub fn pose<'a>(
        &'a self,
        poses_WB: &[Pose],
        shares: &'a mut Vec<KernelValue>,
    ) -> PosedOffsets<'a> {
        shares.clear();
        let mut samples = &self.samples[..];
        for driver in &self.drivers {
            let (own, others) = samples.split_at(driver.samples);
            shares.extend(own.iter().map(driver.at(poses_WB)));
            samples = others;
        }
        self.with(shares)
    }
}

impl Driver {
    /// The share of a sample where the bones are. The joint turns by `ω = ω_child − ω_parent`:
    /// `q̇ = ½ (Rᵀ ω) q` in the parent's frame, `(q·q_s)˙ = ½ (Rᵀ ω)·vec(q_s q*)`.
    fn at(&self, poses_WB: &[Pose]) -> impl Fn(&Quat) -> KernelValue {
        let parent = poses_WB[self.parent as usize].rotation;
        let q = parent.inverse() * poses_WB[self.child as usize].rotation * self.rest;
        let n = self.exponent;
        move |sample| {
            let dot = q.coords.dot(&sample.coords);
            let power = dot.powi(2 * n - 1);
            let axis = (sample * q.inverse()).imag();
            KernelValue { amount: power * dot, slope_W: parent * axis * (f64::from(n) * power) }
        }
    }
}

impl PosedOffsets<'_> {
    /// Offset of a node in the frame of its bone `j`, as it was at rest \[m\].
    #[inline]
    pub fn offset(&self, at: &NodeOffset, j: usize) -> Vec3 {
        self.samples(at).fold(Vec3::zeros(), |sum, (share, c)| sum + c[j] * share.amount)
    }

    /// Returns the derivative of the offset as bone 0 turns against bone 1: `± Σ c_s γ_sᵀ`, from
    /// the world to the frame of its bone `j`.
    #[inline]
    pub fn slope(&self, at: &NodeOffset, j: usize) -> Mat3 {
        let outer =
            |sum, (share, c): (&KernelValue, &[Vec3; 2])| sum + c[j] * share.slope_W.transpose();
        self.samples(at).fold(Mat3::zeros(), outer) * at.sign
    }

    fn samples(&self, at: &NodeOffset) -> impl Iterator<Item = (&KernelValue, &[Vec3; 2])> {
        let shares = &self.shares[at.sample as usize..][..at.samples as usize];
        shares.iter().zip(&self.offsets.coefficients[at.coefficient as usize..])
    }
}

/// n, and what solves for coefficients; none where two poses are nearly the same. With n, k falls
/// to `e^−¼` between the two poses that are closest to each other: a bend that grows with the angle
/// is met within 2 % of its largest between poses 20 to 35° apart, 5 % where it falls to `e^−½`.
/// Farther from all poses offsets fade, and never swing beyond what was given by more than a third.
/// About one axis such functions span 2 n + 1 dimensions: n is raised until they tell the poses
/// apart.
fn interpolation(poses: &[Quat]) -> Option<(i32, Cholesky<f64, Dyn>)> {
    let dot = |i: usize, j: usize| poses[i].coords.dot(&poses[j].coords);
    let count = poses.len();
    let pairs = (0..count).flat_map(|i| (0..i).map(move |j| (i, j)));
    let closest = pairs.map(|(i, j)| dot(i, j).powi(2)).fold(0.0, f64::max);
    let mut n = ((0.25 / -closest.ln()).round() as i32).max(1);
    while n <= EXPONENT_MAX {
        let kernel = DMatrix::from_fn(count, count, |i, j| dot(i, j).powi(2 * n));
        if let Some(solver) = Cholesky::new(kernel.clone())
            && kernel.norm() * solver.inverse().norm() <= CONDITION_MAX
        {
            return Some((n, solver));
        }
        n += 1 + n / 4;
    }
    None
}

/// c of all samples, the first of rest, for which Δ is what is wanted at each pose, and zero at
/// rest.
fn coefficients(
    kernel: &Cholesky<f64, Dyn>,
    wanted: &[Vec3],
) -> impl Iterator<Item = Vec3> + use<> {
    let mut c = DMatrix::zeros(wanted.len() + 1, 3);
    for (s, offset) in wanted.iter().enumerate() {
        c.set_row(s + 1, &offset.transpose());
    }
    kernel.solve_mut(&mut c);
    (0..c.nrows()).map(move |s| c.fixed_view::<1, 3>(s, 0).transpose())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coupling::BoundNode;
    use crate::coupling::pivot::tests::{derivatives, posed, random_pair};
    use crate::random::Random;
    use crate::testing::assert_close;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    /// Offsets of one node between two bodies, with what it takes to look at them.
    struct Case {
        rest: [Pose; 2],
        bound: BoundNode,
        given: PoseOffsets,
        offsets: OffsetModel,
        pair: PairAtRest,
    }

    impl Case {
        /// A random node by either skinning, its first bone the parent or the child, whose flesh
        /// lies anyhow.
        fn new(random: &mut Random, poses: Vec<Quat>, k: usize) -> Self {
            let (rest, mut bound) = random_pair(random);
            bound.pivot = bound.pivot.filter(|_| k.is_multiple_of(2));
            let bodies = if k % 4 < 2 { [0, 1] } else { [1, 0] };
            let rotations_WB = bodies.map(|b| rest[b as usize].rotation);
            let pair = PairAtRest { bodies, rotations_WB, model_WM: random.rotation(PI) };
            let offsets = poses.iter().map(|_| random.vector(0.01)).collect();
            let given = PoseOffsets { soft: 0, joint: 0, poses, nodes: vec![0], offsets };
            // Those of another joint come first.
            let mut offsets = OffsetModel::default();
            offsets.push(&given, &pair, &[true]).unwrap();
            bound.posed = Some(offsets.push(&given, &pair, &[bodies[0] == 0]).unwrap()[0]);
            Self { rest, bound, given, offsets, pair }
        }

        /// Gives the node these offsets, and lets its first bone alone carry it.
        fn give(&mut self, offsets: Vec<Vec3>) {
            self.given.offsets = offsets;
            self.offsets = OffsetModel::default();
            let child_first = [self.pair.bodies[0] == 0];
            let places = self.offsets.push(&self.given, &self.pair, &child_first).unwrap();
            self.bound.posed = Some(places[0]);
            self.bound.weights = [1.0, 0.0];
        }

        /// Returns the first bone's rotation from rest, world.
        fn carried(&self, poses: &[Pose]) -> Quat {
            poses[0].rotation * self.rest[0].rotation.inverse()
        }

        /// The bones where the child has turned by `turn` in the parent's frame, its place kept.
        fn turned(&self, turn: &Quat) -> [Pose; 2] {
            let [child, _] = self.pair.bodies.map(|b| b as usize);
            let parent_W = self.pair.rotations_WB[1];
            let mut poses = self.rest;
            poses[child].rotation = parent_W * turn * parent_W.inverse() * poses[child].rotation;
            poses
        }

        /// By how much the offsets move the target at these poses, world.
        fn shift(&self, poses: &[Pose]) -> Vec3 {
            let plain = BoundNode { posed: None, ..self.bound };
            let at = |bound| posed(bound, poses, &self.offsets).position_W;
            at(&self.bound) - at(&plain)
        }
    }

    fn about_x(angles: &[f64]) -> Vec<Quat> {
        angles.iter().map(|&angle| Quat::from_scaled_axis(Vec3::x() * angle)).collect()
    }

    /// One to five poses, far apart or near to each other.
    fn some_poses(random: &mut Random, k: usize) -> Vec<Quat> {
        (0..1 + k % 5).map(|s| random.rotation(1.0) * about_x(&[0.6 * (s + 1) as f64])[0]).collect()
    }

    /// At each pose the target is off by what was given, at rest by nothing.
    #[test]
    fn offsets_are_those_given() {
        let mut random = Random::new(11);
        for k in 0..100 {
            let poses = some_poses(&mut random, k);
            let case = Case::new(&mut random, poses, k);
            assert!(case.shift(&case.rest).norm() < 1e-12, "{}", case.shift(&case.rest));
            // Blended bones turn an offset by less than its length; one that both bones turn alike
            // keeps it.
            for (pose, offset) in case.given.poses.iter().zip(&case.given.offsets) {
                let at = case
                    .offsets
                    .pose(&case.turned(pose), &mut Vec::new())
                    .offset(case.bound.posed.as_ref().unwrap(), 0);
                let wanted_W = case.pair.model_WM * offset;
                assert!((case.rest[0].rotation * at - wanted_W).norm() < 1e-10, "{k}");
            }
        }
    }

    /// Figure B2: bones turned by up to 179° to each other and pulled 10 mm apart, by either
    /// skinning.
    #[test]
    fn derivative_matches_finite_differences() {
        let mut random = Random::new(32);
        for k in 0..200 {
            let poses = some_poses(&mut random, k);
            let case = Case::new(&mut random, poses, k);
            let whole = Pose::new(random.vector(1.0), random.rotation(PI));
            let bend = Pose::new(random.vector(0.01), random.rotation(179.0_f64.to_radians()));
            let poses = [whole * case.rest[0], whole * bend * case.rest[1]];
            let [analytic, numeric] = derivatives(&case.bound, &poses, &case.offsets);
            assert_close(&analytic, &numeric, 1e-8);
        }
    }

    #[test]
    fn a_motion_of_both_bones_moves_the_target_with_them() {
        let mut random = Random::new(8);
        for k in 0..100 {
            let poses = some_poses(&mut random, k);
            let case = Case::new(&mut random, poses, k);
            let bent = case.turned(&random.rotation(2.5));
            let motion = Pose::new(random.vector(1.0), random.rotation(PI));
            let before = posed(&case.bound, &bent, &case.offsets).position_W;
            let after = posed(&case.bound, &bent.map(|p| motion * p), &case.offsets).position_W;
            assert!((motion.point(&before) - after).norm() < 1e-13, "{k}");
        }
    }

    /// A force on the target and what it puts on the bones have no net force and no net torque
    /// (D4).
    #[test]
    fn forces_on_target_and_bones_are_in_balance() {
        let mut random = Random::new(10);
        for k in 0..100 {
            let poses = some_poses(&mut random, k);
            let case = Case::new(&mut random, poses, k);
            let bent = case.turned(&random.rotation(2.5));
            let target = posed(&case.bound, &bent, &case.offsets);
            let force = random.vector(10.0);
            let mut torque = -target.position_W.cross(&force);
            for j in 0..2 {
                torque += bent[j].position.cross(&(force * case.bound.weights[j]));
                torque += target.turning.torque(j, &force);
            }
            assert!(torque.norm() < 1e-12, "{torque}");
        }
    }

    /// With one pose at 90°, n is 1 and the coefficients are (−2/3, 4/3) of its offset: at 45° both
    /// samples have cos² 22.5°.
    #[test]
    fn between_poses_offsets_follow_the_kernel() {
        let mut random = Random::new(12);
        let case = Case::new(&mut random, about_x(&[FRAC_PI_2]), 0);
        let share = case.shift(&case.turned(&about_x(&[FRAC_PI_4])[0])).norm();
        let whole = case.given.offsets[0].norm();
        let expected = 2.0 / 3.0 * (FRAC_PI_4 / 2.0).cos().powi(2);
        assert!((share / whole - expected).abs() < 1e-12, "{share}");
    }

    /// A full turn of the child: half a turn, where linear blending of rotations jumps, is nothing
    /// special to offsets.
    #[test]
    fn offsets_are_smooth_all_round() {
        let mut random = Random::new(13);
        let mut case = Case::new(&mut random, about_x(&[0.5, 1.0, 1.5]), 1);
        case.bound.weights = [1.0, 0.0];
        let at =
            |k: i32| case.shift(&case.turned(&about_x(&[2.0 * PI * f64::from(k) / 3600.0])[0]));
        let moved = |k: i32| (at(k) - at(k - 1)).norm();
        let fastest = (1..=3600).map(moved).fold(0.0, f64::max);
        let bend = (2..=3600).map(|k| (moved(k) - moved(k - 1)).abs()).fold(0.0, f64::max);
        assert!(fastest > 0.0 && bend < 0.02 * fastest, "{bend} of {fastest}");
        assert!((at(0) - at(3600)).norm() < 1e-12);
    }

    /// Offsets that grow with the angle, known each 30°, at all angles between: within 2 % of the
    /// largest.
    #[test]
    fn offsets_that_grow_with_the_angle_do_so_between_poses() {
        let mut random = Random::new(15);
        let angles: Vec<f64> = (1..=4).map(|s| f64::from(s) * PI / 6.0).collect();
        let mut case = Case::new(&mut random, about_x(&angles), 1);
        case.give(angles.iter().map(|angle| Vec3::z() * (0.01 * angle)).collect());
        for k in 0..=120 {
            let angle = f64::from(k).to_radians();
            let shift = case.shift(&case.turned(&about_x(&[angle])[0])).norm();
            let most = 0.01 * angles[3];
            assert!((shift - 0.01 * angle).abs() < 0.02 * most, "{k}°: {shift}");
        }
    }

    /// Offsets that are alike at uneven poses stay so between the near ones, fade between far ones,
    /// and swing nowhere beyond what was given by more than a third.
    #[test]
    fn uneven_poses_do_not_make_offsets_swing() {
        let mut random = Random::new(17);
        for angles in [&[10.0, 20.0, 30.0, 120.0][..], &[5.0, 10.0, 90.0], &[1.0, 2.0, 90.0]] {
            let radians: Vec<f64> = angles.iter().map(|a: &f64| a.to_radians()).collect();
            let mut case = Case::new(&mut random, about_x(&radians), 1);
            case.give(vec![Vec3::z() * 1e-3; angles.len()]);
            for k in 0..=240 {
                let turn = &about_x(&[f64::from(k).to_radians() / 2.0])[0];
                let shift = case.shift(&case.turned(turn)).norm();
                assert!(shift < 1.34e-3, "{angles:?}, {}°: {shift}", f64::from(k) / 2.0);
            }
        }
    }

    /// A grid of flexion and abduction, 20 and 15° apart: an offset that grows with flexion does so
    /// all over the grid, within 6 % of its largest.
    #[test]
    fn poses_about_two_axes_are_interpolated() {
        let mut random = Random::new(18);
        let turn = |[about_y, about_x]: [f64; 2]| {
            Quat::from_scaled_axis(Vec3::y() * about_y.to_radians())
                * Quat::from_scaled_axis(Vec3::x() * about_x.to_radians())
        };
        let grid = |step: [f64; 2]| -> Vec<[f64; 2]> {
            let (rows, columns) = ((60.0 / step[0]) as i32, (100.0 / step[1]) as i32);
            let at = |i, j| [f64::from(i) * step[0] - 30.0, f64::from(j) * step[1] - 20.0];
            (0..=rows).flat_map(|i| (0..=columns).map(move |j| at(i, j))).collect()
        };
        let known: Vec<[f64; 2]> =
            grid([15.0, 20.0]).into_iter().filter(|a| *a != [0.0; 2]).collect();
        let mut case = Case::new(&mut random, known.iter().map(|a| turn(*a)).collect(), 1);
        case.give(known.iter().map(|[_, x]| Vec3::z() * (x * 1e-4)).collect());
        let along_W = case.pair.model_WM * Vec3::z();
        for angles in grid([5.0, 5.0]) {
            case.bound.weights = [1.0, 0.0];
            let poses = case.turned(&turn(angles));
            let shift_W = case.carried(&poses).inverse() * case.shift(&poses);
            let off = shift_W.dot(&along_W) - angles[1] * 1e-4;
            assert!(off.abs() < 0.06 * 80e-4, "{angles:?}: {off}");
        }
    }

    /// Many poses about one axis, all round: as many as the kernel must have dimensions for.
    #[test]
    fn poses_all_round_an_axis_can_be_told_apart() {
        let mut random = Random::new(16);
        for count in 2..12 {
            let angles: Vec<f64> =
                (1..count).map(|s| 2.0 * PI * f64::from(s) / f64::from(count)).collect();
            Case::new(&mut random, about_x(&angles), 0);
        }
    }

    #[test]
    fn poses_that_are_the_same_are_refused() {
        let mut random = Random::new(14);
        let case = Case::new(&mut random, about_x(&[0.5]), 0);
        for angles in
            [&[0.0][..], &[0.5, 0.5], &[0.5, 0.5 + 1e-5], &[0.5, 0.51], &[1.0, 1.0 + 2.0 * PI]]
        {
            let given = PoseOffsets {
                poses: about_x(angles),
                offsets: vec![Vec3::x(); angles.len()],
                ..case.given.clone()
            };
            assert!(
                OffsetModel::default().push(&given, &case.pair, &[true]).is_none(),
                "{angles:?}"
            );
        }
    }
}
