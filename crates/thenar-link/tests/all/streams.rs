//! Goal: every device on the network moves the hand, survives noise, is taken up again after a loss
//! and may come later. Method: simulated twins on real sockets, the same suite for each.

use crate::conformance::open_device;
use std::io::Write;
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use thenar_core::model::Side;
use thenar_core::random::Random;
use thenar_core::{Pose, Vec3};
use thenar_link::force_device::twin::SimulatedArm;
use thenar_link::hand_tracking_streamer::{Points, twin};
use thenar_link::{DigitOutput, HandOutput, Opened, Tracker, now_ns, pose_stream};
use thenar_testing::free_port;
use thenar_track::Recording;
use thenar_track::live::LivePose;
use tungstenite::{Message, WebSocket};

/// Longest that anything may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(30);

fn wait<T>(what: &str, mut f: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = f() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "{what} never came");
        std::thread::sleep(Duration::from_micros(300));
    }
}

/// The relaxed left hand, moved along x so that its wrist is at `x` \[m\].
fn hand(x: f64) -> [Pose; 25] {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hands.jsonl");
    let recording = Recording::open(std::path::Path::new(file)).unwrap();
    let joints = recording.hand(Side::Left)[0].joints;
    let to = Vec3::x() * (x - joints[0].position.x);
    joints.map(|pose| Pose::new(pose.position + to, pose.rotation))
}

fn wrist_x(pose: &LivePose) -> f64 {
    match pose {
        LivePose::Joints { joints, .. } => joints[0].position.x,
        LivePose::Angles { wrist, .. } => wrist.position.x,
    }
}

/// A device's end of the wire. Dropping it is unplugging.
trait Wire {
    /// Says these bytes; what is lost is lost.
    fn say(&mut self, bytes: &[u8]);
}

/// A device, and how it speaks of a hand whose wrist is at x.
struct Bench<'a> {
    side: Side,
    open: &'a dyn Fn() -> Opened,
    plug: &'a dyn Fn() -> Box<dyn Wire>,
    frame: &'a dyn Fn(f64) -> Vec<u8>,
}

/// The suite.
fn conforms(bench: &Bench) {
    // The device comes later.
    let mut device = Device { opened: (bench.open)(), last_ns: 0 };
    assert!(device.tracker().latest(bench.side).is_none());
    let mut wire = (bench.plug)();
    for x in [0.1, -0.2, 0.3] {
        device.follows(bench, &mut *wire, x);
    }
    let other = if bench.side == Side::Left { Side::Right } else { Side::Left };
    assert!(device.tracker().latest(other).is_none(), "only one hand was seen");
    assert!(device.tracker().heard_ns().is_some_and(|ns| ns <= now_ns()));

    // Noise of all kinds, and halves of frames, in the midst of it.
    let mut random = Random::new(77);
    for round in 0..30 {
        let length = 1 + random.below(1200);
        let mut noise: Vec<u8> = (0..length).map(|_| random.bits() as u8).collect();
        if round % 2 == 0 {
            let good = (bench.frame)(0.7);
            noise = good[..random.below(good.len())].to_vec();
        }
        wire.say(&noise);
        wire.say(b"\n");
    }
    device.follows(bench, &mut *wire, 0.05);
    let told = device.tracker().messages();
    assert!(!told.is_empty() && told.len() <= 65, "{told:?}");

    // Unplugged in the midst of a frame, and plugged in again.
    for cut in [1, 20, 50] {
        let good = (bench.frame)(0.4);
        wire.say(&good[..cut]);
        drop(wire);
        wire = (bench.plug)();
        device.follows(bench, &mut *wire, 0.001 * cut as f64);
    }
    // Closed and opened again.
    drop(device);
    drop(wire);
    let mut device = Device { opened: (bench.open)(), last_ns: 0 };
    let mut wire = (bench.plug)();
    device.follows(bench, &mut *wire, -0.1);
}

struct Device {
    opened: Opened,
    last_ns: u64,
}

impl Device {
    fn tracker(&mut self) -> &mut Box<dyn Tracker> {
        self.opened.tracker.as_mut().unwrap()
    }

    /// Waits until the wrist is at x, which is said again and again.
    fn follows(&mut self, bench: &Bench, wire: &mut dyn Wire, x: f64) {
        let start = Instant::now();
        let mut said = None::<Instant>;
        loop {
            if said.is_none_or(|said| said.elapsed() > Duration::from_millis(10)) {
                wire.say(&(bench.frame)(x));
                said = Some(Instant::now());
            }
            let last_ns = self.last_ns;
            if let Some(sample) = self.tracker().latest(bench.side) {
                assert!(sample.time_ns > last_ns && sample.time_ns <= now_ns(), "time goes on");
                let (time_ns, at) = (sample.time_ns, sample.pose.as_ref().map(wrist_x));
                self.last_ns = time_ns;
                if at.is_some_and(|at| (at - x).abs() < 1e-5) {
                    return;
                }
            }
            if start.elapsed() > PATIENCE {
                panic!("{x} never came: {:?}", self.tracker().messages());
            }
            std::thread::sleep(Duration::from_micros(300));
        }
    }
}

/// Speaks datagrams, always from the same port of its own: a headset that returns is the same.
struct Datagrams(UdpSocket, SocketAddr);

impl Datagrams {
    fn to(own: u16, port: u16) -> Box<dyn Wire> {
        let socket = wait("the device's own port", || UdpSocket::bind(("127.0.0.1", own)).ok());
        Box::new(Self(socket, ([127, 0, 0, 1], port).into()))
    }
}

impl Wire for Datagrams {
    fn say(&mut self, bytes: &[u8]) {
        let _ = self.0.send_to(bytes, self.1);
    }
}

impl Wire for TcpStream {
    fn say(&mut self, bytes: &[u8]) {
        let _ = self.write_all(bytes);
    }
}

/// Number of frames so far, so that numbers rise whoever counts.
static FRAMES: AtomicU64 = AtomicU64::new(1);

fn streamer_frame(x: f64) -> Vec<u8> {
    let frame = FRAMES.fetch_add(1, Ordering::Relaxed) as i64;
    let metadata = Some((frame, now_ns() as i64 + 3_600_000_000_000));
    twin::lines(Side::Left, &hand(x), Points::Local, metadata).into_bytes()
}

#[test]
fn the_streamer_conforms_over_udp() {
    let (port, own) = (free_port(), free_port());
    conforms(&Bench {
        side: Side::Left,
        open: &|| open_device(&format!("hts:127.0.0.1:{port}")),
        plug: &|| Datagrams::to(own, port),
        frame: &streamer_frame,
    });
}

#[test]
fn the_streamer_conforms_where_it_calls_us() {
    let port = free_port();
    conforms(&Bench {
        side: Side::Left,
        open: &|| open_device(&format!("hts:tcp:127.0.0.1:{port}")),
        plug: &|| Box::new(wait("a call", || TcpStream::connect(("127.0.0.1", port)).ok())),
        frame: &streamer_frame,
    });
}

#[test]
fn the_streamer_conforms_where_we_call_it() {
    // The port stays the headset's while nobody listens there.
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    conforms(&Bench {
        side: Side::Left,
        open: &|| open_device(&format!("hts:call:127.0.0.1:{port}")),
        plug: &|| {
            // The newest call counts: older ones are those of a device that was closed.
            listener.set_nonblocking(true).unwrap();
            let mut stream = wait("a call", || listener.accept().ok()).0;
            while let Ok((newer, _)) = listener.accept() {
                stream = newer;
            }
            stream.set_nonblocking(false).unwrap();
            Box::new(stream)
        },
        frame: &streamer_frame,
    });
}

fn pose_frame(x: f64) -> Vec<u8> {
    let pose = LivePose::Joints { joints: hand(x), radii: [0.01; 25] };
    pose_stream::write(Side::Left, now_ns() as f64 * 1e-9 + 5.0, Some(&pose)).into_bytes()
}

#[test]
fn pose_streams_conform_over_udp() {
    let (port, own) = (free_port(), free_port());
    conforms(&Bench {
        side: Side::Left,
        open: &|| open_device(&format!("poses:{port}")),
        plug: &|| Datagrams::to(own, port),
        frame: &pose_frame,
    });
}

/// A server that sends poses.
struct Served(WebSocket<TcpStream>);

impl Wire for Served {
    fn say(&mut self, bytes: &[u8]) {
        let _ = match std::str::from_utf8(bytes) {
            Ok(text) => self.0.send(Message::text(text)),
            Err(_) => self.0.send(Message::binary(bytes.to_vec())),
        };
    }
}

#[test]
fn pose_streams_conform_over_websocket() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    conforms(&Bench {
        side: Side::Left,
        open: &|| open_device(&format!("poses:ws://127.0.0.1:{port}/hands?x=1")),
        plug: &|| {
            let socket = wait("a call", || {
                let (stream, _) = listener.accept().ok()?;
                tungstenite::accept(stream).ok()
            });
            Box::new(Served(socket))
        },
        frame: &pose_frame,
    });
}

impl Wire for std::fs::File {
    fn say(&mut self, bytes: &[u8]) {
        let _ = self.write_all(bytes);
    }
}

#[cfg(unix)]
#[test]
fn pose_streams_conform_over_a_named_pipe() {
    let path = std::env::temp_dir().join(format!("thenar-poses-{}", std::process::id()));
    thenar_testing::make_pipe(&path);
    conforms(&Bench {
        side: Side::Left,
        open: &|| open_device(&format!("poses:{}", path.display())),
        // Opening waits for the reader.
        plug: &|| Box::new(std::fs::OpenOptions::new().write(true).open(&path).unwrap()),
        // A pipe knows no break: what was cut ends with the next line.
        frame: &|x| [b"\n".to_vec(), pose_frame(x)].concat(),
    });
    std::fs::remove_file(&path).unwrap();
}

/// Two senders on one port move no hand in turns: the first has it.
#[test]
fn a_second_sender_is_not_heard() {
    let port = free_port();
    let mut device = Device { opened: open_device(&format!("poses:{port}")), last_ns: 0 };
    let [mut first, mut second] = [free_port(), free_port()].map(|own| Datagrams::to(own, port));
    wait("the first sender", || {
        first.say(&pose_frame(0.1));
        device.tracker().latest(Side::Left)?.pose.as_ref().map(|_| ())
    });
    for _ in 0..200 {
        second.say(&pose_frame(-0.5));
        first.say(&pose_frame(0.1));
        std::thread::sleep(Duration::from_millis(1));
        if let Some(sample) = device.tracker().latest(Side::Left) {
            assert!((wrist_x(sample.pose.as_ref().unwrap()) - 0.1).abs() < 1e-5);
        }
    }
    // Its datagrams are counted and told of.
    let told = device.tracker().messages().into_iter().find(|told| told.contains("another sender"));
    let message = told.unwrap_or_else(|| {
        wait("the second sender's mention", || {
            second.say(&pose_frame(-0.5));
            first.say(&pose_frame(0.1));
            device.tracker().messages().into_iter().find(|told| told.contains("another sender"))
        })
    });
    assert!(
        message.starts_with(&format!("poses:{port}: another sender is not heard")),
        "{message}"
    );
}

/// A bridge at 1 kHz until it is dropped.
struct Bridge {
    arm: Arc<Mutex<SimulatedArm>>,
    stop: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Bridge {
    fn start(arm: &Arc<Mutex<SimulatedArm>>, port: u16) -> Self {
        let socket = wait("the bridge's port", || UdpSocket::bind(("127.0.0.1", port)).ok());
        socket.set_nonblocking(true).unwrap();
        let (stop, arm) = (Arc::new(AtomicBool::new(false)), arm.clone());
        let (told, handle) = (stop.clone(), arm.clone());
        let run = move || {
            let mut host = None;
            let mut buffer = [0; 2000];
            while !told.load(Ordering::Relaxed) {
                let mut arm = handle.lock().unwrap();
                while let Ok((length, from)) = socket.recv_from(&mut buffer) {
                    arm.receive(now_ns(), &buffer[..length]).unwrap();
                    host = Some(from);
                }
                let state = arm.state(now_ns());
                drop(arm);
                if let Some(host) = host {
                    let _ = socket.send_to(&state, host);
                }
                std::thread::sleep(Duration::from_millis(1));
            }
        };
        Self { arm, stop, thread: Some(std::thread::spawn(run)) }
    }

    fn force(&self) -> Vec3 {
        self.arm.lock().unwrap().force(now_ns())
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let _ = self.thread.take().unwrap().join();
    }
}

#[test]
fn a_haptic_arm_moves_the_hand_and_pushes_until_anything_ends() {
    let port = free_port();
    let arm = Arc::new(Mutex::new(SimulatedArm::new()));
    let open = || open_device(&format!("force-device:desktop@127.0.0.1:{port}"));
    let mut device = Device { opened: open(), last_ns: 0 };
    assert_eq!(device.opened.display.as_ref().unwrap().limits().rated, 7.9);
    let shown = |opened: &mut Opened| {
        let force_W = Vec3::new(0.5, -1.0, 2.0);
        let output = HandOutput { force_W, ..HandOutput::released(Side::Right, now_ns()) };
        opened.display.as_mut().unwrap().show(&output);
    };
    let mut bridge = Bridge::start(&arm, port);
    for x in [0.0, 0.1, -0.05] {
        arm.lock().unwrap().pose = Pose::translation(x, 0.0, 0.0);
        wait("the handle", || {
            let sample = device.tracker().latest(Side::Right)?;
            ((wrist_x(sample.pose.as_ref()?) - x).abs() < 1e-6).then_some(())
        });
    }
    let feels = |opened: &mut Opened, bridge: &Bridge| {
        wait("the force", || {
            shown(opened);
            ((bridge.force() - Vec3::new(0.5, -1.0, 2.0)).norm() < 1e-6).then_some(())
        });
    };
    let free = |what: &str, bridge: &Bridge| {
        wait(what, || (bridge.force() == Vec3::zeros()).then_some(()));
    };
    feels(&mut device.opened, &bridge);
    free("release when the loop is silent", &bridge);
    // The bridge ends and starts again: no late force, then forces again.
    feels(&mut device.opened, &bridge);
    drop(bridge);
    bridge = Bridge::start(&arm, port);
    wait("its return", || device.tracker().latest(Side::Right).map(|_| ()));
    free("release after a loss", &bridge);
    feels(&mut device.opened, &bridge);
    // The display is dropped, the tracker stays; then both.
    device.opened.display = None;
    free("release by the display's drop", &bridge);
    device.opened = open();
    wait("a sample", || device.tracker().latest(Side::Right).map(|_| ()));
    feels(&mut device.opened, &bridge);
    drop(device);
    free("release by a drop", &bridge);
}

/// A player that keeps what it was told.
#[test]
#[allow(clippy::result_large_err)] // the handshake's own type
fn gloves_vibrate_through_the_player_and_again_after_it_restarts() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let mut opened = open_device(&format!("bhaptics:127.0.0.1:{port}"));
    assert!(opened.tracker.is_none());
    let display = opened.display.as_mut().unwrap();
    let mut touch = HandOutput::released(Side::Right, 0);
    touch.digits[1] = DigitOutput { pad_force: 5.0, ..Default::default() };
    for round in 0..2 {
        let (stream, _) = listener.accept().unwrap();
        let mut asked = String::new();
        let mut player = tungstenite::accept_hdr(
            stream,
            |request: &tungstenite::handshake::server::Request, response| {
                asked = request.uri().to_string();
                Ok(response)
            },
        )
        .unwrap();
        assert_eq!(asked, "/v2/feedbacks?app_id=thenar&app_name=Thenar");
        player.send(Message::text("{\"ConnectedPositions\":[\"GloveR\"]}")).unwrap();
        player.get_ref().set_read_timeout(Some(Duration::from_millis(2))).unwrap();
        let mut read = || match player.read() {
            Ok(Message::Text(text)) => Some(text.to_string()),
            _ => None,
        };
        let has = |text: &str, intensity: u8| {
            let dot = format!("{{\"index\":1,\"intensity\":{intensity}}}");
            text.contains("GloveR") && text.contains(&dot)
        };
        wait("vibration", || {
            display.show(&touch);
            read().filter(|text| has(text, 60))
        });
        if round == 0 {
            // The loop is silent.
            wait("its end", || read().filter(|text| has(text, 0)));
            let told = display.messages();
            assert!(told.iter().any(|m| m.ends_with("the player has GloveR")), "{told:?}");
        } else {
            opened.display = None;
            wait("its end by a drop", || read().filter(|text| has(text, 0)));
            break;
        }
    }
}

#[test]
fn a_recording_plays_and_goes_wrong_as_planned() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hands.jsonl");
    for address in [format!("replay:{file}?loop=yes&speed=20"), format!("poses:{file}")] {
        let mut opened = open_device(&address);
        let tracker = opened.tracker.as_mut().unwrap();
        wait("a sample", || tracker.latest(Side::Left)?.pose.clone());
    }
    let address = format!("fault:7:replay:{file}?loop=yes&speed=20");
    let mut opened = open_device(&address);
    wait("a sample", || opened.tracker.as_mut().unwrap().latest(Side::Left).map(|_| ()));
    let told = |address: &str| thenar_link::open(address).map(|_| ()).unwrap_err().to_string();
    assert!(told("replay:nowhere.jsonl").starts_with("recording nowhere.jsonl: "));
    assert!(told("fault:x:null:left").contains("whole number"));
    assert!(told("poses:nowhere.jsonl").contains("an existing file"));
    assert!(told("hts:9000?points=up").contains("expected auto, local or world"));
}

/// What a headset's profile states of its samples is what the loop reckons with; a file of one's
/// own lies over it.
#[test]
fn a_headset_states_what_its_profile_has() {
    let file = std::env::temp_dir().join(format!("thenar-hts-{}.toml", std::process::id()));
    std::fs::write(&file, "[tracking]\nrate = 60.0\nlatency = 0.07\n").unwrap();
    let open = |address: &str| thenar_link::open(address).map(|opened| opened.tracker.unwrap());
    let address = format!("hts:127.0.0.1:0?profile={}", file.display());
    let timing = open(&address).unwrap().timing().unwrap();
    assert_eq!((timing.rate, timing.latency, timing.noise), (60.0, 0.07, 0.001));
    std::fs::write(&file, "[tracking]\nrate = 0.0\n").unwrap();
    let told = open(&address).err().unwrap().to_string();
    assert!(told.contains("tracking.rate"), "{told}");
    std::fs::remove_file(&file).unwrap();
}
