//! Goal: a recorded session is made again with the same bits: poses, losses, settings, restarts and
//! files that its scene names included. Method: sessions are recorded while all that enters them,
//! replayed, and compared step by step by hash, and once with a copy of the states themselves.

use std::path::{Path, PathBuf};
use thenar::world::Target;
use thenar::{Pose, Vec3};
use thenar_record::{Header, Recorder};
use thenar_scene::live::LivePose;
use thenar_scene::recording::{Event, Replay, ReplayError, SessionTape, TimeOf};
use thenar_scene::session::Session;
use thenar_scene::tuning::SettingValue;

/// A folder of its own for each test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("thenar-rec-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn recording(&self) -> PathBuf {
        self.0.join("test.rec")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

const RIGID: &str = r#"
version = 1
time_step = 0.005
[[rigid]]
name = "table"
motion = "fixed"
shape = { kind = "plane" }
[[rigid]]
name = "box"
mass = 0.2
position = [0.3, 0.06, 0.0]
velocity = [0.5, 0.0, 0.1]
angular_velocity = [3.0, 1.0, 0.0]
shape = { kind = "box", size = [0.1, 0.06, 0.08] }
[[hand]]
name = "right"
flesh = false
tets = 300
position = [0.0, 0.3, 0.0]
"#;

const BALL: &str = r#"
version = 1
time_step = 0.005
[[rigid]]
name = "table"
motion = "fixed"
shape = { kind = "plane" }
[[rigid]]
name = "ball"
mass = 0.2
position = [0.3, 0.06, 0.0]
velocity = [0.5, 0.0, 0.1]
shape = { kind = "sphere", radius = 0.05 }
"#;

const SOFT: &str = r#"
version = 1
time_step = 0.005
[[rigid]]
name = "floor"
motion = "fixed"
shape = { kind = "plane" }
[[hand]]
name = "right"
flesh = false
tets = 300
position = [0.0, 0.3, 0.0]
[[soft]]
name = "cube"
position = [0.0, 0.03, 0.0]
velocity = [0.3, -0.5, 0.0]
material = { young = 20e3, poisson = 0.3, density = 500.0 }
shape = { kind = "lattice", size = [0.05, 0.05, 0.05], cells = [3, 3, 3] }
"#;

/// Records `drive`, which steps a session; returns the hashes after all steps.
fn record(
    file: &Path,
    mut session: Session,
    drive: impl FnOnce(&mut dyn FnMut(&mut Session), &mut Session),
) -> Vec<u64> {
    let recorder = Recorder::create(file, &Header::default()).unwrap();
    let tape = SessionTape::new(recorder.session(), recorder.clock(), TimeOf::Simulation, 0.1);
    session.set_witness(Box::new(tape));
    let mut hashes = Vec::new();
    let mut step = |session: &mut Session| {
        session.step(&mut ());
        hashes.push(session.world().state_hash());
    };
    drive(&mut step, &mut session);
    drop(session);
    recorder.finish().unwrap();
    hashes
}

/// Everything that can enter, over 120 steps.
fn busy(step: &mut dyn FnMut(&mut Session), session: &mut Session) {
    for k in 0..120 {
        let t = f64::from(k) * 0.005;
        match k {
            20 | 21 => session.set("friction", &SettingValue::Number(0.3 + 0.01 * t)).unwrap(),
            // Refused: leaves no trace.
            22 => assert!(session.set("friction", &SettingValue::Number(-1.0)).is_err()),
            40 => session.set("time_step", &SettingValue::Number(0.004)).unwrap(),
            50 => session.set("solver", &SettingValue::Choice("two-step".into())).unwrap(),
            60 => session.live_lost(0),
            80 => session.follow_script(0),
            100 => session.restart(),
            _ => {}
        }
        if (10..60).contains(&k) && k % 2 == 0 {
            let wrist = Pose::new(Vec3::new(0.2 * t, 0.3 - 0.4 * t, 0.1 * t), Default::default());
            let angles = std::array::from_fn(|a| 0.02 * a as f64 * t);
            let pose = LivePose::Angles { wrist, angles };
            session.live_pose(0, 100.0 + t, &pose).unwrap();
        }
        // The haptic loop takes the hand over, and lets go of it again.
        if (105..115).contains(&k) {
            let bones = session.hands()[0].handle.bones.clone();
            let target = |bone: u32| {
                let mut target = session.input().targets[bone as usize].unwrap();
                target.pose_WB.position.x += 1e-3 * t;
                target
            };
            let targets: Vec<Target> = bones.map(target).collect();
            assert!(session.lead(0, targets.into_iter()));
        }
        if k == 115 {
            session.let_go(0);
        }
        step(session);
    }
}

/// Hashes after the steps of a replay.
fn replayed(replay: &mut Replay) -> Vec<u64> {
    let mut hashes = Vec::new();
    while let Some(event) = replay.next().unwrap() {
        if let Event::Stepped { .. } = event {
            hashes.push(replay.session().unwrap().world().state_hash());
        }
    }
    hashes
}

fn open(text: &str, folder: &Folder) -> Session {
    Session::from_text(text, &folder.0.join("scene.toml"), &[]).unwrap()
}

#[test]
fn a_replay_gives_the_same_bits_whatever_entered() {
    for (name, text) in [("rigid", RIGID), ("soft", SOFT)] {
        let folder = Folder::new(name);
        let recorded = record(&folder.recording(), open(text, &folder), busy);
        // The bits depend on what enters.
        let quiet = {
            let mut session = open(text, &folder);
            (0..120).for_each(|_| _ = session.step(&mut ()));
            session.world().state_hash()
        };
        assert_ne!(quiet, recorded[119], "{name}");
        let mut replay = Replay::open(&folder.recording()).unwrap();
        assert_eq!(replayed(&mut replay), recorded, "{name}");
        let verdict = replay.verdict();
        assert!(verdict.is_same() && verdict.ended && verdict.losses.is_empty(), "{verdict:?}");
        assert_eq!((verdict.scenes, verdict.steps, verdict.same), (1, 120, 120));
        assert_eq!(verdict.put_right.0, 0, "keyframes agree");
        // 40 steps of 5 ms, 60 of 4 ms, and after the restart 20 more: settings stay.
        assert!((verdict.seconds - (0.2 + 0.24 + 0.08)).abs() < 1e-9, "{}", verdict.seconds);
    }
}

#[test]
fn a_replay_may_begin_at_any_keyframe() {
    let folder = Folder::new("at");
    let recorded = record(&folder.recording(), open(SOFT, &folder), busy);
    for seconds in [0.25, 9.0] {
        let mut replay = Replay::open_at(&folder.recording(), seconds).unwrap();
        let hashes = replayed(&mut replay);
        assert_eq!(hashes, recorded[120 - hashes.len()..], "{seconds}");
        let verdict = replay.verdict();
        assert!(verdict.is_same(), "{seconds}: {verdict:?}");
        assert!(verdict.passed > 0 && verdict.passed + verdict.steps == 120, "{verdict:?}");
    }
}

#[test]
fn a_recording_holds_the_files_its_scene_names() {
    let folder = Folder::new("assets");
    let tets = "nodes = [[0,0,0],[0.05,0,0],[0,0.05,0],[0,0,0.05]]\ntets = [[0,1,2,3]]\n";
    std::fs::create_dir(folder.0.join("meshes")).unwrap();
    std::fs::write(folder.0.join("meshes/one.toml"), tets).unwrap();
    let text = "version = 1\n[[soft]]\nname = \"tet\"\nposition = [0, 1, 0]\n\
                shape = { kind = \"tet-file\", file = \"meshes/one.toml\" }\n\
                material = { young = 1e4, poisson = 0.3, density = 1000.0 }\n";
    let steps = |step: &mut dyn FnMut(&mut Session), session: &mut Session| {
        (0..10).for_each(|_| step(session));
    };
    let recorded = record(&folder.recording(), open(text, &folder), steps);
    // Neither the scene nor its files are needed any more.
    std::fs::remove_dir_all(folder.0.join("meshes")).unwrap();
    let mut replay = Replay::open(&folder.recording()).unwrap();
    assert_eq!(replayed(&mut replay), recorded);
    assert!(replay.verdict().is_same());
}

#[test]
fn whatever_is_cut_off_the_rest_is_replayed() {
    let folder = Folder::new("cut");
    let text = "version = 1\ntime_step = 0.01\n[[rigid]]\nname = \"ball\"\nmass = 1\n\
                position = [0, 1, 0]\nshape = { kind = \"sphere\", radius = 0.1 }\n";
    let steps = |step: &mut dyn FnMut(&mut Session), session: &mut Session| {
        for k in 0..6 {
            if k == 3 {
                session.set("gravity", &SettingValue::Number(5.0)).unwrap();
            }
            step(session);
        }
    };
    let recorded = record(&folder.recording(), open(text, &folder), steps);
    let whole = std::fs::read(folder.recording()).unwrap();
    let cut = folder.0.join("cut.rec");
    let (mut lengths, mut damaged) = (Vec::new(), 0);
    for size in (0..whole.len()).step_by(5) {
        std::fs::write(&cut, &whole[..size]).unwrap();
        match Replay::open(&cut) {
            Err(error) => assert!(matches!(error, ReplayError::Open(_)) && size < 300, "{error}"),
            Ok(mut replay) => {
                let hashes = replayed(&mut replay);
                assert_eq!(hashes, recorded[..hashes.len()], "{size}");
                assert!(replay.verdict().is_same() && !replay.verdict().ended);
                damaged += usize::from(!replay.verdict().losses.is_empty());
                lengths.push(hashes.len());
            }
        }
    }
    assert!(lengths.is_sorted() && lengths.first() == Some(&0) && lengths.last() == Some(&6));
    assert!(damaged > lengths.len() / 2, "only cuts between frames leave no damage");
}

#[test]
fn a_difference_is_found_told_and_put_right() {
    let folder = Folder::new("differs");
    let steps = |step: &mut dyn FnMut(&mut Session), session: &mut Session| {
        for k in 0..60 {
            if k == 25 {
                // Behind the witness's back.
                let pose = Pose::new(Vec3::new(0.3, 0.5, 0.0), Default::default());
                session.world_mut().set_rigid_state(1, pose, [Vec3::zeros(); 2]);
            }
            step(session);
        }
    };
    let recorded = record(&folder.recording(), open(BALL, &folder), steps);
    let mut replay = Replay::open(&folder.recording()).unwrap();
    let hashes = replayed(&mut replay);
    let verdict = replay.verdict();
    let first = verdict.first.unwrap();
    assert_eq!((first.scene, first.step), (1, 26));
    assert!((first.time - 0.13).abs() < 1e-9);
    assert_eq!(hashes[..25], recorded[..25]);
    assert_ne!(hashes[25..39], recorded[25..39]);
    // The keyframe after step 40 puts it right.
    assert_eq!(hashes[40..], recorded[40..]);
    let (times, moved) = verdict.put_right;
    assert!(times == 1 && moved.rigid > 0.3 && moved.node == 0.0, "{moved:?}");
    assert!(
        verdict.to_string().starts_with("differs from step 26 of scene 1 on, at 0.130 s; 45 of")
    );
    let here = Header { vectors: "Other".into(), ..Header::default() };
    let causes = verdict.causes(replay.header(), &here);
    assert!(causes[0].contains("vector instructions"), "{causes:?}");
}

#[test]
fn several_scenes_may_follow_one_another() {
    let folder = Folder::new("scenes");
    let recorder = Recorder::create(&folder.recording(), &Header::default()).unwrap();
    let tape = SessionTape::new(recorder.session(), recorder.clock(), TimeOf::Clock, 0.1);
    let mut one = open(BALL, &folder);
    one.set_witness(Box::new(tape));
    (0..7).for_each(|_| _ = one.step(&mut ()));
    let mut two = open(BALL, &folder);
    two.set_witness(one.take_witness().unwrap());
    (0..5).for_each(|_| _ = two.step(&mut ()));
    let hash = two.world().state_hash();
    drop(two);
    recorder.finish().unwrap();
    let mut replay = Replay::open(&folder.recording()).unwrap();
    assert_eq!(replayed(&mut replay).last(), Some(&hash));
    let verdict = replay.verdict();
    assert_eq!((verdict.scenes, verdict.same), (2, 12));
    assert!(verdict.is_same(), "{verdict:?}");
}
