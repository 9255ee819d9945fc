//! Goal: in slow motion the force follows position without flicker. Method: things drawn and rolled
//! at 20 mm/s over a finger of the default hand, over one of the paper's and over a soft pad, and
//! the finger over the pad, at 1 ms steps once they are pressed. The part of the net force above 50
//! Hz (rms over the three components, Hann window, straight trend removed) is below 0.5 % of the
//! mean force: amplitudes, not their squares. At half the speed the largest change of force and
//! torque in a step is half.

mod over_fingertips;
mod soft_pad;

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;
use thenar_core::Vec3;
use thenar_core::model::BodyId;
use thenar_core::world::World;
use thenar_scene::session::Session;

const H: f64 = 1e-3;
/// Until a thing is pressed on \[s\]; nothing is measured then.
const H_BEFORE: f64 = 5e-3;
/// When a thing has been pressed on, and when it starts to move \[s\].
const PRESSED: f64 = 0.2;
const MOVES: f64 = 0.3;

/// A hand whose bones are held where they are, palm down, fingers along -z.
const HAND: &str = r#"
[[hand]]
preset = "PRESET"
name = "below"
self_contact = false
bone_drive = { stiffness = 1e6, damping = 1e3, angular_stiffness = 1e3, angular_damping = 1 }
palm_drive = { stiffness = 1e6, damping = 1e3, angular_stiffness = 1e4, angular_damping = 10 }
"#;
/// Under the pad of its index finger \[m\].
const FINGERTIP: [f64; 3] = [-0.0197, -0.0185, -0.170];

const PAD: &str = r#"
[[soft]]
name = "below"
shape = { kind = "lattice", size = [0.06, 0.02, 0.04], cells = [12, 4, 8] }
material = { young = 5e4, density = 1000 }
stiffness_damping = 0.005
friction = 0.6
position = [0, -0.01, 0]
fixed = [{ nodes = { side = "y-min" } }]
"#;

/// A body that moves over another.
#[derive(Clone, Copy)]
struct Case<'a> {
    name: &'a str,
    shape: &'a str,
    /// Start rotation, TOML.
    rotation: &'a str,
    /// From its centre to the point that touches first \[m\].
    reach: f64,
    depth: f64,
    /// The way of the body, middle at the place where it is pressed on \[m\].
    way: [f64; 3],
    /// Turns without sliding over the way (a ball of radius `reach`).
    rolls: bool,
    friction: f64,
    /// What it moves over: a hand of this preset, or the pad.
    over: Option<&'a str>,
    /// \[m/s\]
    speed: f64,
}

const BALL: Case<'_> = Case {
    name: "ball of 10 mm",
    shape: r#"{ kind = "sphere", radius = 0.01 }"#,
    rotation: "{ axis = [0, 0, 1], angle = 0 }",
    reach: 0.01,
    depth: 0.0015,
    way: [0.0, 0.0, 0.006],
    rolls: false,
    friction: 0.6,
    over: Some("paper"),
    speed: 0.02,
};

/// Force on the thing and its torque about where it was first, at every step on its way.
fn wrenches(case: &Case<'_>, speed: f64) -> Vec<[Vec3; 2]> {
    let (start, up) = match case.over {
        Some(_) => (FINGERTIP, -1.0),
        None => ([0.0; 3], 1.0),
    };
    let way = Vec3::from(case.way);
    let pressed = Vec3::from(start) + Vec3::y() * (up * (case.reach - case.depth));
    let above = pressed + Vec3::y() * (up * (case.depth + 2e-3));
    let end = MOVES + way.norm() / speed;
    // Rolling: the point that touches stands still.
    let turn = if case.rolls { (Vec3::y() * up).cross(&way) / case.reach } else { Vec3::zeros() };
    let (angle, axis) = (turn.norm(), turn.try_normalize(0.0).unwrap_or(Vec3::x()));
    let (from, to) = (pressed - way * 0.5, pressed + way * 0.5);
    let rotation = |part: f64| match case.rolls {
        true => format!("{{ axis = {:?}, angle = {:e} }}", <[f64; 3]>::from(axis), angle * part),
        false => case.rotation.into(),
    };
    let key = |time: f64, at: Vec3, part: f64| {
        let (at, rotation) = (<[f64; 3]>::from(at), rotation(part));
        format!("{{ time = {time:e}, position = {at:?}, rotation = {rotation} }},\n")
    };
    let mut text = format!("version = 1\ngravity = [0, 0, 0]\ntime_step = {H}\nduration = {end}\n");
    let _ = write!(
        text,
        "{}\n[[rigid]]\nname = \"thing\"\nshape = {}\nmotion = \"scripted\"\nfriction = {}\n\
         interpolation = \"linear\"\nkeyframes = [\n{}{}{}{}]\n\
         [[pair]]\nbodies = [\"thing\", \"below\"]\nfriction = {}\n",
        case.over.map_or(PAD.into(), |preset| HAND.replace("PRESET", preset)),
        case.shape,
        case.friction,
        key(0.0, above - way * 0.5, 0.0),
        key(PRESSED, from, 0.0),
        key(MOVES, from, 0.0),
        key(end, to, 1.0),
        case.friction,
    );
    let mut session = Session::from_text(&text, Path::new("drawn.toml"), &[])
        .unwrap_or_else(|e| panic!("{}: {e}\n{text}", case.name));
    let world = session.world();
    let thing = world.desc().rigids.iter().position(|r| r.name == "thing").unwrap() as u32;
    let mut found = Vec::new();
    run(&mut session, end, |time, world| {
        // A few steps on the way, friction has built up.
        if time > MOVES + 0.15 * way.norm() / speed + 0.5 * H {
            let mut wrench = [Vec3::zeros(); 2];
            for c in world.contacts() {
                let [a, b] = c.bodies.map(|body| body == BodyId::Rigid(thing));
                let sign = if a {
                    1.0
                } else if b {
                    -1.0
                } else {
                    continue;
                };
                wrench[0] += c.force_W * sign;
                wrench[1] += (c.position_W - from).cross(&c.force_W) * sign;
            }
            found.push(wrench);
        }
    });
    found
}

/// The rms of what is above 50 Hz in all components of a force, over its mean size.
pub(super) fn above_50_hz(force: &[Vec3]) -> f64 {
    let n = force.len();
    let mean = force.iter().sum::<Vec3>() / n as f64;
    let at = |i: usize| i as f64 - 0.5 * (n as f64 - 1.0);
    let slope = force.iter().enumerate().map(|(i, f)| (f - mean) * at(i)).sum::<Vec3>()
        / (0..n).map(|i| at(i) * at(i)).sum::<f64>();
    let window = |i: usize| 0.5 - 0.5 * (TAU * (i as f64 + 0.5) / n as f64).cos();
    let weight: f64 = (0..n).map(|i| window(i) * window(i)).sum();
    let rest: Vec<Vec3> =
        force.iter().enumerate().map(|(i, f)| (f - mean - slope * at(i)) * window(i)).collect();
    let lowest = (50.0 * n as f64 * H).ceil() as usize;
    let mut power = 0.0;
    for k in lowest..=n / 2 {
        let (mut re, mut im) = (Vec3::zeros(), Vec3::zeros());
        for (i, f) in rest.iter().enumerate() {
            let (sin, cos) = (TAU * (k * i % n) as f64 / n as f64).sin_cos();
            re += f * cos;
            im += f * sin;
        }
        let both = if 2 * k == n { 1.0 } else { 2.0 };
        power += both * (re.norm_squared() + im.norm_squared()) / (n as f64 * weight);
    }
    power.sqrt() / (force.iter().map(Vec3::norm).sum::<f64>() / n as f64)
}

/// Largest change of force \[N\] and torque \[N m\] in a step.
pub(super) fn largest_change(wrenches: &[[Vec3; 2]]) -> [f64; 2] {
    let change = |k: usize| wrenches.windows(2).map(move |w| (w[1][k] - w[0][k]).norm());
    [0, 1].map(|k| change(k).fold(0.0, f64::max))
}

/// Steps to the end, long ones until the thing is pressed on; `each` hears the time after each
/// step.
fn run(session: &mut Session, end: f64, mut each: impl FnMut(f64, &World)) {
    while session.world().time() < end - 0.5 * H {
        let pressed = session.world().time() > PRESSED - 0.5 * H;
        session.world_mut().set_time_step(if pressed { H } else { H_BEFORE });
        session.step(&mut ());
        each(session.world().time(), session.world());
    }
}

/// Hardly anything above 50 Hz; returns what acted.
fn check_spectrum(case: &Case<'_>) -> Vec<[Vec3; 2]> {
    let found = wrenches(case, case.speed);
    let force: Vec<Vec3> = found.iter().map(|w| w[0]).collect();
    let mean = force.iter().map(Vec3::norm).sum::<f64>() / force.len() as f64;
    let high = above_50_hz(&force);
    println!("{}: {mean:.2} N, {:.3} % above 50 Hz", case.name, 100.0 * high);
    assert!(mean > 0.1, "{}: {mean} N", case.name);
    assert!(high < 5e-3, "{}: {} % above 50 Hz", case.name, 100.0 * high);
    found
}

/// Checks the spectrum, and that half the speed halves the change.
fn check(case: &Case<'_>) {
    let found = check_spectrum(case);
    let slow = wrenches(case, 0.5 * case.speed);
    for (k, unit) in [(0, "N"), (1, "N m")] {
        let [fast, slow] = [&found, &slow].map(|w| largest_change(w)[k]);
        println!("    largest change {fast:.3e} to {slow:.3e} {unit}: {:.2}", slow / fast);
        // A slope halves and a jump stays: midway, as slopes peak between steps.
        assert!(slow < 0.75 * fast, "{}: {fast} to {slow} {unit} in a step", case.name);
    }
}

const LARGE: Case<'_> = Case {
    name: "ball of 30 mm",
    shape: r#"{ kind = "sphere", radius = 0.03 }"#,
    reach: 0.03,
    way: [0.0, 0.0, 0.008],
    ..BALL
};

const EDGE: Case<'_> = Case {
    name: "edge of a box, straight",
    shape: r#"{ kind = "box", size = [0.02, 0.02, 0.06] }"#,
    rotation: "{ axis = [0, 0, 1], angle_deg = 45 }",
    reach: 0.014142,
    depth: 0.002,
    way: [0.006, 0.0, 0.0],
    over: None,
    ..BALL
};

#[test]
fn a_ball_rolls_over_a_fingertip() {
    check(&Case { name: "ball rolls along", rolls: true, ..BALL });
    check(&Case { name: "ball rolls across", rolls: true, way: [0.006, 0.0, 0.0], ..BALL });
    check(&Case { name: "large ball rolls along", rolls: true, ..LARGE });
}

#[test]
fn a_fingertip_is_drawn_over_a_ball() {
    check(&Case { name: "ball drawn along", ..BALL });
    check(&Case {
        name: "ball drawn across, frictionless",
        friction: 0.0,
        way: [0.006, 0.0, 0.0],
        ..BALL
    });
    check(&LARGE);
}

/// The same on the hand that a scene means without saying so.
#[test]
fn a_ball_is_drawn_and_rolls_over_a_fingertip_of_the_default_hand() {
    let small = Case { over: Some("touch"), ..BALL };
    check(&Case { name: "default hand, ball rolls along", rolls: true, ..small });
    check_spectrum(&Case { name: "default hand, ball drawn along", ..small });
    check_spectrum(&Case {
        name: "default hand, ball drawn across, frictionless",
        friction: 0.0,
        way: [0.006, 0.0, 0.0],
        ..small
    });
}

#[test]
fn a_large_ball_rolls_over_a_fingertip_of_the_default_hand() {
    let large = Case { over: Some("touch"), ..LARGE };
    check_spectrum(&Case { name: "default hand, large ball rolls along", rolls: true, ..large });
    check_spectrum(&Case { name: "default hand, large ball drawn", ..large });
}

#[test]
fn an_edge_is_drawn_over_a_pad() {
    check(&EDGE);
    check(&Case {
        name: "edge of a box, skew",
        shape: r#"{ kind = "box", size = [0.02, 0.02, 0.03] }"#,
        rotation: "{ quaternion = [0.04, 0.09657, 0.3806, 0.91881] }",
        ..EDGE
    });
}

/// On its tip, on its flank, on its rim.
#[test]
fn round_and_pointed_shapes_are_drawn_over_a_pad() {
    let on_pad = Case { depth: 0.0015, way: [0.004, 0.0, 0.001], ..EDGE };
    let cone = Case {
        name: "cone",
        shape: r#"{ kind = "cone", radius = 0.01, height = 0.02 }"#,
        rotation: "{ axis = [0, 0, 1], angle_deg = 180 }",
        reach: 0.015,
        ..on_pad
    };
    check(&cone);
    let ellipsoid = Case {
        name: "ellipsoid",
        shape: r#"{ kind = "ellipsoid", size = [0.03, 0.012, 0.02] }"#,
        rotation: "{ axis = [0, 1, 0], angle_deg = 20 }",
        reach: 0.006,
        ..on_pad
    };
    check_spectrum(&ellipsoid);
    let cylinder = Case {
        name: "cylinder",
        shape: r#"{ kind = "cylinder", radius = 0.006, length = 0.02 }"#,
        rotation: "{ axis = [0, 0, 1], angle_deg = 0 }",
        reach: 0.01,
        ..on_pad
    };
    check_spectrum(&cylinder);
}

/// A ball as scans and printers have it: its triangles have edges of 0.9 mm.
#[test]
fn a_ball_of_triangles_is_drawn_and_rolls_over_a_fingertip() {
    let file = std::env::temp_dir().join(format!("thenar-ball-{}.stl", std::process::id()));
    let ball = thenar_rig::mesh::shapes::sphere(0.01, 12);
    std::fs::write(&file, thenar_rig::mesh::write_stl(&ball)).unwrap();
    let shape = format!("{{ kind = \"mesh\", file = {:?} }}", file.to_str().unwrap());
    let meshed = Case { name: "ball of triangles drawn", shape: &shape, ..BALL };
    check_spectrum(&meshed);
    check_spectrum(&Case { name: "ball of triangles rolls", rolls: true, ..meshed });
    std::fs::remove_file(&file).unwrap();
}

/// A capsule that is slim beside the triangles of the pad, along and across its axis; also without
/// friction, so that nothing sticks and slips.
#[test]
fn a_slim_capsule_is_drawn_over_a_pad() {
    let slim = Case {
        name: "slim capsule",
        shape: r#"{ kind = "capsule", radius = 0.003, length = 0.02 }"#,
        rotation: "{ axis = [0, 0, 1], angle_deg = 90 }",
        reach: 0.003,
        depth: 0.0015,
        way: [0.001, 0.0, 0.006],
        ..EDGE
    };
    check_spectrum(&slim);
    check_spectrum(&Case { name: "slim capsule, along", way: [0.006, 0.0, 0.001], ..slim });
    check_spectrum(&Case { name: "slim capsule, frictionless", friction: 0.0, ..slim });
}

#[test]
fn a_corner_is_drawn_over_a_fingertip() {
    let corner = Case {
        name: "corner of a plate",
        shape: r#"{ kind = "box", size = [0.03, 0.004, 0.03] }"#,
        rotation: "{ axis = [-1, 0, 1], angle_deg = 84.612 }",
        reach: 0.021307,
        depth: 0.001,
        way: [0.004, 0.0, 0.0],
        // A point that passes from one flat triangle of the skin to the next turns its path there.
        speed: 0.01,
        ..BALL
    };
    check(&corner);
}
