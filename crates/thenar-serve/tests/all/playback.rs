//! Goal: a recorded session is shown as it was: the same states at the same places, at its own
//! pace; with pause, steps and places to go to, and with nothing that clients could change. Method:
//! sessions are recorded while their states are kept, and a visitor at the hub of the replay
//! compares.

use crate::visitor::Visitor;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use thenar_core::{Pose, Vec3};
use thenar_record::{Header, Recorder};
use thenar_scene::live::LivePose;
use thenar_scene::recording::{SessionWriter, TimeOf};
use thenar_scene::session::{Session, Witness};
use thenar_scene::tuning::SettingValue;
use thenar_serve::playback::{Playback, PlaybackError};

const PAUSED: u16 = 1;
const TRACKED: u16 = 32;

/// Simulated time of each scene, in steps of 10 ms.
const STEPS: usize = 60;

const GLOVE: &str = r#"
version = 1
time_step = 0.01
[[hand]]
preset = "paper"
name = "glove"
flesh = false
tets = 60
position = [0.0, 0.3, 0.0]
[[rigid]]
name = "ball"
mass = 0.1
position = [0.3, 0.2, 0.0]
velocity = [0.2, 0.0, 0.0]
shape = { kind = "sphere", radius = 0.04 }
"#;

const BALL: &str = r#"
version = 1
time_step = 0.01
[[rigid]]
name = "ball"
mass = 0.1
position = [0.1, 0.2, 0.0]
shape = { kind = "sphere", radius = 0.04 }
"#;

struct Recording {
    file: PathBuf,
    /// Pose of the ball after every step of both scenes, and the hands of the first.
    poses: Vec<[f64; 3]>,
}

impl Recording {
    /// A glove that is tracked, beside a ball; then a ball alone.
    fn new(name: &str) -> Self {
        let file = std::env::temp_dir().join(format!("thenar-play-{name}-{}", std::process::id()));
        let _ = std::fs::remove_file(&file);
        let recorder = Recorder::create(&file, &Header::default()).unwrap();
        let writer =
            SessionWriter::new(recorder.session(), recorder.clock(), TimeOf::Simulation, 0.1);
        let mut witness: Option<Box<dyn Witness>> = Some(Box::new(writer));
        let mut poses = Vec::new();
        for text in [GLOVE, BALL] {
            let mut session = Session::from_text(text, "scene.toml".as_ref(), &[]).unwrap();
            session.set_witness(witness.take().unwrap());
            for k in 0..STEPS {
                let t = 0.01 * k as f64;
                let at = Pose::translation(0.1 * t, 0.3 - 0.1 * t, 0.0);
                let _ = session.live_pose(0, t, &LivePose::Angles { wrist: at, angles: [t; 20] });
                if k == 25 {
                    session.set("gravity", &SettingValue::Number(2.0)).unwrap();
                }
                session.step(&mut ());
                let last = session.world().state().poses_WB.last().unwrap().position;
                poses.push([last.x, last.y, last.z]);
            }
            witness = session.take_witness();
        }
        drop(witness);
        recorder.finish().unwrap();
        Self { file, poses }
    }
}

impl Drop for Recording {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.file);
    }
}

/// Where the ball of a snapshot is, and where it was then, after so many steps.
fn ball(visitor: &Visitor, poses: &[[f64; 3]], number: usize) -> [Vec3; 2] {
    let snapshot = visitor.snapshot();
    let shown = snapshot.rigids.last().unwrap();
    let [x, y, z] = poses[number - 1];
    [Vec3::new(shown[0], shown[1], shown[2]), Vec3::new(x, y, z)]
}

#[test]
fn a_recording_is_shown_as_it_was_wherever_one_goes() {
    let recording = Recording::new("places");
    let (_playback, hub) = Playback::start(&recording.file, 0.0).unwrap();
    let one = Visitor::join(&hub, 1);
    let status = one.until_status("control", |s| s["control"] == 1);
    let end = status["recording"]["end"].as_f64().unwrap();
    assert!((end - 1.2).abs() < 1e-9, "{status}");
    one.say(r#"{"type":"run","paused":true}"#);
    one.until("pause", |s| s.flags & PAUSED != 0);
    // Forwards, backwards, into the other scene and back, before and behind the changed gravity.
    let mut epochs = Vec::new();
    for number in [30, 12, 58, 100, 61, 7, 30] {
        let time = 0.01 * number as f64;
        one.say(&format!(r#"{{"type":"seek","time":{time}}}"#));
        let steps = ((number - 1) % STEPS + 1) as u32;
        let shown = one.until("the place", |s| s.steps == steps && s.flags & PAUSED != 0);
        one.until_status("its time", |s| {
            (s["recording"]["time"].as_f64().unwrap() - time).abs() < 1e-6
        });
        let [is, was] = ball(&one, &recording.poses, number);
        // Snapshots have 32-bit numbers.
        assert!((is - was).norm() < 1e-6, "{number}: {is} {was}");
        assert_eq!(one.model().epoch, shown.epoch);
        let hands = one.model().json["hands"].as_array().unwrap().len();
        assert_eq!(hands, usize::from(number <= STEPS), "{number}");
        assert_eq!(shown.flags & TRACKED != 0, number <= STEPS, "{number}");
        epochs.push(shown.epoch);
    }
    assert_eq!(epochs, [1, 1, 1, 2, 2, 3, 3], "a model for each scene that begins");
    // One step on, and back to the start.
    one.say(r#"{"type":"step"}"#);
    one.until("a step", |s| s.steps == 31);
    one.say(r#"{"type":"reset"}"#);
    one.until("the start", |s| s.steps == 1);
    // Set later only.
    one.until_status("the scene's own gravity", |status| {
        let settings = status["settings"].as_array().unwrap();
        settings.iter().any(|s| s["key"] == "gravity" && s["value"] == s["own"])
    });
}

#[test]
fn it_takes_its_own_time_and_begins_again() {
    let recording = Recording::new("pace");
    let (_playback, hub) = Playback::start(&recording.file, 0.0).unwrap();
    let one = Visitor::join(&hub, 1);
    one.until_status("control", |s| s["control"] == 1);
    let place = |status: &serde_json::Value| status["recording"]["time"].as_f64().unwrap();
    one.say(r#"{"type":"speed","value":0.5}"#);
    one.say(r#"{"type":"seek","time":0.6}"#);
    one.until_status("the middle", |s| (0.59..0.7).contains(&place(s)) && s["speed"] == 0.5);
    let begun = Instant::now();
    one.until_status("the end", |s| place(s) > 1.19);
    // Half a second and more, never sooner than at half the speed; later, where the machine is
    // busy.
    assert!(begun.elapsed() > Duration::from_millis(800), "{:?}", begun.elapsed());
    one.until_status("the beginning again", |s| place(s) < 0.3);
    assert_eq!(one.status()["problem"], serde_json::Value::Null);
    // Nobody watching, it waits where it is.
    one.say(r#"{"type":"seek","time":0.4}"#);
    let before = place(&one.until_status("0.4 s", |s| place(s) > 0.35));
    one.leave();
    std::thread::sleep(Duration::from_millis(400));
    let two = Visitor::join(&hub, 2);
    let now = place(&two.until_status("control", |s| s["control"] == 2));
    assert!(now >= before - 1e-9 && now < before + 0.3, "{before} {now}");
}

#[test]
fn nothing_that_clients_send_moves_it() {
    let recording = Recording::new("input");
    let (_playback, hub) = Playback::start(&recording.file, 0.0).unwrap();
    let mut one = Visitor::join(&hub, 1);
    one.until_status("control", |s| s["control"] == 1);
    one.say(r#"{"type":"run","paused":true}"#);
    for text in [
        r#"{"type":"set","key":"gravity","value":0.0}"#,
        r#"{"type":"scene","name":"falling-box"}"#,
        r#"{"type":"hands","which":"both"}"#,
        r#"{"type":"arm"}"#,
    ] {
        one.say(text);
        let (note, refusal) = one.note();
        let why = note["message"].as_str().unwrap();
        assert!(why.contains("this is a recording") && !refusal, "{text}: {note}");
    }
    for k in 0..20 {
        let pose = one.angles(1, &Pose::translation(0.0, 0.2, 0.0), [0.3; 20], 0.01 * f64::from(k));
        one.send(pose).unwrap();
    }
    let (note, _) = one.note();
    assert!(note["message"].as_str().unwrap().contains("this is a recording"), "{note}");
    one.say(r#"{"type":"ping","t":1.5}"#);
    assert_eq!(one.note().0["type"], "pong", "told once, not twenty times");
    one.say(r#"{"type":"seek","time":-1.0}"#);
    assert!(one.note().1, "no place");
    // And it is as it was.
    one.say(r#"{"type":"seek","time":0.5}"#);
    one.until("the place", |s| s.steps == 50);
    let [is, was] = ball(&one, &recording.poses, 50);
    assert!((is - was).norm() < 1e-6, "{is} {was}");
    // Who only watches changes not even the place.
    let mut two = Visitor::join(&hub, 2);
    two.say(r#"{"type":"seek","time":0.1}"#);
    let (note, refusal) = two.note();
    assert!(refusal && note["message"].as_str().unwrap().contains("viewer 1"), "{note}");
}

#[test]
fn what_cannot_be_shown_is_refused() {
    let recording = Recording::new("none");
    let whole = std::fs::read(&recording.file).unwrap();
    let (_, mut frames) = thenar_record::open(&recording.file).unwrap();
    frames.next().unwrap();
    // Without its scene there is nothing to be seen.
    std::fs::write(&recording.file, &whole[..frames.offset() as usize - 10]).unwrap();
    assert!(matches!(Playback::start(&recording.file, 0.0), Err(PlaybackError::Empty)));
    std::fs::write(&recording.file, b"something else").unwrap();
    let error = Playback::start(&recording.file, 0.0).unwrap_err().to_string();
    assert!(error.contains("is not a Thenar recording"), "{error}");
}
