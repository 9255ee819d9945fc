//! Goal: offsets of targets by pose go with their body wherever the world goes on without the rest,
//! or with other numbers. Method: two fingers, of which the second has offsets; it is taken out,
//! and the world is given other offsets.

use crate::common::finger;
use thenar_core::model::{Drive, PoseOffsets, WorldDesc};
use thenar_core::world::{Input, ModelError, Target};
use thenar_core::{Pose, Quat, Vec3, World};

/// Two fingers, the second of bones 2 and 3, joint 1 and body 1, whose targets at the joint go up
/// by `up` \[m\] in a bend of 0.5 rad.
fn fingers(up: f64) -> WorldDesc {
    let mut desc = finger(1e8, 1e-3);
    desc.solver.velocity_tolerance = 1e-10;
    let other = finger(1e8, 1e-3);
    for rigid in other.rigids {
        let pose_WB = Pose::translation(0.0, 0.0, 0.1) * rigid.pose_WB;
        desc.add_rigid(thenar_core::model::RigidDesc {
            name: format!("other {}", rigid.name),
            pose_WB,
            ..rigid
        });
    }
    desc.joints.extend(other.joints.into_iter().map(|joint| thenar_core::model::JointDesc {
        parent: joint.parent.map(|p| p + 2),
        child: joint.child + 2,
        ..joint
    }));
    for mut soft in other.softs {
        soft.name = "other".into();
        soft.pose_WM = Pose::translation(0.0, 0.0, 0.1);
        let bindings = soft.coupling.iter_mut().flat_map(|coupling| &mut coupling.bindings);
        bindings.for_each(|binding| binding.bones = binding.bones.map(|b| b + 2));
        desc.add_soft(soft);
    }
    let bindings = &desc.softs[1].coupling.as_ref().unwrap().bindings;
    let between = (0..).zip(bindings).filter(|(_, b)| b.weights.iter().all(|w| *w > 0.0));
    let nodes: Vec<u32> = between.map(|(node, _)| node).collect();
    assert!(nodes.len() > 5);
    desc.pose_offsets.push(PoseOffsets {
        soft: 1,
        joint: 1,
        poses: vec![Quat::from_scaled_axis(Vec3::z() * -0.5)],
        offsets: vec![Vec3::y() * up; nodes.len()],
        nodes,
    });
    let drive =
        Drive { stiffness: 400.0, damping: 1.0, angular_stiffness: 0.4, angular_damping: 1e-3 };
    desc.drives = vec![None, None, Some(drive), Some(drive)];
    desc
}

/// Targets of the second finger, bent by 0.5 rad at the knuckle.
fn targets(desc: &WorldDesc) -> [Target; 2] {
    let root = desc.rigids[2].pose_WB;
    let turn = Quat::from_scaled_axis(Vec3::z() * -0.5);
    let knuckle = root.position + Vec3::x() * 0.015;
    let bent = Pose::new(knuckle + turn * (Vec3::x() * 0.015), turn);
    [root, bent].map(|pose_WB| Target {
        pose_WB,
        velocity_W: Vec3::zeros(),
        angular_velocity_W: Vec3::zeros(),
    })
}

/// Nodes of the second finger among others and taken out, after 0.1 s \[m\].
fn moved(up: f64) -> [Vec<Vec3>; 2] {
    let desc = fingers(up);
    let [root, bent] = targets(&desc);
    let lead = |input: &mut Input, first: usize| {
        input.targets[first] = Some(root);
        input.targets[first + 1] = Some(bent);
    };
    let mut whole = World::new(desc).unwrap();
    let mut sub_world = whole.sub_world(2..4).unwrap();
    let (mut input, mut own) = (whole.input(), sub_world.input());
    lead(&mut input, 2);
    lead(&mut own, 0);
    for _ in 0..100 {
        whole.step(&input, &mut ());
        sub_world.step(1e-3, &own);
    }
    [whole.nodes(1).to_vec(), sub_world.world().nodes(0).to_vec()]
}

fn apart(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

#[test]
fn a_finger_taken_out_keeps_its_offsets() {
    let ([whole, sub_world], [plain, _]) = (moved(2e-3), moved(0.0));
    assert!(apart(&whole, &sub_world) < 1e-8, "{} m", apart(&whole, &sub_world));
    assert!(apart(&whole, &plain) > 1e-4, "the offsets must do something");
}

/// Other offsets of as many nodes and poses act at once; others are refused, and nothing has
/// changed.
#[test]
fn a_running_world_takes_other_offsets_but_no_more() {
    let mut world = World::new(fingers(2e-3)).unwrap();
    let mut targets = [world.nodes(1).to_vec(), world.nodes(1).to_vec()];
    let mut state = world.state().clone();
    let turn = Quat::from_scaled_axis(Vec3::z() * -0.5);
    state.poses_WB[3].rotation = turn * state.poses_WB[3].rotation;
    assert!(world.restore(&state));
    world.skin_targets(1, &mut targets[0]);
    world.retune(fingers(3e-3)).unwrap();
    world.skin_targets(1, &mut targets[1]);
    let most = apart(&targets[0], &targets[1]);
    assert!(most > 0.9e-3 && most < 1e-3 + 1e-12, "{most} m");
    let mut more = fingers(3e-3);
    more.pose_offsets[0].poses.push(Quat::from_scaled_axis(Vec3::z() * 0.5));
    let twice = more.pose_offsets[0].offsets.clone();
    more.pose_offsets[0].offsets.extend(twice);
    assert!(matches!(world.retune(more), Err(ModelError::Changed { .. })));
}

/// A change that makes offsets senseless, and words of the error.
type Case<'a> = (&'a dyn Fn(&mut PoseOffsets), &'a str);

#[test]
fn offsets_that_make_no_sense_are_refused() {
    let refused = |change: &dyn Fn(&mut PoseOffsets)| {
        let mut desc = fingers(1e-3);
        change(&mut desc.pose_offsets[0]);
        World::new(desc).unwrap_err().to_string()
    };
    let cases: [Case<'_>; 9] = [
        (&|o| o.soft = 7, "deformable body 7"),
        (&|o| o.joint = 9, "joint of pose offsets 9"),
        (&|o| o.joint = 0, "both bodies of joint knuckle"),
        (&|o| o.nodes[0] = 9999, "node of pose offsets 9999"),
        (&|o| o.nodes[1] = o.nodes[0], "each named once"),
        (&|o| o.offsets[0] = Vec3::x() * f64::NAN, "pose offset"),
        (&|o| o.offsets[0] = Vec3::x() * 1e300, "within 1e4 m"),
        (&|o| o.poses[0] = Quat::identity(), "too near"),
        (&|o| o.poses.clear(), "number of poses"),
    ];
    for (change, words) in cases {
        let error = refused(change);
        assert!(error.contains(words), "{words}: {error}");
    }
}
