//! Goal: every output of every command is complete or not there, replaces nothing but plain files,
//! and leaves nothing behind whatever signal comes when. Method: the program is run as a user runs
//! it, and its folder looked at.

#[cfg(unix)]
mod signals;
mod taken_back;
#[cfg(unix)]
mod targets;

use crate::stage::{Folder, err};
use std::path::Path;

/// Names in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Every command with an output, up to the name of the output; `r.rec` and `t.obj` are there.
const COMMANDS: [&[&str]; 15] = [
    &["run", "finger-pendulum", "--seconds", "0.001", "-q", "--probe"],
    &["run", "finger-pendulum", "--seconds", "0.001", "-q", "--report"],
    &["run", "finger-pendulum", "--seconds", "0.001", "-q", "--size", "8x8", "--picture"],
    &["run", "finger-pendulum", "--seconds", "0.001", "-q", "--size", "8x8", "--movie"],
    &["replay", "r.rec", "-q", "--csv"],
    &["replay", "r.rec", "-q", "--mcap"],
    &["build", "t.obj", "--rigid", "-o"],
    &["build", "left", "--hand", "--tets", "100", "-o"],
    &["build", "left", "--hand", "--tets", "100", "--glb"],
    &["build", "left", "--hand", "--tets", "100", "--json"],
    &["compare", "finger-pendulum", "--seconds", "0.001", "-q", "--csv"],
    &["compare", "finger-pendulum", "--seconds", "0.001", "-q", "--svg"],
    &["compare", "finger-pendulum", "--seconds", "0.001", "-q", "--report"],
    &["haptics", "map", "--human", "0.05,10,50", "--rates", "1000", "--delays", "0", "--svg"],
    &["validate", "--case", "A1", "--json"],
];

/// A folder with what the commands read.
fn stocked(name: &str) -> Folder {
    let folder = Folder::new(name);
    let obj = "v 0 0 0\nv 0.06 0 0\nv 0 0.06 0\nv 0 0 0.06\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    std::fs::write(folder.0.join("t.obj"), obj).unwrap();
    let recorded =
        folder.thenar(&["record", "finger-pendulum", "--seconds", "0.001", "-q", "-o", "r.rec"]);
    assert!(recorded.status.success(), "{}", err(&recorded));
    folder
}

#[test]
fn an_input_or_another_output_is_never_replaced() {
    let folder = stocked("over");
    let scene = "version = 1\nduration = 0.01\n[[rigid]]\nname = \"r\"\nmass = 1\n\
                 shape = { kind = \"mesh\", file = \"t.obj\" }\n\
                 [[probe]]\nname = \"r\"\nmeasure = \"velocity\"\nbody = \"r\"\n";
    std::fs::write(folder.0.join("s.toml"), scene).unwrap();
    let before: Vec<_> = ["s.toml", "t.obj", "r.rec"].map(|f| folder.0.join(f)).into();
    let contents = || before.iter().map(|f| std::fs::read(f).unwrap()).collect::<Vec<_>>();
    let old = contents();
    let run = ["run", "s.toml", "-q"];
    let cases: [(&[&str], &str); 10] = [
        (&["--report", "s.toml"], "s.toml: it is an input"),
        (&["--probe", "t.obj"], "t.obj: it is an input"),
        (&["--probe", "./s.toml"], "s.toml: it is an input"),
        (&["--picture", "./s.toml"], "ends in .png, not .toml"),
        (&["--record", "s.toml"], "s.toml"),
        (&["--report", "x", "--probe", "x"], "x: two outputs"),
        (&["--report", "x", "--picture", "./x"], "x: two outputs"),
        (&["--movie", "x", "--picture", "x"], "x: two outputs"),
        (&["--report", "x", "--record", "x"], "x: two outputs"),
        (&["--frames", "f", "--picture", "f/frame-000000.png"], "frame-000000.png: two outputs"),
    ];
    for (args, told) in cases {
        let output = folder.thenar(&[&run[..], args].concat());
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", err(&output));
        assert_eq!(err(&output).lines().count(), 1, "{}", err(&output));
        assert!(err(&output).contains(told), "{args:?}: {}", err(&output));
    }
    for args in [
        &["replay", "r.rec", "--csv", "r.rec"][..],
        &["replay", "r.rec", "--mcap", "x", "--csv", "x"],
        &["build", "t.obj", "--rigid", "-o", "t.obj"],
        &["compare", "s.toml", "--report", "s.toml"],
    ] {
        let output = folder.thenar(args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", err(&output));
    }
    let _ = std::fs::remove_dir(folder.0.join("f"));
    assert_eq!(names(&folder.0), ["r.rec", "s.toml", "t.obj"]);
    assert!(contents() == old);
}
