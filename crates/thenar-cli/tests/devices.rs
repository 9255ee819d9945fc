//! Goal: `thenar devices` works as a person uses it, without hardware. Method: one process simulates
//! a device, another opens it.
#![cfg(unix)]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

fn thenar(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_thenar"));
    // No profile of whoever runs the tests.
    command.args(args).env("THENAR_CONFIG", std::env::temp_dir().join("thenar-no-such-folder"));
    command
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// A simulated device in a process of its own.
struct Simulated {
    process: Child,
    port: PathBuf,
}

impl Simulated {
    fn start(name: &str, test: &str) -> Self {
        let port = std::env::temp_dir().join(format!("thenar-cli-{test}-{}", std::process::id()));
        let args =
            ["devices", "simulate", name, "--seconds", "120", "--port", port.to_str().unwrap()];
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
        (&["devices", "test", "cyberglove:x?colour=red"][..], 2, "`colour=red` is no option"),
        (&["devices", "test", "cyberglove:x?profile=/no/such"][..], 2, "/no/such"),
        (&["devices", "test", "cyberglove:/no/such", "--seconds", "0.3"][..], 1, "told no pose"),
        (&["devices", "calibrate", "null:left"][..], 2, "null needs no calibration"),
        (&["devices", "simulate", "toaster"][..], 2, "no device is simulated as `toaster`"),
    ] {
        let output = thenar(args).stdin(Stdio::null()).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{args:?}: {}", text(&output));
        assert!(text(&output).contains(told), "{args:?}: {}", text(&output));
    }
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
