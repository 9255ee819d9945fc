//! Goal: a device on the network that can be reached and answers nothing is named with its cause,
//! holds nobody up, and is taken up when it answers. Method: real sockets whose other ends are
//! silent first. (Gloves on serial lines: `tests/conformance`.)

use crate::conformance::{open_device, wait};
use std::io::{ErrorKind, Write};
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use thenar_core::Pose;
use thenar_core::model::Side;
use thenar_link::cybergrasp::{SimulatedUnit, serve_unit};
use thenar_link::force_device::twin::SimulatedArm;
use thenar_link::hand_tracking_streamer::{Points, twin};
use thenar_link::haptic_loop::{ManualLoop, Settings};
use thenar_link::{HandOutput, Opened, now_ns, pose_stream};
use thenar_testing::free_port;
use thenar_track::Recording;
use thenar_track::live::LivePose;
use tungstenite::{Message, WebSocket};

const SILENT: &str = "is connected but says nothing: is it switched on";

fn hand() -> [Pose; 25] {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hands.jsonl");
    Recording::open(std::path::Path::new(file)).unwrap().hand(Side::Left)[0].joints
}

fn streamer_frame() -> Vec<u8> {
    twin::lines(Side::Left, &hand(), Points::Local, None).into_bytes()
}

fn pose_line() -> String {
    let pose = LivePose::Joints { joints: hand(), radii: [0.01; 25] };
    pose_stream::write(Side::Left, now_ns() as f64 * 1e-9, Some(&pose))
}

/// Waits for this message, which begins with the device's address.
fn told(opened: &mut Opened, address: &str, what: &str) {
    let mut messages = || match (&mut opened.tracker, &mut opened.display) {
        (Some(tracker), _) => tracker.messages(),
        (_, Some(display)) => display.messages(),
        _ => Vec::new(),
    };
    let message = wait(what, || messages().into_iter().find(|told| told.contains(what)));
    assert!(message.starts_with(&format!("{address}: ")), "{message}");
}

/// A tracker that is silent until `say` says something.
fn a_mute_tracker(address: &str, opened: &mut Opened, mut say: impl FnMut()) {
    told(opened, address, SILENT);
    let tracker = opened.tracker.as_mut().unwrap();
    assert!(tracker.latest(Side::Left).is_none() && tracker.heard_ns().is_none());
    wait("a sample", || {
        say();
        opened.tracker.as_mut().unwrap().latest(Side::Left).map(|_| ())
    });
    told(opened, address, "speaks now");
}

/// All at once: each mostly waits for two seconds of silence.
#[test]
fn mute_devices_are_named_and_taken_up() {
    std::thread::scope(|scope| {
        scope.spawn(mute_trackers_over_datagrams);
        scope.spawn(mute_trackers_over_streams);
        scope.spawn(a_mute_websocket);
        scope.spawn(a_mute_player_of_vibrations);
        #[cfg(unix)]
        scope.spawn(a_mute_pipe);
        scope.spawn(a_mute_bridge_of_tendons);
        scope.spawn(the_loop_lives_beside_mute_devices);
    });
}

fn mute_trackers_over_datagrams() {
    for (driver, frame) in [("hts", streamer_frame()), ("poses", pose_line().into_bytes())] {
        let port = free_port();
        let address = format!("{driver}:127.0.0.1:{port}");
        let mut opened = open_device(&address);
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        a_mute_tracker(&address, &mut opened, || {
            let _ = socket.send_to(&frame, ("127.0.0.1", port));
        });
    }
}

fn mute_trackers_over_streams() {
    let port = free_port();
    let address = format!("hts:tcp:127.0.0.1:{port}");
    let mut opened = open_device(&address);
    told(&mut opened, &address, "is not there (nobody has called yet)");
    let mut caller = TcpStream::connect(("127.0.0.1", port)).unwrap();
    a_mute_tracker(&address, &mut opened, || _ = caller.write_all(&streamer_frame()));

    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("hts:call:{}", listener.local_addr().unwrap());
    let mut opened = open_device(&address);
    let mut called = listener.accept().unwrap().0;
    a_mute_tracker(&address, &mut opened, || _ = called.write_all(&streamer_frame()));
}

/// Greets whoever still waits: calls that were given up lie before the newest.
fn greet(listener: &TcpListener) -> WebSocket<TcpStream> {
    wait("a call that still waits", || {
        let mut server = tungstenite::accept(listener.accept().unwrap().0).ok()?;
        server.get_ref().set_read_timeout(Some(Duration::from_millis(20))).unwrap();
        match server.read() {
            Ok(_) => Some(server),
            Err(tungstenite::Error::Io(e)) if e.kind() == ErrorKind::WouldBlock => Some(server),
            Err(_) => None,
        }
    })
}

/// First it does not even greet.
fn a_mute_websocket() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("poses:ws://{}/", listener.local_addr().unwrap());
    let mut opened = open_device(&address);
    told(&mut opened, &address, "is not there (the server does not greet)");
    let mut server = greet(&listener);
    a_mute_tracker(&address, &mut opened, || _ = server.send(Message::text(pose_line())));
}

fn a_mute_player_of_vibrations() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("bhaptics:{}", listener.local_addr().unwrap());
    let mut opened = open_device(&address);
    told(&mut opened, &address, "is not there (the server does not greet)");
    let mut player = greet(&listener);
    // It need not say anything: what is felt arrives all the same.
    let mut touch = HandOutput::released(Side::Right, 0);
    touch.digits[2].pad_force = 5.0;
    wait("vibration", || {
        opened.display.as_mut().unwrap().show(&touch);
        let Ok(Message::Text(text)) = player.read() else { return None };
        text.contains("{\"index\":2,\"intensity\":60}").then_some(())
    });
    told(&mut opened, &address, "is connected");
}

#[cfg(unix)]
fn a_mute_pipe() {
    let path = std::env::temp_dir().join(format!("thenar-mute-{}", std::process::id()));
    thenar_testing::make_pipe(&path);
    let address = format!("poses:{}", path.display());
    let mut opened = open_device(&address);
    let mut writer = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
    a_mute_tracker(&address, &mut opened, || _ = writer.write_all(pose_line().as_bytes()));
    std::fs::remove_file(&path).unwrap();
}

/// Somebody takes its commands and answers none.
fn a_mute_bridge_of_tendons() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("cybergrasp:{}", listener.local_addr().unwrap());
    let mut opened = open_device(&address);
    let (mute, _) = listener.accept().unwrap();
    told(&mut opened, &address, SILENT);
    assert!(opened.display.as_mut().unwrap().heard_ns().is_none());
    drop(mute);
    told(&mut opened, &address, "is lost");
    let (unit, stop) = (SimulatedUnit::default(), AtomicBool::new(false));
    let mut served = unit.clone();
    std::thread::scope(|scope| {
        scope.spawn(|| serve_unit(&listener, &mut served, &stop).unwrap());
        let mut output = HandOutput::released(Side::Right, 0);
        output.digits[1].pad_force = 3.0;
        wait("the pull", || {
            opened.display.as_mut().unwrap().show(&output);
            (unit.tendons().0 == [0.0, 3.0, 0.0, 0.0, 0.0]).then_some(())
        });
        // It was lost before it had said anything: it is back when it speaks.
        told(&mut opened, &address, "is back");
        stop.store(true, Ordering::Release);
    });
}

/// The loop ticks on beside an arm and a headset that answer nothing, and nothing is felt.
fn the_loop_lives_beside_mute_devices() {
    let bridge = UdpSocket::bind("127.0.0.1:0").unwrap();
    bridge.set_nonblocking(true).unwrap();
    let address = format!("force-device:desktop@{}", bridge.local_addr().unwrap());
    let mut arm = open_device(&address);
    let (tracker, display) = (arm.tracker.take().unwrap(), arm.display.take().unwrap());
    let (mut of_arm, headset) =
        (tracker.message_source(), open_device(&format!("hts:{}", free_port())));
    let mut clock = ManualLoop::new(
        &Settings::default(),
        vec![tracker, headset.tracker.unwrap()],
        vec![display],
    )
    .unwrap();
    let mut simulated = SimulatedArm::new();
    let host = std::cell::Cell::new(None);
    let mut ticks = 0;
    let mut tick = || {
        assert!(clock.tick(now_ns()), "the loop was kept from ticking");
        while clock.records.pop().is_ok() {}
        ticks += 1;
        let mut buffer = [0; 2000];
        while let Ok((length, from)) = bridge.recv_from(&mut buffer) {
            simulated.receive(now_ns(), &buffer[..length]).unwrap();
            assert_eq!(simulated.force(now_ns()), thenar_core::Vec3::zeros());
            host.set(Some(from));
        }
    };
    let message = wait("its name and cause", || {
        tick();
        of_arm().into_iter().find(|told| told.contains(SILENT))
    });
    assert!(message.starts_with(&format!("{address}: ")), "{message}");
    wait("its return", || {
        tick();
        let _ = host.get().map(|host| bridge.send_to(&SimulatedArm::new().state(now_ns()), host));
        of_arm().into_iter().find(|told| told.contains("speaks now"))
    });
    assert!(ticks > 20, "{ticks}");
}

/// Nobody is at its port: a datagram socket opens all the same, and the system tells each second
/// that nobody is there. A person is told once.
#[cfg(target_os = "linux")]
#[test]
fn an_arm_that_is_not_there_is_told_of_once() {
    let port = free_port();
    let address = format!("force-device:desktop@127.0.0.1:{port}");
    let mut opened = open_device(&address);
    let mut all = Vec::new();
    let tracker = opened.tracker.as_mut().unwrap();
    wait("its loss", || {
        all.extend(tracker.messages());
        all.iter().any(|told| told.contains("is lost")).then_some(())
    });
    // Long enough for some more attempts.
    std::thread::sleep(Duration::from_millis(1500));
    all.extend(tracker.messages());
    assert!(all.len() <= 3, "{all:?}");
    let bridge = UdpSocket::bind(("127.0.0.1", port)).unwrap();
    bridge.set_nonblocking(true).unwrap();
    let (mut arm, mut buffer) = (SimulatedArm::new(), [0; 2000]);
    wait("its handle", || {
        while let Ok((_, from)) = bridge.recv_from(&mut buffer) {
            let _ = bridge.send_to(&arm.state(now_ns()), from);
        }
        tracker.latest(Side::Right).map(|_| ())
    });
    wait("its return", || tracker.messages().into_iter().find(|told| told.contains("is back")));
}
