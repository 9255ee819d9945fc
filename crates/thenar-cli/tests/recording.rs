//! Goal: `record`, `run --record`, `serve --record` and `replay` keep their promises: the same
//! bits, usable files after `kill -9`, exit codes, whole tables. Method: the program is run as a
//! user runs it.

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// An empty folder of its own for each test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("thenar-cli-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_thenar"));
        command.args(args).current_dir(&self.0);
        command
    }

    fn thenar(&self, args: &[&str]) -> Output {
        self.command(args).output().unwrap()
    }

    fn text(&self, file: &str) -> String {
        std::fs::read_to_string(self.0.join(file)).unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn out(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn err(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The hash that a summary ends with.
fn state(output: &Output) -> String {
    let text = out(output);
    let hash = text.lines().rev().find_map(|line| line.trim().strip_prefix("state "));
    hash.unwrap_or_else(|| panic!("{text}{}", err(output))).into()
}

#[test]
fn a_recorded_run_is_verified_and_its_tables_are_whole() {
    let folder = Folder::new("record");
    let recorded = folder.thenar(&["record", "falling-box", "--seconds", "0.6"]);
    assert!(recorded.status.success(), "{}", err(&recorded));
    assert!(out(&recorded).starts_with("falling-box.rec: 0.600 s in 300 steps"));
    let plain = folder.thenar(&["run", "falling-box", "--seconds", "0.6", "--record", "run.rec"]);
    assert_eq!(state(&plain), state(&recorded), "recording changes nothing");
    for file in ["falling-box.rec", "run.rec"] {
        let replayed = folder.thenar(&["replay", file, "--verify", "--csv", "t.csv"]);
        assert!(replayed.status.success(), "{}", err(&replayed));
        assert!(out(&replayed).contains("the same bits in all 300 steps, 0.600 s"));
        assert_eq!(state(&replayed), state(&recorded));
        let table = folder.text("t.csv");
        let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
        assert_eq!(rows.len(), 301);
        assert!(rows.iter().all(|row| row.len() == rows[0].len()));
        assert!(
            rows[0].contains(&"box.y [m]") && rows[0].contains(&"probe.on-table.fy [N]"),
            "{:?}",
            rows[0]
        );
        assert_eq!((rows[1][0], rows[300][0]), ("0.002", "0.6"));
        let names: std::collections::BTreeSet<&str> = rows[0].iter().copied().collect();
        assert_eq!(names.len(), rows[0].len(), "no name stands for two columns");
    }
    // A recording is never replaced.
    let again = folder.thenar(&["record", "falling-box"]);
    assert_eq!(again.status.code(), Some(2));
    assert!(err(&again).contains("is there already"), "{}", err(&again));
}

#[test]
fn damage_is_told_with_what_was_kept_and_fails_verification() {
    let folder = Folder::new("damage");
    assert!(folder.thenar(&["record", "falling-box", "--seconds", "0.2", "-q"]).status.success());
    let file = folder.0.join("falling-box.rec");
    let mut bytes = std::fs::read(&file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    std::fs::write(&file, &bytes).unwrap();
    let replayed = folder.thenar(&["replay", "falling-box.rec"]);
    assert!(replayed.status.success(), "what is whole is good: {}", err(&replayed));
    let told = out(&replayed);
    assert!(told.contains("the file is damaged; the first 0."), "{told}");
    assert!(told.contains("a checksum does not agree at byte "), "{told}");
    let verified = folder.thenar(&["replay", "falling-box.rec", "--verify"]);
    assert_eq!(verified.status.code(), Some(1));
    assert!(err(&verified).contains("the file is damaged"), "{}", err(&verified));

    std::fs::write(&file, b"not a recording").unwrap();
    let foreign = folder.thenar(&["replay", "falling-box.rec"]);
    assert_eq!(foreign.status.code(), Some(2));
    assert!(err(&foreign).contains("is not a Thenar recording"), "{}", err(&foreign));
}

/// Ends a program the hard way when the test ends.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Waits until a file has grown beyond so many bytes.
#[track_caller]
fn wait_for(file: &std::path::Path, bytes: u64) {
    let begun = Instant::now();
    while std::fs::metadata(file).map_or(0, |m| m.len()) < bytes {
        assert!(begun.elapsed() < Duration::from_secs(120), "{} does not grow", file.display());
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn what_was_recorded_before_kill_9_is_replayed() {
    let folder = Folder::new("kill");
    let args = ["record", "falling-box", "--seconds", "100000", "-q", "--out", "k.rec"];
    let file = folder.0.join("k.rec");
    let running = Running(folder.command(&args).stdout(Stdio::null()).spawn().unwrap());
    wait_for(&file, 100_000);
    drop(running); // SIGKILL
    let replayed = folder.thenar(&["replay", "k.rec"]);
    assert!(replayed.status.success(), "{}", err(&replayed));
    let told = out(&replayed);
    assert!(told.contains("the same bits in all "), "{told}");
    let steps = told.split("in all ").nth(1).and_then(|t| t.split(' ').next()).unwrap();
    // 38 bytes a step, the scene and a few keyframes.
    assert!(steps.parse::<u64>().unwrap() > 1500, "{told}");
    assert!(told.contains("was not ended") || told.contains("is damaged"), "{told}");
    assert_eq!(folder.thenar(&["replay", "k.rec", "--verify"]).status.code(), Some(1));
}

#[test]
fn nothing_is_left_of_a_recording_whose_scene_is_wrong() {
    let folder = Folder::new("wrong");
    std::fs::write(folder.0.join("bad.toml"), "version = 1\nnonsense = 1\n").unwrap();
    for args in [
        &["record", "bad.toml"][..],
        &["run", "bad.toml", "--record", "bad.rec"],
        &["serve", "bad.toml", "--record", "bad.rec", "--no-open"],
        &["record", "falling-box", "--keyframes", "-1", "--out", "bad.rec"],
    ] {
        let output = folder.thenar(args);
        assert_eq!(output.status.code(), Some(2), "{args:?} {}", err(&output));
        assert!(!folder.0.join("bad.rec").exists(), "{args:?}");
    }
}

#[test]
fn an_mcap_file_has_the_promised_topics_and_the_physics_in_them() {
    let folder = Folder::new("mcap");
    assert!(folder.thenar(&["record", "soft-cube", "--seconds", "0.4", "-q"]).status.success());
    let replayed = folder.thenar(&["replay", "soft-cube.rec", "--mcap", "c.mcap", "--rate", "50"]);
    assert!(replayed.status.success(), "{}", err(&replayed));
    let bytes = std::fs::read(folder.0.join("c.mcap")).unwrap();
    let mut topics: BTreeMap<String, Vec<(u64, Value)>> = BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!(
            (&schema.encoding[..], &message.channel.message_encoding[..]),
            ("jsonschema", "json")
        );
        let value = serde_json::from_slice(&message.data).unwrap();
        topics.entry(message.channel.topic.clone()).or_default().push((message.log_time, value));
    }
    let names: Vec<&str> = topics.keys().map(String::as_str).collect();
    let expected = [
        "/flesh",
        "/forces",
        "/haptics/force",
        "/log",
        "/objects",
        "/probes",
        "/sim/step",
        "/sim/timing",
        "/tf",
    ];
    assert_eq!(names, expected);
    let unknown =
        |(_, message): &(u64, Value)| message.as_object().unwrap().values().any(Value::is_null);
    assert!(!topics.values().flatten().any(unknown), "what is not known is left out");
    // 200 steps of 2 ms, and moments 50 times a second.
    assert_eq!(topics["/sim/timing"].len(), 200);
    assert_eq!(topics["/tf"].len(), 21);
    let times: Vec<u64> = topics["/sim/timing"].iter().map(|(time, _)| *time).collect();
    assert_eq!(times[199] - times[0], 398_000_000);
    assert!(topics.values().all(|messages| messages.is_sorted_by_key(|(time, _)| *time)));

    // The cube falls from 60 mm with its mass in the middle until it touches at 35 mm.
    let height = |message: &Value| {
        let points = message["entities"][0]["triangles"][0]["points"].as_array().unwrap();
        points.iter().map(|p| p["y"].as_f64().unwrap()).fold(f64::INFINITY, f64::min)
    };
    // The first update clears the topic, the second is the start.
    let flesh = &topics["/flesh"];
    assert_eq!(flesh[0].1["deletions"][0]["type"], 1);
    let fallen = height(&flesh[1].1) - height(&flesh[3].1);
    let t = (flesh[3].0 - flesh[1].0) as f64 * 1e-9;
    let theory = 0.5 * 9.81 * t * t;
    assert!((fallen - theory).abs() < 0.1 * theory + 2e-6, "{fallen} m in {t} s, {theory}");
    let arrows = |message: &Value| message["entities"][0]["arrows"].as_array().unwrap().len();
    assert_eq!(arrows(&topics["/forces"][0].1), 0);
    assert!(arrows(&topics["/forces"].last().unwrap().1) > 0, "it has landed");
    // A file that could not be finished leaves nothing.
    let refused = folder.thenar(&["replay", "soft-cube.rec", "--mcap", "no/such/folder.mcap"]);
    assert_ne!(refused.status.code(), Some(0));
    assert!(std::fs::read_dir(&folder.0).unwrap().count() == 2);
}
