//! Calibration to a tracked hand: the turn of its tracker's wrist frame, and its size.

use super::recording::mirrored;
use super::retarget::tracked_index;
use thenar_core::model::HandModel;
use thenar_core::{Mat3, Pose, Quat, Vec3};

/// A tracked hand is larger than ours by a factor within these, or it is none.
pub(crate) const RATIOS: std::ops::RangeInclusive<f64> = 0.3..=3.0;
/// The knuckles of the four fingers among the tracked joints.
const KNUCKLES: [usize; 4] = [6, 11, 16, 21];

/// Directions from the wrist to the four knuckles, ours and those of a tracked hand.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Knuckles {
    /// In our wrist frame; `None` where our hand lacks the finger.
    ours: [Option<Vec3>; 4],
    /// Sums over the samples, in the tracked wrist frame.
    tracked: [Vec3; 4],
}

impl Knuckles {
    /// Knuckles of `hand`, and no sample yet.
    pub fn of(hand: &HandModel) -> Self {
        let wrist_M =
            hand.bones.first().map_or(Pose::identity(), |palm| palm.pose_MB * palm.pose_BT);
        let direction = |knuckle: usize| {
            let bone = hand.bones.iter().find(|bone| tracked_index(bone) == Some(knuckle))?;
            let place = (bone.pose_MB * bone.pose_BT).position;
            wrist_M.inverse_point(&place).try_normalize(1e-9)
        };
        Self { ours: KNUCKLES.map(direction), tracked: [Vec3::zeros(); 4] }
    }

    /// Takes in a sample; `mirror` when it is of the other side.
    pub fn take(&mut self, joints: &[Pose; 25], mirror: bool) {
        let place = |k: usize| if mirror { mirrored(&joints[k]) } else { joints[k] };
        let wrist = place(0);
        for (sum, knuckle) in self.tracked.iter_mut().zip(KNUCKLES) {
            let away = wrist.inverse_point(&place(knuckle).position);
            *sum += away.try_normalize(1e-6).unwrap_or_else(Vec3::zeros);
        }
    }

    /// Forgets all samples.
    pub fn forget(&mut self) {
        self.tracked = [Vec3::zeros(); 4];
    }

    /// Sums of the directions seen, in the tracked wrist frame.
    pub fn sums(&self) -> [Vec3; 4] {
        self.tracked
    }

    /// Goes on from such sums.
    pub fn set_sums(&mut self, sums: [Vec3; 4]) {
        self.tracked = sums;
    }

    /// Rotation `R` of least squared error in `d_tracked = R d_ours` over the mean directions:
    /// from our wrist frame to the tracked one. The identity when fewer than two are known.
    pub fn wrist_offset(&self) -> Quat {
        let mut correlation = Mat3::zeros();
        let mut found = 0;
        for (ours, sum) in self.ours.iter().zip(&self.tracked) {
            if let (Some(ours), Some(mean)) = (ours, sum.try_normalize(1e-6)) {
                correlation += mean * ours.transpose();
                found += 1;
            }
        }
        if found < 2 { Quat::identity() } else { nearest_rotation(&correlation) }
    }
}

/// The rotation nearest to `correlation`, by singular values with the sign of the last fixed.
fn nearest_rotation(correlation: &Mat3) -> Quat {
    let svd = correlation.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Quat::identity() };
    let sign = (u * v_t).determinant().signum();
    let R = u * Mat3::from_diagonal(&Vec3::new(1.0, 1.0, sign)) * v_t;
    Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(R))
}

/// Distances between the joints of neighbouring bones, to tell how large a tracked hand is.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct BoneLengths {
    /// Tracked joints whose distance is compared.
    pairs: Vec<[usize; 2]>,
    /// Sum of our distances \[m\].
    ours: f64,
}

impl BoneLengths {
    /// Lengths of the bones of `hand`.
    pub fn of(hand: &HandModel) -> Self {
        let origin = |b: usize| (hand.bones[b].pose_MB * hand.bones[b].pose_BT).position;
        let mut lengths = Self { pairs: Vec::new(), ours: 0.0 };
        for b in 1..hand.bones.len() {
            let Some(parent) = hand.bones[b].parent.map(|p| p as usize) else { continue };
            let ends = [b, parent].map(|bone| hand.bones.get(bone).and_then(tracked_index));
            if let [Some(child), Some(above)] = ends {
                lengths.pairs.push([child, above]);
                lengths.ours += (origin(b) - origin(parent)).norm();
            }
        }
        lengths
    }

    /// Returns the size of a tracked hand over ours; `None` when nothing is comparable.
    pub fn ratio(&self, joints: &[Pose; 25]) -> Option<f64> {
        let distance = |[a, b]: &[usize; 2]| (joints[*a].position - joints[*b].position).norm();
        let ratio = self.pairs.iter().map(distance).sum::<f64>() / self.ours;
        Some(ratio).filter(|ratio| ratio.is_finite() && *ratio > 0.0)
    }
}
