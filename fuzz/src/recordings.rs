//! From the bytes of a recording to its replayed steps.
//!
//! The fuzz target `recording` and `crates/thenar-scene/tests/all/recording/fuzz.rs` run this code.

use std::path::Path;
use std::sync::OnceLock;
use thenar_core::Pose;
use thenar_core::model::Side;
use thenar_record::{FrameKind, Header, Recorder};
use thenar_rig::hand::{HandOptions, asset, build_hand};
use thenar_rig::{Model, write_model};
use thenar_scene::build::wanted_bytes;
use thenar_scene::live::LivePose;
use thenar_scene::recording::{
    Event, Index, Replay, ReplayError, SceneStart, SessionWriter, TimeOf,
};
use thenar_scene::session::{Session, Source, read};
use thenar_scene::tuning::SettingValue;

/// Scenes that would take more memory are not built: a fuzzer learns nothing from waiting.
const BYTES_MAX: u64 = 20_000_000;
/// So many steps are replayed.
const STEPS: usize = 40;
/// So many events are looked at.
const EVENTS: usize = 400;

/// A bare glove over a table, and a cube of flesh: what frames without a beginning belong to.
const GLOVE: &str = r#"version = 1
time_step = 0.01
[[rigid]]
name = "table"
motion = "fixed"
shape = { kind = "plane" }
[[hand]]
preset = "paper"
name = "right"
model = "hand.thenar"
flesh = false
position = [0, 0.1, 0]
[[soft]]
name = "cube"
position = [0.2, 0.024, 0]
shape = { kind = "lattice", size = [0.05, 0.05, 0.05], cells = [1, 1, 1] }
"#;

/// Steps of a recording, whose checksums are made to agree, replayed from its beginning and from
/// its middle; how many there were. Bytes that begin with `+` are the frames that follow the
/// beginning of a session.
pub fn replays(bytes: &[u8], file: &Path) -> Result<usize, ReplayError> {
    let bytes = match bytes {
        [b'+', frames @ ..] => sealed(&[beginning(), frames].concat()),
        whole => sealed(whole),
    };
    std::fs::write(file, &bytes).unwrap();
    if !is_small(file)? {
        return Ok(0);
    }
    let steps = looked_at(Replay::open(file)?)?;
    let end = Index::of(file)?.end();
    assert!((0.0..2e10).contains(&end), "{end}");
    let mut replay = Replay::open_at(file, 0.5 * end)?;
    if let Some(session) = replay.session_mut() {
        session.probe();
    }
    looked_at(replay)?;
    Ok(steps)
}

fn looked_at(mut replay: Replay) -> Result<usize, ReplayError> {
    let mut steps = 0;
    for _ in 0..EVENTS {
        let Some(event) = replay.next()? else { break };
        if let Event::Entered { what, .. } = &event {
            assert!(what.len() < 300, "{what}");
        }
        if let (Event::Stepped { .. }, Some(session)) = (&event, replay.session()) {
            // A step whose numbers are not finite is taken back.
            assert!(session.world().state().is_sound(), "{:?}", session.report());
            steps += 1;
            if steps == STEPS {
                break;
            }
        }
    }
    let verdict = replay.verdict();
    assert!(verdict.seconds.is_finite() && verdict.same <= verdict.steps, "{verdict:?}");
    assert!(!verdict.to_string().is_empty());
    for loss in &verdict.losses {
        assert!(loss.to_string().len() < 300, "{loss}");
    }
    Ok(steps)
}

/// True when its scenes are those of the shared beginning, or small and without files and hands of
/// their own, which take a second each.
fn is_small(file: &Path) -> Result<bool, ReplayError> {
    let (_, mut frames) = thenar_record::open(file)?;
    while let Some(frame) = frames.next()? {
        let known = beginning().ends_with(frame.body) && !frame.body.is_empty();
        if frame.kind != Some(FrameKind::Scene) || known {
            continue;
        }
        // What cannot be decoded is refused when it is replayed.
        let Some(start) = SceneStart::read(frame.body) else { continue };
        let Source { text, overrides, hands, lengths, file, .. } = &start.source;
        let plain = Source::new(text, file, overrides);
        let small = |text: &str| {
            read(text, overrides).is_ok_and(|s| s.hand.is_empty() && wanted_bytes(&s) < BYTES_MAX)
        };
        let is_plain = plain.hands == *hands && plain.lengths == *lengths;
        if !(is_plain && start.assets.is_empty() && small(text)) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The bytes with the checksums of prologue and frames made right.
pub fn sealed(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    if bytes.len() < 16 {
        return bytes;
    }
    let mut sum = crc32fast::hash(&bytes[..12]);
    bytes[12..16].copy_from_slice(&sum.to_le_bytes());
    let mut at = 16;
    while let Some(head) = bytes.get(at..at + 8) {
        let length = u32::from_le_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let Some(payload) = bytes.get(at + 8..at.saturating_add(8).saturating_add(length)) else {
            break;
        };
        let mut hasher = crc32fast::Hasher::new_with_initial(sum);
        hasher.update(&head[..4]);
        hasher.update(payload);
        sum = hasher.finalize();
        bytes[at + 4..at + 8].copy_from_slice(&sum.to_le_bytes());
        at += 8 + length;
    }
    bytes
}

/// A session with a hand, whose model lies in this folder.
fn glove(folder: &Path) -> Session {
    std::fs::create_dir_all(folder).unwrap();
    let options = HandOptions {
        name: "hand".into(),
        side: Some(Side::Right),
        tets: 60,
        collision_triangles: 300,
        ..HandOptions::paper()
    };
    let hand = build_hand(asset(Side::Right), &options).unwrap();
    write_model(&folder.join("hand.thenar"), &Model::Hand(hand)).unwrap();
    Session::from_text(GLOVE, &folder.join("scene.toml"), &[]).unwrap()
}

/// Prologue, header and scene of a session with a hand.
pub fn beginning() -> &'static [u8] {
    static BEGINNING: OnceLock<Vec<u8>> = OnceLock::new();
    BEGINNING.get_or_init(|| {
        let folder = std::env::temp_dir().join(format!("thenar-fuzz-scene-{}", std::process::id()));
        let bytes = recorded(glove(&folder), &folder.join("glove.rec"), 0, |_, _| ());
        std::fs::remove_dir_all(&folder).unwrap();
        bytes[..behind_scene(&bytes)].to_vec()
    })
}

/// Where the frames after prologue, header and scene begin.
fn behind_scene(bytes: &[u8]) -> usize {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let scene = 16 + 8 + word(16);
    scene + 8 + word(scene)
}

/// A recording of some steps of a session, each after what `drive` does.
pub fn recorded(
    mut session: Session,
    file: &Path,
    steps: usize,
    mut drive: impl FnMut(usize, &mut Session),
) -> Vec<u8> {
    let header = Header { simulated_time: true, ..Header::default() };
    let recorder = Recorder::create(file, &header).unwrap();
    let every = 5.0 * session.world().time_step();
    let tape = SessionWriter::new(recorder.session(), recorder.clock(), TimeOf::Simulation, every);
    session.set_witness(Box::new(tape));
    for k in 0..steps {
        drive(k, &mut session);
        session.step(&mut ());
    }
    drop(session.take_witness());
    recorder.finish().unwrap();
    std::fs::read(file).unwrap()
}

/// Good recordings to begin with: a whole one of a ball, and the frames of a glove that is moved,
/// led, put elsewhere, set and restarted.
pub fn seeds(folder: &Path) -> Vec<Vec<u8>> {
    const BALL: &str = r#"version = 1
time_step = 0.01
[[rigid]]
name = "table"
motion = "fixed"
shape = { kind = "plane" }
[[rigid]]
name = "ball"
mass = 0.2
position = [0.3, 0.06, 0]
velocity = [0.5, 0, 0.1]
shape = { kind = "sphere", radius = 0.05 }
"#;
    let ball = Session::from_text(BALL, Path::new("ball.toml"), &[]).unwrap();
    let ball = recorded(ball, &folder.join("ball.rec"), 8, |_, _| ());
    let glove = recorded(glove(folder), &folder.join("glove.rec"), 10, |k, session| {
        let wrist = Pose::translation(0.0, 0.1 - 0.01 * k as f64, 0.0);
        let pose = LivePose::Angles { wrist, angles: [0.1 * k as f64; 20] };
        match k {
            0..3 => session.live_pose(0, 7.0 + 0.01 * k as f64, &pose).unwrap(),
            3 => {
                let targets: Vec<_> = session.input().targets.iter().flatten().copied().collect();
                assert!(session.lead(0, targets.into_iter()));
            }
            4 => session.let_go(0),
            5 => session.set("gravity", &SettingValue::Number(4.0)).unwrap(),
            6 => session.live_lost(0),
            7 => session.restart(),
            8 => {
                let state = session.world().state().clone();
                assert!(session.resume(&state));
            }
            _ => session.follow_script(0),
        }
    });
    let frames = &glove[behind_scene(&glove)..];
    vec![ball, [b"+", frames].concat()]
}
