//! Goal: `record`, `run --record`, `serve --record`, `touch --record` and `replay` keep their
//! promises: the same bits, usable files after `kill -9` and on a full disk, exit codes, whole
//! tables. Method: the program is run as a user runs it.

#[cfg(unix)]
mod disk;
mod mcap_file;
mod show;
mod verify;

use crate::stage::{Folder, Running, err, out, state, wait_for};
use std::process::Stdio;

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
