//! Goal: a visitor's hand, settings and choice of hands act on the physics; what goes wrong is
//! reported and survived. Method: visitors at the hub of a running simulation.

use crate::decoder::{Model, Snapshot};
use crate::visitor::{Visitor, pose, seven, start};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use thenar_core::{Pose, Quat, Vec3};
use thenar_serve::live::{Live, Options, SceneSource};

const SCRIPT: u16 = 16;
const TRACKED: u16 = 32;
/// The hand of fewest tetrahedra keeps pace on any machine.
const PAPER: &str = "hand.0.preset=paper";

/// Wrist of a hand, from the pose of its palm.
fn wrist(model: &Model, snapshot: &Snapshot, hand: usize) -> Pose {
    let described = &model.json["hands"][hand];
    let palm = described["bone_start"].as_u64().unwrap() as usize;
    pose(snapshot.rigids[palm]) * pose(seven(&described["wrist_B"]))
}

/// Sends a pose again and again, as a page does, until a snapshot is as wanted.
fn hold(
    one: &mut Visitor,
    hand: u8,
    to: &Pose,
    angles: [f64; 20],
    what: &str,
    wanted: impl Fn(&Snapshot) -> bool,
) -> Snapshot {
    for k in 0..6000 {
        let message = one.angles(hand, to, angles, f64::from(k) * 0.01);
        one.send(message).unwrap();
        std::thread::sleep(Duration::from_millis(10));
        let snapshot = one.snapshot();
        if wanted(&snapshot) {
            return snapshot;
        }
    }
    panic!("waited in vain for {what}");
}

/// Rest angles of a hand.
fn rest(model: &Model, hand: usize) -> [f64; 20] {
    std::array::from_fn(|k| model.json["hands"][hand]["angles"][k]["rest"].as_f64().unwrap_or(0.0))
}

#[test]
fn a_pose_moves_the_hand_and_is_acknowledged() {
    let (_live, hub) = start("free-motion", &["duration=1000", PAPER]);
    let mut one = Visitor::join(&hub, 1);
    let (model, before) = (one.model(), one.until("motion", |s| s.steps > 3));
    assert!(before.flags & SCRIPT != 0 && before.flags & TRACKED == 0 && before.pose == 0);

    // To another place, turned.
    let turned = wrist(&model, &before, 0).rotation * Quat::from_scaled_axis(Vec3::y() * 0.6);
    let to = Pose::new(Vec3::new(0.15, 0.3, -0.1), turned);
    let mut angles = rest(&model, 0);
    let there = |s: &Snapshot| {
        let wrist = wrist(&model, s, 0);
        (wrist.position - to.position).norm() < 3e-3 && wrist.rotation.angle_to(&to.rotation) < 0.03
    };
    let arrived = hold(&mut one, 1, &to, angles, "the wrist", there);
    assert!(arrived.flags & TRACKED != 0 && arrived.flags & SCRIPT == 0);
    assert!(arrived.pose > 0 && arrived.pose <= one.number());

    // The index finger bends at its second joint: the target as told, the bone as far as flesh lets
    // it. The bones follow their targets within a few millimetres.
    let straight = knuckle(&model, &arrived.targets);
    angles[6] += 0.8;
    let bend = |bones: &[[f64; 7]]| knuckle(&model, bones).angle_to(&straight);
    let settled = hold(&mut one, 1, &to, angles, "the finger", |s| {
        (bend(&s.targets) - 0.8).abs() < 1e-3 && bend(bones(&model, s)) > 0.6
    });
    for (k, target) in settled.targets.iter().enumerate() {
        let off = pose(bones(&model, &settled)[k]).position - pose(*target).position;
        assert!(off.norm() < 5e-3, "bone {k} is {off} from its target");
    }

    // The joint frames of the model tell the angles from the bones.
    for k in 0..20 {
        let off = joint_turn(&model, &settled.targets, k).angle_to(&told_turn(&model, &angles, k));
        assert!(off < 2e-3, "angle {k}: {off} rad from the one told");
    }

    // Not tracked any more, it holds still; the script takes it back when asked.
    let number = one.number() + 1;
    let mut lost = vec![18, 3, 1, 0];
    lost.extend(number.to_le_bytes());
    lost.extend(9.0_f64.to_le_bytes());
    one.send(lost).unwrap();
    let lost = one.until("the loss", |s| s.flags & (TRACKED | SCRIPT) == 0);
    let later = one.until("later", |s| s.time > lost.time + 0.5);
    assert!(there(&later), "it holds still");
    one.say(r#"{"type":"script"}"#);
    let script = one.until("the script", |s| s.flags & SCRIPT != 0);
    assert!(script.time < later.time && script.pose == 0);
}

/// The bones of the first hand.
fn bones<'a>(model: &Model, snapshot: &'a Snapshot) -> &'a [[f64; 7]] {
    &snapshot.rigids[model.json["hands"][0]["bone_start"].as_u64().unwrap() as usize..]
}

/// Rotation of the joint of angle `k`, from the bones at its two sides.
fn joint_turn(model: &Model, bones: &[[f64; 7]], k: usize) -> Quat {
    let hand = &model.json["hands"][0];
    let angle = &hand["angles"][k];
    let bone = angle["bone"].as_u64().unwrap() as usize;
    let parent = hand["bones"][bone]["parent"].as_u64().unwrap() as usize;
    let frame = |key: &str| {
        let part = |i: usize| angle[key][i].as_f64().unwrap();
        pose([0.0, 0.0, 0.0, part(0), part(1), part(2), part(3)]).rotation
    };
    let before = pose(bones[parent]).rotation * frame("rotation_PJ");
    before.inverse() * pose(bones[bone]).rotation * frame("rotation_BK")
}

/// The same from the angles told: about y, then x.
fn told_turn(model: &Model, angles: &[f64; 20], k: usize) -> Quat {
    let list = &model.json["hands"][0]["angles"];
    let about = |axis: &str| {
        let same = |other: &usize| list[*other]["bone"] == list[k]["bone"];
        let turns = (0..20).filter(same).filter(|other| list[*other]["axis"] == axis);
        turns.map(|other| list[other]["sense"].as_f64().unwrap() * angles[other]).sum::<f64>()
    };
    let (y, x) = (Vec3::y() * about("y"), Vec3::x() * about("x"));
    Quat::from_scaled_axis(y) * Quat::from_scaled_axis(x)
}

/// Rotation of the second bone of the index finger in the first.
fn knuckle(model: &Model, bones: &[[f64; 7]]) -> Quat {
    let list = model.json["hands"][0]["bones"].as_array().unwrap();
    let bone = list.iter().position(|bone| bone["name"] == "index-intermediate").unwrap();
    let parent = list[bone]["parent"].as_u64().unwrap() as usize;
    pose(bones[parent]).rotation.inverse() * pose(bones[bone]).rotation
}

#[test]
fn joints_of_a_headset_move_the_hand() {
    let (_live, hub) = start("free-motion", &["duration=1000", PAPER]);
    let one = Visitor::join(&hub, 1);
    let (model, _) = (one.model(), one.until("motion", |s| s.steps > 3));
    // A flat hand held out along -z: joints on lines from the wrist, frames all the same.
    let mut k = 0;
    let flat = loop {
        k += 1;
        let mut bytes = vec![16, 3, 1, 0];
        bytes.extend((k as u32).to_le_bytes());
        bytes.extend((f64::from(k) * 0.011).to_le_bytes());
        for joint in flat_hand(Vec3::new(0.0, 0.25, 0.1)) {
            for x in [joint.x, joint.y, joint.z, 0.0, 0.0, 0.0, 1.0, 0.01] {
                bytes.extend((x as f32).to_le_bytes());
            }
        }
        one.send(bytes).unwrap();
        std::thread::sleep(Duration::from_millis(11));
        let snapshot = one.snapshot();
        let wrist = wrist(&model, &snapshot, 0);
        if (wrist.position - Vec3::new(0.0, 0.25, 0.1)).norm() < 3e-3 {
            break snapshot;
        }
        assert!(k < 3000, "{wrist:?}");
    };
    assert!(flat.flags & TRACKED != 0);
    // Fingers point along -z: the middle fingertip is a hand's length ahead of the wrist.
    let settled = one.until("the fingers", |s| {
        let hand = &model.json["hands"][0];
        let bones = hand["bones"].as_array().unwrap();
        let tip = bones.iter().rposition(|b| b["digit"] == "middle").unwrap();
        let end = seven3(&bones[tip]["ends_B"][1]);
        let start = hand["bone_start"].as_u64().unwrap() as usize;
        let tip = pose(s.rigids[start + tip]).point(&end);
        let ahead = tip - wrist(&model, s, 0).position;
        ahead.z < -0.13 && ahead.x.abs() < 0.04 && ahead.y.abs() < 0.04
    });
    assert!(settled.pose > 0);
}

fn seven3(value: &serde_json::Value) -> Vec3 {
    Vec3::from_fn(|k, _| value[k].as_f64().unwrap())
}

/// 25 joints of a right hand held flat, palm down, fingers along -z, wrist at `at`.
fn flat_hand(at: Vec3) -> Vec<Vec3> {
    let mut joints = vec![at];
    for along in [0.03, 0.06, 0.09, 0.12] {
        joints.push(at + Vec3::new(-0.02 - 0.4 * along, 0.0, -along));
    }
    for (x, scale) in [(-0.02, 0.95), (0.0, 1.0), (0.02, 0.95), (0.04, 0.85)] {
        for along in [0.035, 0.095, 0.135, 0.16, 0.18] {
            joints.push(at + Vec3::new(x, 0.0, -along * scale));
        }
    }
    joints
}

#[test]
fn when_whoever_moved_the_hand_leaves_the_script_takes_over() {
    let (_live, hub) = start("free-motion", &["duration=1000", PAPER]);
    let mut one = Visitor::join(&hub, 1);
    let two = Visitor::join(&hub, 2);
    let (model, first) = (one.model(), one.until("motion", |s| s.time > 0.3));
    let here = wrist(&model, &first, 0);
    let angles = rest(&model, 0);
    hold(&mut one, 1, &here, angles, "the hand", |s| s.flags & TRACKED != 0);
    one.leave();
    two.until_status("control", |s| s["control"] == 2);
    let still = two.until("let go", |s| s.flags & (TRACKED | SCRIPT) == 0);
    let script = two.until("the script", |s| s.flags & SCRIPT != 0);
    assert!(script.time < still.time, "from its start");
}

#[test]
fn settings_change_the_physics() {
    let (_live, hub) = start("falling-box", &["duration=1000"]);
    let mut one = Visitor::join(&hub, 1);
    let status =
        one.until_status("settings", |s| s["settings"].as_array().is_some_and(|l| !l.is_empty()));
    let gravity = |status: &serde_json::Value| {
        let list = status["settings"].as_array().unwrap().clone();
        list.into_iter().find(|s| s["key"] == "gravity").unwrap()
    };
    assert!((gravity(&status)["value"].as_f64().unwrap() - 9.81).abs() < 1e-9);
    assert!(gravity(&status)["max"].as_f64().unwrap() >= 15.0);

    // Free fall before the ground: half g t² below the start.
    one.say(r#"{"type":"run","paused":true}"#);
    one.say(r#"{"type":"set","key":"gravity","value":3}"#);
    one.until_status("the setting", |s| gravity(s)["value"] == 3.0);
    one.say(r#"{"type":"reset"}"#);
    let start = one.until("the start", |s| s.time == 0.0);
    for k in 1..=20 {
        one.say(r#"{"type":"step"}"#);
        one.until("a step", |s| s.steps == k);
    }
    let fallen = one.snapshot();
    let moved = (0..start.rigids.len()).max_by(|a, b| {
        let way = |i: usize| (fallen.rigids[i][1] - start.rigids[i][1]).abs();
        way(*a).total_cmp(&way(*b))
    });
    let fall = start.rigids[moved.unwrap()][1] - fallen.rigids[moved.unwrap()][1];
    // Backward Euler: g h² (1 + 2 + … + n).
    let h = fallen.time / 20.0;
    assert!((fall - 3.0 * h * h * 210.0).abs() < 1e-6, "{fall}");

    one.say(r#"{"type":"set","key":"gravity","value":900}"#);
    assert!(one.note().1, "beyond its range");
    one.say(r#"{"type":"set","key":"gravitation","value":3}"#);
    let (note, refusal) = one.note();
    assert!(refusal && note["message"].as_str().unwrap().contains("gravit"), "{note}");
}

#[test]
fn both_hands_of_a_given_length_come_when_asked_for() {
    let (_live, hub) = start("free-motion", &[PAPER]);
    let mut one = Visitor::join(&hub, 1);
    let epoch = one.model().epoch;
    one.say(r#"{"type":"hands","which":"both","lengths":{"left":0.16,"right":0.2}}"#);
    // The old scene goes on meanwhile.
    one.until_status("making", |s| s["loading"] == "free-motion");
    one.until_status("both", |s| s["hands"] == "both" && s["loading"].is_null());
    let model = one.model();
    assert!(model.epoch > epoch);
    let hands = model.json["hands"].as_array().unwrap();
    let length =
        |side: &str| hands.iter().find(|h| h["side"] == side).unwrap()["length"].as_f64().unwrap();
    assert_eq!(hands.len(), 2);
    assert!((length("left") - 0.16).abs() < 2e-3 && (length("right") - 0.2).abs() < 2e-3);

    // Each follows its own pose.
    let left = hands.iter().position(|h| h["side"] == "left").unwrap();
    let now = one.until("its snapshots", |s| s.epoch == model.epoch && s.steps > 2);
    let to = Pose::new(
        wrist(&model, &now, left).position + Vec3::new(-0.05, 0.05, 0.0),
        wrist(&model, &now, left).rotation,
    );
    let angles = rest(&model, left);
    hold(&mut one, 0, &to, angles, "the left wrist", |s| {
        (wrist(&model, s, left).position - to.position).norm() < 3e-3
    });
}

#[test]
fn a_hand_that_the_scene_lacks_is_no_offence() {
    let (_live, hub) = start("free-motion", &[PAPER]);
    let mut one = Visitor::join(&hub, 1);
    one.until_status("control", |s| s["control"] == 1);
    let message = one.angles(0, &Pose::identity(), [0.0; 20], 0.0);
    one.send(message).unwrap();
    let (note, refusal) = one.note();
    assert!(!refusal && note["message"].as_str().unwrap().contains("left"), "{note}");
    // Numbers of messages rise.
    let message = one.angles(1, &Pose::identity(), [0.0; 20], 0.0);
    one.send(message.clone()).unwrap();
    one.send(message).unwrap();
    assert!(one.note().1);
}

#[test]
fn a_panic_is_reported_and_the_scene_starts_again() {
    let once = AtomicBool::new(true);
    let options = Options {
        watcher: Some(Box::new(move |session| {
            let fails = session.steps() == 30 && once.swap(false, Ordering::Relaxed);
            assert!(!fails, "made to fail");
        })),
        ..Options::default()
    };
    let source = SceneSource::Builtin("falling-box".into());
    let (_live, hub) = Live::start(&source, options).unwrap();
    let one = Visitor::join(&hub, 1);
    let epoch = one.model().epoch;
    let status = one.until_status("the failure", |s| !s["problem"].is_null());
    assert!(status["problem"].as_str().unwrap().contains("made to fail"), "{status}");
    one.until_status("another start", |s| s["problem"].is_null());
    let again = one.until("motion", |s| s.epoch > epoch && s.steps > 60);
    assert_eq!(one.model().epoch, again.epoch);
}

#[test]
fn what_fails_again_and_again_is_left_alone() {
    let options = Options {
        watcher: Some(Box::new(|session| assert!(session.name() != "falling-box", "always"))),
        ..Options::default()
    };
    let source = SceneSource::Builtin("falling-box".into());
    let (_live, hub) = Live::start(&source, options).unwrap();
    let one = Visitor::join(&hub, 1);
    one.until_status("the end of patience", |s| {
        s["problem"].as_str().is_some_and(|p| p.contains("again and again"))
    });
    // Another scene helps.
    one.say(r#"{"type":"scene","name":"soft-cube"}"#);
    one.until_status("the other", |s| s["scene"] == "soft-cube" && s["problem"].is_null());
    let epoch = one.model().epoch;
    one.until("motion", |s| s.epoch == epoch && s.steps > 3);
}

#[test]
fn a_broken_scene_file_is_refused_and_the_old_scene_lives() {
    let folder = std::env::temp_dir().join(format!("thenar-live-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("own.toml");
    let text = thenar_scene::session::builtin("falling-box").unwrap().text;
    std::fs::write(&file, text).unwrap();
    let (_live, hub) = Live::start(&SceneSource::File(file.clone()), Options::default()).unwrap();
    let mut one = Visitor::join(&hub, 1);
    one.until_status("the file", |s| s["scene"] == "own");
    let welcome: serde_json::Value = serde_json::from_str(&hub.welcome(one.id)).unwrap();
    assert_eq!(welcome["scenes"][0]["name"], "own");
    // Somebody edits the file while it is shown.
    std::fs::write(&file, "version = 1\nshapes = 3\n").unwrap();
    one.say(r#"{"type":"scene","name":"own"}"#);
    let (note, _) = one.note();
    assert!(note["message"].as_str().unwrap().contains("shapes"), "{note}");
    let steps = one.snapshot().steps;
    one.until("it goes on", |s| s.steps > steps);
    std::fs::remove_dir_all(&folder).unwrap();
    let gone = Live::start(&SceneSource::File(file), Options::default());
    assert!(gone.unwrap_err().to_string().contains("own.toml"));
    let unknown = Live::start(&SceneSource::Builtin("nothing".into()), Options::default());
    assert!(unknown.unwrap_err().to_string().contains("nothing"));
}
