//! `thenar fit`: moduli of a finger from what was measured on it.

mod assess;
mod bench;
mod data;
mod least_squares;
mod report;
mod student;
mod unknowns;

use crate::error::CliError;
use crate::interrupt;
use crate::run::{SceneLocation, find};
use assess::{Assessment, Parameter, assess};
use bench::{Bench, Finger};
use data::PressData;
use least_squares::{Minimum, Trial, Trouble, minimise};
use report::{FitReport, digits};
use std::io::Write;
use std::path::PathBuf;
use thenar_core::model::Digit;
use thenar_output::Output;
use unknowns::{OFFSET, Unknown};

/// The built-in press: a flat plate on the pad of a finger of the hand for touch.
const PRESS: &str = include_str!("../../../scenes/validation/f01-press.toml");
const PRESS_FILE: &str = "scenes/validation/f01-press.toml";

/// Find moduli from force and depth measured on a finger, with their uncertainty.
///
/// The table has a header with units, e.g. `depth [mm],force [N]`, and perhaps `time [s]`. The
/// program's own press is run again and again until its force fits best; see docs/fit.md.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The measurement: CSV with the columns depth, force and perhaps time.
    data: PathBuf,
    /// A scene that presses, instead of the built-in one: one scripted body with keyframes, and a
    /// contact probe that has it.
    #[arg(long, value_name = "SCENE", conflicts_with_all = ["finger", "angle"])]
    scene: Option<PathBuf>,
    /// The scripted body that presses; needed if there are several.
    #[arg(long, value_name = "NAME", requires = "scene")]
    body: Option<String>,
    /// The finger of the built-in press: thumb, index, middle, ring or little.
    #[arg(long, value_name = "FINGER", default_value = "index")]
    finger: String,
    /// Angle of the built-in press between plate and hand (of the thumb: its last bone) [degrees].
    #[arg(long, value_name = "DEG", default_value_t = 30.0)]
    angle: f64,
    /// Speed of the press where the data have no time [mm/s].
    #[arg(long, value_name = "MM/S", default_value_t = 5.0)]
    rate: f64,
    /// Parameters to find: young, alpha (Ogden's law), part1 to part4 and time1 to time4 (memory),
    /// or keys of the scene with a start, e.g. hand.hand.material.poisson=0.45; `young=3e4` starts
    /// there.
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',', default_value = "young")]
    parameters: Vec<String>,
    /// The zero of depth is certain: do not fit it.
    #[arg(long)]
    no_offset: bool,
    /// An interval that spans a larger factor counts as unknown.
    #[arg(long, value_name = "FACTOR", default_value_t = 3.0)]
    factor: f64,
    /// Change a value of the scene, e.g. hand.hand.length=0.18; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Also write what was found as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Also write depth, force and fitted force as CSV.
    #[arg(long, value_name = "FILE")]
    curve: Option<PathBuf>,
    /// No word on how far it is.
    #[arg(long, short)]
    quiet: bool,
}

/// Runs the command.
///
/// # Errors
/// Data, scene or a parameter is wrong, the press cannot be computed, an output cannot be written,
/// or Ctrl-C was pressed.
pub fn run(args: &Args) -> Result<(), CliError> {
    check(args)?;
    thenar_output::protect(&args.data);
    let data = data::read(&args.data)?;
    let bench = bench(args)?;
    let session = bench.session()?;
    let unknowns = unknowns(args, &session)?;
    let rows = data.depth.len();
    if rows <= unknowns.len() {
        let (file, n) = (args.data.display(), unknowns.len());
        return Err(CliError::Input(format!(
            "{file}: {rows} rows of data cannot give {n} parameters and their errors; at least {} are needed",
            n + 1
        )));
    }
    let json = args.json.as_deref().map(Output::create).transpose()?;
    let curve = args.curve.as_deref().map(Output::create).transpose()?;

    interrupt::listen();
    let fit = fit(&bench, &data, &unknowns, args.factor, |iteration, values, left| {
        if !args.quiet {
            let names = unknowns.iter().zip(values);
            let all = names.map(|(u, v)| format!("{} {}", u.parameter.name, digits(*v)));
            let all = all.collect::<Vec<_>>().join(", ");
            eprintln!("step {iteration}: {all}; {} N left", digits(left));
        }
    })?;

    let softs = &session.world().desc().softs;
    let tets: usize = softs.iter().map(|s| s.flesh.tets.len()).sum();
    let told = FitReport {
        unknowns: &unknowns,
        found: &fit.found,
        rows,
        converged: fit.minimum.converged,
        iterations: fit.minimum.iterations,
        runs: fit.runs,
        setup: format!(
            "{tets} tetrahedra, steps of {} ms",
            digits(1e3 * session.world().time_step())
        ),
    };
    println!("{}", told.text());
    let failed = |e: std::io::Error| CliError::Other(format!("cannot write: {e}"));
    if let Some(mut json) = json {
        writeln!(json, "{:#}", told.json()).map_err(failed)?;
        json.finish()?;
    }
    if let Some(mut curve) = curve {
        writeln!(curve, "depth [m],force [N],fitted [N]").map_err(failed)?;
        for i in 0..rows {
            let (depth, force) = (data.depth[i], data.force[i]);
            writeln!(curve, "{depth:e},{force:e},{:e}", force + fit.minimum.residuals[i])
                .map_err(failed)?;
        }
        curve.finish()?;
    }
    Ok(())
}

fn check(args: &Args) -> Result<(), CliError> {
    let wrong = |what: &str| Err(CliError::Input(what.into()));
    if !(0.01..=1000.0).contains(&args.rate) {
        return wrong("--rate must be from 0.01 to 1000 mm/s");
    }
    if !(args.factor > 1.0 && args.factor <= 1e6) {
        return wrong("--factor must be more than 1 and at most 1e6");
    }
    if !(-30.0..=90.0).contains(&args.angle) {
        return wrong("--angle must be from -30 to 90 degrees");
    }
    Ok(())
}

fn bench(args: &Args) -> Result<Bench, CliError> {
    let rate = 1e-3 * args.rate;
    let Some(scene) = &args.scene else {
        let known = Digit::FINGERS.map(Digit::name);
        let digit =
            Digit::FINGERS.into_iter().find(|d| d.name() == args.finger).ok_or_else(|| {
                let finger = thenar_input::quoted(&args.finger);
                CliError::Input(format!(
                    "--finger: no finger {finger}; there are {}",
                    known.join(", ")
                ))
            })?;
        let finger = Finger { digit, angle_deg: args.angle };
        return Bench::new(PRESS.into(), PRESS_FILE.into(), &args.set, None, Some(finger), rate);
    };
    let (text, file) = match find(scene)? {
        SceneLocation::File(path) => {
            thenar_output::protect(&path);
            (thenar_scene::session::read_scene(&path)?, path)
        }
        SceneLocation::Builtin(known) => (known.text.to_string(), crate::run::file(scene)?),
    };
    Bench::new(text, file, &args.set, args.body.as_deref(), None, rate)
}

fn unknowns(
    args: &Args,
    session: &thenar_scene::session::Session,
) -> Result<Vec<Unknown>, CliError> {
    let mut all: Vec<Unknown> = Vec::new();
    let wrong = |e: String| CliError::Input(format!("--parameters: {e}"));
    for text in args.parameters.iter().filter(|text| text.trim() != OFFSET) {
        let unknown = Unknown::read(text, session).map_err(wrong)?;
        if all.iter().any(|u| u.key == unknown.key) {
            return Err(wrong(format!("`{}` is given twice", unknown.parameter.name)));
        }
        all.push(unknown);
    }
    if all.is_empty() {
        return Err(wrong("nothing is to be found".into()));
    }
    if !args.no_offset {
        all.push(Unknown::offset());
    }
    Ok(all)
}

/// A fit that is done.
struct Fit {
    minimum: Minimum,
    found: Assessment,
    runs: usize,
}

/// Differences are taken over this much of a logarithm, or of an offset's unit: a press repeats to
/// 1e-4 of its force (steps end at velocities of 1e-5 m/s), and over four hundredths the second
/// derivative leaves less.
const WIDTH: f64 = 0.02;

fn fit(
    bench: &Bench,
    data: &PressData,
    unknowns: &[Unknown],
    span_max: f64,
    mut tell: impl FnMut(u32, &[f64], f64),
) -> Result<Fit, CliError> {
    let curve = |u: &[f64]| -> Result<Trial, CliError> {
        let mut changes = Vec::new();
        let mut offset = 0.0;
        for (unknown, u) in unknowns.iter().zip(u) {
            let value = unknown.parameter.value(*u);
            match &unknown.key {
                Some(key) => changes.push(format!("{key}={value:e}")),
                None if value.abs() > bench::SLACK => {
                    return Ok(Trial::Impossible(format!("an offset of {value:e} m")));
                }
                None => offset = value,
            }
        }
        bench.forces(data, &changes, offset)
    };
    let start = vec![0.0; unknowns.len()];
    let values = |u: &[f64]| -> Vec<f64> {
        unknowns.iter().zip(u).map(|(unknown, u)| unknown.parameter.value(*u)).collect()
    };
    let widths: Vec<f64> = unknowns
        .iter()
        // Of an offset more: a tenth of its unit, the way of a press of 5 mm/s in 5 ms.
        .map(|u| if u.key.is_some() { WIDTH } else { 5.0 * WIDTH })
        .collect();
    let minimum =
        minimise(&curve, &data.force, &start, &widths, |i, u, left| tell(i, &values(u), left));
    let minimum = minimum.map_err(|trouble| match trouble {
        Trouble::NoStart(reason) => CliError::Input(format!("the press cannot start: {reason}")),
        Trouble::Ended(error) => error,
    })?;
    let parameters: Vec<Parameter> = unknowns.iter().map(|u| u.parameter.clone()).collect();
    let found = assess(&parameters, &minimum, span_max);
    Ok(Fit { minimum, found, runs: bench.presses() })
}

#[cfg(test)]
mod tests;
