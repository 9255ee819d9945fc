//! The digits of a rig at rest: joint places, directions and flexion axes.
//!
//! Rigs made by artists have joint axes that are a few degrees off one another along a finger. A
//! finger's phalanges move in one plane, so each digit gets one flexion axis: the mean of its
//! joints' own (WebXR: -x), made perpendicular to the line from its first moving joint to its tip.

use super::names;
use super::rig::Posed;
use crate::RigError;
use crate::mesh::Bvh;
use thenar_core::model::{Digit, Side};
use thenar_core::{Pose, Vec3};

/// One digit at rest in the model frame M.
#[derive(Clone, Debug)]
pub(super) struct DigitRig {
    pub digit: Digit,
    /// Place at which the digit's ray leaves the wrist: the base of the metacarpal.
    pub base: Vec3,
    /// Tracked joints at the proximal ends of the three moving bones.
    pub joints: [Pose; 3],
    /// WebXR names of the joints.
    pub joint_names: [String; 3],
    /// End of the last bone, under the pulp.
    pub end: Vec3,
    /// Skin at the tip of the digit.
    pub tip: Vec3,
    /// Unit axis about which a positive turn closes the digit.
    pub flexion: Vec3,
}

impl DigitRig {
    /// Proximal and distal end of moving bone `k`.
    pub fn bone(&self, k: usize) -> [Vec3; 2] {
        let end = if k < 2 { self.joints[k + 1].position } else { self.end };
        [self.joints[k].position, end]
    }

    /// Unit direction of moving bone `k`.
    pub fn direction(&self, k: usize) -> Vec3 {
        let [a, b] = self.bone(k);
        (b - a).normalize()
    }

    /// Unit direction of what comes before moving bone `k`.
    pub fn direction_before(&self, k: usize) -> Vec3 {
        match k {
            0 => (self.joints[0].position - self.base).normalize(),
            _ => self.direction(k - 1),
        }
    }
}

/// Thickness of the pulp beyond the end of the bone, relative to the length of the hand: 5.7 mm
/// at the thumb and 3.8-4.0 mm at the fingers (Buryanov & Kotiuk 2010) of a 190 mm hand.
fn pulp(digit: Digit) -> f64 {
    if digit == Digit::Thumb { 5.7 / 190.0 } else { 4.0 / 190.0 }
}

/// Reads a digit. `surface` is the hand's skin and `length` the hand's length.
pub(super) fn read(
    rig: &Posed<'_>,
    digit: Digit,
    surface: &Bvh,
    length: f64,
) -> Result<DigitRig, RigError> {
    let prefix = names::prefix(digit);
    let poses = rig.digit(digit, surface)?;
    let moving = poses.len() - 4;
    let joints: [Pose; 3] = std::array::from_fn(|k| poses[moving + k]);
    let joint_names =
        std::array::from_fn(|k| format!("{prefix}-{}", names::suffixes(digit)[moving + k]));

    let tracked_tip = poses[poses.len() - 1].position;
    let along = (tracked_tip - joints[2].position).normalize();
    let tip = leave(surface, &tracked_tip, &along, length);
    let end = tip - along * pulp(digit) * length;

    let axis: Vec3 = joints.iter().map(|j| -j.vector(&Vec3::x())).sum();
    let line = (tracked_tip - joints[0].position).normalize();
    let flexion = (axis - line * line.dot(&axis)).try_normalize(1e-3).ok_or_else(|| {
        RigError::invalid(format!("the joint axes of the {} do not agree", digit.name()))
    })?;
    let base = if digit == Digit::Thumb { rig.thumb_base() } else { poses[0].position };
    Ok(DigitRig { digit, base, joints, joint_names, end, tip, flexion })
}

/// Steps on the way out of the skin at most.
pub(super) const WAY_MAX: usize = 64;

/// Finds the place at which a ray from inside leaves the skin, by steps of the distance to it.
pub(super) fn leave(surface: &Bvh, from: &Vec3, along: &Vec3, length: f64) -> Vec3 {
    let mut at = *from;
    for _ in 0..WAY_MAX {
        let distance = surface.signed_distance(&at);
        if distance > -1e-6 * length {
            break;
        }
        at -= along * distance;
    }
    at
}

/// The side on which the thumb says this hand is: in the wrist's frame the thumb of a right hand
/// lies towards -x.
pub(super) fn side(digits: &[DigitRig]) -> Side {
    if digits[0].tip.x < digits[2].tip.x { Side::Right } else { Side::Left }
}
