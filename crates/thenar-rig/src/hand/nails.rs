//! The nodes of the flesh that stand for nails and their beds.
//!
//! A nail plate is three orders of magnitude stiffer than flesh, and its bed, a millimetre or two
//! of dense fibres without fat, ties it to the bone under it. So nails move with the last bones:
//! the inside points between a nail and its bone give their volume to the nodes of their
//! tetrahedra, which springs hold as those in bone. The plate itself, which bends between its
//! edges, is skin with a modulus of its own.

use super::sides::Sides;
use crate::lattice::{Lattice, tet};
use crate::mesh::Bvh;
use std::collections::BTreeMap;
use thenar_core::model::{Binding, Bone, BoneNode, Digit, HandRegion};

/// Depth of a nail and its bed under the skin, relative to the hand's length: what the last bones
/// leave on the back (`solids`), 2.5 mm of 190.
const BED: f64 = 2.5 / 190.0;

/// Nodes that stand for nails and their beds, ascending.
pub(super) fn nail_nodes(
    lattice: &Lattice,
    bones: &[Bone],
    sides: &Sides,
    surface: &Bvh,
    length: f64,
) -> Vec<BoneNode> {
    let volume = lattice.filled.iter().sum::<f64>() / lattice.sample_count() as f64;
    let mut shares: BTreeMap<u32, (u32, f64)> = BTreeMap::new();
    // Elements are coarse beside a nail: of their nodes those on the back stand for it, those in
    // the pad stay free.
    let on_back: Vec<bool> = (lattice.nodes.iter())
        .map(|x| matches!(sides.of(x).0, HandRegion::Nail | HandRegion::Back))
        .collect();
    for i in 0..lattice.sample_count() {
        let p = lattice.sample_position(i);
        let (HandRegion::Nail, Some(digit)) = sides.of(&p) else { continue };
        if surface.closest_within(&p, BED * length).is_none() {
            continue;
        }
        let Some(bone) = last_bone(bones, Digit::FINGERS[digit]) else { continue };
        let t = lattice.sample_tet(i) as usize;
        let weights = tet::barycentric(&lattice.corners(t), &p);
        let nodes = lattice.tets[t].iter().zip(weights);
        for (node, weight) in nodes.filter(|(node, _)| on_back[**node as usize]) {
            let share = shares.entry(*node).or_insert((bone, 0.0));
            share.1 += volume * weight.max(0.0);
        }
    }
    let node = |(&node, &(bone, volume)): (&u32, &(u32, f64))| {
        let binding = Binding { bones: [bone; 2], weights: [1.0, 0.0] };
        (volume > 0.0).then_some(BoneNode { node, binding, volume })
    };
    shares.iter().filter_map(node).collect()
}

fn last_bone(bones: &[Bone], digit: Digit) -> Option<u32> {
    bones.iter().rposition(|bone| bone.digit == digit).map(|b| b as u32)
}
