//! Goal: one client holds control and what it commands happens; others watch. Method: visitors at
//! the hub of a running simulation, whose snapshots are read as a page reads them.

use crate::decoder;
use crate::visitor::{Visitor, start};
use std::time::{Duration, Instant};
use thenar_serve::hub::{Event, Refused};
use thenar_serve::live::{Live, Options, SceneSource};

const PAUSED: u16 = 1;
const SLOW: u16 = 4;
const SCRIPT: u16 = 16;

#[test]
fn the_first_has_control_and_it_passes_on() {
    let (_live, hub) = start("falling-box", &[]);
    let mut first = Visitor::join(&hub, 1);
    let mut second = Visitor::join(&hub, 2);
    let third = Visitor::join(&hub, 3);
    let status = first.until_status("three viewers", |s| s["viewers"] == 3);
    assert_eq!(status["control"], 1);
    assert_eq!(status["scene"], "falling-box");

    // Who only watches is refused, and nothing happens.
    second.say(r#"{"type":"run","paused":true}"#);
    let (note, refusal) = second.note();
    assert!(refusal && note["message"].as_str().unwrap().contains("viewer 1"), "{note}");
    assert_eq!(second.status()["paused"], false);

    // Anybody may take it; who had it is told, and is not blamed for what was on its way.
    second.say(r#"{"type":"control","take":true}"#);
    second.until_status("the second holds control", |s| s["control"] == 2);
    let (note, refusal) = first.note();
    assert!(!refusal && note["message"].as_str().unwrap().contains("viewer 2"), "{note}");
    first.say(r#"{"type":"run","paused":true}"#);
    first.say(r#"{"type":"ping","t":7.5}"#);
    let (note, refusal) = first.note();
    assert!(note["type"] == "pong" && note["t"] == 7.5 && !refusal, "{note}");
    assert_eq!(first.status()["paused"], false);

    // It goes to the oldest that remains, or to who asks when it was given up.
    second.leave();
    first.until_status("the first again", |s| s["control"] == 1 && s["viewers"] == 2);
    first.say(r#"{"type":"control","take":false}"#);
    first.until_status("nobody", |s| s["control"].is_null());
    third.say(r#"{"type":"control","take":true}"#);
    third.until_status("the third", |s| s["control"] == 3);
}

#[test]
fn pause_step_reset_and_slow_motion_act() {
    let (_live, hub) = start("soft-cube", &[]);
    let one = Visitor::join(&hub, 1);
    one.until("motion", |s| s.steps > 10);
    one.say(r#"{"type":"run","paused":true}"#);
    let still = one.until("pause", |s| s.flags & PAUSED != 0);
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(one.snapshot().steps, still.steps);

    one.say(r#"{"type":"step"}"#);
    let next = one.until("a step", |s| s.number > still.number);
    assert_eq!(next.steps, still.steps + 1);
    let h = one.model().json["time_step"].as_f64().unwrap();
    assert!((next.time - still.time - h).abs() < 1e-9);
    assert!(next.flags & PAUSED != 0 && next.speed == 0.0);

    one.say(r#"{"type":"reset"}"#);
    let start = one.until("the start", |s| s.time == 0.0);
    // As a new simulation starts.
    let (_other, fresh) = start_state("soft-cube");
    assert_eq!((start.steps, start.nodes), (0, fresh.nodes));

    one.say(r#"{"type":"speed","value":0.1}"#);
    one.say(r#"{"type":"run","paused":false}"#);
    one.until_status("slow motion", |s| s["speed"] == 0.1 && s["paused"] == false);
    let from = (Instant::now(), one.snapshot().time);
    let to = one.until("slow motion", |s| s.time > from.1 + 0.02);
    let real = from.0.elapsed().as_secs_f64();
    // Never faster than asked for; a busy machine may be slower.
    assert!(to.time - from.1 <= 0.1 * real + 0.01, "{} in {real}", to.time - from.1);
    assert!((to.budget_ms - 10.0 * h * 1e3).abs() < 1e-3);
}

fn start_state(scene: &str) -> (Live, decoder::Snapshot) {
    let (live, hub) = start(scene, &[]);
    let snapshot = decoder::Snapshot::read(&hub.snapshot.borrow());
    (live, snapshot)
}

#[test]
fn nonsense_is_refused_and_changes_nothing() {
    let (_live, hub) = start("falling-box", &[]);
    let mut one = Visitor::join(&hub, 1);
    one.until_status("control", |s| s["control"] == 1);
    for text in ["", "{", r#"{"type":"fly"}"#, r#"{"type":"scene","name":"../../etc/passwd"}"#] {
        one.say(text);
        let (note, refusal) = one.note();
        assert!(refusal && note["type"] == "error", "{text}: {note}");
    }
    // However long the name of what is not there.
    let long = "\u{1}x".repeat(300);
    for command in [
        serde_json::json!({"type": "scene", "name": long}),
        serde_json::json!({"type": "set", "key": long, "value": 1}),
        serde_json::json!({"type": "set", "key": "solver", "value": long}),
    ] {
        one.say(&command.to_string());
        let (note, refusal) = one.note();
        let told = note["message"].as_str().unwrap();
        assert!(refusal && told.len() < 700 && !told.contains('\u{1}'), "{told}");
        assert!(told.contains("… ("), "a beginning, and how long it is: {told}");
    }
    for bytes in [vec![], vec![1, 2, 3], vec![16; 816]] {
        one.send(bytes).unwrap();
        let (note, refusal) = one.note();
        assert!(refusal && note["type"] == "error", "{note}");
    }
    let status = one.status();
    assert_eq!((&status["scene"], &status["loading"]), (&"falling-box".into(), &().into()));
    let steps = one.snapshot().steps;
    one.until("it goes on", |s| s.steps > steps);
}

#[test]
fn a_flood_is_refused_and_steps_go_on() {
    let (_live, hub) = start("falling-box", &["duration=1000"]);
    let (one, mut loud) = (Visitor::join(&hub, 1), Visitor::join(&hub, 2));
    one.until_status("two", |s| s["viewers"] == 2);
    let before = one.snapshot();
    let (mut busy, mut sent) = (0, 0);
    // The flood lasts until the simulation has gone a second on, whatever comes.
    while sent < 100_000 || one.snapshot().time < before.time + 1.0 {
        let taken = match sent % 3 {
            0 => loud.send(vec![sent as u8; 816]),
            1 => loud.send(vec![0; 70_000]),
            _ => loud.hub.submit(Event::Text(loud.id, "{}".repeat(50))),
        };
        busy += u32::from(taken == Err(Refused::Busy));
        sent += 1;
    }
    assert!(busy > 10_000, "{busy} of {sent} refused");
    // Whoever has control is heard.
    one.say(r#"{"type":"run","paused":true}"#);
    one.until("pause", |s| s.flags & PAUSED != 0);
    // Every message that got through and was looked at was answered with a refusal.
    assert!(loud.note().1);
}

#[test]
fn every_scene_can_be_chosen_and_has_its_own_epoch() {
    let (_live, hub) = start("falling-box", &[]);
    let one = Visitor::join(&hub, 1);
    let welcome: serde_json::Value = serde_json::from_str(&hub.welcome(one.id)).unwrap();
    assert_eq!((&welcome["protocol"], &welcome["client"]), (&3.into(), &1.into()));
    let mut epoch = one.model().epoch;
    for scene in welcome["scenes"].as_array().unwrap() {
        let name = scene["name"].as_str().unwrap();
        assert!(!scene["title"].as_str().unwrap().is_empty());
        one.say(&format!(r#"{{"type":"scene","name":"{name}"}}"#));
        one.until_status(name, |s| s["scene"] == name && s["loading"].is_null());
        let model = one.model();
        assert!(model.epoch > epoch, "{name}");
        epoch = model.epoch;
        let shown = one.until("its snapshots", |s| s.epoch == epoch && s.steps > 2);
        assert_eq!(model.json["scene"], name);
        assert_eq!(shown.rigids.len(), model.count("/rigids"));
        let nodes: usize = (0..model.count("/softs"))
            .map(|i| model.array(&format!("/softs/{i}/nodes")).len())
            .sum();
        assert_eq!(shown.nodes.len(), nodes);
        let bones = model.json["hands"].as_array().unwrap().iter();
        let bones: u64 = bones.map(|hand| hand["bone_count"].as_u64().unwrap()).sum();
        assert_eq!(shown.targets.len() as u64, bones);
        assert!(shown.nodes.iter().flatten().all(|x| x.abs() < 10.0));
    }
    assert_eq!(
        welcome["scenes"].as_array().unwrap().len(),
        thenar_scene::session::builtins().len()
    );
}

#[test]
fn the_script_plays_again_after_its_end() {
    let (_live, hub) = start("falling-box", &["duration=0.1"]);
    let one = Visitor::join(&hub, 1);
    let before = one.until("its end", |s| s.time > 1.2);
    assert!(before.flags & SCRIPT != 0);
    // 0.1 s, and 1.5 s to look at the end.
    let again = one.until("its beginning", |s| s.number > before.number && s.time < 1.2);
    assert!(again.time < 0.5, "{}", again.time);
    let last = one.until("the middle", |s| s.time > 1.0);
    assert!(last.time <= 1.62, "{}", last.time);
}

#[test]
fn too_slow_a_machine_says_so_and_slows_down() {
    // Every step of 5 ms takes 20 ms: a quarter of real time at best.
    let slow = |_: &thenar_scene::session::Session| std::thread::sleep(Duration::from_millis(20));
    let options = Options {
        overrides: vec!["time_step=0.005".into(), "duration=1000".into()],
        haptics: None,
        watcher: Some(Box::new(slow)),
        ..Options::default()
    };
    let source = SceneSource::Builtin("falling-box".into());
    let (_live, hub) = Live::start(&source, options).unwrap();
    let one = Visitor::join(&hub, 1);
    let slow = one.until("honesty", |s| s.flags & SLOW != 0);
    assert!(slow.speed <= 0.26, "{}", slow.speed);
    // Commands are heard all the same.
    one.say(r#"{"type":"run","paused":true}"#);
    one.until("pause", |s| s.flags & PAUSED != 0);
}

#[test]
fn nobody_there_it_rests_and_starts_anew() {
    let (_live, hub) = start("soft-cube", &["duration=1000"]);
    let one = Visitor::join(&hub, 1);
    one.until("motion", |s| s.time > 0.2);
    one.leave();
    // It rests at its start: the number of snapshots stands still.
    std::thread::sleep(Duration::from_secs(6));
    let watch = || decoder::Snapshot::read(&hub.snapshot.borrow());
    let resting = watch();
    assert_eq!((resting.time, resting.steps), (0.0, 0));
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(watch().number, resting.number);
    let three = Visitor::join(&hub, 3);
    let awake = three.until("motion", |s| s.time > 0.0);
    assert!(awake.time < 0.2, "no time was made up for: {}", awake.time);
}
