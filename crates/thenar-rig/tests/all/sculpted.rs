//! Goal: offsets by pose take skinned targets to where a hand's own flesh comes to rest. Method:
//! hands whose bones are held at poses that the offsets know, and at others between them; flesh
//! held at the bone alone is brought to rest there by small steps of a world of its own, and
//! compared with the targets of a hand that is held everywhere.

use thenar_core::kinematics::Tree;
use thenar_core::model::{
    CouplingKind, ElementPatches, HandModel, HandPlacement, Motion, PoseOffsets, Side, Skinning,
    WorldDesc, patches,
};
use thenar_core::{Pose, Vec3, World};
use thenar_rig::hand::{sculpted_offsets, uniform_hand};

/// The hand held still by such a coupling, without weight.
fn still(
    hand: &HandModel,
    coupling: CouplingKind,
    skinning: Skinning,
    offsets: &[PoseOffsets],
) -> World {
    let mut desc = WorldDesc { gravity: Vec3::zeros(), time_step: 0.1, ..WorldDesc::default() };
    desc.solver.velocity_tolerance = 1e-7;
    let placement = HandPlacement {
        name: "hand".into(),
        pose_WM: Pose::identity(),
        coupling,
        coupling_stiffness: hand.usual_coupling_stiffness(coupling),
        coupling_damping_time: 0.0,
        skinning,
        root_drive: None,
        bone_drive: None,
        solid_bones: false,
        nails: false,
    };
    desc.add_hand(hand, &placement);
    desc.self_contact.clear();
    desc.rigids.iter_mut().for_each(|bone| bone.motion = Motion::Prescribed);
    desc.pose_offsets = offsets.to_vec();
    if coupling == CouplingKind::Bone {
        let flesh = &desc.softs[0].flesh;
        let of_tet = patches(&flesh.nodes, &flesh.tets, &flesh.materials, &flesh.relaxation);
        desc.patches.push(ElementPatches { soft: 0, of_tet });
    }
    World::new(desc).unwrap()
}

/// The bones with one joint's axis turned from rest by `turn` \[rad\].
fn bent(hand: &HandModel, joint: &str, axis: usize, turn: f64) -> Vec<Pose> {
    let tree = Tree::of_hand(hand).unwrap();
    let mut poses: Vec<Pose> = hand.bones.iter().map(|bone| bone.pose_MB).collect();
    let mut angles = vec![[0.0; 2]; hand.joints.len()];
    tree.angles(&poses, &mut angles);
    let j = hand.joints.iter().position(|j| j.name == joint).unwrap();
    angles[j][axis] += turn;
    let root = poses[0];
    tree.forward(&root, &angles, &mut poses);
    poses
}

fn put(world: &mut World, poses: &[Pose]) {
    let mut state = world.state().clone();
    state.poses_WB.copy_from_slice(poses);
    assert!(world.restore(&state));
}

/// Where the flesh comes to rest, in steps of 0.1 s.
fn at_rest(hand: &HandModel, poses: &[Pose]) -> Vec<Vec3> {
    let mut world = still(hand, CouplingKind::Bone, Skinning::Linear, &[]);
    let rest: Vec<Pose> = hand.bones.iter().map(|bone| bone.pose_MB).collect();
    let parts = 20;
    for part in 1..=parts {
        let share = f64::from(part) / f64::from(parts);
        let between: Vec<Pose> = rest
            .iter()
            .zip(poses)
            .map(|(a, b)| {
                Pose::new(a.position.lerp(&b.position, share), a.rotation.slerp(&b.rotation, share))
            })
            .collect();
        put(&mut world, &between);
        let input = world.input();
        for _ in 0..if part == parts { 300 } else { 3 } {
            world.step(&input, &mut ());
        }
    }
    world.nodes(0).to_vec()
}

fn targets(
    hand: &HandModel,
    skinning: Skinning,
    offsets: &[PoseOffsets],
    poses: &[Pose],
) -> Vec<Vec3> {
    let mut world = still(hand, CouplingKind::Uniform, skinning, offsets);
    put(&mut world, poses);
    let mut targets = world.nodes(0).to_vec();
    world.skin_targets(0, &mut targets);
    targets
}

/// Root mean square distance \[m\] of the nodes that a joint's bones carry together.
fn apart(hand: &HandModel, joint: &str, a: &[Vec3], b: &[Vec3]) -> f64 {
    let joint = hand.joints.iter().find(|j| j.name == joint).unwrap();
    let both = |n: &usize| {
        let binding = &hand.bindings[*n];
        let of = |bone: u32| (0..2).any(|k| binding.bones[k] == bone && binding.weights[k] > 0.0);
        of(joint.child) && of(joint.parent.unwrap())
    };
    let ways: Vec<f64> = (0..a.len()).filter(both).map(|n| (a[n] - b[n]).norm()).collect();
    assert!(ways.len() >= 4, "{} nodes", ways.len());
    let square = ways.iter().map(|d| d * d).sum::<f64>() / ways.len() as f64;
    square.sqrt()
}

/// Turn from rest to the upper end of a joint's last axis \[rad\], with the axis.
fn largest_turn(hand: &HandModel, joint: &str) -> (usize, f64) {
    let j = hand.joints.iter().position(|j| j.name == joint).unwrap();
    let axis = hand.joints[j].axes.iter().rposition(|axis| axis.limit.is_some()).unwrap();
    let rest: Vec<Pose> = hand.bones.iter().map(|bone| bone.pose_MB).collect();
    let mut angles = vec![[0.0; 2]; hand.joints.len()];
    Tree::of_hand(hand).unwrap().angles(&rest, &mut angles);
    (axis, hand.joints[j].axes[axis].limit.unwrap().max - angles[j][axis])
}

/// At the end of its range a joint's targets lie where the flesh does, while skinning alone is off
/// by millimetres; half-way to the first pose, at 11 to 15°, at most half of what it lacks is left.
#[test]
fn targets_lie_where_the_flesh_comes_to_rest() {
    let hand = uniform_hand(Side::Right, 600).unwrap();
    for skinning in [Skinning::Linear, Skinning::Joint] {
        let offsets = sculpted_offsets(&hand, skinning).unwrap();
        for joint in ["index-pip", "thumb-mcp", "ring-mcp", "little-dip"] {
            let (axis, end) = largest_turn(&hand, joint);
            let first = end / (end / std::f64::consts::FRAC_PI_6).ceil();
            for (turn, known) in [(end, true), (0.5 * first, false)] {
                let poses = bent(&hand, joint, axis, turn);
                let flesh = at_rest(&hand, &poses);
                let off = |offsets: &[PoseOffsets]| {
                    apart(&hand, joint, &targets(&hand, skinning, offsets, &poses), &flesh)
                };
                let (plain, posed) = (off(&[]), off(&offsets));
                let what = format!("{skinning:?} {joint} {turn:.2} rad: {plain} m, then {posed} m");
                let most = if known { 1e-6 } else { 0.5 * plain };
                assert!(plain > 1e-3 && posed < most, "{what}");
            }
        }
    }
}
