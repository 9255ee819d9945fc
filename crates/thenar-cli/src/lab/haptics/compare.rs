//! The three modes on one motion.

use super::rehearse::tracker;
use crate::chart::{Axis, Dash, Line, Panel, page};
use crate::error::CliError;
use crate::run::open_live;
use std::io::Write;
use std::path::{Path, PathBuf};
use thenar_core::Vec3;
use thenar_link::haptic_loop::LoopMode;
use thenar_output::Output;
use thenar_rehearsal::{Comparison, Study};
use thenar_scene::session::Session;
use thenar_touch::{CouplingDesign, TrackerTiming};

/// Fingertips of a hand of about 600 tetrahedra over a table.
const SCENE: &str = include_str!("../../../scenes/validation/e09-press.toml");

/// The three modes of touch on one motion: stiffness, delay and energy.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene whose first hand is led; without one, fingertips press a table.
    scene: Option<PathBuf>,
    /// The way it is led, world [m].
    #[arg(long, num_args = 3, allow_negative_numbers = true, default_values_t = [0.0, -0.02, 0.0])]
    way: Vec<f64>,
    /// Frequency of the motion [Hz].
    #[arg(long, default_value_t = 1.0)]
    frequency: f64,
    /// Rate [Hz], delay [ms] and noise [mm] of the tracker.
    #[arg(long, value_name = "HZ,DELAY,NOISE", default_value = "1000,0,0", value_parser = tracker)]
    tracker: TrackerTiming,
    /// Damping of the loosest grip that the loop reckons with [N s/m]; without it the couplings are
    /// felt as they are.
    #[arg(long, value_name = "B")]
    grip: Option<f64>,
    /// Also draws force against time and against displacement as SVG.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
}

/// Modes and periods of the scene \[ms\]; the first, which steps within each tick, is the
/// reference.
const RUNS: [(LoopMode, u64); 5] = [
    (LoopMode::SingleRate, 16),
    (LoopMode::Shared, 16),
    (LoopMode::Shared, 50),
    (LoopMode::Multirate, 16),
    (LoopMode::Multirate, 50),
];

/// Runs the command.
///
/// # Errors
/// The scene is wrong, or the picture cannot be written.
pub fn run(args: &Args) -> Result<(), CliError> {
    let svg = args.svg.as_deref().map(Output::create).transpose()?;
    let way = Vec3::new(args.way[0], args.way[1], args.way[2]);
    let (frequency, grip) = (args.frequency, args.grip);
    let (tracker, design) = (args.tracker, CouplingDesign::default());
    let study = Study { way, frequency, cycles: 2, tracker, design, grip };
    study.check().map_err(|e| CliError::Input(e.to_string()))?;
    println!("{}", head());
    let mut found: Vec<Comparison> = Vec::new();
    for (mode, period) in RUNS {
        let step = [format!("time_step={}", 1e-3 * period as f64)];
        let session = match &args.scene {
            Some(file) => open_live(file, &step)?,
            None => Session::from_text(SCENE, Path::new("e09-press.toml"), &step)?,
        };
        let one = study.run(session, mode).map_err(|e| CliError::Input(e.to_string()))?;
        println!("{}", row(&one, found.first().unwrap_or(&one)));
        found.push(one);
    }
    if let Some(mut svg) = svg {
        svg.write_all(picture(&found).as_bytes())
            .map_err(|e| CliError::Other(format!("cannot write the picture: {e}")))?;
        svg.finish()?;
    }
    Ok(())
}

/// Name of a mode in tables.
fn name(mode: LoopMode) -> &'static str {
    match mode {
        LoopMode::Multirate => "multirate",
        LoopMode::Shared => "shared constraints",
        LoopMode::SingleRate => "single-rate",
    }
}

fn head() -> String {
    format!(
        "{:<20} {:>10} {:>10} {:>8} {:>10} {:>12} {:>12} {:>12}",
        "mode", "period", "stiffness", "delay", "rms error", "given", "stored", "largest jump"
    )
}

fn row(one: &Comparison, reference: &Comparison) -> String {
    format!(
        "{:<20} {:>7} ms {:>6.0} N/m {:>5.1} ms {:>8.3} N {:>9.2} mJ {:>9.2} mJ {:>10.3} N",
        name(one.mode),
        one.period,
        one.stiffness,
        one.delay_ms,
        one.rms_from(reference),
        1e3 * one.given,
        1e3 * one.stored_max,
        one.jump_max
    )
}

fn picture(found: &[Comparison]) -> String {
    let named = |one: &Comparison| format!("{}, {} ms", name(one.mode), one.period);
    let over_time = |one: &Comparison| -> Vec<(f64, f64)> {
        let each = one.force.iter().enumerate().step_by(4);
        each.map(|(ms, force)| (1e-3 * ms as f64, *force)).collect()
    };
    let over_way = |one: &Comparison| -> Vec<(f64, f64)> {
        let pairs = one.displacement.iter().zip(&one.force).skip(one.force.len() / 2).step_by(4);
        pairs.map(|(d, f)| (1e3 * d, *f)).collect()
    };
    let panel = |title: &str, x: &str, points: &dyn Fn(&Comparison) -> Vec<(f64, f64)>| {
        let lines: Vec<Line> = (found.iter().enumerate())
            .map(|(i, one)| Line::new(named(one), i, Dash::Solid, points(one)))
            .collect();
        let all = || lines.iter().flat_map(|line| line.points.iter().copied());
        Panel {
            title: title.into(),
            x_label: x.into(),
            x: Axis::linear(all().map(|p| p.0)),
            y: Axis::linear(all().map(|p| p.1)),
            lines,
            marks: Vec::new(),
        }
    };
    let panels = [
        panel("force on the hand [N]", "time [s]", &over_time),
        panel("force on the hand, last half [N]", "way [mm]", &over_way),
    ];
    page("Three modes of touch on one motion", "all couplings together, along the way", &panels)
}
