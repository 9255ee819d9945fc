//! From the 25 tracked joints of a person's hand to the joint angles of ours.
//!
//! Bone lengths differ, so rotations are carried over, positions only for the wrist. Each of our
//! bones takes the rotation of the tracked joint at its proximal end, and the tree takes the
//! nearest admissible angles. Both use the same frames (-z along the bone, +y out of the back)
//! for phalanges, where the bone itself fixes the axis. A wrist frame is a convention of the
//! tracker instead, so it is calibrated: the constant rotation that best lays the directions from
//! the wrist to the four knuckles of our hand on those of the tracked one [Kabsch 1976].

use super::articulation::Articulation;
use super::error::MotionError;
use super::recording::{TRACKED_JOINTS, TrackedSample, mirrored};
use thenar::model::{Bone, HandModel};
use thenar::{Mat3, Pose, Quat, Vec3};

/// The knuckles of the four fingers among the tracked joints.
const KNUCKLES: [usize; 4] = [6, 11, 16, 21];
/// Samples looked at for calibration, evenly over the recording.
const CALIBRATION_SAMPLES: usize = 500;

/// Carries tracked poses over to one hand.
#[derive(Clone, Debug)]
pub struct Retarget {
    /// Per bone: the tracked joint at its proximal end.
    tracked: Vec<Option<usize>>,
    /// Per bone: that joint's frame in the bone, inverted.
    rotation_TB: Vec<Quat>,
    /// Per bone: its rest pose in its parent.
    pose_PB: Vec<Pose>,
    /// Our wrist frame in the tracked wrist frame.
    wrist_offset: Quat,
    mirror: bool,
}

impl Retarget {
    /// Fits `hand` to a recording of a hand; `mirror` when it is of the other side.
    pub fn new(
        hand: &HandModel,
        samples: &[TrackedSample],
        mirror: bool,
    ) -> Result<Self, MotionError> {
        let tracked: Vec<_> = hand.bones.iter().map(tracked_index).collect();
        if tracked.first() != Some(&Some(0)) {
            return Err(MotionError::NoWrist { hand: hand.name.clone() });
        }
        let parent = |b: usize| hand.bones[b].parent.map_or(0, |p| p as usize);
        let pose_PB = (0..hand.bones.len())
            .map(|b| hand.bones[parent(b)].pose_MB.inverse() * hand.bones[b].pose_MB)
            .collect();
        let rotation_TB = hand.bones.iter().map(|bone| bone.pose_BT.rotation.inverse()).collect();
        let wrist_offset = wrist_offset(hand, &tracked, samples, mirror);
        Ok(Self { tracked, rotation_TB, pose_PB, wrist_offset, mirror })
    }

    /// Rotation from our wrist frame to the tracked one, found by calibration.
    pub fn wrist_offset(&self) -> Quat {
        self.wrist_offset
    }

    /// Our wrist in the recording's space, and the joint angles \[rad\], for tracked joints.
    /// `wanted` and `poses` are scratch, one entry per bone.
    pub fn apply(
        &self,
        articulation: &Articulation,
        joints: &[Pose; 25],
        angles: &mut [[f64; 2]],
        wanted: &mut [Pose],
        poses: &mut [Pose],
    ) -> Pose {
        let tree = &articulation.tree;
        let tracked = |k: usize| if self.mirror { mirrored(&joints[k]) } else { joints[k] };
        let mut wrist = tracked(0);
        wrist.rotation *= self.wrist_offset;
        wanted[0] = wrist * articulation.pose_BT.inverse();
        for b in 1..wanted.len() {
            wanted[b] = wanted[tree.parent(b - 1)] * self.pose_PB[b];
            if let Some(k) = self.tracked[b] {
                wanted[b].rotation = tracked(k).rotation * self.rotation_TB[b];
            }
        }
        tree.project(wanted, angles, poses);
        wrist
    }
}

/// How much larger the tracked hand is than `hand`: median over the recording of the ratio of
/// summed distances between the joints of neighbouring bones. `None` when nothing is comparable.
pub fn size_ratio(hand: &HandModel, samples: &[TrackedSample]) -> Option<f64> {
    let tracked: Vec<_> = hand.bones.iter().map(tracked_index).collect();
    let origin = |b: usize| (hand.bones[b].pose_MB * hand.bones[b].pose_BT).position;
    let pairs: Vec<_> = (1..hand.bones.len())
        .filter_map(|b| {
            let parent = hand.bones[b].parent? as usize;
            let ours = (origin(b) - origin(parent)).norm();
            Some((tracked[b]?, (*tracked.get(parent)?)?, ours))
        })
        .collect();
    let ours: f64 = pairs.iter().map(|pair| pair.2).sum();
    let mut ratios: Vec<f64> = spread_over(samples)
        .map(|sample| {
            let distance =
                |a: usize, b: usize| (sample.joints[a].position - sample.joints[b].position).norm();
            pairs.iter().map(|(a, b, _)| distance(*a, *b)).sum::<f64>() / ours
        })
        .filter(|ratio| ratio.is_finite() && *ratio > 0.0)
        .collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied()
}

fn tracked_index(bone: &Bone) -> Option<usize> {
    let name = bone.tracked_joint.as_deref()?;
    TRACKED_JOINTS.iter().position(|joint| *joint == name)
}

fn spread_over(samples: &[TrackedSample]) -> impl Iterator<Item = &TrackedSample> {
    samples.iter().step_by(samples.len().div_ceil(CALIBRATION_SAMPLES).max(1))
}

/// Rotation `R` of least squared error in `d_tracked = R d_ours` over the knuckle directions.
fn wrist_offset(
    hand: &HandModel,
    tracked: &[Option<usize>],
    samples: &[TrackedSample],
    mirror: bool,
) -> Quat {
    let wrist_M = hand.bones[0].pose_MB * hand.bones[0].pose_BT;
    let mut correlation = Mat3::zeros();
    let mut found = 0;
    for knuckle in KNUCKLES {
        let Some(b) = tracked.iter().position(|k| *k == Some(knuckle)) else { continue };
        let place = (hand.bones[b].pose_MB * hand.bones[b].pose_BT).position;
        let ours = wrist_M.inverse_point(&place);
        let mean = mean_direction(samples, knuckle, mirror);
        if let (Some(ours), Some(mean)) = (ours.try_normalize(1e-9), mean) {
            correlation += mean * ours.transpose();
            found += 1;
        }
    }
    // Two directions fix a rotation; fewer leave the frames as they are.
    if found < 2 { Quat::identity() } else { nearest_rotation(&correlation) }
}

/// Mean direction from the wrist to a tracked joint, in the tracked wrist frame.
fn mean_direction(samples: &[TrackedSample], joint: usize, mirror: bool) -> Option<Vec3> {
    let sum: Vec3 = spread_over(samples)
        .map(|sample| {
            let [wrist, joint] = [0, joint].map(|k| match mirror {
                true => mirrored(&sample.joints[k]),
                false => sample.joints[k],
            });
            wrist.inverse_point(&joint.position).try_normalize(1e-6).unwrap_or_else(Vec3::zeros)
        })
        .sum();
    sum.try_normalize(1e-6)
}

/// The rotation nearest to `correlation`, by singular values with the sign of the last fixed.
fn nearest_rotation(correlation: &Mat3) -> Quat {
    let svd = correlation.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Quat::identity() };
    let sign = (u * v_t).determinant().signum();
    let R = u * Mat3::from_diagonal(&Vec3::new(1.0, 1.0, sign)) * v_t;
    Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(R))
}
