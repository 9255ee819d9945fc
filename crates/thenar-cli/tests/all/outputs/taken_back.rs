//! Steps that are taken back end in exit code 1 and a line.

use crate::stage::{Folder, err, out};

/// A grain that 1e12 N would move by 1e15 m in a step: none succeeds.
const SCENE: &str = "version = 1\nduration = 0.1\n[[rigid]]\nname = \"a\"\n\
                     shape = { kind = \"sphere\", radius = 0.02 }\nmass = 1e-9\n\
                     [[load]]\nkind = \"force\"\nbody = \"a\"\nforce = [1e12, 0, 0]\n";

#[test]
fn a_run_whose_steps_are_taken_back_fails_quietly_or_not() {
    let folder = Folder::new("taken-back");
    std::fs::write(folder.0.join("l.toml"), SCENE).unwrap();
    let commands: [&[&str]; 6] = [
        &["run", "l.toml"],
        &["run", "l.toml", "-q"],
        &["record", "l.toml", "-o", "l.rec"],
        &["record", "l.toml", "-q", "-o", "q.rec"],
        &["replay", "l.rec"],
        &["replay", "l.rec", "--verify", "-q"],
    ];
    for command in commands {
        let output = folder.thenar(command);
        let told = err(&output);
        assert_eq!(output.status.code(), Some(1), "{command:?}: {told}");
        assert_eq!(told.lines().count(), 1, "{command:?}: {told}");
        assert!(
            told.contains("steps gave numbers that are not finite and were taken back"),
            "{told}"
        );
        assert!(told.contains("more than 1 %"), "{told}");
    }
    // The recording is whole and the same all the same.
    let replayed = folder.thenar(&["replay", "l.rec"]);
    assert!(out(&replayed).contains("the same bits in all"), "{}", out(&replayed));
}

#[test]
fn a_run_that_succeeds_does_not() {
    let folder = Folder::new("not-taken-back");
    std::fs::write(folder.0.join("l.toml"), SCENE.replace("1e12", "1e-12")).unwrap();
    for command in [
        &["run", "l.toml", "-q"][..],
        &["record", "l.toml", "-q"],
        &["replay", "l.rec", "--verify"],
    ] {
        let output = folder.thenar(command);
        assert!(output.status.success(), "{command:?}: {}", err(&output));
    }
}
