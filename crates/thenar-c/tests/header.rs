//! Goal: the header that is committed is the one that the sources make, and a program in C that is
//! built with it alone runs. Method: cbindgen again, and the machine's own `cc`.

use std::path::{Path, PathBuf};
use std::process::Command;

fn here() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The header as the sources have it now.
fn made() -> String {
    let config =
        cbindgen::Config::from_file(here().join("cbindgen.toml")).expect("a configuration");
    let bindings = cbindgen::Builder::new()
        .with_config(config)
        .with_crate(here())
        .generate()
        .expect("sources that cbindgen reads");
    let mut header = Vec::new();
    bindings.write(&mut header);
    String::from_utf8(header).expect("UTF-8")
}

#[test]
fn the_header_is_that_of_the_sources() {
    let file = here().join("include/thenar.h");
    let made = made();
    if std::env::var_os("THENAR_UPDATE").is_some() {
        std::fs::write(&file, &made).expect("written");
    }
    let committed = std::fs::read_to_string(&file).unwrap_or_default();
    assert!(committed == made, "include/thenar.h is stale: run this test with THENAR_UPDATE=1");
    // Every exported function is in it, whatever cbindgen makes of attributes.
    for source in std::fs::read_dir(here().join("src")).expect("sources") {
        let text = std::fs::read_to_string(source.expect("a file").path()).expect("text");
        for line in text.lines().filter(|line| line.contains("extern \"C\" fn thenar_")) {
            let name = line.split("fn ").nth(1).and_then(|rest| rest.split('(').next());
            let name = name.expect("a name");
            assert!(made.contains(&format!("{name}(")), "{name} is not in the header");
        }
    }
}

/// Builds a C file against the static library, with every warning an error, and returns the
/// program.
fn build(source: &str, name: &str) -> PathBuf {
    // It was built with this test, and lies beside it.
    let library = std::env::current_exe().expect("a place").with_file_name("libthenar_c.a");
    let program = std::env::temp_dir().join(format!("thenar-c-{}-{name}", std::process::id()));
    let done = Command::new("cc")
        .args(["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1", "-I"])
        .arg(here().join("include"))
        .arg(here().join(source))
        .arg("-o")
        .arg(&program)
        .arg(&library)
        .args(["-lpthread", "-ldl", "-lm"])
        .output()
        .expect("a C compiler, as `cc`");
    let words = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{source}: {words}");
    program
}

fn run(program: &Path) -> String {
    let done = Command::new(program).output().expect("it starts");
    std::fs::remove_file(program).expect("removed");
    let (out, words) =
        (String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
    assert!(done.status.success(), "{:?}\n{out}\n{words}", done.status);
    out.into_owned()
}

#[cfg(unix)]
#[test]
fn the_example_presses_a_table_and_follows_a_pose() {
    let out = run(&build("examples/press.c", "press"));
    let number = |line: &str| -> f64 {
        let found = out.lines().find_map(|l| l.strip_prefix(line));
        let word = found.and_then(|rest| rest.split_whitespace().next());
        word.and_then(|word| word.trim_end_matches(',').parse().ok())
            .unwrap_or_else(|| panic!("no `{line}` in\n{out}"))
    };
    // The same forces by the session itself, which needs no border.
    let set = ["hand.0.preset=\"paper\"", "time_step=0.01"].map(str::to_owned);
    let scene = thenar_scene::session::builtin("table-press").expect("it comes along");
    let file = Path::new("scenes/table-press.toml");
    let mut session =
        thenar_scene::session::Session::from_text(scene.text, file, &set).expect("a scene");
    for _ in 0..150 {
        session.step(&mut ());
    }
    let normal: f64 = session.hand_loads(0).iter().map(|load| load.figures()[0]).sum();
    assert!(normal > 1.0, "{normal} N");
    assert!((number("pressed with") - normal).abs() < 1e-3, "{normal} N\n{out}");
    assert_eq!(number("contacts") as usize, session.world().contacts().len());
    // The example asks the wrist to go up by 40 mm, and half a second is time enough.
    assert!((number("wrist rose by") - 40.0).abs() < 2.0, "{out}");
    assert!(
        out.contains("thumb") && out.contains("refused: there is no hand 7: there are 1"),
        "{out}"
    );
}

#[cfg(unix)]
#[test]
fn wrong_calls_are_refused_and_change_nothing() {
    let out = run(&build("tests/refusals.c", "refusals"));
    assert!(out.ends_with("all refused\n"), "{out}");
}
