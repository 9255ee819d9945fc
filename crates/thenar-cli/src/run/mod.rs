//! `thenar run`: a scene without a window.

mod find;
mod grips;
mod outputs;
mod report;
mod timer;
mod verdict;
mod vtk;

pub use find::{
    SceneLocation, file, find, known, open, open_checked, open_live, tell, tell_overlaps,
};
pub use report::{report, times};
pub use timer::{STAGES, StageTimes, StopWatch};

use crate::error::CliError;
use crate::interrupt;
use crate::progress::Meter;
use crate::recorder::PictureOptions;
use crate::recording::{RecordOptions, Recording, attach};
use grips::GripReporter;
use outputs::Outputs;
use std::path::PathBuf;
use std::time::Instant;
use thenar_scene::format::Scene;
use thenar_scene::session::{Session, Summary, TakenBack};

/// Run a scene without a window.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene file, or the name of a built-in scene (see `thenar scenes`).
    scene: PathBuf,
    /// Simulated time [s] instead of the scene's own.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// Change a value of the scene, e.g. solver.cone=linearised; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Write the probes' table: CSV, or JSON lines if the name ends in .jsonl.
    #[arg(long, value_name = "FILE")]
    probe: Option<PathBuf>,
    /// Write figures of the run as JSON.
    #[arg(long, value_name = "FILE.json")]
    report: Option<PathBuf>,
    /// Write a series of VTK files for ParaView into this folder.
    #[arg(long, value_name = "DIR")]
    vtk: Option<PathBuf>,
    /// Simulated time between moments of the VTK series [s].
    #[arg(long, value_name = "S", default_value_t = 1.0 / 30.0, requires = "vtk", allow_negative_numbers = true)]
    vtk_interval: f64,
    /// Options of the recording.
    #[command(flatten)]
    recording: RecordOptions,
    /// Options of pictures.
    #[command(flatten)]
    pictures: PictureOptions,
    /// No progress bar and no summary.
    #[arg(long, short)]
    quiet: bool,
}

/// Outcome of a run.
#[derive(Debug)]
pub struct Outcome {
    /// Extremes of the whole run.
    pub summary: Summary,
    /// Time of each stage.
    pub times: StageTimes,
    /// Time of the whole loop \[s\].
    pub wall: f64,
    /// Steps that were made.
    pub steps: u64,
    /// Ctrl-C ended it early.
    pub interrupted: bool,
}

/// Runs a scene.
///
/// # Errors
/// The scene is wrong, an output cannot be written, or the run was interrupted.
pub fn run(args: &Args) -> Result<(), CliError> {
    seconds_make_sense(args.seconds)?;
    if !(args.vtk_interval > 0.0 && args.vtk_interval.is_finite()) {
        return Err(CliError::Input("--vtk-interval must be more than 0 s".into()));
    }
    args.pictures.check()?;
    let mut session = open_checked(&args.scene, &args.set, |scene| suits(args, scene))?;
    let steps = steps(&session, args.seconds)?;
    tell(&session);
    let mut outputs = Outputs::create(args, &session, steps)?;
    interrupt::listen();
    let recording = attach(&args.recording, &mut session)?;
    let outcome = advance(&mut session, steps, &mut outputs, args.quiet)?;
    outputs.finish(&session, &outcome)?;
    drop(session.take_witness());
    let recorded = recording.map(Recording::finish).transpose();
    // What was found out is worth telling even when the disk was full.
    if !args.quiet {
        report::print(&session, &outcome);
    }
    recorded?;
    match outcome.interrupted {
        true => Err(CliError::Other("interrupted; the outputs are written up to here".into())),
        false => Ok(TakenBack::judge(outcome.summary.non_finite, outcome.steps)?),
    }
}

/// Refuses a scene that has no probes to write, or ends before the moment of the picture.
fn suits(args: &Args, scene: &Scene) -> Result<(), CliError> {
    if args.probe.is_some() && scene.probe.is_empty() {
        return Err(CliError::Input("the scene has no probes to write".into()));
    }
    let (step, seconds) = (scene.time_step, args.seconds.unwrap_or(scene.duration));
    let end = (seconds / step).round().max(1.0) * step;
    match args.pictures.at {
        Some(at) if at > end + 0.5 * step => {
            Err(CliError::Input(format!("--at {at} s is beyond the end of the run at {end:.3} s")))
        }
        _ => Ok(()),
    }
}

fn seconds_make_sense(seconds: Option<f64>) -> Result<(), CliError> {
    match seconds {
        Some(s) if !(s > 0.0 && s <= 1e9) => {
            Err(CliError::Input("--seconds must be more than 0 s and at most 1e9 s".into()))
        }
        _ => Ok(()),
    }
}

/// Steps that a run of these seconds takes, or of the scene's own duration.
///
/// # Errors
/// The number makes no sense.
pub fn steps(session: &Session, seconds: Option<f64>) -> Result<u64, CliError> {
    seconds_make_sense(seconds)?;
    Ok(match seconds {
        Some(s) => (s / session.world().time_step()).round().max(1.0) as u64,
        None => session.steps_wanted(),
    })
}

fn advance(
    session: &mut Session,
    steps: u64,
    outputs: &mut Outputs,
    quiet: bool,
) -> Result<Outcome, CliError> {
    let meter = Meter::of_steps(steps, quiet);
    let mut watch = StopWatch::default();
    let mut summary = Summary::new(session);
    let start = Instant::now();
    let (mut interrupted, mut made) = (false, 0);
    outputs.take(session)?;
    let mut grips = GripReporter::new(session);
    for _ in 0..steps {
        session.step(&mut watch);
        grips.tell(session);
        summary.take(session);
        outputs.take(session)?;
        made += 1;
        meter.at(made, made);
        if interrupt::asked() {
            interrupted = true;
            break;
        }
    }
    let wall = start.elapsed().as_secs_f64();
    drop(meter);
    Ok(Outcome { summary, times: watch.times, wall, steps: made, interrupted })
}
