//! Goal: the nodes that stand for bone hold each bone where it lies, whatever the mesh. Method: the
//! volumes that they stand for are compared with the solids' own; barycentric weights keep the
//! centre of mass.

use thenar_core::Vec3;
use thenar_core::model::{HandModel, Side};
use thenar_core::shape::Shape;
use thenar_rig::HandReport;
use thenar_rig::hand::{HandOptions, Size, asset, build_hand_with_report};

fn hand(side: Side, tets: usize, length: f64) -> (HandModel, HandReport) {
    let options = HandOptions { tets, size: Size::Length(length), ..HandOptions::paper() };
    build_hand_with_report(asset(side), &options).unwrap()
}

/// Largest extent of a solid \[m\].
fn extent(shape: &Shape) -> f64 {
    match *shape {
        Shape::Compound(ref parts) => extent(&parts[0].shape),
        Shape::Capsule { radius, half_length } => 2.0 * (radius + half_length),
        Shape::Cuboid { half } => 2.0 * half.norm(),
        ref other => panic!("the solid of a bone is a {other:?}"),
    }
}

/// Every bone is held, by nodes that stand for most of its volume. The rest lies at nodes of coarse
/// elements that reach from one finger's bones to another's and follow only one.
fn check_bones_are_held(side: Side, tets: usize, length: f64) {
    let (hand, report) = hand(side, tets, length);
    for cover in &report.bone_covers {
        let what = format!("{side:?}, {tets} tetrahedra, {length} m: {cover:?}");
        assert!(cover.nodes >= 4, "{what}");
        assert!(cover.bound > 0.4 * cover.volume && cover.bound < 1.1 * cover.volume, "{what}");
        assert!(cover.dorsal >= cover.flesh - 1e-4 && cover.palmar >= cover.flesh - 1e-4, "{what}");
    }
    // All volumes together are no more than those of all solids.
    let bound: f64 = hand.bone_nodes.iter().map(|n| n.volume).sum();
    let solid: f64 = report.bone_covers.iter().map(|c| c.volume).sum();
    assert!(bound > 0.8 * solid && bound < solid * (1.0 + 1e-9), "{bound} m³ of {solid} m³");
}

#[test]
fn every_bone_is_held_in_coarse_and_fine_flesh() {
    for side in [Side::Right, Side::Left] {
        for tets in [300, 600, 2000, 20_000] {
            check_bones_are_held(side, tets, 0.19);
        }
    }
}

#[test]
fn every_bone_is_held_in_small_and_large_hands() {
    for side in [Side::Right, Side::Left] {
        for length in [0.051, 0.499] {
            check_bones_are_held(side, 300, length);
        }
    }
}

/// The centre of what a bone's nodes stand for is that of its solid, up to the distance of inside
/// points: a twentieth of the solid in fine flesh.
#[test]
fn a_bone_is_held_at_its_middle() {
    let (hand, _) = hand(Side::Right, 20_000, 0.19);
    for (b, (bone, solid)) in hand.bones.iter().zip(&hand.solids).enumerate() {
        let (mut sum, mut volume) = (Vec3::zeros(), 0.0);
        for node in &hand.bone_nodes {
            for k in (0..2).filter(|&k| node.binding.bones[k] as usize == b) {
                let share = node.binding.weights[k] * node.volume;
                sum += hand.flesh.nodes[node.node as usize] * share;
                volume += share;
            }
        }
        let off = (sum / volume - (bone.pose_MB * solid.pose_BS).position).norm();
        assert!(off < 0.05 * extent(&solid.shape), "{}: {off} m", bone.name);
    }
}

/// Nodes of elements that no bone reaches are free, and skin lies on them in fine flesh.
#[test]
fn what_lies_between_bone_and_skin_is_free() {
    let (hand, _) = hand(Side::Right, 20_000, 0.19);
    let mut held = vec![false; hand.flesh.nodes.len()];
    hand.bone_nodes.iter().for_each(|n| held[n.node as usize] = true);
    let skin = &hand.flesh.collision.vertices;
    let free = |v: &thenar_core::model::SurfaceVertex| {
        hand.flesh.tets[v.tet as usize].iter().all(|&n| !held[n as usize])
    };
    let share = skin.iter().filter(|v| free(v)).count() as f64 / skin.len() as f64;
    assert!(share > 0.5, "{share} of the skin is free");
    assert!(hand.bone_nodes.iter().all(|n| n.volume > 0.0));
}
