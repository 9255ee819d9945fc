//! Goal: `thenar compare` keeps its promises to scripts: exit codes, a table that parses, the same
//! bytes again, divergence said with its time. Method: it is run as a user runs it.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// An empty folder of its own for each test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("thenar-cmp-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn read(&self, file: &str) -> String {
        std::fs::read_to_string(self.0.join(file)).unwrap()
    }

    fn compare(&self, args: &[&str]) -> Output {
        let program = env!("CARGO_BIN_EXE_thenar");
        Command::new(program).arg("compare").args(args).current_dir(&self.0).output().unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn said(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn finger() -> String {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/validation");
    scenes.join("d05-finger.toml").display().to_string()
}

#[test]
fn the_same_comparison_writes_the_same_bytes() {
    let folder = Folder::new("bytes");
    let scene = finger();
    for name in ["a", "b"] {
        let [csv, svg] = ["csv", "svg"].map(|ending| format!("{name}.{ending}"));
        let done = folder.compare(&[&scene, "--csv", &csv, "--svg", &svg]);
        assert!(done.status.success(), "{}", said(&done.stderr));
    }
    assert_eq!(folder.read("a.csv"), folder.read("b.csv"));
    assert_eq!(folder.read("a.svg"), folder.read("b.svg"));

    let table = folder.read("a.csv");
    let mut lines = table.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    for column in ["time [s]", "bones.position_max [m]", "monolithic.energy [J]"] {
        assert!(head.contains(&column), "{head:?}");
    }
    let mut rows = 0;
    for line in lines {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(cells.len(), head.len());
        assert!(cells.iter().all(|cell| cell.is_finite()), "{line}");
        rows += 1;
    }
    // 0.1 s of 1 ms, and the start.
    assert_eq!(rows, 101);
    let svg = folder.read("a.svg");
    assert!(svg.contains("Bones: distance [mm]") && !svg.contains("NaN"));
}

#[test]
fn divergence_is_said_with_its_time() {
    let folder = Folder::new("diverges");
    let stiff = [0, 1, 2].map(|i| format!("soft.flesh.bind.{i}.stiffness=1e9"));
    let scene = finger();
    let mut args = vec![scene.as_str(), "--paper", "--seconds", "1.5"];
    args.extend(["--set", "time_step=0.005", "--report", "r.json"]);
    stiff.iter().for_each(|set| args.extend(["--set", set]));
    let done = folder.compare(&args);
    assert!(done.status.success(), "{}", said(&done.stderr));
    let report: Value = serde_json::from_str(&folder.read("r.json")).unwrap();
    let time = report["two_step"]["diverged"]["time_s"].as_f64().unwrap();
    assert!(time > 0.0 && time < 1.5);
    assert!(report["monolithic"]["diverged"].is_null());
    assert_eq!(report["steps"], 300, "the survivor goes on");
    let words = format!("diverged at {time:.4} s");
    assert!(said(&done.stderr).contains(&words) && said(&done.stdout).contains(&words));
    let median = |side: &str| report[side]["stages"]["total"]["median_us"].as_f64().unwrap();
    assert!(median("two_step") > 0.0 && median("monolithic") > 0.0);
}

#[test]
fn bad_arguments_exit_with_2_and_leave_nothing() {
    let folder = Folder::new("bad");
    let scene = finger();
    for args in [
        vec!["no-such-scene"],
        vec![&scene, "--seconds", "-1"],
        vec![&scene, "--seconds", "nan"],
        vec![&scene, "--set", "no.such.key=1"],
        vec![&scene, "--stiffness", "1e6"],
        vec![&scene, "--sweep", "--stiffness", "0"],
        vec![&scene, "--sweep", "--steps-ms", "x"],
        vec![&scene, "--sweep", "--csv", "t.csv"],
        vec!["falling-box", "--sweep", "--seconds", "0.01"],
    ] {
        let done = folder.compare(&args);
        assert_eq!(done.status.code(), Some(2), "{args:?}: {}", said(&done.stderr));
        assert!(!done.stderr.is_empty(), "{args:?} says why");
    }
    assert_eq!(std::fs::read_dir(&folder.0).unwrap().count(), 0);
}

#[test]
fn a_sweep_prints_a_table_and_draws_it() {
    let folder = Folder::new("sweep");
    let scene = finger();
    let mut args = vec![scene.as_str(), "--sweep", "--stiffness", "1e6,1e9", "--steps-ms", "5"];
    args.extend(["--from", "0.02", "--seconds", "0.05", "--svg", "s.svg", "--report", "s.json"]);
    let done = folder.compare(&args);
    assert!(done.status.success(), "{}", said(&done.stderr));
    let rows = said(&done.stdout).lines().filter(|line| line.starts_with("| 5.0 |")).count();
    assert_eq!(rows, 6, "{}", said(&done.stdout));
    let report: Value = serde_json::from_str(&folder.read("s.json")).unwrap();
    assert!(report["points"][1]["schemes"][0]["diverged_s"].is_number());
    assert!(folder.read("s.svg").contains("Step 5.0 ms"));
}

/// As `compare ... | head -c 1` does, at the worst moment.
#[test]
fn a_closed_output_is_no_interruption() {
    let folder = Folder::new("closed");
    let scene = finger();
    for more in [&[][..], &["--csv", "a.csv"]] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_thenar"));
        command.args(["compare", &scene, "--seconds", "0.05"]).args(more).current_dir(&folder.0);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", said(&output.stderr));
        assert!(!said(&output.stderr).contains("interrupted"), "{}", said(&output.stderr));
    }
    let whole = folder.compare(&[&scene, "--seconds", "0.05", "--csv", "b.csv", "-q"]);
    assert!(whole.status.success(), "{}", said(&whole.stderr));
    assert_eq!(folder.read("a.csv"), folder.read("b.csv"));
}
