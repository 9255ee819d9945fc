//! The hand closed to a fist by skinning alone, to see what becomes of its elements.

use crate::RigError;
use crate::lattice::tet;
use thenar_core::kinematics::Tree;
use thenar_core::model::{Binding, Bone, Digit, HandModel, JointKind};
use thenar_core::{Pose, Vec3};

/// Elements turned inside out.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Inversions {
    /// Number of elements.
    pub tets: usize,
    /// The part of the body's volume in them, 0..1.
    pub volume_fraction: f64,
    /// Smallest `det F` of all elements.
    pub det_min: f64,
}

/// Active flexion of the three joints of a finger \[°\]: healthy means 87, 97 and 83.
const FINGER: [f64; 3] = [87.0, 97.0, 83.0];
/// The thumb across the palm \[°\].
const THUMB: [f64; 3] = [15.0, 50.0, 70.0];

/// Skins the nodes of a hand closed by `closing` (0 rest, 1 a full fist) and counts.
///
/// # Errors
/// When the model's joints do not make a tree.
pub fn fist(hand: &HandModel, closing: f64) -> Result<Inversions, RigError> {
    let flesh = &hand.flesh;
    let dets = stretches(hand, &pose(hand, closing)?);
    // Density goes with the filled fraction, so this weighs elements by the body in them.
    let weight = |t: usize| {
        let volume = tet::volume(&flesh.tets[t].map(|n| flesh.nodes[n as usize]));
        volume * flesh.materials[t].density
    };
    let lost: Vec<usize> = (0..dets.len()).filter(|&t| dets[t] <= 0.0).collect();
    Ok(Inversions {
        tets: lost.len(),
        volume_fraction: lost.iter().map(|&t| weight(t)).sum::<f64>()
            / (0..dets.len()).map(weight).sum::<f64>(),
        det_min: dets.iter().copied().fold(f64::INFINITY, f64::min),
    })
}

/// Poses of the bones of a hand closed by `closing`.
pub(super) fn pose(hand: &HandModel, closing: f64) -> Result<Vec<Pose>, RigError> {
    let mut poses: Vec<Pose> = hand.bones.iter().map(|b| b.pose_MB).collect();
    let tree = Tree::of_hand(hand).map_err(|e| RigError::invalid(e.to_string()))?;
    let root = poses[0];
    tree.forward(&root, &angles(hand, closing), &mut poses);
    Ok(poses)
}

/// The elements that skinning to these bone poses turns inside out.
pub(super) fn inverted(hand: &HandModel, poses: &[Pose]) -> Vec<usize> {
    let dets = stretches(hand, poses);
    (0..dets.len()).filter(|&t| dets[t] <= 0.0).collect()
}

/// `det F` of every element under skinning.
fn stretches(hand: &HandModel, poses: &[Pose]) -> Vec<f64> {
    let rest = &hand.flesh.nodes;
    let nodes = skin(&hand.bones, poses, &hand.bindings, rest);
    let at = |x: &[Vec3], tet: &[u32; 4]| tet.map(|n| x[n as usize]);
    hand.flesh.tets.iter().map(|t| tet::stretch(&at(rest, t), &at(&nodes, t))).collect()
}

/// Joint angles between rest and fist, within the limits.
fn angles(hand: &HandModel, closing: f64) -> Vec<[f64; 2]> {
    let mut place = 0;
    hand.joints
        .iter()
        .map(|joint| {
            place = if joint.parent == Some(0) { 0 } else { place + 1 };
            let thumb = hand.bones[joint.child as usize].digit == Digit::Thumb;
            let wanted = if thumb { THUMB } else { FINGER }[place.min(2)].to_radians();
            let flexion = usize::from(joint.kind == JointKind::Universal);
            let mut angles = joint.axes.map(|a| a.rest_angle);
            let axis = &joint.axes[flexion];
            let wanted = axis.limit.map_or(wanted, |l| wanted.clamp(l.min, l.max));
            angles[flexion] = axis.rest_angle + closing * (wanted - axis.rest_angle);
            angles
        })
        .collect()
}

/// Linear blend skinning (Eq. 6) of points given at rest.
fn skin(bones: &[Bone], poses: &[Pose], bindings: &[Binding], points: &[Vec3]) -> Vec<Vec3> {
    let moved = |bone: u32, p: &Vec3| {
        let bone = bone as usize;
        poses[bone].point(&bones[bone].pose_MB.inverse_point(p))
    };
    points
        .iter()
        .zip(bindings)
        .map(|(p, b)| (0..2).map(|k| moved(b.bones[k], p) * b.weights[k]).sum())
        .collect()
}
