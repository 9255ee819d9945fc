//! Goal: `thenar devices` works as a person uses it, without hardware. Method: one process
//! simulates a device, another opens it.
#![cfg(unix)]

#[cfg(target_os = "linux")]
mod comfort;
#[cfg(target_os = "linux")]
mod latency;
#[cfg(target_os = "linux")]
mod person;

use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};
use thenar_link::cyberglove::ClassicTwin;
use thenar_link::lucidgloves::LucidGlovesTwin;
use thenar_link::twin::{PtyTwin, Twin};

fn thenar(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_thenar"));
    // No profile of whoever runs the tests.
    command.args(args).env("THENAR_CONFIG", std::env::temp_dir().join("thenar-no-such-folder"));
    command
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// Longest that anything may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// What a program prints, line by line, while it runs.
fn lines(from: impl Read + Send + 'static) -> Receiver<String> {
    let (to, lines) = channel();
    std::thread::spawn(move || {
        BufReader::new(from).lines().map_while(Result::ok).all(|line| to.send(line).is_ok())
    });
    lines
}

/// The next line that has one of these in it: that line, and which.
fn line_with_any(lines: &Receiver<String>, what: &[&str]) -> (String, usize) {
    let mut seen = Vec::new();
    loop {
        let Ok(line) = lines.recv_timeout(PATIENCE) else {
            panic!("none of {what:?} ever came: {seen:#?}");
        };
        if let Some(which) = what.iter().position(|what| line.contains(what)) {
            return (line, which);
        }
        seen.push(line);
    }
}

/// The next line that has this in it.
fn line_with(lines: &Receiver<String>, what: &str) -> String {
    line_with_any(lines, &[what]).0
}

/// A simulated device on the network, in a process of its own, with a hand that holds still.
struct Networked {
    process: Child,
    address: String,
    /// Somebody reads what it prints.
    _said: Receiver<String>,
}

impl Networked {
    fn start(name: &str) -> Self {
        let place = &format!("127.0.0.1:{}", thenar_testing::free_port());
        let args = ["devices", "simulate", name, "--seconds", "120", "--port", place];
        let mut process = thenar(&[&args[..], &["--still", "0.5"]].concat())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let said = lines(process.stdout.take().unwrap());
        let line = line_with(&said, "in another terminal: ");
        let address = line.rsplit(' ').next().unwrap().to_string();
        Self { process, address, _said: said }
    }
}

impl Drop for Networked {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// A simulated device in a process of its own.
struct Simulated {
    process: Child,
    port: PathBuf,
}

impl Simulated {
    fn start(name: &str, test: &str) -> Self {
        Self::late(name, test, 0.0)
    }

    /// What it tells is so old \[s\].
    fn late(name: &str, test: &str, late: f64) -> Self {
        let port = std::env::temp_dir().join(format!("thenar-port-{test}-{}", std::process::id()));
        let (place, late) = (port.to_str().unwrap(), late.to_string());
        let args =
            ["devices", "simulate", name, "--seconds", "120", "--late", &late, "--port", place];
        let process = thenar(&args).stdout(Stdio::null()).spawn().unwrap();
        let start = Instant::now();
        while !port.is_symlink() {
            assert!(start.elapsed() < Duration::from_secs(30), "{name} never came up");
            std::thread::sleep(Duration::from_millis(5));
        }
        Self { process, port }
    }

    fn address(&self, driver: &str) -> String {
        format!("{driver}:{}", self.port.display())
    }
}

impl Drop for Simulated {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = std::fs::remove_file(&self.port);
    }
}

#[test]
fn the_list_names_every_driver() {
    let output = thenar(&["devices", "list"]).output().unwrap();
    assert!(output.status.success());
    for driver in ["lucidgloves", "cyberglove", "cyberglove3", "cybergrasp", "null"] {
        assert!(text(&output).contains(driver), "{}", text(&output));
    }
}

#[test]
fn a_simulated_glove_is_shown_live() {
    for (name, driver) in [("lucidgloves", "lucidgloves"), ("cyberglove3", "cyberglove3")] {
        let glove = Simulated::start(name, name);
        let address = glove.address(driver);
        let output = thenar(&["devices", "test", &address, "--seconds", "2"]).output().unwrap();
        let told = text(&output);
        assert!(output.status.success(), "{told}");
        assert!(told.contains("right hand: ") && told.contains("is connected"), "{told}");
    }
}

#[test]
fn what_is_wrong_is_named_and_has_its_exit_code() {
    for (args, code, told) in [
        (&["devices", "test", "toaster:x"][..], 2, "no driver has that name"),
        (&["devices", "test", "null:up"][..], 2, "expected `left` or `right`"),
        (&["devices", "test", "cyberglove:x?colour=red"][..], 2, "`colour=red` is not an option"),
        (&["devices", "test", "cyberglove:x?profile=/no/such"][..], 2, "/no/such"),
        (&["devices", "test", "cyberglove:/no/such", "--seconds", "0.3"][..], 1, "sent no pose"),
        (&["devices", "calibrate", "null:left"][..], 2, "null needs no calibration"),
        (&["devices", "simulate", "toaster"][..], 2, "no device is simulated as `toaster`"),
    ] {
        let output = thenar(args).stdin(Stdio::null()).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{args:?}: {}", text(&output));
        assert!(text(&output).contains(told), "{args:?}: {}", text(&output));
    }
}

/// Waiting is told, and how long it lasts.
#[test]
fn a_silent_device_is_listened_to_aloud() {
    let args = ["devices", "test", "lucidgloves:/dev/zero", "--seconds", "2.5"];
    let output = thenar(&args).stdin(Stdio::null()).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    let waits = ["1.5", "0.5"]
        .map(|left| format!("lucidgloves:/dev/zero: no pose yet, listening for {left} s more\n"));
    assert_eq!(
        told,
        format!("{}{}error: lucidgloves:/dev/zero sent no pose\n", waits[0], waits[1])
    );
    // Nothing of it where there is a pose.
    let heard = thenar(&["devices", "test", "null:left", "--seconds", "1.2"]).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&heard.stderr), "");
}

#[test]
fn devices_inside_devices_have_an_end() {
    let folder = std::env::temp_dir().join(format!("thenar-inside-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let profile = folder.join("own.toml");
    let own = format!("lucidgloves:x?profile={}", profile.display());
    std::fs::write(&profile, format!("[wrist]\ntracker = '{own}'\n")).unwrap();
    let wrists = format!("{}hts:1", "lucidgloves:x?wrist=".repeat(1000));
    let faults = format!("{}hts:1", "fault:7:".repeat(3000));
    let deep = "devices are nested too deep, more than 8 of them";
    let itself = "own.toml, wrist.tracker = \"lucidgloves:x?profile=";
    for (address, told) in [(&own, itself), (&wrists, deep), (&faults, deep)] {
        let output = thenar(&["devices", "test", address]).stdin(Stdio::null()).output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.starts_with("error: ") && error.contains(told), "{error}");
        assert!(error.lines().count() == 1 && error.len() < 600, "{error}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

/// No force before a person agrees.
#[test]
fn nothing_is_felt_without_consent() {
    let args = ["devices", "test", "null:right", "--seconds", "0.2", "--feel"];
    let output = thenar(&args).stdin(Stdio::null()).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output).contains("not armed: no force was shown"), "{}", text(&output));
}

/// The simulated hand opens and closes without rest, so that no pose holds still: the person is
/// asked again, and when nobody answers any more nothing is written.
#[test]
fn an_unfinished_calibration_writes_nothing() {
    let glove = Simulated::start("lucidgloves", "unfinished");
    let file: &Path = &glove.port.with_extension("toml");
    let address = glove.address("lucidgloves");
    let args = ["devices", "calibrate", &address, "--output", file.to_str().unwrap()];
    let mut process = thenar(&args)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    process.stdin.take().unwrap().write_all(b"\n").unwrap();
    let output = process.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    assert!(text(&output).contains("That moved; again, please."), "{}", text(&output));
    assert!(!file.exists());
}

#[test]
fn simulated_trackers_are_shown_live() {
    for name in ["hts", "poses", "force-device"] {
        let device = Networked::start(name);
        let output =
            thenar(&["devices", "test", &device.address, "--seconds", "2"]).output().unwrap();
        assert!(text(&output).contains("right hand: "), "{name}: {}", text(&output));
    }
    let output = thenar(&["devices", "simulate"]).output().unwrap();
    for name in ["lucidgloves", "cybergrasp", "force-device", "bhaptics", "hts", "poses"] {
        assert!(text(&output).contains(name), "{}", text(&output));
    }
}

/// A session of `calibrate` and a person who answers it: at each prompt the hand takes the pose,
/// then Enter.
fn calibrate<T: Twin + 'static>(
    glove: &PtyTwin<T>,
    driver: &str,
    file: &Path,
    poses: &[(&str, [f64; 5])],
    length: &[&str],
) -> Vec<String> {
    let address = format!("{driver}:{}", glove.path().display());
    let args = ["devices", "calibrate", &address, "--seconds", "0.3", "--output"];
    let mut process = thenar(&[&args[..], &[file.to_str().unwrap()]].concat())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let said = lines(process.stdout.take().unwrap());
    let mut person = process.stdin.take().unwrap();
    // One prompt after the other; where the hand moved meanwhile, the same again.
    let prompts: Vec<String> = poses.iter().map(|(name, _)| format!(" {name}: ")).collect();
    let mut known: Vec<&str> = prompts.iter().map(String::as_str).collect();
    known.push("Length of your hand");
    while let Some((_, curls)) = poses.get(line_with_any(&said, &known).1) {
        glove.twin().set_curls(*curls);
        // The glove speaks a hundred times a second or more; what it said before does not count.
        std::thread::sleep(Duration::from_millis(300));
        person.write_all(b"\n").unwrap();
    }
    for answer in length {
        person.write_all(format!("{answer}\n").as_bytes()).unwrap();
    }
    assert!(process.wait().unwrap().success());
    let rest = said.iter().collect::<Vec<_>>();
    assert!(rest.iter().any(|line| line.starts_with("wrote ")), "{rest:?}");
    rest
}

/// What the driver tells of a hand, with the profile in this file.
fn told<T: Twin + 'static>(glove: &PtyTwin<T>, driver: &str, file: &Path) -> String {
    let address = format!("{driver}:{}?profile={}", glove.path().display(), file.display());
    let output = thenar(&["devices", "test", &address, "--seconds", "1"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    text(&output)
}

/// A wearer whose open hand reads a quarter and whose fist reads three quarters of the sensors'
/// range, with a profile that has notes of theirs. Then half-way, by the sensors, is half-way by
/// the hand: of 80, 95 and 55 degrees.
#[test]
fn a_lucid_glove_is_calibrated_from_prompt_to_pose() {
    let port = std::env::temp_dir().join(format!("thenar-calibrate-l-{}", std::process::id()));
    let glove = PtyTwin::start(LucidGlovesTwin::new(false, false), &port).unwrap();
    let file = port.with_extension("toml");
    let own = "# Anna's glove\n[index] # the new servo\nraw = [0.0, 1.0]\n\n[hand]\nlength = 0.2\n";
    std::fs::write(&file, own).unwrap();
    let poses = [("open", [0.25; 5]), ("fist", [0.75, 0.75, 0.75, 0.75, 0.25])];
    let rest = calibrate(&glove, "lucidgloves", &file, &poses, &["18 cm", "180"]);
    assert!(
        rest.iter().any(|line| line.contains("`18 cm` mm is not the length of a hand")),
        "{rest:?}"
    );
    assert!(rest.iter().any(|line| line.contains("the little's sensor hardly moved")), "{rest:?}");
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.starts_with("# Anna's glove\n[index] # the new servo\nraw = [0.2"), "{text}");
    assert!(text.contains("[hand]\nlength = 0.18\n") && !text.contains("[little]"), "{text}");
    glove.twin().set_curls([0.5; 5]);
    let told = told(&glove, "lucidgloves", &file);
    assert!(told.contains("hand length 180 mm"), "{told}");
    assert!(told.contains("I  40 "), "{told}");
    std::fs::remove_file(&file).unwrap();
}

/// The simulated wearer of a CyberGlove bends all of a finger's joints at once: flat is 0 and the
/// other poses are 80, 95 and 55 degrees by the twin. Least squares over the prescribed poses then
/// gives, for the index finger's base (0, 85 and 0 degrees for flat, table-top and hook, where the
/// sensor is at its curls 0, 1 and 0): a gain by which curl 1 is 85 degrees.
#[test]
fn a_cyberglove_is_calibrated_from_prompt_to_pose() {
    let port = std::env::temp_dir().join(format!("thenar-calibrate-c-{}", std::process::id()));
    let glove = PtyTwin::start(ClassicTwin::new(22), &port).unwrap();
    let file = port.with_extension("toml");
    let poses = [
        ("flat", [0.0; 5]),
        ("spread", [0.0; 5]),
        ("table-top", [0.0, 1.0, 1.0, 1.0, 1.0]),
        ("hook", [0.0; 5]),
        ("thumb", [1.0, 0.0, 0.0, 0.0, 0.0]),
    ];
    let rest = calibrate(&glove, "cyberglove", &file, &poses, &[""]);
    assert!(rest.iter().any(|line| line.contains("middle_abduction hardly moved")), "{rest:?}");
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.contains("[sensors.index_mpj]") && !text.contains("[hand]"), "{text}");
    glove.twin().set_curls([0.0, 1.0, 0.0, 0.0, 0.0]);
    let told = told(&glove, "cyberglove", &file);
    assert!(told.contains("I  85 "), "{told}");
    std::fs::remove_file(&file).unwrap();
}
