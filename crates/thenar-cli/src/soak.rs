//! `thenar soak`: thrashes a hand at random against table, car and bread, and watches for numbers
//! that are not finite and for energy that grows.

mod sweep;

use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;
use thenar::model::BodyId;
use thenar::world::Failure;
use thenar_scene::session::{Random, Session};

/// A hand can put no more energy than this into the scene: its drives at full stretch across the
/// pen hold about 100 J.
const ENERGY_MAX_J: f64 = 1000.0;

/// Half the width of the pen that keeps everything within reach, and its height \[m\].
const PEN: [f64; 2] = [0.25, 0.4];

/// Thrashes a hand at random against a table, a car and a loaf of bread.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Simulated time \[s\].
    #[arg(long, default_value_t = 60.0)]
    seconds: f64,
    /// Time steps to run, one after the other \[s\].
    #[arg(long = "time-step", value_delimiter = ',', default_values_t = [1.0 / 60.0, 1e-3])]
    time_steps: Vec<f64>,
    /// Seed of the motion.
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Soaks at couplings of 1e7 to 1e10 N/m⁴ and tissue of 5 kPa to 5 MPa, each at steps of 0.25 to
    /// 20 ms, instead of `--time-step`.
    #[arg(long, conflicts_with = "time_steps")]
    sweep: bool,
    /// Overrides as of `thenar run`, e.g. `hand.hand.coupling_stiffness=1e9`.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

/// Extremes of one soak.
#[derive(Clone, Copy, Debug, Default)]
struct Extremes {
    steps: u64,
    non_finite: u64,
    fell_back: u64,
    failure: Option<Failure>,
    energy: f64,
    penetration: f64,
    /// When that was \[s\], and between which bodies.
    deepest: Option<(f64, [BodyId; 2])>,
    joint_gap: f64,
    inverted: u32,
    contacts: u32,
    contact_residual: f64,
    speed: f64,
    hash: u64,
}

impl Extremes {
    fn sound(&self) -> bool {
        self.non_finite == 0 && self.energy < ENERGY_MAX_J
    }

    fn word(&self) -> &'static str {
        if self.sound() { "ok" } else { "FAIL" }
    }
}

/// Runs the command; exit code 1 when a soak went wrong.
pub fn run(args: &Args) -> ExitCode {
    let bad_step = args.time_steps.iter().any(|h| !(*h > 0.0 && *h <= 0.1));
    if bad_step || !(args.seconds > 0.0 && args.seconds <= 1e6) {
        eprintln!("error: --time-step must be within (0, 0.1] s and --seconds within (0, 1e6] s");
        return ExitCode::from(2);
    }
    match if args.sweep { sweep::run(args) } else { each_step(args) } {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(problem) => {
            eprintln!("error: {problem}");
            ExitCode::from(2)
        }
    }
}

fn each_step(args: &Args) -> Result<bool, String> {
    let mut passed = true;
    for &h in &args.time_steps {
        let e = soak(args, h, &[])?;
        passed &= e.sound();
        println!(
            "{:4}  step {:.3} ms, {} s, seed {}: {} steps, not finite {}, fell back {}, energy max \
             {:.3} J, penetration max {:.3} mm, joint gap max {:.3} mm, inverted tets max {}, \
             contacts max {}, node speed max {:.2} m/s, hash {:016x}",
            e.word(),
            h * 1e3,
            args.seconds,
            args.seed,
            e.steps,
            e.non_finite,
            e.fell_back,
            e.energy,
            e.penetration * 1e3,
            e.joint_gap * 1e3,
            e.inverted,
            e.contacts,
            e.speed,
            e.hash,
        );
        if let Some((time, bodies)) = e.deepest {
            let [a, b] = bodies.map(name_of);
            println!("      deepest at {time:.3} s, between {a} and {b}");
        }
        if let Some(failure) = e.failure {
            println!("      the last step that fell back: {failure}");
        }
    }
    Ok(passed)
}

fn soak(args: &Args, h: f64, more: &[String]) -> Result<Extremes, String> {
    let mut overrides = vec![format!("time_step={h}")];
    overrides.extend(args.overrides.iter().chain(more).cloned());
    let text = scene(args.seconds, args.seed);
    let mut session =
        Session::from_text(&text, Path::new("soak.toml"), &overrides).map_err(|e| e.to_string())?;
    let mut extremes = Extremes::default();
    let steps = (args.seconds / h).round() as u64;
    for step in 0..steps {
        let report = session.step(&mut ());
        extremes.steps += 1;
        extremes.non_finite += u64::from(report.non_finite);
        extremes.fell_back += u64::from(report.fell_back);
        extremes.failure = report.failure.or(extremes.failure);
        if report.penetration_max > extremes.penetration {
            extremes.penetration = report.penetration_max;
            let world = session.world();
            let deepest = world.contacts().iter().min_by(|a, b| a.gap.total_cmp(&b.gap));
            extremes.deepest = deepest.map(|contact| (world.time(), contact.bodies));
        }
        extremes.joint_gap = extremes.joint_gap.max(report.joint_gap_max);
        extremes.inverted = extremes.inverted.max(report.inverted_tets);
        extremes.contacts = extremes.contacts.max(report.contacts_active);
        extremes.contact_residual = extremes.contact_residual.max(report.contact_residual);
        if step % 16 == 0 {
            let world = session.world();
            extremes.energy = extremes.energy.max(world.energy(session.input()).total().abs());
            let speeds = world.node_velocities(0).iter().map(|v| v.norm());
            extremes.speed = speeds.fold(extremes.speed, f64::max);
        }
    }
    extremes.hash = session.world().state_hash();
    Ok(extremes)
}

/// A closed pen with a table, a car, a loaf and a hand that goes anywhere in it at random.
fn scene(seconds: f64, seed: u32) -> String {
    let mut random = Random::new(u64::from(seed));
    let mut text = String::from(
        r#"
version = 1
gravity = [0, -9.81, 0]

[[rigid]]
name = "table"
shape = { kind = "plane" }
motion = "fixed"
"#,
    );
    let [half, height] = PEN;
    let walls = [
        ("east", [half, 0.0], 90.0, [0, 0, 1]),
        ("west", [-half, 0.0], -90.0, [0, 0, 1]),
        ("north", [0.0, half], -90.0, [1, 0, 0]),
        ("south", [0.0, -half], 90.0, [1, 0, 0]),
    ];
    for (name, [x, z], angle, axis) in walls {
        let _ = write!(
            text,
            "\n[[rigid]]\nname = \"{name}\"\nshape = {{ kind = \"plane\" }}\nmotion = \"fixed\"\n\
             position = [{x}, 0, {z}]\nrotation = {{ axis = {axis:?}, angle_deg = {angle} }}\n"
        );
    }
    let _ = write!(
        text,
        r#"
[[rigid]]
name = "lid"
shape = {{ kind = "plane" }}
motion = "fixed"
position = [0, {height}, 0]
rotation = {{ axis = [0, 0, 1], angle_deg = 180 }}

[[rigid]]
name = "car"
shape = {{ kind = "car" }}
mass = 0.1
position = [0.1, 0.03, 0.1]

[[soft]]
name = "bread"
shape = {{ kind = "bread" }}
position = [-0.1, 0.06, 0]
material = {{ young = 12e3, poisson = 0.25, density = 250 }}
stiffness_damping = 0.005

[[hand]]
name = "hand"
position = [0, 0.2, 0]
motion = {{ kind = "keyframes", limits = "clamp", key = [
"#
    );
    // It begins above everything, as a hand that is in the table already says nothing.
    let (mut t, mut lowest) = (0.0, 0.2);
    while t < seconds + 1.0 {
        let position: Vec<String> = [-0.15, lowest, -0.15]
            .iter()
            .zip([0.15, 0.25, 0.15])
            .map(|(low, high)| format!("{:.4}", between(&mut random, *low, high)))
            .collect();
        let curl: Vec<String> = ["thumb", "index", "middle", "ring", "little"]
            .iter()
            .map(|finger| format!("{finger} = {:.3}", between(&mut random, 0.0, 1.0)))
            .collect();
        let fingers: Vec<String> = (0..3).map(|_| format!("{:.3}", random.symmetric())).collect();
        let back: Vec<String> = (0..3).map(|_| format!("{:.3}", random.symmetric())).collect();
        let _ = writeln!(
            text,
            "{{ time = {t:.3}, wrist = {{ position = [{}], fingers = [{}], back = [{}] }}, \
             curl = {{ {} }} }},",
            position.join(", "),
            fingers.join(", "),
            back.join(", "),
            curl.join(", ")
        );
        t += between(&mut random, 0.25, 0.9);
        lowest = 0.02;
    }
    text.push_str("] }\n");
    text
}

/// What the scene calls a body.
fn name_of(body: BodyId) -> &'static str {
    match body {
        BodyId::Soft(0) => "the hand",
        BodyId::Soft(_) => "the bread",
        BodyId::Rigid(0) => "the table",
        BodyId::Rigid(1..=4) => "a wall",
        BodyId::Rigid(5) => "the lid",
        BodyId::Rigid(6) => "the car",
        BodyId::Rigid(_) => "a bone",
    }
}

fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * 0.5 * (random.symmetric() + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five seconds at 60 Hz stay finite and bounded, and a second run gives the same bits.
    #[test]
    fn a_short_soak_is_sound_and_repeats() {
        let (seconds, time_steps, overrides) = (5.0, vec![], vec![]);
        let args = Args { seconds, time_steps, seed: 3, sweep: false, overrides };
        let first = soak(&args, 1.0 / 60.0, &[]).unwrap();
        assert_eq!(first.non_finite, 0);
        assert!(first.energy < ENERGY_MAX_J, "{first:?}");
        assert!(first.contacts > 10, "it must hit something: {first:?}");
        assert_eq!(first.hash, soak(&args, 1.0 / 60.0, &[]).unwrap().hash);
    }
}
