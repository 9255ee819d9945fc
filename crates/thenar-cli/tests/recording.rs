//! Goal: `record`, `run --record`, `serve --record` and `replay` keep their promises: the same
//! bits, usable files after `kill -9`, exit codes, whole tables. Method: the program is run as a
//! user runs it.

use prost_reflect::{DescriptorPool, DynamicMessage, ReflectMessage};
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
    assert!(told.contains("the file is damaged; "), "{told}");
    assert!(told.contains("a checksum does not agree at byte "), "{told}");
    // The hash after the damage agrees, so that nothing but a mark is missing.
    assert!(told.contains("no step is lost at 0."), "{told}");
    assert!(told.contains("the same bits in all 99 steps") || told.contains("all 98"), "{told}");
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

/// A disk that is full looks like a file that may grow no further: writing fails part of the way.
#[cfg(unix)]
#[test]
fn when_the_disk_is_full_the_run_goes_on_and_the_file_is_good_up_to_there() {
    let folder = Folder::new("full");
    let program = env!("CARGO_BIN_EXE_thenar");
    let run = |args: &str| {
        // 64 or 128 kB, as the shell counts.
        let script = format!("trap '' XFSZ; ulimit -f 128; exec '{program}' {args}");
        Command::new("sh").args(["-c", &script]).current_dir(&folder.0).output().unwrap()
    };
    let seconds = ["falling-box", "--seconds", "12"];
    let whole = folder.thenar(&[&["record"][..], &seconds, &["--out", "whole.rec"]].concat());
    assert!(std::fs::metadata(folder.0.join("whole.rec")).unwrap().len() > 200_000);
    let ran = run("run falling-box --seconds 12 --record run.rec");
    assert_eq!(state(&ran), state(&whole), "all steps were made, and the report is there");
    let recorded = run("record falling-box --seconds 12 --out record.rec -q");
    for (output, file) in [(&ran, "run.rec"), (&recorded, "record.rec")] {
        assert_eq!(output.status.code(), Some(1), "{}", err(output));
        let told = err(output);
        assert_eq!(told.matches("File too large").count(), 1, "{told}");
        assert!(told.contains(file), "{told}");
        let replayed = folder.thenar(&["replay", file]);
        assert!(replayed.status.success(), "{}", err(&replayed));
        let text = out(&replayed);
        let steps = text.split("the same bits in all ").nth(1).and_then(|t| t.split(' ').next());
        // 38 bytes a step fill most of the file.
        assert!(steps.unwrap().parse::<u64>().unwrap() > 1000, "{text}");
    }
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

/// Messages by topic with their times, read by nothing but the schemas in the file.
fn topics(bytes: &[u8]) -> BTreeMap<String, Vec<(u64, DynamicMessage)>> {
    let mut topics: BTreeMap<String, Vec<(u64, DynamicMessage)>> = BTreeMap::new();
    for message in mcap::MessageStream::new(bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!(
            (&schema.encoding[..], &message.channel.message_encoding[..]),
            ("protobuf", "protobuf")
        );
        let pool = DescriptorPool::decode(&schema.data[..]).unwrap();
        let kind = pool.get_message_by_name(&schema.name).unwrap();
        let value = DynamicMessage::decode(kind, &message.data[..]).unwrap();
        assert_eq!(value.unknown_fields().count(), 0, "{}", schema.name);
        topics.entry(message.channel.topic.clone()).or_default().push((message.log_time, value));
    }
    topics
}

/// The messages of a repeated field.
fn list(message: &DynamicMessage, field: &str) -> Vec<DynamicMessage> {
    let value = message.get_field_by_name(field).unwrap();
    value.as_list().unwrap().iter().map(|entry| entry.as_message().unwrap().clone()).collect()
}

fn number(message: &DynamicMessage, field: &str) -> f64 {
    message.get_field_by_name(field).unwrap().as_f64().unwrap()
}

/// Bytes per point and all of them.
fn cloud(message: &DynamicMessage) -> (usize, Vec<u8>) {
    let stride = message.get_field_by_name("point_stride").unwrap().as_u32().unwrap();
    let data = message.get_field_by_name("data").unwrap();
    (stride as usize, data.as_bytes().unwrap().to_vec())
}

#[test]
fn an_mcap_file_has_the_promised_topics_and_the_physics_in_them() {
    let folder = Folder::new("mcap");
    assert!(folder.thenar(&["record", "soft-cube", "--seconds", "0.4", "-q"]).status.success());
    let replayed = folder.thenar(&["replay", "soft-cube.rec", "--mcap", "c.mcap", "--rate", "50"]);
    assert!(replayed.status.success(), "{}", err(&replayed));
    let bytes = std::fs::read(folder.0.join("c.mcap")).unwrap();
    let topics = topics(&bytes);
    let names: Vec<&str> = topics.keys().map(String::as_str).collect();
    let expected = [
        "/flesh",
        "/forces",
        "/haptics/force",
        "/log",
        "/objects",
        "/points/contacts",
        "/points/flesh/cube",
        "/points/forces",
        "/points/objects/table",
        "/probes",
        "/sim/step",
        "/sim/timing",
        "/tf",
    ];
    assert_eq!(names, expected);
    let schema = |topic: &str| topics[topic][0].1.descriptor().full_name().to_string();
    assert_eq!(schema("/tf"), "foxglove.FrameTransforms");
    assert_eq!(schema("/flesh"), "foxglove.SceneUpdate");
    assert_eq!(schema("/points/flesh/cube"), "foxglove.PointCloud");
    assert_eq!(schema("/sim/step"), "thenar.Step");
    // 200 steps of 2 ms, and moments 50 times a second.
    assert_eq!(topics["/sim/timing"].len(), 200);
    assert_eq!(topics["/tf"].len(), 21);
    let times: Vec<u64> = topics["/sim/timing"].iter().map(|(time, _)| *time).collect();
    assert_eq!(times[199] - times[0], 398_000_000);
    assert!(topics.values().all(|messages| messages.is_sorted_by_key(|(time, _)| *time)));
    let simulated = number(&topics["/sim/timing"][199].1, "simulated");
    assert!((simulated - 0.4).abs() < 1e-12, "{simulated}");

    // The cube falls from 60 mm with its mass in the middle until it touches at 35 mm.
    let height = |message: &DynamicMessage| {
        let entity = &list(message, "entities")[0];
        let points = list(&list(entity, "triangles")[0], "points");
        points.iter().map(|p| number(p, "y")).fold(f64::INFINITY, f64::min)
    };
    // The first update clears the topic, the second is the start.
    let flesh = &topics["/flesh"];
    let cleared =
        list(&flesh[0].1, "deletions")[0].get_field_by_name("type").unwrap().as_enum_number();
    assert_eq!(cleared, Some(1));
    let fallen = height(&flesh[1].1) - height(&flesh[3].1);
    let t = (flesh[3].0 - flesh[1].0) as f64 * 1e-9;
    let theory = 0.5 * 9.81 * t * t;
    assert!((fallen - theory).abs() < 0.1 * theory + 2e-6, "{fallen} m in {t} s, {theory}");
    // Its points fall with it: they lie on its lowest face too.
    let lowest = |message: &DynamicMessage| {
        let (stride, data) = cloud(message);
        let y = |point: &[u8]| f64::from(f32::from_le_bytes(point[4..8].try_into().unwrap()));
        data.chunks_exact(stride).map(y).fold(f64::INFINITY, f64::min)
    };
    let dots = &topics["/points/flesh/cube"];
    for (k, (_, message)) in dots.iter().enumerate() {
        assert!((lowest(message) - height(&flesh[k + 1].1)).abs() < 1e-6, "{k}");
    }
    let arrows = |message: &DynamicMessage| list(&list(message, "entities")[0], "arrows").len();
    assert_eq!(arrows(&topics["/forces"][0].1), 0);
    let landed = arrows(&topics["/forces"].last().unwrap().1);
    assert!(landed > 0, "it has landed");
    // An arrow and twelve points for each force that is seen.
    let (stride, data) = cloud(&topics["/points/forces"].last().unwrap().1);
    assert_eq!(data.len() / stride, 12 * landed);
    // A file that could not be finished leaves nothing.
    let refused = folder.thenar(&["replay", "soft-cube.rec", "--mcap", "no/such/folder.mcap"]);
    assert_ne!(refused.status.code(), Some(0));
    assert!(std::fs::read_dir(&folder.0).unwrap().count() == 2);
}
