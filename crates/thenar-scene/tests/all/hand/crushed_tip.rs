//! Goal: bones are solid where the flesh of the default hand is crushed. Method: the tip of its
//! index finger lies between two steel plates, of which one is fixed and the other kept level by a
//! large inertia; 200 N press that one down, and let go. Expected from geometry and statics: the
//! plates come no nearer than the bone is thick, both bear the load, no element stays inverted and
//! the tip is as thick afterwards as before.

use std::path::Path;
use thenar_core::model::{BodyId, Digit};
use thenar_core::readout::ContactReadout;
use thenar_core::shape::Shape;
use thenar_core::world::ContactPoint;
use thenar_scene::session::Session;

/// What crushes the tip \[N\].
const CRUSHING: f64 = 200.0;
/// What holds the plate on the skin before and after \[N\].
const RESTING: f64 = 0.1;
/// Half of a plate's height \[m\].
const HALF: f64 = 0.005;
/// When the load is whole \[s\].
const LOADED: f64 = 0.5;
/// When it is taken away \[s\].
const RELEASED: f64 = 0.7;
/// The end \[s\].
const END: f64 = 1.2;

fn scene(h: f64) -> String {
    let [light, whole] = [RESTING / CRUSHING, 1.0];
    format!(
        r#"version = 1
gravity = [0, 0, 0]
time_step = {h}
duration = {END}
[[hand]]
name = "hand"
self_contact = false
palm_drive = {{ stiffness = 1e6, damping = 1e3, angular_stiffness = 1e4, angular_damping = 10 }}
[[rigid]]
name = "lower"
shape = {{ kind = "box", size = [0.018, 0.01, 0.016] }}
motion = "fixed"
position = [-0.0197, -0.0237, -0.172]
[[rigid]]
name = "upper"
shape = {{ kind = "box", size = [0.018, 0.01, 0.016] }}
mass = 0.0226
inertia = [1e3, 1e3, 1e3]
position = [-0.0197, -0.0005, -0.172]
[[load]]
kind = "force"
body = "upper"
force = [0, -{CRUSHING}, 0]
profile = {{ kind = "keyframes", times = [0, 0.3, {LOADED}, {RELEASED}, {}, 9], factors = [{light}, {light}, {whole}, {whole}, {light}, {light}] }}
"#,
        RELEASED + 0.02
    )
}

struct Press {
    session: Session,
    tip: u32,
    plates: [u32; 2],
    /// Vertices of the skin between the plates.
    between: Vec<usize>,
}

impl Press {
    fn new(h: f64) -> Self {
        let session = Session::from_text(&scene(h), Path::new("crushed-tip.toml"), &[])
            .unwrap_or_else(|error| panic!("{error}"));
        let find = |name: &str| {
            let rigids = &session.world().desc().rigids;
            let index = rigids.iter().position(|r| r.name == name);
            index.unwrap_or_else(|| panic!("no {name}")) as u32
        };
        let (tip, plates) = (find("hand/index-distal"), ["lower", "upper"].map(find));
        let middle = session.world().rigid_pose(plates[0]).position;
        let near = |i: &usize| {
            let apart = session.world().collision_vertices(0)[*i] - middle;
            apart.x.abs() < 0.009 && apart.z.abs() < 0.008
        };
        let between = (0..session.world().collision_vertices(0).len()).filter(near).collect();
        Self { session, tip, plates, between }
    }

    fn run_to(&mut self, time: f64) {
        while self.session.world().time() < time - 1e-9 {
            self.session.step(&mut ());
        }
    }

    /// Between the plates [m].
    fn opening(&self) -> f64 {
        let [lower, upper] = self.plates.map(|p| self.session.world().rigid_pose(p).position.y);
        upper - lower - 2.0 * HALF
    }

    /// Thickness of the tip, from pad to nail in the frame of its bone [m].
    fn thickness(&self) -> f64 {
        let world = self.session.world();
        let (pose, x) = (world.rigid_pose(self.tip), world.collision_vertices(0));
        let heights = self.between.iter().map(|i| pose.inverse_point(&x[*i]).y);
        heights.clone().fold(f64::NEG_INFINITY, f64::max) - heights.fold(f64::INFINITY, f64::min)
    }

    /// Thickness of the bone of the tip [m].
    fn bone(&self) -> f64 {
        let shape = self.session.world().desc().rigids[self.tip as usize].shape.as_ref();
        let first = match shape.expect("a bone is solid") {
            Shape::Compound(parts) => &parts[0].shape,
            shape => shape,
        };
        match first {
            Shape::Capsule { radius, .. } => 2.0 * radius,
            other => panic!("the bone is a {other:?}"),
        }
    }

    /// Sum of the vertical forces on a plate [N].
    fn load(&self, plate: u32) -> f64 {
        let on = |c: &ContactPoint| match c.bodies.map(|body| body == BodyId::Rigid(plate)) {
            [true, _] => c.force_W.y,
            [_, true] => -c.force_W.y,
            _ => 0.0,
        };
        self.session.world().contacts().iter().map(on).sum::<f64>().abs()
    }
}

fn stops_at_the_bone(h: f64) {
    let mut press = Press::new(h);
    press.run_to(0.3);
    let (rest, bone) = (press.thickness(), press.bone());
    assert!(bone > 3e-3 && bone < 0.6 * rest, "a bone of {bone} m in a tip of {rest} m");
    press.run_to(RELEASED);
    let opening = press.opening();
    println!("step {h} s: {opening} m between plates, bone {bone} m, tip {rest} m");
    assert!(opening > bone - 0.2e-3, "{opening} m between plates around a bone of {bone} m");
    // Flesh is crushed below 0.3 of its thickness (`flesh/crush.rs`).
    let most = bone + 0.3 * (rest - bone);
    assert!(opening < most, "the flesh is not crushed: {opening} m, bone {bone} m of {rest} m");
    for plate in press.plates {
        let load = press.load(plate);
        assert!((load / CRUSHING - 1.0).abs() < 0.02, "{load} N on a plate");
    }
    // The finger's readout holds what presses from both sides, on flesh and on bone.
    let mut readout = ContactReadout::new(press.session.world());
    readout.read(press.session.world());
    let finger = readout.parts(0)[Digit::Index.part() as usize].contact.normal;
    assert!((finger / (2.0 * CRUSHING) - 1.0).abs() < 0.1, "{finger} N on the finger");

    press.run_to(END - h);
    let report = press.session.step(&mut ());
    assert_eq!(report.inverted_tets, 0, "elements stay inverted");
    let after = press.thickness();
    assert!((after / rest - 1.0).abs() < 0.02, "{after} m of {rest} m after release");
}

#[test]
fn steel_plates_stop_at_the_bone_at_1_ms() {
    stops_at_the_bone(1e-3);
}

#[test]
fn steel_plates_stop_at_the_bone_at_5_ms_and_60_hz() {
    stops_at_the_bone(5e-3);
    stops_at_the_bone(1.0 / 60.0);
}
