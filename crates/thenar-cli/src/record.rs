//! `thenar record`: a scene run and recorded.

use crate::error::CliError;
use crate::progress::Meter;
use crate::recording::{RecordOptions, attach};
use crate::run::{open, tell};
use crate::{files, interrupt};
use std::path::{Path, PathBuf};
use thenar_scene::session::TakenBack;

/// Run a scene as fast as it can and record it.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene file, or the name of a built-in scene (see `thenar scenes`).
    scene: PathBuf,
    /// Simulated time [s] instead of the scene's own.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// File to write, which must not be there yet; without it the scene's name and `.rec`.
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Change a value of the scene, e.g. solver.cone=linearised; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Simulated time between keyframes, from which a replay can begin [s]; 0 for none.
    #[arg(long, value_name = "S", default_value_t = 1.0, allow_negative_numbers = true)]
    keyframes: f64,
    /// No progress bar and no summary.
    #[arg(long, short)]
    quiet: bool,
}

/// Records what a device sends.
///
/// # Errors
/// The scene is wrong, the file cannot be written, or the run was interrupted.
pub fn run(args: &Args) -> Result<(), CliError> {
    let mut session = open(&args.scene, &args.set)?;
    tell(&session);
    let steps = crate::run::steps(&session, args.seconds)?;
    let name = || Path::new(session.name()).with_extension("rec");
    let file = args.out.clone().unwrap_or_else(name);
    let options = RecordOptions { record: Some(file), keyframes: args.keyframes };
    interrupt::listen();
    let mut recording = attach(&options, &mut session)?;
    let meter = Meter::of_steps(steps, args.quiet);
    let (mut made, mut taken) = (0, 0);
    while made < steps && !interrupt::asked() {
        taken += u64::from(session.step(&mut ()).non_finite);
        made += 1;
        meter.at(made, made);
        if let Some(recording) = &mut recording {
            recording.complain();
        }
    }
    drop(meter);
    let hash = session.world().state_hash();
    let time = session.world().time();
    drop(session);
    if let Some(recording) = recording {
        let name = recording.file().display().to_string();
        let bytes = recording.finish()?;
        if !args.quiet {
            println!("{name}: {time:.3} s in {made} steps, {}", files::size(bytes));
            println!("  state {hash:016x}");
        }
    }
    match made < steps {
        true => Err(CliError::Other("interrupted; what was recorded up to here is kept".into())),
        false => Ok(TakenBack::judge(taken, made)?),
    }
}
