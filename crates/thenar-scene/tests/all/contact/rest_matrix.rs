//! Goal: whatever is set down stays where it is, and its force with it. Method: every rigid shape
//! on every support at three steps, at five places and tilts; after half a second it neither
//! travels nor moves nor overlaps by more than 0.05 mm, its force is steady from step to step, the
//! forces of its contacts balance its weight where they act, and nothing has put energy in. Of a
//! hand, a finger is driven down on what lies on a column, and held there.
//!
//! A fixed eleventh of the cases runs here, and half of that where a case takes seconds. All of
//! them: `THENAR_CASES=all cargo test -p thenar-scene --test all rest_matrix -- --nocapture`; with
//! another text, those whose names contain it. The scenes of cases that fail are kept, and named.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use thenar_core::math::Vec3;
use thenar_core::model::BodyId;
use thenar_core::world::ContactPoint;
use thenar_scene::session::Session;

/// A shape, half its height in the pose in which it rests, its mass \[kg\], and whether it rolls.
struct Thing {
    name: &'static str,
    shape: &'static str,
    half_height: f64,
    mass: f64,
    rolls: bool,
    /// Turns it into its resting pose.
    turn_deg: f64,
}

const fn thing(
    name: &'static str,
    shape: &'static str,
    half_height: f64,
    mass: f64,
    rolls: bool,
) -> Thing {
    Thing { name, shape, half_height, mass, rolls, turn_deg: 0.0 }
}

/// Of steel, or hollow where that would be more than a fingertip bears.
const THINGS: [Thing; 13] = [
    thing("ball 8", r#"kind = "sphere", radius = 0.008"#, 0.008, 0.017, true),
    thing("ball 30", r#"kind = "sphere", radius = 0.03"#, 0.03, 0.2, true),
    thing("cube 10", r#"kind = "box", size = [0.01, 0.01, 0.01]"#, 0.005, 0.008, false),
    thing("cube 40", r#"kind = "box", size = [0.04, 0.04, 0.04]"#, 0.02, 0.2, false),
    thing("slab", r#"kind = "box", size = [0.05, 0.006, 0.02]"#, 0.003, 0.047, false),
    Thing {
        turn_deg: 90.0,
        ..thing("rod", r#"kind = "capsule", radius = 0.006, length = 0.04"#, 0.006, 0.04, true)
    },
    thing("pill", r#"kind = "capsule", radius = 0.012, length = 0.01"#, 0.017, 0.05, true),
    thing("tin", r#"kind = "cylinder", radius = 0.012, length = 0.02"#, 0.01, 0.05, false),
    Thing {
        turn_deg: 90.0,
        ..thing("roller", r#"kind = "cylinder", radius = 0.006, length = 0.04"#, 0.006, 0.04, true)
    },
    thing("pebble", r#"kind = "ellipsoid", size = [0.04, 0.016, 0.028]"#, 0.008, 0.06, true),
    thing("cone", r#"kind = "cone", radius = 0.014, height = 0.02"#, 0.005, 0.03, false),
    thing("mug", MUG, 0.01, 0.06, false),
    thing("mesh ball", r#"kind = "mesh", file = "ball.obj""#, 0.01, 0.03, true),
];
/// A cylinder with a handle.
const MUG: &str = r#"kind = "compound", parts = [
    { shape = { kind = "cylinder", radius = 0.012, length = 0.02 } },
    { shape = { kind = "box", size = [0.01, 0.01, 0.004] }, frame = { position = [0.016, 0, 0] } },
]"#;

const PLANE: &str = r#"
[[rigid]]
name = "support"
shape = { kind = "plane" }
motion = "fixed"
"#;
/// Under a finger: the thumb hangs beside it.
const COLUMN: &str = r#"
[[rigid]]
name = "support"
shape = { kind = "box", size = [0.06, 0.2, 0.06] }
motion = "fixed"
position = [0, -0.1, 0]
"#;
const BLOCK: &str = r#"
[[rigid]]
name = "support"
shape = { kind = "box", size = [0.2, 0.02, 0.2] }
motion = "fixed"
position = [0, -0.01, 0]
"#;

fn pad(cells: [u32; 3]) -> String {
    let [x, y, z] = cells;
    format!(
        r#"
[[soft]]
name = "support"
shape = {{ kind = "lattice", size = [0.1, 0.03, 0.1], cells = [{x}, {y}, {z}] }}
material = {{ young = 2e5, density = 1000 }}
mass_damping = 1.0
stiffness_damping = 0.005
position = [0, -0.015, 0]
fixed = [{{ nodes = {{ side = "y-min" }} }}]
"#
    )
}

fn plate(file: &str) -> String {
    format!(
        "[[rigid]]\nname = \"support\"\nmotion = \"fixed\"\n\
         shape = {{ kind = \"mesh\", file = \"{file}\" }}\n"
    )
}

/// A grate of round bars, a hair apart: what is flat lies on two or more.
fn bars() -> String {
    let bar = |k: i32| {
        format!(
            "{{ shape = {{ kind = \"cylinder\", radius = 0.0024, length = 0.2 }}, \
             frame = {{ position = [{}, -0.0024, 0], rotation = {{ axis = [1, 0, 0], angle_deg = 90 }} }} }}",
            0.005 * f64::from(k)
        )
    };
    let parts: Vec<String> = (-12..=12).map(bar).collect();
    format!(
        "[[rigid]]\nname = \"support\"\nmotion = \"fixed\"\n\
         shape = {{ kind = \"compound\", parts = [{}] }}\n",
        parts.join(", ")
    )
}

/// A board, lighter than some and heavier than others, that lies on two rollers that lie in
/// grooves.
const STACK: &str = r#"
[[rigid]]
name = "support"
shape = { kind = "box", size = [0.12, 0.01, 0.12] }
mass = 0.05
position = [0, -0.005, 0]
[[rigid]]
name = "left roller"
shape = { kind = "cylinder", radius = 0.01, length = 0.1 }
mass = 0.1
position = [-0.05, -0.02, 0]
rotation = { axis = [1, 0, 0], angle_deg = 90 }
[[rigid]]
name = "right roller"
shape = { kind = "cylinder", radius = 0.01, length = 0.1 }
mass = 0.1
position = [0.05, -0.02, 0]
rotation = { axis = [1, 0, 0], angle_deg = 90 }
[[rigid]]
name = "grooves"
motion = "fixed"
position = [0, -0.02, 0]
shape = { kind = "compound", parts = [
    { shape = { kind = "cylinder", radius = 0.01, length = 0.12 }, frame = { position = [-0.062, -0.016, 0], rotation = { axis = [1, 0, 0], angle_deg = 90 } } },
    { shape = { kind = "cylinder", radius = 0.01, length = 0.12 }, frame = { position = [-0.038, -0.016, 0], rotation = { axis = [1, 0, 0], angle_deg = 90 } } },
    { shape = { kind = "cylinder", radius = 0.01, length = 0.12 }, frame = { position = [0.038, -0.016, 0], rotation = { axis = [1, 0, 0], angle_deg = 90 } } },
    { shape = { kind = "cylinder", radius = 0.01, length = 0.12 }, frame = { position = [0.062, -0.016, 0], rotation = { axis = [1, 0, 0], angle_deg = 90 } } },
] }
"#;

fn supports() -> [(&'static str, String); 10] {
    [
        ("plane", PLANE.into()),
        ("box", BLOCK.into()),
        ("mesh coarse", plate("plate1.obj")),
        ("mesh fine", plate("plate16.obj")),
        ("hand", COLUMN.into()),
        ("paper's hand", COLUMN.into()),
        ("soft coarse", pad([4, 2, 4])),
        ("soft fine", pad([12, 3, 12])),
        ("round bars", bars()),
        ("stack", STACK.into()),
    ]
}

const STEPS: [f64; 3] = [0.001, 0.005, 1.0 / 60.0];
/// Where on the support \[m\], turned about the vertical and tilted \[degrees\].
const PLACES: [([f64; 2], f64, f64); 5] = [
    ([0.0, 0.0], 0.0, 0.0),
    ([0.017, -0.019], 0.0, 0.0),
    ([-0.0083, 0.0041], 33.0, 0.0),
    ([0.0125, 0.0125], 45.0, 1.0),
    ([-0.021, -0.013], 71.0, 3.0),
];

/// Supports on which a case takes seconds, at short steps.
const SLOW: [&str; 3] = ["hand", "paper's hand", "soft fine"];

struct Case {
    name: String,
    text: String,
    slow: bool,
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (support, below) in supports() {
        for thing in &THINGS {
            for h in STEPS {
                for (place, spin, tilt) in PLACES {
                    let name =
                        format!("{} on {support}, h {h:.4}, at {place:?}, {tilt}°", thing.name);
                    let text = match support {
                        "hand" => pressed(thing, &below, "touch", h, (place, spin, tilt)),
                        "paper's hand" => pressed(thing, &below, "paper", h, (place, spin, tilt)),
                        _ => scene(thing, &below, h, (place, spin, tilt)),
                    };
                    cases.push(Case { text, name, slow: SLOW.contains(&support) });
                }
            }
        }
    }
    cases
}

fn scene(thing: &Thing, below: &str, h: f64, (place, spin, tilt): ([f64; 2], f64, f64)) -> String {
    // What rolls is held against turning, as if by a heavy flywheel: one that a finger's 10 mN m
    // turn by 1e-4 rad/s in a second.
    let inertia = if thing.rolls { "inertia = [100, 100, 100]\n" } else { "" };
    // Tilted about x, the lower edge just clears what is below.
    let raised = 0.03 * tilt.to_radians().sin();
    let [x, z] = place;
    let y = thing.half_height + if thing.rolls { 0.0 } else { raised } + 1e-4;
    // Turned about the vertical, tilted about x, laid down about z.
    let q = [("y", spin), ("x", if thing.rolls { 0.0 } else { tilt }), ("z", thing.turn_deg)]
        .into_iter()
        .map(|(axis, degrees)| {
            let (s, c) = (0.5 * f64::to_radians(degrees)).sin_cos();
            match axis {
                "x" => [c, s, 0.0, 0.0],
                "y" => [c, 0.0, s, 0.0],
                _ => [c, 0.0, 0.0, s],
            }
        })
        .fold([1.0, 0.0, 0.0, 0.0], product);
    let angle = 2.0 * q[0].clamp(-1.0, 1.0).acos().to_degrees();
    let axis = if angle.abs() < 1e-9 { [0.0, 1.0, 0.0] } else { [q[1], q[2], q[3]] };
    let mut text = format!("version = 1\ntime_step = {h}\nduration = 1.0\n{below}");
    let _ = write!(
        text,
        "[[rigid]]\nname = \"thing\"\nshape = {{ {} }}\nmass = {}\n{inertia}position = [{x}, {y}, {z}]\n\
         rotation = {{ axis = [{}, {}, {}], angle_deg = {angle} }}\nfriction = 0.6\n",
        thing.shape, thing.mass, axis[0], axis[1], axis[2]
    );
    text
}

/// The index finger of a hand is driven down on what lies level on a column, a little off its
/// middle; the hand is turned about the vertical and tilted.
fn pressed(
    thing: &Thing,
    below: &str,
    hand: &str,
    h: f64,
    (place, spin, tilt): ([f64; 2], f64, f64),
) -> String {
    let mut text = scene(thing, below, h, ([0.0; 2], 0.0, 0.0));
    let top = match thing.name {
        "cone" => 0.02,
        _ => 2.0 * thing.half_height,
    };
    let (sin, cos) = spin.to_radians().sin_cos();
    let fingers = [-sin, 0.0, -cos];
    let (lean, stand) = tilt.to_radians().sin_cos();
    let back = [-lean * sin, stand, -lean * cos];
    // The wrist, of a finger whose pad is so far to the right, below and ahead of it \[m\].
    let [right, down, ahead] = [-0.0197, 0.0185, 0.170];
    let x = 0.1 * place[0] - right * cos + ahead * sin;
    let z = 0.1 * place[1] + right * sin + ahead * cos;
    let (start, end) = (top + down + 2e-3, top + down - 1e-3);
    let key = |time: f64, y: f64| {
        format!(
            "[[hand.motion.key]]\ntime = {time}\npose = \"rest\"\n\
             wrist = {{ position = [{x:e}, {y:e}, {z:e}], fingers = {fingers:?}, back = {back:?} }}\n"
        )
    };
    let _ = write!(
        text,
        "[[hand]]\npreset = \"{hand}\"\nname = \"hand\"\n\
         bone_drive = {{ stiffness = 1e4, damping = 100, angular_stiffness = 10, angular_damping = 0.1 }}\n\
         palm_drive = {{ stiffness = 1e4, damping = 100, angular_stiffness = 100, angular_damping = 1 }}\n\
         [hand.motion]\nkind = \"keyframes\"\n{}{}",
        key(0.0, start),
        key(0.25, end),
    );
    text
}

/// The meshes that the scenes name, in the folder that is returned.
fn meshes() -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("rest-matrix");
    std::fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, text: String| std::fs::write(folder.join(name), text).unwrap();
    write("plate1.obj", plate_obj(1));
    write("plate16.obj", plate_obj(16));
    write("ball.obj", ball_obj(0.01, 12));
    folder
}

/// A plate of 200 x 20 x 200 mm whose top, at y = 0, has n x n squares of two triangles.
fn plate_obj(n: usize) -> String {
    let mut text = String::new();
    for (i, k) in (0..=n).flat_map(|i| (0..=n).map(move |k| (i, k))) {
        let at = |j: usize| 0.2 * j as f64 / n as f64 - 0.1;
        let _ = writeln!(text, "v {} 0 {}\nv {} -0.02 {}", at(i), at(k), at(i), at(k));
    }
    let top = |i: usize, k: usize| 2 * (i * (n + 1) + k) + 1;
    let mut quad = |a: usize, b: usize, c: usize, d: usize| {
        let _ = writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}");
    };
    for (i, k) in (0..n).flat_map(|i| (0..n).map(move |k| (i, k))) {
        let [a, b, c, d] = [top(i, k), top(i, k + 1), top(i + 1, k + 1), top(i + 1, k)];
        quad(a, b, c, d);
        quad(d + 1, c + 1, b + 1, a + 1);
    }
    for j in 0..n {
        let sides = [
            (top(0, j), top(0, j + 1)),
            (top(j + 1, 0), top(j, 0)),
            (top(n, j + 1), top(n, j)),
            (top(j, n), top(j + 1, n)),
        ];
        for (a, b) in sides {
            quad(a, a + 1, b + 1, b);
        }
    }
    text
}

/// A ball of so many circles of latitude, each of twice as many points.
fn ball_obj(radius: f64, n: usize) -> String {
    let mut text = format!("v 0 {radius} 0\nv 0 {} 0\n", -radius);
    let turn = |part: f64| (std::f64::consts::PI * part).sin_cos();
    for (i, k) in (1..n).flat_map(|i| (0..2 * n).map(move |k| (i, k))) {
        let ((s, c), (sin, cos)) = (turn(i as f64 / n as f64), turn(k as f64 / n as f64));
        let _ = writeln!(text, "v {} {} {}", radius * s * cos, radius * c, radius * s * sin);
    }
    let at = |i: usize, k: usize| 3 + (i - 1) * 2 * n + k % (2 * n);
    for k in 0..2 * n {
        let _ = writeln!(text, "f 1 {} {}", at(1, k + 1), at(1, k));
        let _ = writeln!(text, "f 2 {} {}", at(n - 1, k), at(n - 1, k + 1));
        for i in 1..n - 1 {
            let [a, b, c, d] = [at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)];
            let _ = writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}");
        }
    }
    text
}

/// Of quaternions (w, x, y, z).
fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// The speed of what turns is that at this distance \[m\]: most things reach no farther.
const SIZE: f64 = 0.025;

/// How far a body's contacts are from carrying its weight at rest: the force left over, and its
/// torque about the centre of mass at [`SIZE`] where contacts alone hold it against turning, as
/// parts of all that presses it.
fn imbalance(session: &Session, body: u32, turns: bool) -> f64 {
    let world = session.world();
    let weight = world.desc().gravity * world.desc().rigids[body as usize].mass;
    let centre = world.rigid_pose(body).position;
    let (mut force, mut torque, mut pressed) = (weight, Vec3::zeros(), weight.norm());
    for contact in world.contacts() {
        let Some(side) = contact.bodies.iter().position(|b| *b == BodyId::Rigid(body)) else {
            continue;
        };
        let pull = if side == 0 { contact.force_W } else { -contact.force_W };
        force += pull;
        torque += (contact.position_W - centre).cross(&pull);
        pressed += pull.norm();
    }
    let turning = if turns { torque.norm() / SIZE } else { 0.0 };
    force.norm().max(turning) / pressed
}

/// What is wrong with a case, if anything is.
fn judge(case: &Case, folder: &std::path::Path) -> Option<String> {
    let mut session = Session::from_text(&case.text, &folder.join("matrix.toml"), &[])
        .unwrap_or_else(|e| panic!("{}: {e}\n{}", case.name, case.text));
    let h = session.world().time_step();
    let driven = !session.hands().is_empty();
    let rigids = &session.world().desc().rigids;
    let thing = rigids.iter().position(|r| r.name == "thing")? as u32;
    let energy = |s: &Session| s.world().energy(s.input()).total();
    let start = energy(&session);
    // Of a stack, how much it squeezes its grooves is not determined.
    let counts = |c: &&ContactPoint| driven || c.bodies.contains(&BodyId::Rigid(thing));
    let force = |s: &Session| -> f64 {
        let counted = s.world().contacts().iter().filter(counts);
        counted.map(|c| c.force_W.dot(&c.normal_W)).sum()
    };
    let (mut at_half, mut at_03, mut highest) = (None, None, start);
    let (mut before, mut flicker, mut speed) = (0.0, 0.0_f64, 0.0_f64);
    let (mut travel, mut sunk, mut depth, mut off) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    // Held against turning by a flywheel, what rolls is not held by its contacts alone.
    let turns = rigids[thing as usize].inertia.trace() < 1.0;
    for k in 1..=session.steps_wanted() {
        session.step(&mut ());
        let t = k as f64 * h;
        let p = session.world().rigid_pose(thing).position;
        // Drives bring a hand down: from then on it counts.
        let counts = !driven || at_half.is_some();
        highest = if counts { highest.max(energy(&session)) } else { energy(&session) };
        if t >= 0.3 {
            let from: f64 = *at_03.get_or_insert(p.y);
            sunk = sunk.max((p.y - from).abs());
        }
        let now = force(&session);
        if t >= 0.5 {
            let (from, _) = *at_half.get_or_insert((p, energy(&session)));
            travel = travel.max((p - from).xz().norm());
            flicker = flicker.max((now - before).abs() / now.max(1e-3));
            let [v, omega] = session.world().rigid_velocity(thing);
            speed = speed.max(v.norm() + omega.norm() * SIZE);
            let gaps = session.world().contacts().iter().map(|c| c.gap);
            depth = gaps.fold(depth, |depth, gap| depth.max(-gap));
            off = off.max(imbalance(&session, thing, turns));
        }
        before = now;
    }
    let (_, energy_at_half) = at_half?;
    let gained = highest - if driven { energy_at_half } else { start };
    let limit = 1e-6 + 1e-3 * start.abs();
    let stays = travel < 2e-4 && sunk < 2e-4 && speed < 1e-3 && depth < 5e-5;
    let well = stays && flicker < 1e-3 && off < 1e-3 && gained < limit;
    (!well).then(|| {
        let file = folder.join(format!("{}.toml", case.name.replace([' ', ','], "-")));
        std::fs::write(&file, &case.text).unwrap();
        format!(
            "{}: {:.3} mm sideways, {:.3} mm up or down, {:.2e} m/s, {:.1} um deep, force changes by {:.2} %, \
             {:.2} % out of balance, {:.1e} J gained: {}",
            case.name, travel * 1e3, sunk * 1e3, speed, depth * 1e6, flicker * 100.0, off * 100.0, gained,
            file.display()
        )
    })
}

/// Cases that failed where a contact came or went by round-off, where the direction of an edge did
/// (tin and mug), where the only place of a triangle wandered under a flat body (pebble and ball)
/// or along a rim with the triangle that rocked on it (tin and mug), where an overlap of nanometres
/// was undone at once and the body fell back (pill and pebble), and where impulses stayed within
/// the solver's tolerance until they jumped (mesh ball and rod: of a body that rests by its weight
/// `10 µm/s / (g h)`, 0.1 % at 1 ms).
const HARD: [&str; 12] = [
    "cube 10 on paper's hand, h 0.0010, at [0.0, 0.0]",
    "slab on mesh fine, h 0.0167, at [0.0, 0.0]",
    "tin on paper's hand, h 0.0010, at [0.017, -0.019]",
    "mug on paper's hand, h 0.0010, at [-0.021, -0.013]",
    "pebble on paper's hand, h 0.0050, at [-0.021, -0.013]",
    "ball 30 on soft coarse, h 0.0010, at [0.0, 0.0]",
    "tin on paper's hand, h 0.0050, at [0.017, -0.019]",
    "mug on paper's hand, h 0.0167, at [0.0125, 0.0125]",
    "pebble on paper's hand, h 0.0167, at [0.0, 0.0]",
    "pill on soft fine, h 0.0010, at [0.017, -0.019]",
    "mesh ball on soft coarse, h 0.0010, at [-0.0083, 0.0041]",
    "rod on mesh coarse, h 0.0010, at [0.017, -0.019]",
];

#[test]
fn what_is_set_down_stays() {
    let wanted = thenar_testing::cases_wanted();
    // An eleventh that meets every thing, support, step and place: 11 is coprime to their numbers.
    // So is 22 to those of things, steps and places, of which each support has all.
    let chosen: Vec<Case> = cases()
        .into_iter()
        .enumerate()
        .filter(|(i, case)| match wanted.as_deref() {
            Some("all") => true,
            Some(text) => case.name.contains(text),
            None => {
                let one_in = if case.slow { 22 } else { 11 };
                HARD.iter().any(|name| case.name.starts_with(name)) || i % one_in == 3
            }
        })
        .map(|(_, case)| case)
        .collect();
    let (folder, next, wrong) = (meshes(), AtomicUsize::new(0), Mutex::new(Vec::new()));
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                while let Some(case) = chosen.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if let Some(why) = judge(case, &folder) {
                        println!("{why}");
                        wrong.lock().unwrap_or_else(PoisonError::into_inner).push(why);
                    }
                }
            });
        }
    });
    let mut wrong = wrong.into_inner().unwrap_or_else(PoisonError::into_inner);
    wrong.sort();
    let least = if wanted.is_some() { 1 } else { cases().len() / 13 };
    assert!(chosen.len() >= least, "{} cases", chosen.len());
    let (count, of) = (wrong.len(), chosen.len());
    assert!(wrong.is_empty(), "{count} of {of} do not stay:\n{}", wrong.join("\n"));
}
