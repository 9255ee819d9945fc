//! The same bits: whatever enters, from wherever a replay begins.

use super::stage::*;
use thenar_core::kernels::SeenSides;
use thenar_core::{Pose, Vec3};
use thenar_record::{FrameKind, Header, Recorder};
use thenar_scene::recording::{Index, Replay};
use thenar_scene::session::Session;
use thenar_scene::tuning::SettingValue;

/// Steps of [`busy`].
const STEPS: usize = 80;

/// Everything that can enter.
fn busy(k: usize, session: &mut Session) {
    let t = H * k as f64;
    match k {
        12 | 13 => session.set("friction", &SettingValue::Number(0.3 + 0.01 * t)).unwrap(),
        // Refused: leaves no trace.
        14 => assert!(session.set("friction", &SettingValue::Number(-1.0)).is_err()),
        22 => session.set("time_step", &SettingValue::Number(0.008)).unwrap(),
        26 => session.set("solver", &SettingValue::Choice("two-step".into())).unwrap(),
        33 => session.set("gravity", &SettingValue::Number(5.0)).unwrap(),
        38 => session.live_lost(0),
        46 => session.follow_script(0),
        70 => session.restart(),
        _ => {}
    }
    let wrist = [0.2 * t, 0.1 - 0.3 * t, 0.1 * t];
    match k {
        6..20 if k.is_multiple_of(2) => session.live_pose(0, 100.0 + t, &tracked(wrist)).unwrap(),
        20..38 if k.is_multiple_of(3) => {
            session.live_pose(0, 100.0 + t, &bent(wrist, 0.3 * t)).unwrap()
        }
        // The haptic loop takes the hand over, and lets go of it again.
        55..66 => {
            let targets = moved_targets(session, 1e-3);
            assert!(session.lead(0, targets.into_iter()));
        }
        66 => session.let_go(0),
        _ => {}
    }
}

#[test]
fn a_replay_gives_the_same_bits_whatever_entered() {
    for (name, text) in [("glove", GLOVE), ("flesh", FLESH), ("tissue", TISSUE)] {
        let folder = Folder::new(name);
        let mut contacts = 0;
        let (file, recorded) = folder.record(text, STEPS, |k, session| {
            busy(k, session);
            contacts += session.report().contacts;
        });
        assert!(contacts > 100, "{name}: {contacts}");
        // The bits depend on what enters.
        let mut quiet = folder.open(text);
        (0..STEPS).for_each(|_| _ = quiet.step(&mut ()));
        assert_ne!(quiet.world().state_hash(), recorded[STEPS - 1], "{name}");
        let mut replay = Replay::open(&file).unwrap();
        assert_eq!(replayed(&mut replay), recorded, "{name}");
        let verdict = replay.verdict();
        assert!(verdict.is_same() && verdict.ended && verdict.losses.is_empty(), "{verdict:?}");
        assert_eq!((verdict.scenes, verdict.steps, verdict.same), (1, 80, 80));
        assert_eq!(verdict.put_right.0, 0, "{name}: keyframes agree in state and memory");
        // 22 steps of 10 ms, the others of 8 ms: settings stay through a restart.
        assert!((verdict.seconds - 0.684).abs() < 1e-9, "{}", verdict.seconds);
    }
}

/// Every keyframe falls into something that a step depends on besides the world's state: a
/// tracker's filter while it is calibrated, a changed setting, another solver, a hand that is lost,
/// that returns to its script, that is led.
#[test]
fn a_replay_gives_the_same_bits_from_any_keyframe_on() {
    for (name, text) in [("at-glove", GLOVE), ("at-flesh", FLESH), ("at-tissue", TISSUE)] {
        let folder = Folder::new(name);
        let (file, recorded) = folder.record(text, STEPS, busy);
        let index = Index::of(&file).unwrap();
        let beginnings = index.beginnings();
        assert!(beginnings.len() > 6, "{beginnings:?}");
        // Backwards: each time the session has been elsewhere.
        let mut replay = Replay::open(&file).unwrap();
        for seconds in beginnings.iter().rev() {
            assert_eq!(replay.go_to(&index, *seconds).unwrap(), *seconds);
            let hashes = replayed(&mut replay);
            assert_eq!(hashes, recorded[STEPS - hashes.len()..], "{name} {seconds}");
            let verdict = replay.verdict();
            assert!(verdict.is_same() && verdict.ended, "{name} {seconds}: {verdict:?}");
            assert_eq!(verdict.put_right.0, 0, "{name} {seconds}");
            assert_eq!(verdict.passed + verdict.steps, STEPS as u64, "{name} {seconds}");
        }
        // A session of its own, and between two keyframes.
        let mut replay = Replay::open_at(&file, beginnings[3] + 0.011).unwrap();
        let hashes = replayed(&mut replay);
        assert_eq!(hashes, recorded[STEPS - hashes.len()..], "{name}");
        assert!(replay.verdict().passed > 20);
    }
}

/// A state as keyframes had it before tissue remembered, field by field.
type OldState = (
    f64,
    Vec<Pose>,
    [Vec<Vec3>; 3],
    Vec<(u64, Vec3)>,
    SeenSides,
    Vec<[f64; 2]>,
    Vec<([u32; 3], f64)>,
);

/// Programs before this one kept only the world's state in keyframes.
#[test]
fn keyframes_without_memory_are_replayed_as_well() {
    let folder = Folder::new("old");
    let (file, recorded) = folder.record(GLOVE, STEPS, busy);
    let old = folder.file("old.rec");
    let recorder = Recorder::create(&old, &Header::default()).unwrap();
    let mut writer = recorder.session();
    let (_, mut frames) = thenar_record::open(&file).unwrap();
    let mut shortened = 0;
    while let Some(frame) = frames.next().unwrap() {
        let mut body = frame.body;
        match frame.kind.unwrap() {
            FrameKind::End => continue,
            FrameKind::Keyframe => {
                let (_, rest) = postcard::take_from_bytes::<(u64, OldState)>(body).unwrap();
                body = &body[..body.len() - rest.len()];
                shortened += usize::from(!rest.is_empty());
            }
            _ => {}
        }
        writer.big_frame(frame.kind.unwrap(), frame.time_ns, |out| out.extend(body));
    }
    drop(writer);
    recorder.finish().unwrap();
    assert!(shortened > 5);
    for seconds in [0.0, 0.3, 0.62] {
        let mut replay = Replay::open_at(&old, seconds).unwrap();
        let hashes = replayed(&mut replay);
        assert_eq!(hashes, recorded[STEPS - hashes.len()..], "{seconds}");
        let verdict = replay.verdict();
        assert!(verdict.is_same() && verdict.ended, "{seconds}: {verdict:?}");
        assert_eq!(verdict.passed > 0, seconds > 0.1, "{seconds}: {verdict:?}");
    }
}

#[test]
fn a_recording_holds_the_files_its_scene_names() {
    let folder = Folder::new("assets");
    let tets = "nodes = [[0,0,0],[0.05,0,0],[0,0.05,0],[0,0,0.05]]\ntets = [[0,1,2,3]]\n";
    std::fs::create_dir(folder.file("meshes")).unwrap();
    std::fs::write(folder.file("meshes/one.toml"), tets).unwrap();
    let text = "version = 1\n[[soft]]\nname = \"tet\"\nposition = [0, 1, 0]\n\
                shape = { kind = \"tet-file\", file = \"meshes/one.toml\" }\n\
                material = { young = 1e4, poisson = 0.3, density = 1000.0 }\n";
    let (file, recorded) = folder.record(text, 10, |_, _| ());
    // Neither the scene nor its files are needed any more.
    std::fs::remove_dir_all(folder.file("meshes")).unwrap();
    let mut replay = Replay::open(&file).unwrap();
    assert_eq!(replayed(&mut replay), recorded);
    assert!(replay.verdict().is_same());
}

#[test]
fn several_scenes_may_follow_one_another() {
    let folder = Folder::new("scenes");
    let other = BALL.replace("0.06", "0.2");
    let (file, recorded) = folder.record_all(&[(BALL, 17), (&other, 12)], |_, _| ());
    let mut replay = Replay::open(&file).unwrap();
    assert_eq!(replayed(&mut replay), recorded);
    let verdict = replay.verdict();
    assert_eq!((verdict.scenes, verdict.same), (2, 29));
    assert!(verdict.is_same(), "{verdict:?}");
    // Back to the first scene from within the second, and on into the second again.
    let index = Index::of(&file).unwrap();
    assert_eq!(replay.go_to(&index, 0.155).unwrap(), 0.1);
    assert_eq!(replayed(&mut replay), recorded[10..]);
    assert!(replay.verdict().is_same() && replay.verdict().scenes == 2);
}
