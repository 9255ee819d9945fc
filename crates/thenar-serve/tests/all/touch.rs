//! Goal: a page arms and stops devices, a stop acts while the simulation stands still, and forces
//! last no longer than the page that armed them. Method: a simulation whose watcher blocks it; a
//! display in memory whose guards put up with a busy machine; sockets.

use crate::visitor::Visitor;
use serde_json::Value;
use std::net::TcpStream;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};
use thenar_link::haptic_loop::{HapticLoop, Remote, Settings, State, page_tracker};
use thenar_link::{ForceDisplay, HandOutput, Rendering};
use thenar_serve::http::{self, Port, Reach, Server};
use thenar_serve::hub::{ClientId, Hub};
use thenar_serve::live::{Haptics, Live, Options, SceneSource};
use thenar_touch::safety::Limits;
use thenar_touch::{LoopProfile, TrackerTiming};
use tokio_tungstenite::tungstenite::{Message, WebSocket, client};

const PATIENCE: Duration = Duration::from_secs(30);

fn until(what: &str, mut done: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !done() {
        assert!(begun.elapsed() < PATIENCE, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A display that nobody wears. Its guards forgive gaps: a busy machine stops no force here.
struct Display;

impl ForceDisplay for Display {
    fn rendering(&self) -> Rendering {
        Rendering::Tendons
    }

    fn limits(&self) -> Limits {
        Limits { gap_hold: 60.0, gap_max: 60.0, ..Limits::cybergrasp() }
    }

    fn loop_profile(&self) -> LoopProfile {
        let [damping, rated_stiffness] = [f64::INFINITY; 2];
        let [period, delay, friction, resolution] = [1e-3, 0.0, 0.0, 0.0];
        LoopProfile { period, delay, damping, friction, resolution, rated_stiffness }
    }

    fn show(&mut self, _: &HandOutput) {}

    fn heard_ns(&mut self) -> Option<u64> {
        Some(thenar_link::now_ns())
    }

    fn messages(&mut self) -> Vec<String> {
        Vec::new()
    }
}

/// A scene that is felt, and what it takes to stop its simulation for a while.
struct Felt {
    hub: Hub,
    remote: Remote,
    block: Sender<Receiver<()>>,
    _live: Live,
    _device: HapticLoop,
}

impl Felt {
    fn start() -> Self {
        let (poses, page) = page_tracker(TrackerTiming::HEADSET);
        let display: Box<dyn ForceDisplay> = Box::new(Display);
        let device = HapticLoop::start(Settings::default(), vec![page], vec![display]).unwrap();
        let (port, remote) = (device.port(), device.remote());
        let (block, blocked) = channel::<Receiver<()>>();
        let options = Options {
            overrides: vec!["hand.0.flesh=false".into(), "hand.0.preset=paper".into()],
            watcher: Some(Box::new(move |_| {
                if let Ok(gate) = blocked.try_recv() {
                    let _ = gate.recv_timeout(PATIENCE);
                }
            })),
            haptics: Some(Haptics { port, remote: remote.clone(), poses }),
            ..Options::default()
        };
        let source = SceneSource::Builtin("free-motion".into());
        let (live, hub) = Live::start(&source, options).unwrap();
        Self { hub, remote, block, _live: live, _device: device }
    }

    fn told(&self) -> Value {
        serde_json::from_str(&self.hub.touch.borrow()).unwrap_or_default()
    }

    fn state(&self) -> State {
        self.remote.status().state
    }

    /// Why forces were stopped, once they are.
    fn until_stopped(&self) -> String {
        until("stopped", || matches!(self.state(), State::Tripped(_)));
        self.state().reason().unwrap_or_default().into()
    }

    fn serve(&self) -> Server {
        let options = http::Options {
            reach: Reach::Loopback,
            address: None,
            port: Port::Exactly(0),
            limits: http::RequestLimits::default(),
        };
        Server::start(&options, self.hub.clone()).unwrap()
    }
}

/// A page at the other end of a socket.
struct Page(WebSocket<TcpStream>);

impl Page {
    fn open(server: &Server) -> Self {
        let stream = TcpStream::connect(server.address()).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let (socket, _) = client(format!("ws://{}/live", server.address()), stream).unwrap();
        Self(socket)
    }

    fn say(&mut self, text: &str) {
        self.0.send(Message::text(text)).unwrap();
    }

    /// The next message of this type.
    fn hear(&mut self, kind: &str) -> Value {
        loop {
            let Message::Text(text) = self.0.read().unwrap() else { continue };
            let value: Value = serde_json::from_str(&text).unwrap();
            if value["type"] == kind {
                return value;
            }
        }
    }

    /// Arms, and reads until that has acted; gives this page's number.
    fn arm(&mut self, text: &str) -> u64 {
        let number = self.hear("welcome")["client"].as_u64().unwrap();
        self.say(text);
        while self.hear("touch")["state"] != "waiting" {}
        number
    }

    /// Answers every report for so long, and forces stay on. A machine that stands still for longer
    /// than half the silence allowed (three seconds) has kept the page from answering: that try
    /// does not count.
    fn holds(&mut self, long: Duration) {
        let mut begun = Instant::now();
        let mut answered = begun;
        let mut stood_still = 0;
        while begun.elapsed() < long {
            let told = self.hear("touch");
            if answered.elapsed() > Duration::from_millis(1500) {
                stood_still += 1;
                assert!(stood_still < 10, "the machine stands still again and again");
                begun = Instant::now();
                if told["state"] == "tripped" {
                    self.say(r#"{"type":"arm"}"#);
                    while self.hear("touch")["state"] != "waiting" {}
                }
            } else {
                assert_eq!(told["state"], "waiting", "{told}");
            }
            self.say(r#"{"type":"hold"}"#);
            answered = Instant::now();
        }
    }
}

const GONE: &str = "whoever armed it has gone: the page was closed, or its connection was lost";

#[test]
fn a_stop_acts_while_the_simulation_stands_still() {
    let felt = Felt::start();
    let hub = &felt.hub;
    let first = Visitor::join(hub, 1);
    first.until("motion", |s| s.steps > 2);
    until("a hand in a dry run", || felt.told()["hands"][0]["renders"] == "tendons");
    assert_eq!(felt.told()["state"], "dry-run");
    assert_eq!(felt.told()["hands"][0]["force_max"], Limits::cybergrasp().force_max());
    first.say(r#"{"type":"arm","keep":true}"#);
    until("armed", || matches!(felt.state(), State::Waiting(_)));

    // Only watching, and nothing moves: the message of the socket's side is enough.
    let (open, gate) = channel();
    felt.block.send(gate).unwrap();
    let watcher = ClientId(2);
    assert!(!hub.heed(watcher, r#"{"type":"stop","more":1}"#));
    assert!(!hub.heed(watcher, r#"{"type":"set","key":"stop","value":1}"#));
    assert!(!matches!(felt.state(), State::Tripped(_)));
    hub.heed(watcher, r#"{"type":"stop"}"#);
    assert_eq!(felt.until_stopped(), "stop was asked for");
    until("the page knows", || felt.told()["state"] == "tripped");
    assert!(felt.told()["statement"].as_str().unwrap().starts_with("Research use only"));
    open.send(()).unwrap();
}

/// The simulation stands still as well: nothing but the socket's end says so.
#[test]
fn a_page_whose_socket_is_lost_takes_its_forces_with_it() {
    let felt = Felt::start();
    let server = felt.serve();
    for goodbye in [true, false] {
        let mut page = Page::open(&server);
        let number = page.arm(r#"{"type":"arm"}"#);
        assert_eq!(felt.told()["armed_by"], number);
        let (open, gate) = channel();
        felt.block.send(gate).unwrap();
        if goodbye {
            page.0.close(None).unwrap();
        }
        drop(page);
        assert_eq!(felt.until_stopped(), GONE);
        open.send(()).unwrap();
        until("the next page knows", || felt.told()["armed_by"].is_null());
        // Control goes to the next only when the simulation has heard that this one left.
        let status = || -> Value { serde_json::from_str(&felt.hub.status.borrow()).unwrap() };
        until("nobody is there", || status()["viewers"] == 0);
    }
}

/// A page that hangs keeps its socket, and nobody can press Stop on it. Takes seven seconds: four
/// in which silence would have ended the forces, and three of silence.
#[test]
fn forces_last_while_the_page_answers() {
    let felt = Felt::start();
    let server = felt.serve();
    let mut page = Page::open(&server);
    page.arm(r#"{"type":"arm"}"#);
    page.holds(Duration::from_secs(4));
    // It listens, but says nothing any more.
    let told = loop {
        let told = page.hear("touch");
        if told["state"] != "waiting" {
            break told;
        }
    };
    let reason = "whoever armed it no longer answers: the page hangs, or its network is gone";
    assert_eq!((&told["state"], &told["reason"]), (&"tripped".into(), &reason.into()));
    // It is no offence to hold what is not held.
    page.say(r#"{"type":"hold"}"#);
    page.say(r#"{"type":"ping","t":7.0}"#);
    assert_eq!(page.hear("pong")["t"], 7.0);
}

#[test]
fn a_page_may_leave_forces_on_if_it_says_so() {
    let felt = Felt::start();
    let server = felt.serve();
    let mut page = Page::open(&server);
    page.arm(r#"{"type":"arm","keep":true}"#);
    assert!(felt.told()["armed_by"].is_null());
    drop(page);
    let status = || -> Value { serde_json::from_str(&felt.hub.status.borrow()).unwrap() };
    until("it has left", || status()["viewers"] == 0);
    // Whoever watches then sees them on, and can stop them.
    let mut other = Page::open(&server);
    assert_eq!(other.hear("touch")["state"], "waiting");
    other.say(r#"{"type":"stop"}"#);
    assert_eq!(felt.until_stopped(), "stop was asked for");
}
