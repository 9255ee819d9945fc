//! Goal: a LucidGlove over Wi-Fi moves the hand, stops its fingers, returns after a loss, and
//! nobody else takes its place. Method: its simulated twin calls over a real socket; so do
//! strangers, from other addresses of this computer.
#![cfg(target_os = "linux")] // elsewhere, loopback has one address

use crate::conformance::{open_device, wait};
use socket2::{Domain, Socket, Type};
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use thenar_core::model::Side;
use thenar_core::{Pose, Vec3};
use thenar_link::lucidgloves::LucidGlovesTwin;
use thenar_link::twin::Twin;
use thenar_link::{HandOutput, Opened, now_ns, pose_stream};
use thenar_testing::free_port;
use thenar_track::live::LivePose;

/// Calls the host from 127.0.0.`own`.
fn call(own: u8, port: u16) -> TcpStream {
    wait("somebody who takes calls", || {
        let socket = Socket::new(Domain::IPV4, Type::STREAM, None).unwrap();
        socket.bind(&SocketAddr::from(([127, 0, 0, own], 0)).into()).unwrap();
        socket.connect(&SocketAddr::from(([127, 0, 0, 1], port)).into()).ok()?;
        Some(TcpStream::from(socket))
    })
}

/// A glove that is on until it is dropped.
struct Glove {
    twin: Arc<Mutex<LucidGlovesTwin>>,
    off: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Glove {
    /// It calls from 127.0.0.`own` and hangs up after so many bytes.
    fn switch_on(own: u8, port: u16, curl: f64, bytes: u64) -> Self {
        let mut twin = LucidGlovesTwin::new(false, false);
        twin.set_curls([curl; 5]);
        twin.power_on(now_ns());
        let (twin, off) = (Arc::new(Mutex::new(twin)), Arc::new(AtomicBool::new(false)));
        let (glove, switch) = (twin.clone(), off.clone());
        let left = AtomicU64::new(bytes);
        let run = move || {
            let mut stream = call(own, port);
            stream.set_read_timeout(Some(Duration::from_micros(500))).unwrap();
            let mut buffer = [0; 4096];
            while !switch.load(Ordering::Relaxed) && left.load(Ordering::Relaxed) > 0 {
                let received = match stream.read(&mut buffer) {
                    Ok(0) => return,
                    Ok(received) => received,
                    Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
                    Err(_) => return,
                };
                let mut said = Vec::new();
                let mut send = |bytes: &[u8]| said.extend_from_slice(bytes);
                glove.lock().unwrap().step(now_ns(), &buffer[..received], &mut send);
                said.truncate(left.load(Ordering::Relaxed) as usize);
                left.fetch_sub(said.len() as u64, Ordering::Relaxed);
                if stream.write_all(&said).is_err() {
                    return;
                }
            }
        };
        Self { twin, off, thread: Some(std::thread::spawn(run)) }
    }

    /// Waits until its bytes are said.
    fn hangs_up(mut self) {
        self.thread.take().unwrap().join().unwrap();
    }

    fn felt(&self) -> [f64; 5] {
        self.twin.lock().unwrap().felt()
    }
}

impl Drop for Glove {
    fn drop(&mut self) {
        self.off.store(true, Ordering::Relaxed);
        let _ = self.thread.take().map(std::thread::JoinHandle::join);
    }
}

/// Waits until the index finger is curled so far: its base is flexed by up to 80 degrees.
fn follows(opened: &mut Opened, curl: f64) {
    let tracker = opened.tracker.as_mut().unwrap();
    wait(&format!("a curl of {curl}"), || {
        let Some(LivePose::Angles { angles, .. }) = tracker.latest(Side::Right)?.pose else {
            return None;
        };
        ((angles[4] - curl * 80f64.to_radians()).abs() < 1e-3).then_some(())
    });
}

fn told(opened: &mut Opened, what: &str) -> String {
    let tracker = opened.tracker.as_mut().unwrap();
    wait(what, || tracker.messages().into_iter().find(|told| told.contains(what)))
}

fn stops(opened: &mut Opened, glove: &Glove) {
    let mut output = HandOutput::released(Side::Right, now_ns());
    output.digits.iter_mut().for_each(|digit| digit.curl_at_contact = Some(0.25));
    wait("the stop", || {
        opened.display.as_mut().unwrap().show(&output);
        (glove.felt() == [0.75; 5]).then_some(())
    });
}

#[test]
fn a_glove_calls_moves_the_hand_is_stopped_and_returns() {
    let port = free_port();
    let address = format!("lucidgloves:wifi:{port}");
    let mut opened = open_device(&address);
    told(&mut opened, "is not there (nobody has called yet)");
    let glove = Glove::switch_on(1, port, 0.5, u64::MAX);
    follows(&mut opened, 0.5);
    glove.twin.lock().unwrap().set_curls([0.25; 5]);
    follows(&mut opened, 0.25);
    stops(&mut opened, &glove);
    wait("release after silence", || (glove.felt() == [0.0; 5]).then_some(()));
    drop(glove);
    // It hangs up in the midst of its first line, or of the second. (After every byte, without a
    // socket, in `tests/all/noise.rs`.)
    for bytes in [1, 2, 5, 11, 22, 23, 24, 25, 30, 47] {
        Glove::switch_on(1, port, 0.9, bytes).hangs_up();
        let curl = 0.01 * bytes as f64;
        let glove = Glove::switch_on(1, port, curl, u64::MAX);
        follows(&mut opened, curl);
        stops(&mut opened, &glove);
        // It calls anew, and what is left of its old call does not keep it out.
        let again = Glove::switch_on(1, port, 1.0, u64::MAX);
        follows(&mut opened, 1.0);
        stops(&mut opened, &again);
    }
    let told = opened.tracker.as_mut().unwrap().messages();
    let has = |what: &str| told.iter().any(|told| told.contains(what));
    assert!(has("is lost") && has("is back"), "{told:?}");
}

/// A glove that speaks keeps its hand; who may speak can be said beforehand.
#[test]
fn strangers_do_not_take_a_gloves_place() {
    let port = free_port();
    let mut opened = open_device(&format!("lucidgloves:wifi:{port}"));
    // Somebody calls and says nothing: that is no glove's place.
    let _idle = call(3, port);
    told(&mut opened, "is connected");
    let glove = Glove::switch_on(1, port, 0.5, u64::MAX);
    follows(&mut opened, 0.5);
    opened.tracker.as_mut().unwrap().messages();
    let strangers = [2, 3, 2].map(|own| Glove::switch_on(own, port, 1.0, u64::MAX));
    let message = told(&mut opened, "another sender is not heard");
    assert!(message.starts_with(&format!("lucidgloves:wifi:{port}: ")), "{message}");
    for _ in 0..50 {
        follows(&mut opened, 0.5);
    }
    stops(&mut opened, &glove);
    assert!(strangers.iter().all(|glove| glove.felt() == [0.0; 5]), "strangers are told nothing");
    drop(strangers);

    let port = free_port();
    let address = format!("lucidgloves:wifi:{port}?from=127.0.0.2");
    let mut opened = open_device(&address);
    let _stranger = Glove::switch_on(1, port, 1.0, u64::MAX);
    let message = told(&mut opened, "is not there (others than 127.0.0.2 have called");
    assert!(message.starts_with("lucidgloves:wifi:"), "{message}");
    let _glove = Glove::switch_on(2, port, 0.5, u64::MAX);
    follows(&mut opened, 0.5);
}

/// Reached, but silent.
#[test]
fn a_mute_glove_is_told_of() {
    let port = free_port();
    let mut opened = open_device(&format!("lucidgloves:wifi:{port}"));
    let mut glove = call(1, port);
    told(&mut opened, "is connected but says nothing: is it switched on");
    glove.write_all(LucidGlovesTwin::new(false, false).line().as_bytes()).unwrap();
    follows(&mut opened, 0.0);
    told(&mut opened, "speaks now");
}

/// A pose of the left hand is no wrist of the right one; the profile's pose is where the wrist is
/// in the tracker's frame, here half a metre along its x.
#[test]
fn a_wrist_that_is_tracked_carries_the_glove() {
    let (port, wrists) = (free_port(), free_port());
    let profile = std::env::temp_dir().join(format!("thenar-wrist-{}.toml", std::process::id()));
    let text = format!("wrist.position = [0.5, 0.0, 0.0]\nwrist.tracker = \"poses:{wrists}\"\n");
    std::fs::write(&profile, text).unwrap();
    let address = format!("lucidgloves:wifi:{port}?profile={}", profile.display());
    let mut opened = open_device(&address);
    std::fs::remove_file(&profile).unwrap();
    let _glove = Glove::switch_on(1, port, 0.5, u64::MAX);
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let place = |side, x: f64| {
        let joints = [Pose::translation(x, 1.0, 0.0); 25];
        let pose = LivePose::Joints { joints, radii: [0.01; 25] };
        let line = pose_stream::write(side, now_ns() as f64 * 1e-9, Some(&pose));
        socket.send_to(line.as_bytes(), ("127.0.0.1", wrists)).unwrap();
    };
    let tracker = opened.tracker.as_mut().unwrap();
    let mut last_ns = 0;
    let mut at = |said: &mut dyn FnMut()| {
        said();
        let sample = tracker.latest(Side::Right)?;
        assert!(sample.time_ns > last_ns && sample.time_ns <= now_ns(), "time goes on");
        last_ns = sample.time_ns;
        match sample.pose.as_ref()? {
            LivePose::Angles { wrist, angles } => Some((wrist.position, angles[4])),
            LivePose::Joints { .. } => panic!("the fingers are lost"),
        }
    };
    // The other hand's wrist does not carry it.
    for _ in 0..50 {
        std::thread::sleep(Duration::from_millis(2));
        assert!(at(&mut || place(Side::Left, 0.0)).is_none());
    }
    for x in [0.2, -0.3] {
        wait("the wrist", || {
            let (position, flexion) = at(&mut || place(Side::Right, x))?;
            let there = (position - Vec3::new(x + 0.5, 1.0, 0.0)).norm() < 1e-5;
            let curled = (flexion - 40f64.to_radians()).abs() < 1e-3;
            (there && curled).then_some(())
        });
    }
    // A tracker that tells no wrist is refused by name.
    let told = thenar_link::open(&format!("lucidgloves:wifi:{}?wrist=bhaptics:", free_port()));
    let told = told.map(|_| ()).unwrap_err().to_string();
    assert!(told.contains("wrist = \"bhaptics:\"") && told.contains("no wrist"), "{told}");
}
