//! Goal: however the program ends, the wearer is let go. Method: a simulated glove behind a real
//! terminal and a simulated arm behind a real socket, in this process; the program in another one,
//! pushing firmly, is asked to end, interrupted, or killed outright.
#![cfg(unix)]

use std::net::UdpSocket;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use thenar_core::Vec3;
use thenar_link::force_device::twin::SimulatedArm;
use thenar_link::lucidgloves::LucidGlovesTwin;
use thenar_link::now_ns;
use thenar_link::twin::{PtyTwin, Twin};

/// Longest that anything may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// Bones alone; something pushes the index finger and the palm to and fro. An arm shows as much of
/// it as a loose grip bears behind its delay.
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
        Self::start_with(folder, device, &[])
    }

    fn start_with(folder: &Folder, device: &str, more: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_thenar"));
        command.args(["touch", "scene.toml", "--quiet", "--arm", "--device", device]);
        command.args(more);
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

/// What was felt before a stop is written down, and `thenar haptics replay` makes it again, bit for
/// bit; a file that is none is refused.
#[test]
fn an_incident_is_made_again() {
    let held = Held::new("incident");
    let mut touch = held.start(&[]);
    until("a stop", || held.holds());
    // Longer than a state of the loop is old.
    std::thread::sleep(Duration::from_millis(1500));
    touch.signal("-TERM");
    until("its end", || touch.0.try_wait().unwrap().is_some());
    let files = std::fs::read_dir(&held.folder.0).unwrap().flatten().map(|entry| entry.path());
    let incidents: Vec<_> =
        files.filter(|path| path.extension().is_some_and(|e| e == "touch")).collect();
    let [incident] = &incidents[..] else { panic!("{incidents:?}") };
    let replay = |file: &std::path::Path| {
        let table = held.folder.0.join("again.csv");
        let program = Command::new(env!("CARGO_BIN_EXE_thenar"));
        let args = ["haptics", "replay", file.to_str().unwrap(), "--csv", table.to_str().unwrap()];
        let output = { program }.args(args).output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned()
            + &String::from_utf8_lossy(&output.stderr);
        (output.status.code(), text)
    };
    let (code, text) = replay(incident);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("bit for bit") && text.contains("stop was asked for"), "{text}");
    let table = std::fs::read_to_string(held.folder.0.join("again.csv")).unwrap();
    assert!(table.lines().filter(|line| line.contains(",live,")).count() > 100, "{text}");
    let (code, text) = replay(&held.folder.0.join("scene.toml"));
    assert!(code == Some(2) && text.contains("no incident"), "{text}");
}

/// The programs that keep devices for this one.
fn keepers(program: &Touch) -> Vec<u32> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir("/proc").unwrap().flatten() {
        let Some(id) = entry.file_name().to_str().and_then(|name| name.parse().ok()) else {
            continue;
        };
        let read =
            |file: &str| std::fs::read_to_string(entry.path().join(file)).unwrap_or_default();
        let parent = format!("PPid:\t{}", program.0.id());
        if read("status").lines().any(|line| line == parent)
            && read("cmdline").contains("keep-device")
        {
            found.push(id);
        }
    }
    found
}

/// A glove that stops the index finger of a program, and the address that it was opened by.
struct Held {
    folder: Folder,
    glove: PtyTwin<LucidGlovesTwin>,
}

impl Held {
    fn new(test: &str) -> Self {
        let folder = Folder::new(test);
        let glove = PtyTwin::start(LucidGlovesTwin::new(false, false), &folder.0.join("glove"));
        let glove = glove.unwrap();
        glove.twin().set_curls([0.3; 5]);
        Self { folder, glove }
    }

    fn start(&self, more: &[&str]) -> Touch {
        let port = self.folder.0.join("glove");
        let device = format!("lucidgloves:{}?profile=glove.toml", port.display());
        Touch::start_with(&self.folder, &device, more)
    }

    fn holds(&self) -> bool {
        self.glove.twin().felt()[1] > 0.0
    }
}

/// A glove without a watchdog is let go while the program is stopped, and again when it is killed
/// after it went on. The port is free for the next program.
#[test]
fn a_program_that_stands_still_or_is_killed_lets_a_glove_go() {
    let held = Held::new("keeper");
    let mut touch = held.start(&[]);
    until("a stop", || held.holds());
    touch.signal("-STOP");
    until("free fingers while it stands still", || !held.holds());
    // Nothing but the keeper speaks, and it goes on to say so.
    let mut said = 0;
    held.glove.take_heard();
    until("ten more releases", || {
        said += held.glove.take_heard().len();
        said > 10 * "A0B0C0D0E0\n".len()
    });
    assert!(!held.holds());
    touch.signal("-CONT");
    until("a stop after that", || held.holds());
    touch.signal("-KILL");
    touch.0.wait().unwrap();
    until("free fingers after its end", || !held.holds());
    drop(touch);
    let touch = held.start(&[]);
    until("a stop by the next program", || held.holds());
    drop(touch);
}

/// Without a keeper such a glove holds on, as its firmware has it: what lets it go above is the
/// keeper.
#[test]
fn without_a_keeper_a_glove_holds_on() {
    let held = Held::new("no-keeper");
    let mut touch = held.start(&["--no-keeper"]);
    until("a stop", || held.holds());
    assert!(keepers(&touch).is_empty());
    // The load comes and goes: stopped until that fell on a moment at which the glove holds.
    until("a glove that holds while the program stands still", || {
        touch.signal("-STOP");
        std::thread::sleep(Duration::from_millis(100));
        held.holds() || {
            touch.signal("-CONT");
            std::thread::sleep(Duration::from_millis(70));
            false
        }
    });
    touch.signal("-KILL");
    touch.0.wait().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    assert!(held.holds());
}

/// A keeper that is killed itself is reported and followed by another, which does its work.
#[test]
fn a_keeper_that_is_killed_is_followed_by_another() {
    let held = Held::new("keeper-killed");
    let touch = held.start(&[]);
    until("a stop", || held.holds());
    until("a keeper", || keepers(&touch).len() == 1);
    let first = keepers(&touch)[0];
    assert!(Command::new("kill").args(["-KILL", &first.to_string()]).status().unwrap().success());
    until("another", || keepers(&touch).iter().any(|id| *id != first));
    until("a stop", || held.holds());
    touch.signal("-STOP");
    until("free fingers", || !held.holds());
    touch.signal("-CONT");
}

/// A program that ends in order takes its keeper along, at once.
#[test]
fn a_program_that_ends_takes_its_keeper_along() {
    let held = Held::new("keeper-ends");
    let mut touch = held.start(&[]);
    until("a stop", || held.holds());
    until("a keeper", || keepers(&touch).len() == 1);
    let keeper = keepers(&touch)[0];
    touch.signal("-TERM");
    until("its end", || touch.0.try_wait().unwrap().is_some());
    until("the keeper's end", || !std::path::Path::new(&format!("/proc/{keeper}")).exists());
    assert!(!held.holds());
}

/// A bridge to tendons that has no watchdog: it pulls what it was told last.
struct Tendons {
    pull: Arc<Mutex<[f32; 5]>>,
    port: u16,
}

impl Tendons {
    fn start() -> Self {
        use std::io::{Read, Write};
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let pull = Arc::new(Mutex::new([0.0; 5]));
        let its = pull.clone();
        // It serves until the test's process ends.
        std::thread::spawn(move || {
            for mut host in listener.incoming().flatten() {
                let mut command = [0; 28];
                while host.read_exact(&mut command).is_ok() {
                    assert_eq!(&command[..4], b"TGRP");
                    let force = |k: usize| command[8 + 4 * k..][..4].try_into().unwrap();
                    *its.lock().unwrap() = std::array::from_fn(|k| f32::from_le_bytes(force(k)));
                    if host.write_all(&[b"TGRA", &command[4..8]].concat()).is_err() {
                        break;
                    }
                }
            }
        });
        Self { pull, port }
    }

    fn pull(&self) -> f32 {
        self.pull.lock().unwrap()[1]
    }
}

/// Tendons behind a bridge without a watchdog are let go while the program is stopped, and when it
/// is killed.
#[test]
fn a_program_that_stands_still_or_is_killed_lets_tendons_go() {
    let folder = Folder::new("keeper-tendons");
    let tendons = Tendons::start();
    let tracked =
        PtyTwin::start(LucidGlovesTwin::new(false, false), &folder.0.join("glove")).unwrap();
    tracked.twin().set_curls([0.3; 5]);
    let device = format!("cybergrasp:127.0.0.1:{}?profile=glove.toml", tendons.port);
    let glove = format!("lucidgloves:{}", folder.0.join("glove").display());
    let mut touch = Touch::start_with(&folder, &device, &["--device", &glove]);
    until("a pull", || tendons.pull() > 0.1);
    touch.signal("-STOP");
    until("slack tendons while it stands still", || tendons.pull() == 0.0);
    touch.signal("-CONT");
    until("a pull after that", || tendons.pull() > 0.1);
    touch.signal("-KILL");
    touch.0.wait().unwrap();
    until("slack tendons after its end", || tendons.pull() == 0.0);
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

/// Nothing is said by a program that is killed; the bridge's watchdog lets go, as every device
/// should.
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

/// The paper's device, simulated: its glove moves the hand, and its tendons are sent forces.
#[test]
fn a_simulated_cybergrasp_is_felt_with() {
    use std::io::{BufRead, BufReader};
    let folder = Folder::new("cybergrasp");
    let device = "simulated:cybergrasp?side=right&profile=glove.toml";
    let mut command = Command::new(env!("CARGO_BIN_EXE_thenar"));
    command.args(["touch", "scene.toml", "--arm", "--device", device]).current_dir(&folder.0);
    command.env("THENAR_CONFIG", folder.0.join("none"));
    let mut touch = Touch(command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap());
    let said = BufReader::new(touch.0.stdout.take().unwrap());
    // "  2 s  live ... right tracked, 0.31 N wanted, 0.31 N sent, ..."
    let sent = |line: &str| -> Option<f64> {
        let (before, _) = line.split_once(" N sent")?;
        before.rsplit(' ').next()?.parse().ok()
    };
    let begun = Instant::now();
    let felt =
        said.lines().map_while(Result::ok).take_while(|_| begun.elapsed() < PATIENCE).any(|line| {
            let live = line.contains("  live") && line.contains("right tracked");
            live && sent(&line).is_some_and(|force| force > 0.02)
        });
    assert!(felt, "no force was ever sent to the tendons");
}
