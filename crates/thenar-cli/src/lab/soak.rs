//! `thenar soak`: thrashes a hand at random against table, car and bread, and judges how well
//! contact and joints hold.

mod judge;
mod scene;
mod sweep;

pub use judge::{DEEP, JOINT_GAP_MAX, MISS_MAX};

use crate::build::PresetArg;
use crate::interrupt;
use judge::{Figure, quality, soundness};
use std::process::ExitCode;
use thenar_core::model::BodyId;
use thenar_core::world::{Failure, StepReport};
use thenar_scene::session::Session;

/// Thrashes a hand at random against a table, a car and a loaf of bread, and judges how well
/// contact and joints hold.
///
/// The hand begins where it overlaps nothing. Exit code 1 when a figure misses its limit.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Simulated time [s].
    #[arg(long, default_value_t = 60.0)]
    seconds: f64,
    /// Time steps to run, one after the other [s].
    #[arg(long = "time-step", value_delimiter = ',', default_values_t = [1.0 / 60.0, 1e-3])]
    time_steps: Vec<f64>,
    /// Seeds of the motion. Of several each must be sound, and all together are judged.
    #[arg(long = "seed", value_name = "SEED", value_delimiter = ',', default_values_t = [1])]
    seeds: Vec<u32>,
    /// Judge penetration, joint gaps and the accuracy of contact; with `false` only that numbers
    /// stay finite and energy bounded, which is all that `--sweep` judges.
    #[arg(long, value_name = "BOOL", default_value_t = true, action = clap::ArgAction::Set)]
    judge: bool,
    /// The hand, as scenes name it: the paper's or that for touch. Default: as scenes that name
    /// none have it.
    #[arg(long, value_enum, value_name = "WORD")]
    preset: Option<PresetArg>,
    /// Soaks the paper's hand at couplings of 1e7 to 1e10 N/m⁴ and tissue of 5 kPa to 5 MPa, each
    /// at steps of 0.25 to 20 ms, instead of `--time-step`.
    #[arg(long, conflicts_with_all = ["time_steps", "preset"])]
    sweep: bool,
    /// Overrides as of `thenar run`, e.g. `hand.hand.preset=touch`.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

/// Extremes of one soak.
#[derive(Clone, Copy, Debug, Default)]
struct Extremes {
    /// Places that were tried before one without overlap was found.
    tries: u32,
    steps: u64,
    non_finite: u64,
    fell_back: u64,
    failure: Option<Failure>,
    energy: f64,
    penetration: f64,
    /// Time of the deepest penetration \[s\], and the bodies between which it was.
    deepest: Option<(f64, [BodyId; 2])>,
    /// Steps with a penetration of [`judge::DEEP`] or more; of these the last ones in a row, and
    /// the most in a row.
    deep: u64,
    deep_now: u64,
    deep_longest: u64,
    joint_gap: f64,
    inverted: u32,
    contacts: u32,
    contact_residual: f64,
    /// Steps whose contact missed its accuracy, and the largest velocity error of these \[m/s\].
    missed: u64,
    missed_by: f64,
    speed: f64,
    hash: u64,
}

impl Extremes {
    fn sound(&self) -> bool {
        soundness(self).iter().all(|figure| figure.kept)
    }

    fn word(&self) -> &'static str {
        word(self.sound())
    }

    /// Takes in the soak of another seed; hash, places tried and the deepest place stay those of
    /// one.
    fn join(self, other: &Self) -> Self {
        Self {
            tries: self.tries,
            steps: self.steps + other.steps,
            non_finite: self.non_finite + other.non_finite,
            fell_back: self.fell_back + other.fell_back,
            failure: other.failure.or(self.failure),
            energy: self.energy.max(other.energy),
            penetration: self.penetration.max(other.penetration),
            deepest: if other.penetration > self.penetration {
                other.deepest
            } else {
                self.deepest
            },
            deep: self.deep + other.deep,
            deep_now: 0,
            deep_longest: self.deep_longest.max(other.deep_longest),
            joint_gap: self.joint_gap.max(other.joint_gap),
            inverted: self.inverted.max(other.inverted),
            contacts: self.contacts.max(other.contacts),
            contact_residual: self.contact_residual.max(other.contact_residual),
            missed: self.missed + other.missed,
            missed_by: self.missed_by.max(other.missed_by),
            speed: self.speed.max(other.speed),
            hash: self.hash,
        }
    }

    /// Takes in the step just done.
    fn take(&mut self, report: &StepReport) {
        self.steps += 1;
        self.non_finite += u64::from(report.non_finite);
        self.fell_back += u64::from(report.fell_back);
        self.failure = report.failure.or(self.failure);
        self.deep_now = if report.penetration_max < judge::DEEP { 0 } else { self.deep_now + 1 };
        self.deep += u64::from(self.deep_now > 0);
        self.deep_longest = self.deep_longest.max(self.deep_now);
        self.joint_gap = self.joint_gap.max(report.joint_gap_max);
        self.inverted = self.inverted.max(report.inverted_tets);
        self.contacts = self.contacts.max(report.contacts_active);
        self.contact_residual = self.contact_residual.max(report.contact_residual);
        if report.contact_unconverged {
            self.missed += 1;
            self.missed_by = self.missed_by.max(report.contact_residual);
        }
    }
}

fn word(passed: bool) -> &'static str {
    if passed { "ok" } else { "FAIL" }
}

/// Runs the command; exit code 1 when a soak went wrong.
pub fn run(args: &Args) -> ExitCode {
    let bad_step = args.time_steps.iter().any(|h| !(*h > 0.0 && *h <= 0.1));
    if args.sweep && args.seeds.len() > 1 {
        eprintln!("error: --sweep takes one --seed");
        return ExitCode::from(2);
    }
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
        passed &= each_seed(args, h)?;
        // Nobody reads the next one.
        if interrupt::asked() {
            break;
        }
    }
    Ok(passed)
}

/// Soaks with every seed, which are judged together.
fn each_seed(args: &Args, h: f64) -> Result<bool, String> {
    let figures = |e: &Extremes| {
        let more = if args.judge { quality(e, h) } else { Vec::new() };
        soundness(e).into_iter().chain(more).collect::<Vec<_>>()
    };
    let mut all: Option<Extremes> = None;
    for &seed in &args.seeds {
        let e = soak(args, h, seed, &[])?;
        match &args.seeds[..] {
            [_] => return Ok(print((args.seconds, h, seed), &e, &figures(&e))),
            _ => print((args.seconds, h, seed), &e, &soundness(&e)),
        };
        all = Some(all.map_or(e, |all| all.join(&e)));
        if interrupt::asked() {
            break;
        }
    }
    let figures = all.as_ref().map(figures).unwrap_or_default();
    let passed = are_kept(&figures);
    println!("{:4}  step {:.3} ms, all seeds together:", word(passed), h * 1e3);
    figures.iter().for_each(|figure| println!("      {figure}"));
    Ok(passed)
}

fn are_kept(figures: &[Figure]) -> bool {
    figures.iter().all(|figure| figure.kept)
}

/// Prints the soak of a seed, with its length and its step \[s\]; true when all figures keep to
/// their limits.
fn print((seconds, h, seed): (f64, f64, u32), e: &Extremes, figures: &[Figure]) -> bool {
    let passed = are_kept(figures);
    println!(
        "{:4}  step {:.3} ms, {} s, seed {}: {} steps, not finite {}, fell back {}, energy max \
         {:.3} J, penetration max {:.3} mm, joint gap max {:.3} mm, inverted tets max {}, \
         contacts max {}, node speed max {:.2} m/s, hash {:016x}",
        word(passed),
        h * 1e3,
        seconds,
        seed,
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
    if e.tries > 0 {
        println!("      begins at the first place without overlap: try {}", e.tries + 1);
    }
    if let Some((time, bodies)) = e.deepest {
        let [a, b] = bodies.map(scene::name_of);
        println!("      deepest at {time:.3} s, between {a} and {b}");
    }
    if let Some(failure) = e.failure {
        println!("      the last step that fell back: {failure}");
    }
    if e.non_finite > 0 {
        println!("      {} steps were taken back: their numbers made no sense", e.non_finite);
    }
    figures.iter().for_each(|figure| println!("      {figure}"));
    passed
}

fn soak(args: &Args, h: f64, seed: u32, more: &[String]) -> Result<Extremes, String> {
    let mut overrides = vec![format!("time_step={h}")];
    overrides.extend(args.preset.map(|preset| format!("hand.hand.preset={}", preset.word())));
    overrides.extend(args.overrides.iter().chain(more).cloned());
    let (mut session, tries) = scene::open(args.seconds, seed, &overrides)?;
    let mut extremes = Extremes { tries, ..Extremes::default() };
    let steps = (args.seconds / h).round() as u64;
    for step in 0..steps {
        let report = session.step(&mut ());
        extremes.take(&report);
        if report.penetration_max > extremes.penetration {
            extremes.penetration = report.penetration_max;
            let world = session.world();
            let deepest = world.contacts().iter().min_by(|a, b| a.gap.total_cmp(&b.gap));
            extremes.deepest = deepest.map(|contact| (world.time(), contact.bodies));
        }
        if step % 16 == 0 {
            look_around(&session, &mut extremes);
        }
    }
    extremes.hash = session.world().state_hash();
    Ok(extremes)
}

/// Takes the largest energy and speed into the extremes; called now and then.
fn look_around(session: &Session, extremes: &mut Extremes) {
    let world = session.world();
    extremes.energy = extremes.energy.max(world.energy(session.input()).total().abs());
    let speeds = world.node_velocities(0).iter().map(|v| v.norm());
    extremes.speed = speeds.fold(extremes.speed, f64::max);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five seconds at 60 Hz stay finite and bounded, and a second run gives the same bits.
    #[test]
    fn a_short_soak_is_sound_and_repeats() {
        let (seconds, time_steps, overrides) = (5.0, vec![], vec![]);
        let args = Args {
            seconds,
            time_steps,
            seeds: vec![3],
            judge: true,
            preset: Some(PresetArg::Paper),
            sweep: false,
            overrides,
        };
        let first = soak(&args, 1.0 / 60.0, 3, &[]).unwrap();
        assert!(first.sound(), "{first:?}");
        assert!(first.contacts > 10, "it must hit something: {first:?}");
        assert_eq!(first.hash, soak(&args, 1.0 / 60.0, 3, &[]).unwrap().hash);
    }

    /// The hand for touch, thrashed. With seed 1 it jams the car under it from 3.1 s on, with 4 J
    /// in its drives.
    #[test]
    fn a_hand_for_touch_is_not_torn_up() {
        let args = Args {
            seconds: 4.2,
            time_steps: vec![],
            seeds: vec![1],
            judge: true,
            sweep: false,
            preset: Some(PresetArg::Touch),
            overrides: vec![],
        };
        let soaked = soak(&args, 1.0 / 60.0, 1, &[]).unwrap();
        assert!(soaked.sound() && soaked.contacts > 10, "{soaked:?}");
        assert!(soaked.penetration < 5e-3 && soaked.missed_by < 1e-3, "{soaked:?}");
    }

    /// Deep steps are counted in a row, misses with their size.
    #[test]
    fn the_tally_tells_how_long_and_how_much() {
        let mut e = Extremes::default();
        for depth in [0.0, 1e-3, 2e-3, 0.9e-3, 1e-3, 3e-3, 1.5e-3, 0.0] {
            e.take(&StepReport { penetration_max: depth, ..StepReport::default() });
        }
        let missed = |contact_residual| StepReport {
            contact_unconverged: true,
            contact_residual,
            ..StepReport::default()
        };
        e.take(&missed(2e-4));
        e.take(&missed(1e-4));
        e.take(&StepReport { contact_residual: 5e-3, ..StepReport::default() });
        assert_eq!((e.steps, e.deep, e.deep_longest), (11, 5, 3));
        assert_eq!((e.missed, e.missed_by), (2, 2e-4));
        // Of two seeds counts are added, and what lasts does not go on from one to the other.
        let both = e.join(&Extremes { steps: 9, deep: 1, deep_longest: 1, ..Extremes::default() });
        assert_eq!((both.steps, both.deep, both.deep_longest, both.missed), (20, 6, 3, 2));
    }
}
