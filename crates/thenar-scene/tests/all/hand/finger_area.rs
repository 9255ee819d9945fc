//! Goal: the area that is reported of a finger is that of its patch. Method: the default hand, and
//! the paper's, come down with their index finger first, slowly, on a plate, and the default one on
//! a ball, a cylinder and an edge that stand where it met the plate; when it presses with a few
//! newtons and with many, the area is held against the part of its skin that is nearer than 20 µm,
//! or, in a pinch, that the load asks for at the peak pressure.

use std::path::Path;
use thenar_core::Vec3;
use thenar_core::model::Digit;
use thenar_core::readout::{ContactReadout, PatchContact};
use thenar_scene::session::Session;

/// What is nearer touches \[m\]: the definition of the read-out.
const TOUCHING: f64 = 20e-6;
/// Where the upper side of what is touched is \[m\].
const TOP: f64 = 0.01;
/// Rows of places in which a triangle is looked at: of the default hand's 2 mm² each then stands
/// for 600 µm², of the paper's 12 mm² for 200.
fn rows(preset: &str) -> u32 {
    if preset == "paper" { 240 } else { 60 }
}

const SCENE: &str = r#"version = 1
time_step = 0.005
duration = 3.0
[[hand]]
preset = "PRESET"
name = "hand"
[hand.motion]
kind = "keyframes"
[[hand.motion.key]]
time = 0
wrist = { position = [0, 0.12, 0.05], fingers = [0, 0, -1], back = [0, 1, 0] }
joints.index-mcp = { flexion_deg = 38 }
joints.index-pip = { flexion_deg = 20 }
joints.index-dip = { flexion_deg = 10 }
[[hand.motion.key]]
time = 3.0
wrist = { position = [0, 0.05, 0.05], fingers = [0, 0, -1], back = [0, 1, 0] }
joints.index-mcp = { flexion_deg = 38 }
joints.index-pip = { flexion_deg = 20 }
joints.index-dip = { flexion_deg = 10 }
"#;

/// What stands fixed under the finger, and how far a place is from it \[m\], seen from the middle
/// of its upper side.
struct Thing {
    shape: &'static str,
    /// Turn about z.
    angle_deg: f64,
    /// Depth of its middle below the upper side \[m\].
    below: f64,
    distance: fn(&Vec3) -> f64,
    /// With what the finger presses \[N\].
    loads: [f64; 3],
    /// How far the area may be off, in parts: less where a patch has ten points of the skin and
    /// more, on the plate, than where it has one to three.
    within: f64,
}

const PLATE: Thing = Thing {
    shape: r#"kind = "box", size = [0.4, 0.02, 0.4]"#,
    angle_deg: 0.0,
    below: 0.01,
    distance: |p| p.y,
    loads: [2.0, 8.0, 18.0],
    within: 0.05,
};

const THINGS: [Thing; 3] = [
    Thing {
        shape: r#"kind = "sphere", radius = 0.015"#,
        angle_deg: 0.0,
        below: 0.015,
        distance: |p| (p + Vec3::y() * 0.015).norm() - 0.015,
        loads: [2.0, 8.0, 15.0],
        within: 0.1,
    },
    // Across the finger.
    Thing {
        shape: r#"kind = "cylinder", radius = 0.008, length = 0.06"#,
        angle_deg: 90.0,
        below: 0.008,
        distance: |p| p.z.hypot(p.y + 0.008) - 0.008,
        loads: [2.0, 5.0, 8.0],
        within: 0.1,
    },
    // Of a right angle, along the finger.
    Thing {
        shape: r#"kind = "box", size = [0.03, 0.03, 0.06]"#,
        angle_deg: 45.0,
        below: 0.015 * std::f64::consts::SQRT_2,
        distance: |p| {
            let (right, left) = ((p.y + p.x) / 2.0_f64.sqrt(), (p.y - p.x) / 2.0_f64.sqrt());
            if right.min(left) > 0.0 { right.hypot(left) } else { right.max(left) }
        },
        loads: [2.0, 5.0, 8.0],
        within: 0.1,
    },
];

fn scene(preset: &str, thing: &Thing, at: &Vec3) -> String {
    let Thing { shape, angle_deg, below, .. } = thing;
    let (x, y, z) = (at.x, at.y - below, at.z);
    SCENE.replace("PRESET", preset)
        + &format!(
            "[[rigid]]\nname = \"thing\"\nshape = {{ {shape} }}\nmotion = \"fixed\"\nposition = [{x}, {y}, {z}]\n\
             rotation = {{ axis = [0, 0, 1], angle_deg = {angle_deg} }}\n"
        )
}

/// The middles of the parts into which rows divide a triangle, all of one area.
fn places(x: [Vec3; 3], n: u32) -> impl Iterator<Item = Vec3> {
    let at = move |i: f64, j: f64| {
        x[0] + (x[1] - x[0]) * (i / f64::from(n)) + (x[2] - x[0]) * (j / f64::from(n))
    };
    let all = (0..n).flat_map(move |i| (0..n - i).map(move |j| (f64::from(i), f64::from(j))));
    let third = 1.0 / 3.0;
    all.flat_map(move |(i, j)| {
        let whole = i + j + 1.5 < f64::from(n);
        [Some(at(i + third, j + third)), whole.then(|| at(i + 2.0 * third, j + 2.0 * third))]
    })
    .flatten()
}

/// The part of the index finger's skin that is nearer than [`TOUCHING`] \[m²\], and its middle.
fn patch(session: &Session, thing: &Thing, at: &Vec3, rows: u32) -> (f64, Vec3) {
    let world = session.world();
    let x = world.collision_vertices(0);
    let index = u32::from(Digit::Index.part());
    let (mut area, mut moment) = (0.0, Vec3::zeros());
    for t in &world.desc().softs[0].flesh.collision.triangles {
        if t.iter().any(|v| world.model().part_of(0, *v) != index) {
            continue;
        }
        let corners = t.map(|v| x[v as usize]);
        let each = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).norm()
            / (2.0 * f64::from(rows * rows));
        for p in places(corners, rows).filter(|p| (thing.distance)(&(p - at)) < TOUCHING) {
            area += each;
            moment += each * p;
        }
    }
    (area, moment / area)
}

fn index(session: &Session, readout: &mut ContactReadout) -> PatchContact {
    readout.read(session.world());
    readout.parts(0)[Digit::Index.part() as usize].contact
}

/// Presses with a few loads, and returns the middle of the first patch.
fn presses_on_its_patch(preset: &str, thing: &Thing, at: Vec3) -> Vec3 {
    let text = scene(preset, thing, &at);
    let mut session = Session::from_text(&text, Path::new("finger-area.toml"), &[])
        .unwrap_or_else(|error| panic!("{error}"));
    let mut readout = ContactReadout::new(session.world());
    let mut middle = None;
    for load in thing.loads {
        let mut told = index(&session, &mut readout);
        while told.normal < load {
            let Thing { shape, .. } = thing;
            let normal = told.normal;
            assert!(session.world().time() < 3.0, "{preset}, {shape}: {normal} N only");
            session.step(&mut ());
            told = index(&session, &mut readout);
        }
        let (area, centre) = patch(&session, thing, &at, rows(preset));
        middle.get_or_insert(centre);
        println!(
            "{preset}, {}: {area:e} m2, {:e} reported, {} N",
            thing.shape, told.area, told.normal
        );
        assert!((told.area / area - 1.0).abs() < thing.within, "{} of {area} m2", told.area);
        let spread = told.pressure_mean() * told.area;
        // What the bone bears where flesh is crushed has no area. More load need not touch more
        // skin: a finger that it bends stands on its tip.
        let skin = told.skin_normal;
        assert!((spread / skin - 1.0).abs() < 0.01, "{spread} of {skin} N");
    }
    middle.expect("a load")
}

#[test]
fn the_area_of_the_index_finger_is_that_of_its_patch() {
    presses_on_its_patch("paper", &PLATE, Vec3::y() * TOP);
    let middle = presses_on_its_patch("touch", &PLATE, Vec3::y() * TOP);
    let at = Vec3::new(middle.x, TOP, middle.z);
    for thing in &THINGS {
        presses_on_its_patch("touch", thing, at);
    }
}

const PINCH: &str = r#"version = 1
time_step = 0.005
duration = 2.0
gravity = [0, 0, 0]
[[hand]]
preset = "touch"
name = "hand"
[[hand.grip]]
kind = "pinch"
force = FORCE
at = 0.1
[hand.motion]
kind = "keyframes"
[[hand.motion.key]]
time = 0
pose = "open"
[[hand.motion.key]]
time = 0.6
pose = "pinch"
"#;

/// Distance of `p` to a triangle.
fn to_triangle(p: &Vec3, [a, b, c]: [Vec3; 3]) -> f64 {
    let normal = (b - a).cross(&(c - a));
    let sides = [(a, b), (b, c), (c, a)];
    if sides.iter().all(|(s, e)| normal.cross(&(e - s)).dot(&(p - s)) >= 0.0) {
        return (normal.dot(&(p - a)) / normal.norm()).abs();
    }
    let to_side = |(s, e): (Vec3, Vec3)| {
        let t = ((p - s).dot(&(e - s)) / (e - s).norm_squared()).clamp(0.0, 1.0);
        (p - s - (e - s) * t).norm()
    };
    sides.into_iter().map(to_side).fold(f64::INFINITY, f64::min)
}

/// The part of one finger's skin that is nearer than [`TOUCHING`] to another's \[m²\].
fn patch_on(session: &Session, finger: Digit, other: Digit) -> f64 {
    let world = session.world();
    let x = world.collision_vertices(0);
    let of = |digit: Digit| {
        let part = u32::from(digit.part());
        let triangles = world.desc().softs[0].flesh.collision.triangles.iter();
        let own = triangles.filter(move |t| t.iter().all(|v| world.model().part_of(0, *v) == part));
        own.map(|t| t.map(|v| x[v as usize])).collect::<Vec<_>>()
    };
    let size = |t: &[Vec3; 3]| {
        let middle = (t[0] + t[1] + t[2]) / 3.0;
        (middle, t.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max))
    };
    let (own, others) = (of(finger), of(other));
    let mut area = 0.0;
    for t in &own {
        let (middle, radius) = size(t);
        let near: Vec<_> = others
            .iter()
            .filter(|o| {
                let (at, reach) = size(o);
                (at - middle).norm() < radius + reach + TOUCHING
            })
            .collect();
        let rows = rows("touch");
        let each = (t[1] - t[0]).cross(&(t[2] - t[0])).norm() / (2.0 * f64::from(rows * rows));
        let touches = |p: &Vec3| near.iter().any(|o| to_triangle(p, **o) < TOUCHING);
        area += each * places(*t, rows).filter(touches).count() as f64;
    }
    area
}

/// Between two fingers it is half of what touches on either side.
#[test]
fn the_area_of_a_pinch_is_that_of_its_patches() {
    for load in [1.5, 3.0, 6.0, 9.0] {
        let text = PINCH.replace("FORCE", &load.to_string());
        let mut session = Session::from_text(&text, Path::new("pinch.toml"), &[])
            .unwrap_or_else(|error| panic!("{error}"));
        let mut readout = ContactReadout::new(session.world());
        let mut told = index(&session, &mut readout);
        while session.world().time() < 2.0 {
            session.step(&mut ());
            told = index(&session, &mut readout);
        }
        let sides = [(Digit::Index, Digit::Thumb), (Digit::Thumb, Digit::Index)]
            .map(|(own, other)| patch_on(&session, own, other));
        let near = 0.5 * (sides[0] + sides[1]);
        let peaks = [Digit::Index, Digit::Thumb]
            .map(|digit| readout.parts(0)[digit.part() as usize].contact.pressure_max);
        let area = near.max(told.skin_normal / peaks[0].max(peaks[1]));
        println!("pinch: {near:e} m2 are near, {:e} reported, {} N", told.area, told.normal);
        assert!((told.area / area - 1.0).abs() < 0.2, "{} of {area} m2", told.area);
    }
}
