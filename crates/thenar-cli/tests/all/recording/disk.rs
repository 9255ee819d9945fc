//! A disk that is full looks like a file that may grow no further: writing fails part of the way.

use crate::stage::{Folder, Running, err, out, state};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Command, Output, Stdio};

/// A bare hand, which a glove moves.
const HAND: &str =
    "version = 1\ntime_step = 0.01\n[[hand]]\npreset = \"paper\"\nname = \"hand\"\nflesh = false\n";

/// The program, whose files may take 64 or 128 kB, as the shell counts.
fn cramped(folder: &Folder, args: &str) -> Command {
    let program = env!("CARGO_BIN_EXE_thenar");
    let script = format!("ulimit -f 128; exec '{program}' {args}");
    let mut command = Command::new("sh");
    command
        .args(["-c", &script])
        .current_dir(&folder.0)
        .env("THENAR_CONFIG", folder.0.join("none"));
    command
}

/// Steps and ticks that a replay finds in a file that ends early.
fn found(folder: &Folder, file: &str) -> (u64, usize) {
    let replayed = folder.thenar(&["replay", file, "--csv", "t.csv"]);
    assert!(replayed.status.success(), "{}", err(&replayed));
    let text = out(&replayed);
    let steps = text.split("the same bits in all ").nth(1).and_then(|t| t.split(' ').next());
    (
        steps.unwrap_or_else(|| panic!("{text}")).parse().unwrap(),
        folder.text("t-1-haptic.csv").lines().count(),
    )
}

#[track_caller]
fn assert_told(output: &Output, file: &str) {
    let told = err(output);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert_eq!(told.matches("File too large").count(), 1, "{told}");
    assert!(told.contains(&format!("warning: {file} goes no further")), "{told}");
    assert!(told.contains(&format!("{file} ends before the session does")), "{told}");
}

#[test]
fn when_the_disk_is_full_the_run_goes_on_and_the_file_is_good_up_to_there() {
    let folder = Folder::new("full");
    let run = |args: &str| cramped(&folder, args).output().unwrap();
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

/// Ticks of the haptic loop fill the file within a second; loop and simulation go on.
#[test]
fn when_the_disk_is_full_whoever_touches_goes_on_touching() {
    let folder = Folder::new("full-touch");
    std::fs::write(folder.0.join("hand.toml"), HAND).unwrap();
    let args = "touch hand.toml --device simulated --seconds 5 --record t.rec";
    let touched = cramped(&folder, args).output().unwrap();
    assert_told(&touched, "t.rec");
    let (steps, ticks) = found(&folder, "t.rec");
    assert!(steps > 3 && ticks > 100, "{steps} {ticks}");
    // The loop made many more than the file has: the report counts them.
    let report = out(&touched);
    assert!(report.lines().count() > 5, "{report}");
    let made = report.split(" ticks").next().and_then(|t| t.split_whitespace().last());
    let made: usize = made.and_then(|t| t.replace(',', "").parse().ok()).unwrap_or(0);
    assert!(made > 2 * ticks, "{made} of {ticks}: {report}");
}

#[test]
fn when_the_disk_is_full_the_page_is_served_on() {
    let folder = Folder::new("full-serve");
    std::fs::write(folder.0.join("hand.toml"), HAND).unwrap();
    // With a device nobody needs to watch.
    let args = "serve hand.toml --device simulated --no-open --record s.rec";
    let child = cramped(&folder, args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let mut server = Running(child.unwrap());
    let mut lines = BufReader::new(server.0.stdout.take().unwrap()).lines().map_while(Result::ok);
    let address = lines
        .find_map(|l| Some(l.trim().strip_prefix("http://")?.trim_end_matches('/').to_string()));
    let address = address.unwrap();
    let mut errors = BufReader::new(server.0.stderr.take().unwrap()).lines().map_while(Result::ok);
    let mut told: Vec<String> = Vec::new();
    while !told.last().is_some_and(|line| line.contains("s.rec goes no further")) {
        told.push(errors.next().expect("a warning, while it runs"));
    }
    // It answers as before.
    let mut page = TcpStream::connect(&address).unwrap();
    write!(page, "GET / HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    page.take(12).read_to_string(&mut answer).unwrap();
    assert_eq!(answer, "HTTP/1.1 200");
    assert!(server.0.try_wait().unwrap().is_none());

    let id = server.0.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let status = server.0.wait().unwrap();
    let stderr = told.into_iter().chain(errors).collect::<Vec<_>>().join("\n").into_bytes();
    assert_told(&Output { status, stdout: Vec::new(), stderr }, "s.rec");
    let (steps, ticks) = found(&folder, "s.rec");
    assert!(steps > 3 && ticks > 100, "{steps} {ticks}");
}
