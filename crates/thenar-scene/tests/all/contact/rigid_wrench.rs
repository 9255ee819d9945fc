//! Goal: in slow motion the net force and torque between two rigid bodies follow position without
//! flicker. Method: an arm that turns about a hinge, as a record player's, rests with its tip on a
//! body that is moved under it at 20 mm/s, at 1 ms steps. Expected from statics: the weight's
//! moment about the hinge is that of what presses on the tip, within what it takes to turn the arm;
//! less than 0.5 % of the force is above 50 Hz, and half the speed halves the largest change of
//! force and torque in a step.

use super::force_spectrum::{above_50_hz, largest_change};
use std::fmt::Write as _;
use std::path::Path;
use thenar_core::Vec3;
use thenar_core::model::BodyId;
use thenar_rig::mesh::shapes;
use thenar_scene::session::Session;
use thenar_testing::one_in;

const H: f64 = 1e-3;
const SPEED: f64 = 0.02;
/// Way of the body below \[m\], and when it begins \[s\].
const WAY: f64 = 0.008;
const MOVES: f64 = 0.3;
/// From the hinge's axis to the middle of the tip \[m\], and the arm's weight \[N\].
const ARM: f64 = 0.1;
const WEIGHT: f64 = 0.1 * 9.81;

/// The tip: its shape, its rotation, and how far its lowest point lies below its middle \[m\].
type Tip<'a> = (&'a str, &'a str, f64);

const LEVEL: &str = "{ axis = [0, 0, 1], angle = 0 }";

const TIPS: [Tip<'static>; 9] = [
    (r#"{ kind = "sphere", radius = 0.01 }"#, LEVEL, 0.01),
    (r#"{ kind = "ellipsoid", size = [0.03, 0.012, 0.02] }"#, LEVEL, 0.006),
    // Along z, and leaning by 30°, on its end.
    (
        r#"{ kind = "capsule", radius = 0.004, length = 0.02 }"#,
        "{ axis = [1, 0, 0], angle_deg = 90 }",
        0.004,
    ),
    (
        r#"{ kind = "capsule", radius = 0.004, length = 0.02 }"#,
        "{ axis = [0, 0, 1], angle_deg = 30 }",
        0.004 + 0.01 * 0.866_025,
    ),
    // On its rim.
    (
        r#"{ kind = "cylinder", radius = 0.006, length = 0.02 }"#,
        "{ axis = [0, 0, 1], angle_deg = 30 }",
        0.01 * 0.866_025 + 0.006 * 0.5,
    ),
    // On its tip.
    (
        r#"{ kind = "cone", radius = 0.01, height = 0.02 }"#,
        "{ axis = [0, 0, 1], angle_deg = 180 }",
        0.015,
    ),
    // On a corner, and on an edge across the arm.
    (
        r#"{ kind = "box", size = [0.02, 0.02, 0.02] }"#,
        "{ axis = [-1, 0, 1], angle_deg = 54.7356 }",
        0.0173205,
    ),
    (
        r#"{ kind = "box", size = [0.02, 0.02, 0.02] }"#,
        "{ axis = [0, 0, 1], angle_deg = 40 }",
        0.01 * (0.766_044 + 0.642_788),
    ),
    // On its side, along z.
    (
        r#"{ kind = "cone", radius = 0.01, height = 0.02 }"#,
        "{ axis = [0.6015010, 0.3717480, 0.6015010], angle_deg = 136.353073 }",
        0.006708204,
    ),
];

/// Tips that touch a plane along a line.
const LINES: [usize; 3] = [2, 7, ON_ITS_SIDE];
const ON_ITS_SIDE: usize = 8;
const ALL: Vec3 = Vec3::new(1.0, 1.0, 1.0);

/// A level plate of triangles, 60 mm square, top at half its height of 4 mm.
fn mesh_plate(cells: usize) -> String {
    let n = cells + 1;
    let mut text = String::new();
    for y in [0.002, -0.002] {
        for i in 0..n {
            for k in 0..n {
                let at = |i: usize| 0.06 * (i as f64 / cells as f64 - 0.5);
                writeln!(text, "v {} {y} {}", at(i), at(k)).expect("a string");
            }
        }
    }
    let at = |layer: usize, i: usize, k: usize| 1 + layer * n * n + i * n + k;
    let mut quad = |[a, b, c, d]: [usize; 4]| {
        writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").expect("a string");
    };
    for i in 0..cells {
        for k in 0..cells {
            quad([at(0, i, k), at(0, i, k + 1), at(0, i + 1, k + 1), at(0, i + 1, k)]);
            quad([at(1, i, k), at(1, i + 1, k), at(1, i + 1, k + 1), at(1, i, k + 1)]);
        }
        quad([at(0, i, 0), at(0, i + 1, 0), at(1, i + 1, 0), at(1, i, 0)]);
        quad([at(0, i + 1, cells), at(0, i, cells), at(1, i, cells), at(1, i + 1, cells)]);
        quad([at(0, 0, i + 1), at(0, 0, i), at(1, 0, i), at(1, 0, i + 1)]);
        quad([at(0, cells, i), at(0, cells, i + 1), at(1, cells, i + 1), at(1, cells, i)]);
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("wrench-plate-{cells}.obj"));
    std::fs::write(&path, text).expect("a file");
    format!("{{ kind = \"mesh\", file = {path:?} }}")
}

/// Force \[N\] and torque \[N m\] on the tip about where it is first, at every step on the way.
fn wrenches(tip: Tip<'_>, below: &str, top: f64, way: Vec3, speed: f64) -> Vec<[Vec3; 2]> {
    let (shape, rotation, reach) = tip;
    let end = MOVES + way.norm() / speed;
    let key = |time: f64, at: Vec3| {
        let at = <[f64; 3]>::from(at - Vec3::y() * top);
        format!("{{ time = {time:e}, position = {at:?} }},\n")
    };
    let text = format!(
        r#"version = 1
time_step = {H}
duration = {end}
[[rigid]]
name = "tip"
shape = {shape}
rotation = {rotation}
position = [0, {reach}, 0]
mass = 0.1
inertia = [1e-5, 1e-5, 1e-5]
friction = 0.3
[[joint]]
name = "hinge"
kind = "hinge"
child = "tip"
anchor = [{}, {}, 0]
axis = [0, 0, 1]
[[rigid]]
name = "below"
shape = {below}
motion = "scripted"
friction = 0.3
interpolation = "linear"
keyframes = [
{}{}{}]
"#,
        -ARM,
        reach + 0.01,
        key(0.0, way * -0.5),
        key(MOVES, way * -0.5),
        key(end, way * 0.5),
    );
    let mut session = Session::from_text(&text, Path::new("arm.toml"), &[])
        .unwrap_or_else(|error| panic!("{error}\n{text}"));
    let find = |name: &str| session.world().desc().rigids.iter().position(|r| r.name == name);
    let tip = BodyId::Rigid(find("tip").expect("a tip") as u32);
    let mut found = Vec::new();
    for k in 1..=(end / H).round() as usize {
        session.step(&mut ());
        // Friction has built up.
        if k as f64 * H > MOVES + 0.15 * way.norm() / speed {
            let mut wrench = [Vec3::zeros(); 2];
            for c in session.world().contacts() {
                let sign = if c.bodies[0] == tip { 1.0 } else { -1.0 };
                wrench[0] += c.force_W * sign;
                wrench[1] += c.position_W.cross(&c.force_W) * sign;
            }
            found.push(wrench);
        }
    }
    found
}

/// `seen` are the axes about which torques are looked at.
fn check(tip: Tip<'_>, below: &str, top: f64, seen: Vec3) {
    check_changes(tip, below, top, Some(seen));
}

/// Where faces lie on each other, rigid bodies leave open where between them they press, and so
/// with which lever: only with `seen` are changes looked at.
fn check_changes(tip: Tip<'_>, below: &str, top: f64, seen: Option<Vec3>) {
    for way in [Vec3::x() * WAY, Vec3::z() * WAY, Vec3::new(0.6, 0.0, -0.8) * WAY] {
        let case = format!("{} on {below}, along {way:?}", tip.0);
        let [mut fast, mut slow] = [SPEED, 0.5 * SPEED].map(|v| wrenches(tip, below, top, way, v));
        let force: Vec<Vec3> = fast.iter().map(|w| w[0]).collect();
        let hinge = Vec3::new(-ARM, tip.2 + 0.01, 0.0);
        for [f, torque] in &fast {
            let moment = (torque - hinge.cross(f)).z;
            assert!(
                (moment / (WEIGHT * ARM) - 1.0).abs() < 0.05,
                "{case}: {moment} N m about the hinge, {} of the weight",
                WEIGHT * ARM
            );
        }
        let high = above_50_hz(&force);
        for [_, torque] in fast.iter_mut().chain(&mut slow) {
            torque.component_mul_assign(&seen.unwrap_or_else(Vec3::zeros));
        }
        let [fast, slow] = [fast, slow].map(|w| largest_change(&w));
        println!("{case}: {:.4} % above 50 Hz, {fast:?} to {slow:?} in a step", 100.0 * high);
        if seen.is_none() {
            // On a level face no force is sideways but that of friction.
            let pushed = |f: &Vec3| f.xz().norm() > 0.301 * f.y + 1e-6;
            assert!(!force.iter().any(pushed), "{case}: pushed aside");
            continue;
        }
        assert!(high < 5e-3, "{case}: {} % above 50 Hz", 100.0 * high);
        for k in 0..2 {
            // What acts is found to a hundredth of a promille at least.
            let least = WEIGHT * [1.0, ARM][k] * 1e-5;
            assert!(
                slow[k] < (0.75 * fast[k]).max(least),
                "{case}: {fast:?} to {slow:?} in a step"
            );
        }
    }
}

#[test]
fn tips_are_drawn_over_a_plate() {
    for tip in TIPS {
        check(tip, r#"{ kind = "box", size = [0.06, 0.004, 0.06] }"#, 0.002, ALL);
    }
}

/// Level triangles are one plane, whatever is drawn over them. What touches along a line stands on
/// as many places as there are triangles, and the hinge bears whatever torque they leave about the
/// other axes.
#[test]
fn tips_are_drawn_over_plates_of_triangles() {
    for cells in [1, 9] {
        for (i, tip) in TIPS.into_iter().enumerate() {
            let seen = match i {
                // Along a cone's side places on triangles are off the line by up to 32 µm.
                ON_ITS_SIDE => Vec3::zeros(),
                _ if LINES.contains(&i) => Vec3::z(),
                _ => ALL,
            };
            check(tip, &mesh_plate(cells), 0.002, seen);
        }
    }
}

#[test]
fn tips_are_drawn_over_round_bodies() {
    for below in [
        r#"{ kind = "sphere", radius = 0.06 }"#,
        r#"{ kind = "ellipsoid", size = [0.16, 0.12, 0.1] }"#,
    ] {
        for tip in TIPS {
            check(tip, below, 0.06, ALL);
        }
    }
}

fn stl(name: &str, mesh: &thenar_rig::TriMesh) -> String {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, thenar_rig::mesh::write_stl(mesh)).expect("a file");
    format!("{{ kind = \"mesh\", file = {path:?} }}")
}

/// Level triangles beside a flat body are no step in its way, nor are the vertices under its own:
/// on flat faces, on what is composed, and on what is made of triangles itself.
#[test]
fn flat_composed_and_meshed_tips_are_drawn_over_plates() {
    let dumbbell = r#"{ kind = "compound", parts = [
        { shape = { kind = "sphere", radius = 0.008 }, frame = { position = [0, 0, 0.01] } },
        { shape = { kind = "sphere", radius = 0.008 }, frame = { position = [0, 0, -0.01] } },
        { shape = { kind = "capsule", radius = 0.004, length = 0.02 }, frame = { rotation = { axis = [1, 0, 0], angle_deg = 90 } } },
    ] }"#;
    let ball = stl("wrench-ball.stl", &shapes::sphere(0.01, 12));
    let cube = stl("wrench-cube.stl", &shapes::cuboid(&Vec3::repeat(0.01)));
    let flat: [Tip<'_>; 3] = [
        (r#"{ kind = "box", size = [0.02, 0.02, 0.02] }"#, LEVEL, 0.01),
        (r#"{ kind = "cylinder", radius = 0.006, length = 0.02 }"#, LEVEL, 0.01),
        (&cube, LEVEL, 0.01),
    ];
    let tips: [Tip<'_>; 4] = [
        (dumbbell, LEVEL, 0.008),
        (&ball, LEVEL, 0.01),
        (&cube, "{ axis = [-1, 0, 1], angle_deg = 54.7356 }", 0.0173205),
        (&cube, "{ axis = [0, 0, 1], angle_deg = 40 }", 0.01 * (0.766_044 + 0.642_788)),
    ];
    let plain = r#"{ kind = "box", size = [0.06, 0.004, 0.06] }"#;
    let plates = [plain, &mesh_plate(1), &mesh_plate(9)];
    let tips = flat.map(|tip| (tip, true)).into_iter().chain(tips.map(|tip| (tip, false)));
    let all = tips.flat_map(|tip| plates.map(|below| (tip, below)));
    for ((tip, is_flat), below) in one_in(2, all) {
        match is_flat {
            true => check_changes(tip, below, 0.002, None),
            false => check(tip, below, 0.002, Vec3::z()),
        }
    }
}

/// Where its path bends with the faces below, a tip turns within a step, and what turns it adds to
/// its weight; in between nothing else does, be it smooth, sharp or pointed: edges between vertices
/// hold it.
#[test]
fn tips_are_drawn_over_a_ball_of_triangles() {
    let mesh = shapes::sphere(0.06, 24);
    let normal = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        (b - a).cross(&(c - a)).normalize()
    };
    let shared = |a: &[u32; 3], b: &[u32; 3]| a.iter().filter(|v| b.contains(v)).count();
    // Of the triangles around one vertex, whichever two share an edge.
    let top = |t: &&[u32; 3]| t.iter().any(|&v| mesh.positions[v as usize].y > 0.058);
    let near: Vec<_> = mesh.triangles.iter().filter(top).collect();
    let bends = near.iter().flat_map(|a| near.iter().map(move |b| (a, b)));
    let bend = bends
        .filter(|(a, b)| shared(a, b) == 2)
        .map(|(a, b)| normal(a).cross(&normal(b)).norm())
        .fold(0.0, f64::max);
    assert!(bend > 0.03 && bend < 0.07, "{bend} rad");
    // Faces on either side of a vertex of six are three apart.
    let turned = 0.1 * 3.0 * bend * SPEED / H / WEIGHT;
    let below = stl("wrench-ball-below.stl", &mesh);
    let cube = stl("wrench-cube-tip.stl", &shapes::cuboid(&Vec3::repeat(0.01)));
    let on_edge: Tip<'_> = (&cube, TIPS[7].1, TIPS[7].2);
    let ways = [Vec3::x() * WAY, Vec3::z() * WAY, Vec3::new(0.6, 0.0, -0.8) * WAY];
    let tips = TIPS.into_iter().chain([on_edge]);
    for (tip, way) in one_in(2, tips.flat_map(|tip| ways.map(|way| (tip, way)))) {
        let hinge = Vec3::new(-ARM, tip.2 + 0.01, 0.0);
        let found = wrenches(tip, &below, 0.06, way, SPEED);
        let moments = found.iter().map(|[f, torque]| (torque - hinge.cross(f)).z);
        let offs: Vec<f64> = moments.map(|m| (m / (WEIGHT * ARM) - 1.0).abs()).collect();
        let off = offs.iter().copied().fold(0.0, f64::max);
        let turning = offs.iter().filter(|off| **off > 0.05).count();
        let force: Vec<Vec3> = found.iter().map(|w| w[0]).collect();
        let high = above_50_hz(&force);
        println!("{} along {way:?}: {off:.3} off, {:.3} % above 50 Hz", tip.0, 100.0 * high);
        assert!(off < 0.05 + turned, "{} along {way:?}: {off} off", tip.0);
        // Triangles are 3 mm wide: it passes no more than ten bends.
        assert!(turning <= 20, "{} along {way:?}: off in {turning} steps", tip.0);
    }
}
