//! Goal: the area that is reported of a finger is that of its patch. Method: the default hand, and the paper's, come down
//! on a plate with their index finger first, slowly; when that presses with a few newtons and with many, the area is
//! held against the part of its skin that is nearer than 20 µm to the plate.

use std::path::Path;
use thenar::Vec3;
use thenar::model::Digit;
use thenar::readout::ContactReadout;
use thenar_scene::session::Session;

/// What is nearer touches \[m\]: the definition of the read-out.
const TOUCHING: f64 = 20e-6;
/// Where the plate's upper side is \[m\].
const TOP: f64 = 0.01;

const SCENE: &str = r#"version = 1
time_step = 0.005
duration = 3.0
[[rigid]]
name = "plate"
shape = { kind = "box", size = [0.4, 0.02, 0.4] }
motion = "fixed"
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

/// The part of a triangle below a height, which is a triangle, or what is left of it without one.
fn below(x: &[Vec3; 3], height: f64) -> f64 {
    let area = (x[1] - x[0]).cross(&(x[2] - x[0])).norm() / 2.0;
    let y = [0, 1, 2].map(|k| x[k].y - height);
    // The corner that is alone on its side, and what of the edges to it is on that side.
    let cut = |k: usize| {
        let part = |j: usize| y[k] / (y[k] - y[j]);
        part((k + 1) % 3) * part((k + 2) % 3) * area
    };
    let lower: Vec<usize> = (0..3).filter(|&k| y[k] < 0.0).collect();
    match lower[..] {
        [] => 0.0,
        [k] => cut(k),
        [j, k] => area - cut(3 - j - k),
        _ => area,
    }
}

#[test]
fn the_area_of_the_index_finger_on_a_plate_is_that_of_its_patch() {
    for preset in ["touch", "paper"] {
        presses_on_its_patch(&SCENE.replace("PRESET", preset));
    }
}

fn presses_on_its_patch(scene: &str) {
    let mut session = Session::from_text(scene, Path::new("finger-area.toml"), &[])
        .unwrap_or_else(|error| panic!("{error}"));
    let mut readout = ContactReadout::new(session.world());
    for load in [2.0, 8.0, 18.0] {
        let mut pressed = 0.0;
        while pressed < load {
            assert!(session.world().time() < 3.0, "it presses with {pressed} N only");
            session.step(&mut ());
            readout.read(session.world());
            pressed = readout.parts(0)[Digit::Index.part() as usize].contact.normal;
        }
        let world = session.world();
        let told = readout.parts(0)[Digit::Index.part() as usize].contact;
        let x = world.collision_vertices(0);
        let triangles = &world.desc().softs[0].flesh.collision.triangles;
        let index = u32::from(Digit::Index.part());
        let is_index = |t: &&[u32; 3]| t.iter().all(|v| world.model().part_of(0, *v) == index);
        let of_index = triangles.iter().filter(is_index);
        let patch: f64 = of_index.map(|t| below(&t.map(|v| x[v as usize]), TOP + TOUCHING)).sum();
        assert!((told.area / patch - 1.0).abs() < 0.05, "{} of {patch} m2", told.area);
        let spread = told.pressure_mean() * told.area;
        // What the bone bears where flesh is crushed has no area.
        let skin = told.skin_normal;
        assert!((spread / skin - 1.0).abs() < 0.01, "{spread} of {skin} N");
        // More load need not touch more skin: a finger that it bends stands on its tip.
        println!("{patch} m2 under {load} N");
    }
}
