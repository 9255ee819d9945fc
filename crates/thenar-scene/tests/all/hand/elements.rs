//! Goal: scenes choose how elements are evaluated. Method: a cantilever of cells against its closed
//! form, the paper's hand in a fist and on a table, and words that do not exist.

use std::path::Path;
use thenar_scene::session::{Session, builtin};

fn session(text: &str, overrides: &[String]) -> Session {
    Session::from_text(text, Path::new("test.toml"), overrides).unwrap_or_else(|e| panic!("{e}"))
}

/// Deflection of the end of a bar 100×20×20 mm of 100 kPa under 4 mN \[m\].
fn deflection(split: &str, elements: &str) -> f64 {
    let text = format!(
        r#"
version = 1
gravity = [0, 0, 0]
time_step = 10.0
[solver]
velocity_tolerance = 1e-12
[[soft]]
name = "bar"
shape = {{ kind = "lattice", size = [0.1, 0.02, 0.02], cells = [10, 2, 2], split = "{split}" }}
material = {{ young = 1e5, poisson = 0.3, density = 1000 }}
elements = "{elements}"
fixed = [{{ nodes = {{ side = "x-min" }} }}]
[[load]]
kind = "traction"
body = "bar"
faces = {{ side = "x-max" }}
total = [0, -0.004, 0]
"#
    );
    let mut session = session(&text, &[]);
    for _ in 0..20 {
        session.step(&mut ());
    }
    let nodes = session.world().nodes(0);
    let end: Vec<f64> = nodes.iter().filter(|x| x.x > 0.045).map(|x| x.y).collect();
    let top = end.iter().copied().fold(f64::MIN, f64::max);
    let bottom = end.iter().copied().fold(f64::MAX, f64::min);
    -(top + bottom) / 2.0
}

/// Hexahedra of 27 nodes give 1.016 mm, Timoshenko's cantilever with κ = 5/6 1.031 mm. Patches come
/// nearer to it than tetrahedra, whatever the cells are cut into, and are never softer. The six
/// tetrahedra of a cell are two patches.
#[test]
fn a_bar_of_two_cells_bends_farther_with_patches_and_no_farther_than_theory_says() {
    for split in ["kuhn", "five"] {
        let (single, patched) = (deflection(split, "tetrahedra"), deflection(split, "patches"));
        assert!(patched > 1.3 * single && patched < 1.016e-3, "{split}: {single} m, {patched} m");
    }
}

/// Tetrahedra inside out at the end of the first 1.5 s of a shipped scene.
fn inverted(name: &str, elements: &str) -> u32 {
    let text = builtin(name).expect("a shipped scene").text;
    let mut session =
        session(text, &["hand.hand.preset=paper".into(), format!("hand.hand.elements={elements}")]);
    let patched = usize::from(elements == "patches");
    assert_eq!(session.world().desc().patches.len(), patched);
    let mut inverted = 0;
    while session.world().time() < 1.5 {
        let report = session.step(&mut ());
        assert!(!report.non_finite && !report.fell_back, "{name}, {elements}: {report:?}");
        inverted = report.inverted_tets;
    }
    inverted
}

/// A fist turns four of the tetrahedra in the creases of 600 inside out, a press on a table none.
#[test]
fn hands_go_through_their_scenes_with_patches() {
    for name in ["fist", "table-press"] {
        assert!(inverted(name, "patches") <= inverted(name, "tetrahedra"), "{name}");
    }
}

#[test]
fn unknown_words_are_refused_with_those_that_exist() {
    let text = builtin("fist").expect("a shipped scene").text;
    let overrides = [r#"hand.hand.elements=hexahedra"#.to_owned()];
    let opened = Session::from_text(text, Path::new("fist.toml"), &overrides);
    let Err(error) = opened else { panic!("it was opened") };
    let error = error.to_string();
    assert!(error.contains("\"tetrahedra\"") && error.contains("\"patches\""), "{error}");
}
