//! From the 25 tracked joints of a person's hand to the joint angles of ours.
//!
//! Bone lengths differ, so rotations are carried over, positions only for the wrist and for pads
//! that come near each other (see `Meeting`). Each of our bones takes the rotation of the tracked
//! joint at its proximal end, and the tree takes the nearest admissible angles. Both use the same
//! frames (-z along the bone, +y out of the back) for phalanges, where the bone itself fixes the
//! axis. A wrist frame is a convention of the tracker instead, so it is calibrated: the constant
//! rotation that best lays the directions from the wrist to the four knuckles of our hand on those
//! of the tracked one [Kabsch 1976].

use super::articulation::Articulation;
use super::calibration::{BoneLengths, Knuckles};
use super::meeting::Meeting;
use super::recording::{TRACKED_JOINTS, TrackedSample, mirrored};
use crate::FitError;
use thenar_core::model::{Bone, HandModel};
use thenar_core::{Pose, Quat};

/// Samples looked at for calibration, evenly over the recording.
const CALIBRATION_SAMPLES: usize = 500;

/// Carries tracked poses over to one hand.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
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
    /// Pads that may meet; `None` for a hand without a thumb or fingers.
    pub(crate) meeting: Option<Meeting>,
}

impl Retarget {
    /// Fits `hand` to a recording of a hand; `mirror` when it is of the other side.
    pub fn new(
        hand: &HandModel,
        samples: &[TrackedSample],
        mirror: bool,
    ) -> Result<Self, FitError> {
        let mut retarget = Self::uncalibrated(hand, mirror)?;
        let mut knuckles = Knuckles::of(hand);
        spread_over(samples).for_each(|sample| knuckles.take(&sample.joints, mirror));
        retarget.wrist_offset = knuckles.wrist_offset();
        Ok(retarget)
    }

    /// A retargeting that takes the tracker's wrist frame, not yet known, for ours.
    pub fn uncalibrated(hand: &HandModel, mirror: bool) -> Result<Self, FitError> {
        let tracked: Vec<_> = hand.bones.iter().map(tracked_index).collect();
        if tracked.first() != Some(&Some(0)) {
            return Err(FitError::NoWrist { hand: hand.name.clone() });
        }
        let parent = |b: usize| hand.bones[b].parent.map_or(0, |p| p as usize);
        let pose_PB = (0..hand.bones.len())
            .map(|b| hand.bones[parent(b)].pose_MB.inverse() * hand.bones[b].pose_MB)
            .collect();
        let rotation_TB = hand.bones.iter().map(|bone| bone.pose_BT.rotation.inverse()).collect();
        let (wrist_offset, meeting) = (Quat::identity(), Meeting::of(hand));
        Ok(Self { tracked, rotation_TB, pose_PB, wrist_offset, mirror, meeting })
    }

    /// Rotation from our wrist frame to the tracked one, found by calibration.
    pub fn wrist_offset(&self) -> Quat {
        self.wrist_offset
    }

    /// Changes that rotation, when more is known.
    pub fn set_wrist_offset(&mut self, wrist_offset: Quat) {
        self.wrist_offset = wrist_offset;
    }

    /// Lets pads that touch on the tracked hand touch on ours and no more: for forces that its
    /// wearer feels, whose own fingers press on each other already.
    pub fn without_press(&mut self) {
        self.meeting.iter_mut().for_each(Meeting::without_press);
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
        let joints = if self.mirror { joints.each_ref().map(mirrored) } else { *joints };
        let mut wrist = joints[0];
        wrist.rotation *= self.wrist_offset;
        wanted[0] = wrist * articulation.pose_BT.inverse();
        for b in 1..wanted.len() {
            wanted[b] = wanted[tree.parent(b - 1)] * self.pose_PB[b];
            if let Some(k) = self.tracked[b] {
                wanted[b].rotation = joints[k].rotation * self.rotation_TB[b];
            }
        }
        tree.project(wanted, angles, poses);
        if let Some(meeting) = &self.meeting {
            meeting.apply(&joints, &wanted[0].rotation, angles);
        }
        wrist
    }
}

/// Returns the size of the tracked hand over that of `hand`: the median over the recording of the
/// ratio of summed distances between the joints of neighbouring bones. `None` when nothing is
/// comparable.
pub fn size_ratio(hand: &HandModel, samples: &[TrackedSample]) -> Option<f64> {
    let bones = BoneLengths::of(hand);
    let mut ratios: Vec<f64> =
        spread_over(samples).filter_map(|sample| bones.ratio(&sample.joints)).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied()
}

pub(crate) fn tracked_index(bone: &Bone) -> Option<usize> {
    let name = bone.tracked_joint.as_deref()?;
    TRACKED_JOINTS.iter().position(|joint| *joint == name)
}

fn spread_over(samples: &[TrackedSample]) -> impl Iterator<Item = &TrackedSample> {
    samples.iter().step_by(samples.len().div_ceil(CALIBRATION_SAMPLES).max(1))
}
