//! Goal: a hand at rest on something round presses it with the same force in every step. Method:
//! the default hand, and the paper's (on a ball, and alone at 1 ms and on meshes), come down on a
//! fixed body, a finger here and a palm there, and after they have come to rest the force of each
//! finger is compared from step to step.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::path::Path;
use thenar_scene::session::Session;

/// How long steps are compared, at the end \[s\].
const WATCHED: f64 = 0.2;
/// Largest change of a finger's normal force from one step to the next, over that force.
const FLICKER_MAX: f64 = 1e-3;
/// A finger that bears less is not felt \[N\].
const FELT: f64 = 0.05;

/// `reach` is where the wrist ends beside the middle of the body \[m\].
fn scene(preset: &str, shape: &str, reach: f64, h: f64) -> String {
    format!(
        r#"version = 1
time_step = {h}
duration = 1.6
[[rigid]]
name = "body"
shape = {{ {shape} }}
motion = "fixed"
position = [0, 0.15, 0]
[[hand]]
preset = "{preset}"
name = "hand"
friction = 0.8
[hand.motion]
kind = "keyframes"
[[hand.motion.key]]
time = 0
pose = "open"
wrist = {{ position = [{}, 0.15, 0.09], fingers = [0, 0, -1], back = [1, 0, 0] }}
[[hand.motion.key]]
time = 0.7
pose = "relaxed"
wrist = {{ position = [{reach}, 0.15, 0.09], fingers = [0, 0, -1], back = [1, 0, 0] }}
[[probe]]
name = "of"
measure = "fingers"
hand = "hand"
"#,
        reach + 0.055
    )
}

/// The largest relative change in the watched steps, and the force of all fingers \[N\].
fn flicker(text: &str) -> (f64, f64) {
    let mut session =
        Session::from_text(text, Path::new("test.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
    let columns = session.columns();
    let is_normal = |i: &usize| columns[*i].name.ends_with("normal");
    let normals: Vec<usize> = (0..columns.len()).filter(is_normal).collect();
    assert!(!normals.is_empty());
    let steps = session.steps_wanted();
    let watched = (WATCHED / session.world().time_step()).round() as u64;
    for _ in watched..steps {
        session.step(&mut ());
    }
    let forces = |session: &mut Session| -> Vec<f64> {
        let row = session.probe();
        normals.iter().map(|&i| row[i]).collect()
    };
    let mut before = forces(&mut session);
    let mut worst = 0.0_f64;
    for _ in 0..watched {
        session.step(&mut ());
        let now = forces(&mut session);
        for (a, b) in before.iter().zip(&now) {
            if a.max(*b) > FELT {
                worst = worst.max((a - b).abs() / a.max(*b));
            }
        }
        before = now;
    }
    (worst, before.iter().sum())
}

const BOTH: [&str; 2] = ["touch", "paper"];
const DEFAULT: [&str; 1] = ["touch"];

fn rests_quietly(presets: &[&str], shape: &str, reach: f64, steps: &[f64]) {
    for preset in presets {
        for &h in steps {
            let (flicker, force) = flicker(&scene(preset, shape, reach, h));
            let case = format!("{preset}, {shape} at {h} s");
            println!("{case}: {force:.2} N, {flicker:.1e}");
            // Joints as loose as those of the living close around a small ball with little.
            let least = if *preset == "paper" { 5.0 } else { 1.0 };
            assert!(force > least, "{case}: the fingers bear {force} N");
            assert!(flicker < FLICKER_MAX, "{case}: the force changes by {flicker:.1e}");
        }
    }
}

/// A mesh of rings about y, in a file, from its outline: distance from the axis and height \[m\],
/// from the top down.
fn mesh(name: &str, outline: &[(f64, f64)], stretch: f64) -> String {
    const AROUND: usize = 48;
    let mut text = String::new();
    for (radius, y) in outline {
        for j in 0..AROUND {
            let (s, c) = (TAU * j as f64 / AROUND as f64).sin_cos();
            writeln!(text, "v {} {y} {}", radius * c, stretch * radius * s).expect("a string");
        }
    }
    let at = |i: usize, j: usize| 1 + i * AROUND + j % AROUND;
    for i in 0..outline.len() - 1 {
        for j in 0..AROUND {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").expect("a string");
        }
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("resting-{name}.obj"));
    std::fs::write(&path, text).expect("a file");
    format!(r#"kind = "mesh", file = {path:?}"#)
}

/// From pole to pole, half as high as `height`.
fn arc(radius: f64, height: f64) -> Vec<(f64, f64)> {
    let at = |k: u32| (PI * f64::from(k) / 32.0).sin_cos();
    (0..=32).map(at).map(|(s, c)| (radius * s, height * c)).collect()
}

#[test]
fn on_meshes() {
    let outlines = [
        ("ball", arc(0.06, 0.06), 1.0),
        ("ellipsoid", arc(0.06, 0.08), 0.8),
        ("cylinder", vec![(0.0, 0.06), (0.06, 0.06), (0.06, -0.06), (0.0, -0.06)], 1.0),
    ];
    for (name, outline, stretch) in outlines {
        rests_quietly(&["paper"], &mesh(name, &outline, stretch), 0.075, &[0.005]);
    }
}

#[test]
fn at_1_ms() {
    rests_quietly(&["paper"], r#"kind = "sphere", radius = 0.06"#, 0.075, &[1e-3]);
}

#[test]
fn on_a_large_ball() {
    rests_quietly(&BOTH, r#"kind = "sphere", radius = 0.06"#, 0.075, &[0.005, 1.0 / 60.0]);
}

#[test]
fn on_a_small_ball() {
    rests_quietly(&DEFAULT, r#"kind = "sphere", radius = 0.025"#, 0.04, &[0.005, 1.0 / 60.0]);
}

#[test]
fn on_an_ellipsoid() {
    rests_quietly(&DEFAULT, r#"kind = "ellipsoid", size = [0.12, 0.16, 0.1]"#, 0.075, &[0.005]);
}

#[test]
fn on_a_capsule_and_a_cylinder() {
    rests_quietly(
        &DEFAULT,
        r#"kind = "capsule", radius = 0.05, length = 0.1"#,
        0.075,
        &[1.0 / 60.0],
    );
    rests_quietly(&DEFAULT, r#"kind = "cylinder", radius = 0.06, length = 0.12"#, 0.075, &[0.005]);
}
