//! Goal: a page arms and stops devices, and a stop acts while the simulation stands still. Method: a
//! simulation whose watcher blocks it, a display in memory's place: the null device.

mod decoder;
mod visitor;

use std::sync::mpsc::channel;
use std::time::{Duration, Instant};
use thenar_link::haptic_loop::{HapticLoop, Settings, State, page_tracker};
use thenar_serve::live::{Haptics, Live, Options, SceneSource};
use visitor::Visitor;

const PATIENCE: Duration = Duration::from_secs(30);

fn until(what: &str, mut done: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !done() {
        assert!(begun.elapsed() < PATIENCE, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn a_stop_acts_while_the_simulation_stands_still() {
    let opened = thenar_link::open("null:right").unwrap();
    let (poses, page) = page_tracker();
    let displays = opened.display.into_iter().collect();
    let device = HapticLoop::start(Settings::default(), vec![page], displays).unwrap();
    let (port, remote) = (device.port(), device.remote());
    let (block, blocked) = channel::<std::sync::mpsc::Receiver<()>>();
    let options = Options {
        overrides: vec!["hand.0.flesh=false".into()],
        watcher: Some(Box::new(move |_| {
            if let Ok(gate) = blocked.try_recv() {
                let _ = gate.recv_timeout(PATIENCE);
            }
        })),
        haptics: Some(Haptics { port, remote: remote.clone(), poses }),
        ..Options::default()
    };
    let source = SceneSource::Builtin("free-motion".into());
    let (_live, hub) = Live::start(&source, options).unwrap();
    let first = Visitor::join(&hub, 1);
    first.until("motion", |s| s.steps > 2);
    let told = |hub: &thenar_serve::hub::Hub| -> serde_json::Value {
        serde_json::from_str(&hub.touch.borrow()).unwrap_or_default()
    };
    until("a dry run", || told(&hub)["state"] == "dry-run");
    first.say(r#"{"type":"arm"}"#);
    until("armed", || matches!(remote.status().state, State::Waiting(_)));

    // Only watching, and nothing moves: the message of the socket's side is enough.
    let (open, gate) = channel();
    block.send(gate).unwrap();
    hub.heed(r#"{"type":"stop","more":1}"#);
    hub.heed(r#"{"type":"set","key":"stop","value":1}"#);
    assert!(!matches!(remote.status().state, State::Tripped(_)));
    hub.heed(r#"{"type":"stop"}"#);
    until("stopped", || {
        // A machine so busy that the loop stood still has stopped it already.
        matches!(remote.status().state, State::Tripped(_))
    });
    until("the page knows", || told(&hub)["state"] == "tripped");
    assert!(told(&hub)["statement"].as_str().unwrap().starts_with("Research use only"));
    open.send(()).unwrap();
}
