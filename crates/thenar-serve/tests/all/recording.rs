//! Goal: a live session is recorded whole: poses of a page, settings, resets, other scenes and
//! hands, and what comes after a failure; and its replay gives the same bits. Method: a visitor at
//! the hub of a running simulation with a recording as its witness, which is then replayed.

use crate::visitor::Visitor;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use thenar_core::{Pose, Vec3};
use thenar_record::{Header, Recorder};
use thenar_scene::recording::{Event, Replay, SessionWriter, TimeOf};
use thenar_serve::live::{Live, Options, SceneSource};

const SCENE: &str = r#"
version = 1
time_step = 0.01
duration = 1000
[[hand]]
preset = "paper"
name = "glove"
flesh = false
tets = 300
position = [0.0, 0.3, 0.0]
[[rigid]]
name = "floor"
motion = "fixed"
shape = { kind = "plane" }
[[rigid]]
name = "ball"
mass = 0.1
position = [0.3, 0.2, 0.0]
velocity = [0.2, 0.0, 0.0]
shape = { kind = "sphere", radius = 0.04 }
"#;

struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn a_live_session_is_replayed_to_the_bit_with_all_that_entered_it() {
    let path = std::env::temp_dir().join(format!("thenar-serve-rec-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    let folder = Folder(path);
    let (scene, file) = (folder.0.join("glove.toml"), folder.0.join("live.rec"));
    std::fs::write(&scene, SCENE).unwrap();

    let recorder = Recorder::create(&file, &Header::default()).unwrap();
    let writer = SessionWriter::new(recorder.session(), recorder.clock(), TimeOf::Clock, 0.25);
    let once = AtomicBool::new(true);
    let options = Options {
        witness: Some(Box::new(writer)),
        watcher: Some(Box::new(move |session| {
            let fails = session.name() == "falling-box" && session.steps() == 30;
            assert!(!(fails && once.swap(false, Ordering::Relaxed)), "made to fail");
        })),
        ..Options::default()
    };
    let (live, hub) = Live::start(&SceneSource::File(scene), options).unwrap();
    let mut one = Visitor::join(&hub, 1);
    one.until("motion", |s| s.steps > 3);
    for k in 0..40 {
        let at = Vec3::new(0.01 * f64::from(k), 0.3, 0.0);
        let angles = std::array::from_fn(|a| 0.01 * a as f64);
        let message =
            one.angles(1, &Pose::new(at, Default::default()), angles, f64::from(k) * 0.01);
        one.send(message).unwrap();
        std::thread::sleep(Duration::from_millis(10));
    }
    one.until("the pose to act", |s| s.pose > 30);
    one.say(r#"{"type":"set","key":"friction","value":0.2}"#);
    one.say(r#"{"type":"reset"}"#);
    let reset = one.until("the reset", |s| s.steps > 0 && s.time < 0.1);
    one.until("more", |s| s.time > reset.time + 0.2);
    one.say(r#"{"type":"scene","name":"falling-box"}"#);
    // It fails once, and is made again.
    let status = one.until_status("the failure", |s| !s["problem"].is_null());
    assert!(status["problem"].as_str().unwrap().contains("made to fail"), "{status}");
    let epoch = one.model().epoch;
    one.until("the box again", |s| s.epoch >= epoch && s.steps > 40);
    drop(live);
    recorder.finish().unwrap();

    let mut replay = Replay::open(&file).unwrap();
    let (mut poses, mut others) = (0, Vec::new());
    while let Some(event) = replay.next().unwrap() {
        match event {
            Event::Entered { often: true, .. } => poses += 1,
            Event::Entered { what, .. } => others.push(what),
            _ => {}
        }
    }
    let verdict = replay.verdict();
    assert!(verdict.is_same() && verdict.ended, "{verdict}");
    assert_eq!((verdict.scenes, verdict.unmarked), (3, 0), "the glove, the box, and the box again");
    assert_eq!((poses, verdict.gaps.len()), (40, 0));
    assert_eq!(verdict.same, verdict.steps);
    assert!(others.contains(&"friction = 0.2".into()) && others.contains(&"restart".into()));
}
