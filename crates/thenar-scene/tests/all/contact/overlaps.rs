//! Goal: what a scene starts inside each other is told when it is opened: pair, depth and place.
//! Method: bodies put so deep into each other that geometry gives the answer, and two hands about a
//! ball above a table that one little finger reaches.

use std::path::Path;
use thenar_scene::session::{Session, StartOverlap, builtins};

fn overlaps(text: &str) -> Vec<StartOverlap> {
    let text = format!("version = 1\ntime_step = 0.005\n{text}");
    let session = Session::from_text(&text, Path::new("test.toml"), &[]);
    session.unwrap_or_else(|e| panic!("{e}")).start_overlaps().to_vec()
}

const TABLE: &str = "
    [[rigid]]
    name = \"table\"
    shape = { kind = \"plane\" }
    motion = \"fixed\"";

/// A ball of 20 mm radius, so deep in the table \[m\].
fn ball(depth: f64) -> String {
    let height = 0.02 - depth;
    format!(
        "{TABLE}
        [[rigid]]
        name = \"ball\"
        shape = {{ kind = \"sphere\", radius = 0.02 }}
        mass = 0.1
        position = [0.3, {height}, -0.1]"
    )
}

/// A soft cube of 20 mm with four cells along each edge, so deep in the table \[m\].
fn cube(depth: f64) -> String {
    let height = 0.01 - depth;
    format!(
        "{TABLE}
        [[soft]]
        name = \"cube\"
        shape = {{ kind = \"lattice\", size = [0.02, 0.02, 0.02], cells = [4, 4, 4] }}
        position = [0, {height}, 0]"
    )
}

#[test]
fn pair_depth_and_place_are_told() {
    let told = overlaps(&ball(0.003));
    assert_eq!(told.len(), 1, "{told:?}");
    let StartOverlap { bodies, depth, place_W } = &told[0];
    let mut names = bodies.clone();
    names.sort();
    assert_eq!(names, ["ball", "table"]);
    assert!((depth - 0.003).abs() < 1e-9, "{depth}");
    assert!((place_W.x - 0.3).abs() < 1e-9 && (place_W.z + 0.1).abs() < 1e-9, "{place_W}");
    assert!((-0.003 - 1e-9..=1e-9).contains(&place_W.y), "between the surfaces: {place_W}");
    let line = told[0].to_string();
    assert!(line.contains("ball") && line.contains("table") && line.contains("3.000 mm"), "{line}");
    assert!(line.contains("0.3000") && line.contains("-0.1000] m"), "{line}");
}

#[test]
fn what_touches_does_not_overlap() {
    for apart in [-0.01, 0.0, 9e-6] {
        assert_eq!(overlaps(&ball(apart)), [], "{apart} m deep");
    }
    assert_eq!(overlaps(&ball(11e-6)).len(), 1);
    // Triangles have edges of 5, 5 and 7.07 mm, on the mean 5.69 mm: 57 um is a hundredth.
    assert_eq!(overlaps(&cube(50e-6)), []);
    let told = overlaps(&cube(64e-6));
    assert_eq!(told.len(), 1, "{told:?}");
    assert!((told[0].depth - 64e-6).abs() < 1e-9, "{told:?}");
}

#[test]
fn what_never_touches_does_not_overlap() {
    let pair = "
        [[pair]]
        bodies = [\"ball\", \"table\"]
        contact = false";
    assert_eq!(overlaps(&format!("{}{pair}", ball(0.003))), []);
}

#[test]
fn the_deepest_pair_comes_first() {
    let second = "
        [[rigid]]
        name = \"box\"
        shape = { kind = \"box\", size = [0.02, 0.02, 0.02] }
        mass = 0.1
        position = [0, 0.004, 0]";
    let told = overlaps(&format!("{}{second}", ball(0.003)));
    assert_eq!(told.len(), 2, "{told:?}");
    assert!((told[0].depth - 0.006).abs() < 1e-9 && told[0].bodies.contains(&"box".into()));
    assert!((told[1].depth - 0.003).abs() < 1e-9 && told[1].bodies.contains(&"ball".into()));
}

/// Open hands on both sides of a ball, thumbs up; the larger one's little finger reaches below the
/// table's surface.
#[test]
fn a_finger_in_a_table_is_named() {
    let hand = |name: &str, model: &str, length: f64, side: f64| {
        format!(
            "
            [[hand]]
            preset = \"paper\"
            name = \"{name}\"
            model = \"{model}\"
            length = {length}
            [hand.motion]
            kind = \"keyframes\"
            [[hand.motion.key]]
            time = 0
            pose = \"open\"
            wrist = {{ position = [{}, 0.15, 0.09], fingers = [0, 0, -1], back = [{side}, 0, 0] }}",
            0.13 * side
        )
    };
    let scene = |height: f64| {
        format!(
            "{}{}
            [[rigid]]
            name = \"ball\"
            shape = {{ kind = \"sphere\", radius = 0.06 }}
            mass = 0.3
            position = [0, 0.15, 0]
            [[rigid]]
            name = \"table\"
            shape = {{ kind = \"plane\" }}
            motion = \"fixed\"
            position = [0, {height}, 0]",
            hand("r", "right", 0.21, 1.0),
            hand("l", "left", 0.16, -1.0)
        )
    };
    let told = overlaps(&scene(0.09));
    assert_eq!(told.len(), 1, "{told:?}");
    let mut names = told[0].bodies.clone();
    names.sort();
    assert_eq!(names, ["r (little)", "table"]);
    // The lowest point of that hand, by its distance from the table.
    let free = scene(0.0);
    let text = format!("version = 1\ntime_step = 0.005\n{free}");
    let session = Session::from_text(&text, Path::new("test.toml"), &[]).unwrap();
    assert_eq!(session.start_overlaps(), []);
    let soft = session.hands().iter().find(|h| h.name == "r").unwrap().flesh().unwrap();
    let vertices = session.world().collision_vertices(soft);
    let lowest = vertices.iter().map(|x| x.y).fold(f64::INFINITY, f64::min);
    assert!((told[0].depth - (0.09 - lowest)).abs() < 1e-9, "{} {lowest}", told[0].depth);
}

#[test]
fn no_shipped_scene_begins_with_an_overlap() {
    for scene in builtins() {
        let file = format!("{}.toml", scene.name);
        let session = Session::from_text(scene.text, Path::new(&file), &[]).unwrap();
        assert_eq!(session.start_overlaps(), [], "{}", scene.name);
    }
}
