//! Goal: however the program ends, the wearer is let go. Method: a simulated glove behind a real
//! terminal and a simulated arm behind a real socket, in this process; the program in another one, pushing
//! firmly, is asked to end, interrupted, or killed outright.
#![cfg(unix)]

use std::net::UdpSocket;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use thenar::Vec3;
use thenar_link::force_device::twin::SimulatedArm;
use thenar_link::lucidgloves::LucidGlovesTwin;
use thenar_link::now_ns;
use thenar_link::twin::{PtyTwin, Twin};

/// Longest that anything may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// Bones alone; something pushes the index finger and the palm to and fro. An arm shows as much of it as a loose grip bears
/// behind its delay.
const SCENE: &str = r#"version = 1
time_step = 0.01
[[hand]]
preset = "paper"
name = "hand"
flesh = false
[[load]]
kind = "force"
body = "hand/index-distal"
force = [0, 2, 0]
profile = { kind = "sine", frequency = 0.7 }
[[load]]
kind = "force"
body = "hand/palm"
force = [0, 8, 0]
profile = { kind = "sine", frequency = 0.7 }
"#;

/// No wait, no ramp: this wearer does not exist.
const GLOVE: &str = "display.ramp = 0.0\n";

struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("thenar-touch-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        std::fs::write(path.join("scene.toml"), SCENE).unwrap();
        std::fs::write(path.join("glove.toml"), GLOVE).unwrap();
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The program, armed.
struct Touch(Child);

impl Touch {
    fn start(folder: &Folder, device: &str) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_thenar"));
        command.args(["touch", "scene.toml", "--quiet", "--arm", "--device", device]);
        command.env("THENAR_CONFIG", folder.0.join("none")).current_dir(&folder.0);
        Self(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap())
    }

    fn signal(&self, name: &str) {
        let id = self.0.id().to_string();
        assert!(Command::new("kill").args([name, &id]).status().unwrap().success());
    }
}

impl Drop for Touch {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn until(what: &str, mut done: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !done() {
        assert!(begun.elapsed() < PATIENCE, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// A glove's stop is let go by the last words of a program that is asked to end.
#[test]
fn a_program_that_is_told_to_end_frees_the_fingers() {
    std::thread::scope(|scope| {
        for signal in ["-TERM", "-INT", "-HUP"] {
            scope.spawn(move || ends_with_free_fingers(signal));
        }
    });
}

fn ends_with_free_fingers(signal: &str) {
    let folder = Folder::new(&signal[1..]);
    let port = folder.0.join("glove");
    let glove = PtyTwin::start(LucidGlovesTwin::new(false, false), &port).unwrap();
    glove.twin().set_curls([0.3; 5]);
    let device = format!("lucidgloves:{}?profile=glove.toml", port.display());
    let mut touch = Touch::start(&folder, &device);
    until("a stop", || glove.twin().felt()[1] > 0.0);
    touch.signal(signal);
    until("its end", || touch.0.try_wait().unwrap().is_some());
    // What it said last may still be on the line.
    until("free fingers", || glove.twin().felt() == [0.0; 5]);
}

/// A simulated arm that speaks a thousand times per second.
struct Arm {
    arm: Arc<Mutex<SimulatedArm>>,
    stop: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
    port: u16,
}

impl Arm {
    fn start() -> Self {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.set_read_timeout(Some(Duration::from_millis(1))).unwrap();
        let port = socket.local_addr().unwrap().port();
        let arm = Arc::new(Mutex::new(SimulatedArm::new()));
        let stop = Arc::new(AtomicBool::new(false));
        let (its_arm, its_stop) = (arm.clone(), stop.clone());
        let thread = std::thread::spawn(move || {
            let (mut host, mut bytes, mut told) = (None, [0; 256], Instant::now());
            while !its_stop.load(Ordering::Relaxed) {
                if let Ok((n, from)) = socket.recv_from(&mut bytes) {
                    host = Some(from);
                    let _ = its_arm.lock().unwrap().receive(now_ns(), &bytes[..n]);
                }
                if let Some(host) = host.filter(|_| told.elapsed() >= Duration::from_millis(1)) {
                    told = Instant::now();
                    let state = its_arm.lock().unwrap().state(now_ns());
                    let _ = socket.send_to(&state, host);
                }
            }
        });
        Self { arm, stop, thread: Some(thread), port }
    }

    fn force(&self) -> Vec3 {
        self.arm.lock().unwrap().force(now_ns())
    }
}

impl Drop for Arm {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.take().unwrap().join().unwrap();
    }
}

/// Nothing is said by a program that is killed; the bridge's watchdog lets go, as every device should.
#[test]
fn a_program_that_is_killed_leaves_the_devices_watchdog() {
    let folder = Folder::new("kill");
    let arm = Arm::start();
    let mut touch = Touch::start(&folder, &format!("force-device:touch@127.0.0.1:{}", arm.port));
    until("a force", || arm.force().norm() > 0.3);
    touch.signal("-KILL");
    touch.0.wait().unwrap();
    until("the watchdog", || arm.force() == Vec3::zeros());
    // And it stays so: nobody is left who could speak.
    std::thread::sleep(Duration::from_millis(50));
    assert_eq!(arm.force(), Vec3::zeros());
}
