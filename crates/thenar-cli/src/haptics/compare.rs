//! The three modes on one motion.

use crate::building::told;
use crate::chart::{Axis, Dash, Line, Panel, page};
use crate::error::CliError;
use std::io::Write;
use std::path::{Path, PathBuf};
use thenar::Vec3;
use thenar_output::Output;
use thenar_scene::session::Session;
use thenar_scene::touch::{Comparison, Study, TouchMode, compare};
use thenar_touch::CouplingDesign;

/// Fingertips of a hand of about 600 tetrahedra over a table.
const SCENE: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/validation/e09-press.toml"));

/// The three modes of touch on one motion: stiffness, delay and energy.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene whose first hand is led; without one, fingertips press a table.
    scene: Option<PathBuf>,
    /// The way it is led, world [m].
    #[arg(long, num_args = 3, allow_negative_numbers = true, default_values_t = [0.0, -0.02, 0.0])]
    way: Vec<f64>,
    /// How often [Hz].
    #[arg(long, default_value_t = 1.0)]
    frequency: f64,
    /// Also draws force against time and against displacement as SVG.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
}

/// Modes and simulation periods \[ms\]; the first is the reference.
const RUNS: [(TouchMode, u64); 5] = [
    (TouchMode::SingleRate, 1),
    (TouchMode::SharedConstraints, 16),
    (TouchMode::SharedConstraints, 50),
    (TouchMode::Multirate, 16),
    (TouchMode::Multirate, 50),
];

/// Runs the command.
///
/// # Errors
/// The scene is wrong, or the picture cannot be written.
pub fn run(args: &Args) -> Result<(), CliError> {
    let svg = args.svg.as_deref().map(Output::create).transpose()?;
    let way = Vec3::new(args.way[0], args.way[1], args.way[2]);
    if !(way.norm() > 0.0 && way.norm() < 1.0) {
        return Err(CliError::Input("the way must be longer than 0 and shorter than 1 m".into()));
    }
    if !(0.05..=20.0).contains(&args.frequency) {
        return Err(CliError::Input("the frequency must be from 0.05 to 20 Hz".into()));
    }
    let session = match &args.scene {
        Some(file) => told(|| Ok(Session::load(file, &[])?))?,
        None => Session::from_text(SCENE, Path::new("e09-press.toml"), &[])?,
    };
    let cycle = (1000.0 / args.frequency).round() as u64;
    let study = Study { way, frequency: args.frequency, settle: 600, measured: 2 * cycle };
    println!("{}", head());
    let mut found: Vec<Comparison> = Vec::new();
    for (mode, period) in RUNS {
        let one = compare(&session, CouplingDesign::default(), mode, period, &study)
            .map_err(|e| CliError::Input(e.to_string()))?;
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

fn head() -> String {
    format!(
        "{:<20} {:>10} {:>10} {:>8} {:>10} {:>12} {:>12} {:>12}",
        "mode", "period", "stiffness", "delay", "rms error", "given", "stored", "largest jump"
    )
}

fn row(one: &Comparison, reference: &Comparison) -> String {
    format!(
        "{:<20} {:>7} ms {:>6.0} N/m {:>5.1} ms {:>8.3} N {:>9.2} mJ {:>9.2} mJ {:>10.3} N",
        one.mode.name(),
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
    let name = |one: &Comparison| format!("{}, {} ms", one.mode.name(), one.period);
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
            .map(|(i, one)| Line::new(name(one), i, Dash::Solid, points(one)))
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
