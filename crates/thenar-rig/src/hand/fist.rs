//! The hand closed to a fist by skinning alone, to see what becomes of its elements.

use crate::RigError;
use crate::lattice::tet;
use thenar::model::{Binding, Bone, Digit, HandModel, JointKind};
use thenar::skeleton::Tree;
use thenar::{Pose, Vec3};

/// Elements turned inside out.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Inversions {
    /// How many.
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
    let rest: Vec<Pose> = hand.bones.iter().map(|b| b.pose_MB).collect();
    let tree = Tree::of_hand(hand).map_err(|e| RigError::invalid(e.to_string()))?;
    let mut bent = rest.clone();
    tree.forward(&rest[0], &angles(hand, closing), &mut bent);
    let nodes = skin(&hand.bones, &bent, &hand.bindings, &hand.flesh.nodes);
    Ok(inversions(hand, &nodes))
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
pub(crate) fn skin(
    bones: &[Bone],
    poses: &[Pose],
    bindings: &[Binding],
    points: &[Vec3],
) -> Vec<Vec3> {
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

fn inversions(hand: &HandModel, nodes: &[Vec3]) -> Inversions {
    let full = hand.flesh.materials.iter().map(|m| m.density).fold(0.0, f64::max);
    let (mut whole, mut lost) = (0.0, 0.0);
    let mut found = Inversions { tets: 0, volume_fraction: 0.0, det_min: f64::INFINITY };
    for (tet, material) in hand.flesh.tets.iter().zip(&hand.flesh.materials) {
        let rest = tet.map(|n| hand.flesh.nodes[n as usize]);
        let volume = tet::volume(&rest) * material.density / full;
        let det = tet::stretch(&rest, &tet.map(|n| nodes[n as usize]));
        whole += volume;
        found.det_min = found.det_min.min(det);
        if det <= 0.0 {
            found.tets += 1;
            lost += volume;
        }
    }
    found.volume_fraction = lost / whole;
    found
}
