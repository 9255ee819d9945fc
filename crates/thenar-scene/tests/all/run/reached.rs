//! Goal: the default hand reaches its targets. Method: hands of other proportions are watched as
//! they pinch, and ours must press pad on pad; fingers are bent in free air, and ours must be as
//! bent.

use std::path::Path;
use thenar_core::kinematics::Tree;
use thenar_core::model::{Digit, HandModel, Side};
use thenar_core::world::Target;
use thenar_core::{Pose, Quat, Vec3};
use thenar_rig::hand::default_hand;
use thenar_scene::grip::{GripKind, Opposition};
use thenar_scene::live::LivePose;
use thenar_scene::motion::TRACKED_JOINTS;
use thenar_scene::session::Session;
use thenar_scene::tuning::SettingValue;
use thenar_track::mirrored;
use thenar_track::reach::{Chain, PadPlace};

fn alone(side: Side, more: &str) -> Session {
    let side = if side == Side::Left { "left" } else { "right" };
    let text = format!(
        "version = 1\ntime_step = 0.0111\nduration = 2\n\
         [[hand]]\nname = \"hand\"\nmodel = \"{side}\"\n{more}"
    );
    Session::from_text(&text, Path::new("alone.toml"), &[]).unwrap_or_else(|e| panic!("{e}"))
}

/// A hand whose thumb and fingers are longer by these factors.
fn proportioned(hand: &HandModel, thumb: f64, fingers: f64) -> HandModel {
    let mut hand = hand.clone();
    let digits: Vec<Digit> = hand.bones.iter().map(|bone| bone.digit).collect();
    let factor = |digit| match digit {
        Digit::Palm => 1.0,
        Digit::Thumb => thumb,
        _ => fingers,
    };
    for bone in &mut hand.bones {
        bone.pose_BT.position *= factor(bone.digit);
        bone.ends_B.iter_mut().for_each(|end| *end *= factor(bone.digit));
    }
    for joint in &mut hand.joints {
        joint.pose_CK.position *= factor(digits[joint.child as usize]);
        joint.pose_PJ.position *= factor(digits[joint.parent.unwrap_or(0) as usize]);
    }
    hand
}

/// The joints that a headset would see of a hand whose pads of thumb and index finger stand `width`
/// \[m\] apart.
fn seen(hand: &HandModel, pinch: &Opposition, width: f64) -> [Pose; 25] {
    let tree = Tree::of_hand(hand).expect("a tree");
    let mut angles = vec![[0.0; 2]; tree.joints()];
    let mut poses: Vec<Pose> = hand.bones.iter().map(|bone| bone.pose_MB).collect();
    tree.angles(&poses, &mut angles);
    let span = pinch.at(width);
    for pad in 0..pinch.pads() {
        pinch.chain(pad).expect("a digit").write(&span.angles[pad], &mut angles);
    }
    tree.forward(&Pose::translation(0.0, 0.2, 0.0), &angles, &mut poses);
    let mut joints = [poses[0] * hand.bones[0].pose_BT; 25];
    for (bone, pose) in hand.bones.iter().zip(&poses) {
        let name = bone.tracked_joint.as_deref().expect("a tracked joint");
        let k = TRACKED_JOINTS.iter().position(|joint| *joint == name).expect("a known joint");
        joints[k] = *pose * bone.pose_BT;
        if TRACKED_JOINTS.get(k + 1).is_some_and(|next| next.ends_with("-tip")) {
            joints[k + 1] = Pose::new(pose.point(&bone.ends_B[1]), joints[k].rotation);
        }
    }
    joints
}

/// Force on a pad \[N\], and how far the middle of what presses there is beside the pad's own
/// \[m\].
fn pressed(session: &Session, digit: Digit) -> (f64, f64) {
    let hand = &session.hands()[0];
    let part = Digit::FINGERS.iter().position(|finger| *finger == digit).expect("a finger");
    let force = session.hand_loads(0)[part + 1].normal;
    let pad = Chain::new(&hand.model, digit, PadPlace::Tip).expect("a pad").pad;
    let bone = session.world().rigid_pose(hand.handle.bones.start + pad.bone as u32);
    let (mut sum, mut middle) = (0.0, Vec3::zeros());
    for contact in session.world().contacts() {
        let there = bone.inverse_point(&contact.position_W) - pad.centre_B;
        if there.norm() < 3.0 * pad.radius {
            let force = contact.force_W.dot(&contact.normal_W).abs();
            sum += force;
            middle += there * force;
        }
    }
    let middle = middle / f64::max(sum, 1e-12);
    (force, (middle - pad.normal_B * pad.normal_B.dot(&middle)).norm())
}

/// Hands with thumbs and fingers of other lengths put thumb and index finger together; ours presses
/// with at least 1 N, within 6 mm of the middle of each pad (its thumb cannot turn about its own
/// length, so that pads face each other at an angle).
#[test]
fn a_pinch_of_any_hand_is_one_of_ours() {
    for (side, thumb, fingers) in
        [(Side::Right, 0.9, 1.06), (Side::Right, 1.1, 0.95), (Side::Left, 1.0, 1.0)]
    {
        let theirs = proportioned(&default_hand(side).expect("a hand"), thumb, fingers);
        let pinch = Opposition::new(&theirs, GripKind::Pinch).expect("a pinch");
        let mut session = alone(side, "");
        let (mut time, mut next) = (0.0, 0.0);
        while time < 1.5 {
            if time >= next {
                let width = f64::max(0.0, 0.05 - 0.08 * time);
                let joints = seen(&theirs, &pinch, width);
                let pose = LivePose::Joints { joints, radii: [0.008; 25] };
                session.live_pose(0, time, &pose).expect("a pose");
                next += 1.0 / 90.0;
            }
            assert!(!session.step(&mut ()).non_finite);
            time = session.world().time();
        }
        for digit in [Digit::Thumb, Digit::Index] {
            let (force, beside) = pressed(&session, digit);
            let what =
                format!("{side:?} {thumb} {fingers} {digit:?}: {force} N, {beside} m beside");
            assert!((1.0..4.0).contains(&force) && beside < 6e-3, "{what}");
        }
    }
}

/// A right hand at rest and, after an empty line, with the tips of thumb and index finger on each
/// other, as headsets see it: the thumb's pad stands at 77° to the way to the finger's. Each line
/// has a joint's position \[m\] and rotation (x, y, z, w).
const PINCH_OF_TIPS: &str = include_str!("../../data/pinch-of-tips.txt");

fn joints(text: &str) -> [Pose; 25] {
    let pose = |line: &str| {
        let n: Vec<f64> = line.split(' ').map(|n| n.parse().expect("a number")).collect();
        let rotation = nalgebra::Quaternion::new(n[6], n[3], n[4], n[5]);
        Pose::new(Vec3::new(n[0], n[1], n[2]), Quat::new_normalize(rotation))
    };
    text.lines().map(pose).collect::<Vec<_>>().try_into().expect("25 joints")
}

/// People pinch with the tip or the side of a thumb as well. On our hand pads meet nonetheless,
/// with at least 1 N, within 4 mm of the middle of the thumb's pad and 7 mm of the finger's (its
/// joints would have to bend as far as they can to bring it round).
#[test]
fn a_pinch_of_tips_is_one_of_pads() {
    let (open, closed) = PINCH_OF_TIPS.split_once("\n\n").expect("two poses");
    let (open, closed) = (joints(open), joints(closed));
    for side in [Side::Right, Side::Left] {
        let mut session = alone(side, "");
        let (mut time, mut next) = (0.0, 0.0);
        while time < 1.5 {
            if time >= next {
                let part = f64::min(time / 0.6, 1.0);
                let joints = std::array::from_fn(|k| {
                    let position = open[k].position.lerp(&closed[k].position, part);
                    let rotation = open[k].rotation.slerp(&closed[k].rotation, part);
                    let pose = Pose::new(position, rotation);
                    if side == Side::Left { mirrored(&pose) } else { pose }
                });
                let pose = LivePose::Joints { joints, radii: [0.008; 25] };
                session.live_pose(0, time, &pose).expect("a pose");
                next += 1.0 / 90.0;
            }
            assert!(!session.step(&mut ()).non_finite);
            time = session.world().time();
        }
        for (digit, near) in [(Digit::Thumb, 4e-3), (Digit::Index, 7e-3)] {
            let (force, beside) = pressed(&session, digit);
            let what = format!("{side:?} {digit:?}: {force} N, {beside} m beside");
            assert!((1.0..3.0).contains(&force) && beside < near, "{what}");
        }
    }
}

/// Bends the four fingers, in 0.6 s, from the pose `relaxed`.
fn bending() -> String {
    let bent = ["index", "middle", "ring", "little"].map(|finger| {
        format!(
            "joints.{finger}-mcp = {{ flexion_deg = 60 }}\njoints.{finger}-pip = {{ flexion_deg = 80 }}\n\
             joints.{finger}-dip = {{ flexion_deg = 40 }}\n"
        )
    });
    format!(
        "[hand.motion]\nkind = \"keyframes\"\n[[hand.motion.key]]\ntime = 0\npose = \"relaxed\"\n\
         [[hand.motion.key]]\ntime = 0.6\npose = \"relaxed\"\n{}",
        bent.concat()
    )
}

/// Fingers that are bent in free air get within 2 mm of their targets; without muscles flesh and
/// springs keep them half as far again from there.
#[test]
fn bent_fingers_are_as_bent_as_their_targets() {
    let key = bending();
    let furthest = |more: &str| {
        let mut session = alone(Side::Right, &format!("{more}{key}"));
        while session.world().time() < 1.5 {
            session.step(&mut ());
        }
        let bones = session.hands()[0].handle.bones.clone();
        let off = |bone: u32| {
            let target = session.input().targets[bone as usize].expect("a target").pose_WB;
            (session.world().rigid_pose(bone).position - target.position).norm()
        };
        bones.map(off).fold(0.0, f64::max)
    };
    let (with, without) = (furthest(""), furthest("muscles = false\n"));
    assert!(with < 2e-3 && without > 1.5 * with, "{with} m with muscles, {without} m without");
}

/// Twice the modulus takes twice the torque but for the springs; a hand that is led, limp, without
/// drives or the paper's has none.
#[test]
fn muscles_are_as_strong_as_what_they_hold() {
    let torques = |session: &mut Session| -> Vec<f64> {
        session.step(&mut ());
        let joints = session.hands()[0].handle.joints.clone();
        joints.flat_map(|j| session.input().joint_torques[j as usize]).collect()
    };
    let mut session = alone(Side::Right, &bending());
    while session.world().time() < 0.7 {
        session.step(&mut ());
    }
    let usual = torques(&mut session);
    let young = session.world().desc().softs[0].flesh.materials.iter().map(|m| m.young);
    let young = young.fold(0.0, f64::max);
    let set = |session: &mut Session, to: f64| {
        session.set("hand_young", &SettingValue::Number(to)).expect("a setting");
        torques(session)
    };
    let [twice, thrice] = [2.0, 3.0].map(|factor| set(&mut session, factor * young));
    let sum = |torques: &[f64]| torques.iter().map(|torque| torque.abs()).sum::<f64>();
    let apart =
        |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
    let (flesh, more) = (apart(&twice, &usual), apart(&thrice, &twice));
    let off = sum(&apart(&more, &flesh));
    assert!(sum(&usual) > 0.1 && sum(&flesh) > 0.02, "{usual:?}, {flesh:?} N m for the flesh");
    assert!(off < 1e-3 * sum(&flesh), "{flesh:?}, {more:?} N m");
    let targets: Vec<Target> = session.input().targets.iter().copied().flatten().collect();
    assert!(session.lead(0, targets.into_iter()));
    assert_eq!(sum(&torques(&mut session)), 0.0, "led");

    // Flesh that is held otherwise than it was measured is not counted: twice its modulus changes
    // nothing.
    let mut held =
        alone(Side::Right, &format!("preset = \"touch\"\ncoupling = \"uniform\"\n{}", bending()));
    while held.world().time() < 0.7 {
        held.step(&mut ());
    }
    let springs = torques(&mut held);
    assert_eq!(set(&mut held, 2.0 * young), springs);
    assert!(sum(&springs) > 0.01, "{springs:?} N m");

    let limp = "bone_drive = { stiffness = 0 }\n";
    for more in ["driven = false\n", limp, "preset = \"paper\"\n", "muscles = false\n"] {
        let mut session = alone(Side::Right, &format!("{more}{}", bending()));
        while session.world().time() < 0.7 {
            session.step(&mut ());
        }
        assert_eq!(sum(&torques(&mut session)), 0.0, "{more}");
    }
}
