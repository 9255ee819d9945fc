//! Signals at any moment.

use super::{names, stocked};
use std::os::unix::process::CommandExt;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// Delays from the start of the process \[ms\]: dense while scenes are built and files begun.
fn delays() -> impl Iterator<Item = u64> {
    (0..60).step_by(4).chain((60..=300).step_by(20))
}

/// Makes a program end at a hangup even where tests run under `nohup`, whose children ignore it.
#[allow(unsafe_code)] // the child sets its own signal, which is safe between fork and exec
fn hears_hangups(command: &mut Command) -> &mut Command {
    use nix::sys::signal::{SigHandler, Signal, signal};
    let reset =
        || unsafe { signal(Signal::SIGHUP, SigHandler::SigDfl) }.map(|_| ()).map_err(Into::into);
    unsafe { command.pre_exec(reset) }
}

/// Sends a signal, and another one at once or never; what is left must have its final name.
#[track_caller]
fn check(command: &[&str], signals: &[&str]) {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let folder = stocked(&format!("signals-{number}"));
    let stock = names(&folder.0);
    for delay in delays() {
        let mut child = folder.command(command);
        let mut child =
            hears_hangups(&mut child).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(delay));
        let id = child.id().to_string();
        for signal in signals {
            // It may have ended already.
            let kill = Command::new("kill").args([*signal, id.as_str()]).output();
            assert!(kill.is_ok());
        }
        child.wait().unwrap();
        for name in names(&folder.0) {
            let whole = stock.contains(&name) || !name.contains(".part");
            assert!(whole, "{signals:?} after {delay} ms left {name}");
            if !stock.contains(&name) {
                std::fs::remove_file(folder.0.join(&name)).unwrap();
            }
        }
    }
}

const RUN: &[&str] = &[
    "run",
    "car-grasp",
    "--seconds",
    "100000",
    "-q",
    "--report",
    "r.json",
    "--probe",
    "p.csv",
    "--size",
    "64x64",
    "--picture",
    "p.png",
    "--movie",
    "m.png",
    "--record",
    "run.rec",
];

#[test]
fn a_run_leaves_no_draft_when_it_is_asked_to_end() {
    for signal in ["-INT", "-TERM", "-HUP"] {
        check(RUN, &[signal]);
    }
}

#[test]
fn a_run_leaves_no_draft_when_it_is_made_to_end() {
    check(RUN, &["-INT", "-INT"]);
    check(RUN, &["-HUP", "-TERM", "-INT"]);
}

/// `nohup` has the signal ignored before the program starts.
#[test]
fn a_run_under_nohup_outlasts_its_terminal() {
    let folder = stocked("nohup");
    let program = env!("CARGO_BIN_EXE_thenar");
    let script = format!(
        "trap '' HUP; exec '{program}' run falling-box --seconds 100000 -q --report r.json"
    );
    let mut command = Command::new("sh");
    let mut child = command.args(["-c", &script]).current_dir(&folder.0).spawn().unwrap();
    let signal = |name: &str| {
        let id = child.id().to_string();
        assert!(Command::new("kill").args([name, &id]).status().unwrap().success());
    };
    crate::stage::wait_for_name(&folder.0, ".part");
    signal("-HUP");
    std::thread::sleep(Duration::from_millis(200));
    signal("-TERM");
    assert_eq!(child.wait().unwrap().code(), Some(1));
    let report = folder.text("r.json");
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert!(report["wall_s"].as_f64().unwrap() > 0.19, "it went on after the first: {report}");
}

#[test]
fn builds_and_exports_leave_no_draft() {
    check(&["build", "left", "--hand", "-o", "h.thenar", "--glb", "h.glb"], &["-INT"]);
    check(&["build", "left", "--hand", "-o", "h.thenar", "--picture", "h.png"], &["-TERM"]);
    check(&["haptics", "map", "--svg", "m.svg"], &["-INT"]);
}
