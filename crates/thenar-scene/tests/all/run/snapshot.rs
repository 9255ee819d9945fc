//! Goal: a session goes on from a snapshot of another with the same bits, tracked hands and
//! settings included, and from nothing else. Method: hashes step by step; bytes of other scenes,
//! cut and changed.

use std::path::Path;
use thenar_core::{Pose, Quat, Vec3};
use thenar_scene::live::LivePose;
use thenar_scene::motion::ANGLES;
use thenar_scene::recording::{SnapshotError, go_on_from, snapshot};
use thenar_scene::session::{Session, builtin};
use thenar_scene::tuning::SettingValue;

/// A shipped scene, with the paper's hand if it has one, and the hash of its start.
fn shipped(name: &str) -> (Session, u64) {
    let text = builtin(name).expect("a scene").text;
    let paper = text.contains("[[hand]]").then(|| "hand.0.preset=paper".to_owned());
    let session = Session::from_text(text, Path::new("test.toml"), paper.as_slice());
    let session = session.unwrap_or_else(|e| panic!("{e}"));
    let start = session.world().state_hash();
    (session, start)
}

/// The hand of `table-press` above the table, so high \[m\].
fn pose(session: &Session, height: f64) -> LivePose {
    let rest = session.hands()[0].angles().map(|angle| angle.map_or(0.0, |angle| angle.rest));
    let angles: [f64; ANGLES] = rest;
    LivePose::Angles { wrist: Pose::new(Vec3::new(0.05, height, 0.05), Quat::identity()), angles }
}

/// Steps with poses that press the hand down; the hash after each step.
fn press(session: &mut Session, steps: std::ops::Range<u32>) -> Vec<u64> {
    let step = |k: u32| {
        let height = (0.12 - 2e-3 * f64::from(k)).max(0.02);
        let pose = pose(session, height);
        session.live_pose(0, f64::from(k) * 5e-3, &pose).expect("a pose");
        session.step(&mut ());
        session.world().state_hash()
    };
    steps.map(step).collect()
}

#[test]
fn another_session_goes_on_with_the_same_bits() {
    let (mut first, start) = shipped("table-press");
    first.set("friction", &SettingValue::Number(0.4)).expect("a setting");
    press(&mut first, 0..60);
    assert!(first.world().contacts().iter().any(|contact| contact.force_W.norm() > 0.1));
    let kept = snapshot(&first, start);
    let expected = press(&mut first, 60..90);

    let (mut second, second_start) = shipped("table-press");
    assert_eq!(second_start, start);
    press(&mut second, 0..7);
    go_on_from(&mut second, start, &kept).expect("a state of this scene");
    assert_eq!(second.steps(), 60);
    assert_eq!(snapshot(&second, start), kept);
    assert_eq!(press(&mut second, 60..90), expected);
    // Back in the first one.
    go_on_from(&mut first, start, &kept).expect("a state of this scene");
    assert_eq!(press(&mut first, 60..90), expected);
}

#[test]
fn what_is_no_state_of_the_scene_is_refused_and_changes_nothing() {
    let (mut session, start) = shipped("falling-box");
    (0..5).for_each(|_| assert!(!session.step(&mut ()).taken_back));
    let kept = snapshot(&session, start);
    (0..5).for_each(|_| assert!(!session.step(&mut ()).taken_back));
    let hash = session.world().state_hash();

    let (mut other, other_start) = shipped("soft-cube");
    assert_eq!(
        go_on_from(&mut other, other_start, &kept),
        Err(SnapshotError::OtherScene { theirs: start, own: other_start })
    );
    assert_eq!(go_on_from(&mut other, start, &kept), Err(SnapshotError::Unfit));
    for length in 0..kept.len() {
        assert!(go_on_from(&mut session, start, &kept[..length]).is_err(), "{length} bytes");
    }
    for at in 0..kept.len() {
        let mut bent = kept.clone();
        bent[at] ^= 1 << (at % 8);
        assert!(go_on_from(&mut session, start, &bent).is_err(), "byte {at}");
    }
    assert_eq!(session.world().state_hash(), hash);
    assert_eq!(go_on_from(&mut session, start, &kept), Ok(()));
}
