//! `thenar compare`: the two-step scheme and the monolithic solver on one scene.

mod charts;
mod json;
mod print;
mod sweep;

use crate::error::CliError;
use crate::interrupt;
use crate::progress::Meter;
use crate::run::{StopWatch, open};
use charts::Charts;
use std::io::Write;
use std::path::{Path, PathBuf};
use thenar_output::Output;
use thenar_scene::compare::{CompareError, CompareMode, Comparison, SIDES, Scheme};
use thenar_scene::session::{TableFormat, TableWriter};

/// Millimetres in a metre.
const MM: f64 = 1e3;
/// Degrees in a radian.
const DEG: f64 = 180.0 / std::f64::consts::PI;

/// Setting by which a scene's silence means the paper's hand.
const TWO_STEP: &str = "solver.kind=two-step";

/// Compare the two-step scheme with the monolithic solver on one scene.
///
/// Both get the same motions, loads and settings, and springs as joint limits. Hands of which the
/// scene does not say are the paper's, as springs in bone need the monolithic solver. The two-step
/// scheme is the scene's; --paper makes it the paper's.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene file, or the name of a built-in scene (see `thenar scenes`).
    scene: PathBuf,
    /// Simulated time [s] instead of the scene's own.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// Change a value of the scene, e.g. time_step=0.001; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// The two-step scheme as the paper prints it: flesh frozen in step 1, joints left to the next
    /// step.
    #[arg(long)]
    paper: bool,
    /// Both set out from the monolithic state in every step: what one step does differently, with
    /// inner solvers at their most accurate. Times are not comparable then.
    #[arg(long)]
    single_steps: bool,
    /// Write what is compared over time, in SI units: CSV, or JSON lines if the name ends in
    /// .jsonl.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw it.
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
    /// Write means, extremes and times as JSON.
    #[arg(long, value_name = "FILE.json")]
    report: Option<PathBuf>,
    /// No progress bar and no table.
    #[arg(long, short)]
    quiet: bool,
    /// Instead: measure single steps, and whether the motion diverges, over coupling stiffness and
    /// time step.
    #[command(flatten)]
    sweep: sweep::Options,
}

/// Runs the comparison.
///
/// # Errors
/// The scene is wrong, solvers cannot be compared on it, an output cannot be written, or the run
/// was interrupted.
pub fn run(args: &Args) -> Result<(), CliError> {
    if args.seconds.is_some_and(|s| !(f64::MIN_POSITIVE..=1e9).contains(&s)) {
        return Err(CliError::Input("--seconds must be more than 0 s and at most 1e9 s".into()));
    }
    if args.sweep.sweep {
        return sweep::run(args);
    }
    // Both sides get the hand of the two-step scheme, where the scene says no other.
    let set = [&[TWO_STEP.to_owned()], &args.set[..]].concat();
    let sessions = [open(&args.scene, &set)?, open(&args.scene, &set)?];
    sessions[0].warnings().iter().for_each(|warning| eprintln!("warning: {warning}"));
    let steps = match args.seconds {
        Some(s) => (s / sessions[0].world().time_step()).round().max(1.0) as u64,
        None => sessions[0].steps_wanted().max(1),
    };
    let mode = if args.single_steps { CompareMode::SingleSteps } else { CompareMode::Trajectories };
    let scheme = if args.paper { Scheme::Paper } else { Scheme::AsSet };
    let mut comparison = Comparison::new(sessions, mode, scheme)?;
    interrupt::listen();
    let mut table = args.csv.as_deref().map(|path| start_table(path, &comparison)).transpose()?;
    let mut svg = args.svg.as_deref().map(Output::create).transpose()?;
    let mut report = args.report.as_deref().map(Output::create).transpose()?;
    let writes = table.is_some() || svg.is_some() || report.is_some();

    let mut watches = [StopWatch::default(), StopWatch::default()];
    let mut charts = Charts::new(&comparison, steps);
    let meter = Meter::of_steps(steps, args.quiet);
    let mut lost = [false; 2];
    for step in 0..=steps {
        if step > 0 {
            comparison.step(&mut watches);
            meter.at(step, step);
        }
        if let Some(table) = &mut table {
            let time = comparison.moment().time;
            table.row(time, comparison.row()).map_err(|e| failed("the table", &e))?;
        }
        if svg.is_some() {
            charts.take(&comparison);
        }
        for side in 0..2 {
            if comparison.has_diverged(side) && !lost[side] {
                lost[side] = true;
                meter.suspend(|| print::divergence(&comparison, side));
            }
        }
        // Files are made whoever reads what is printed.
        let unwanted = interrupt::asked() && !writes;
        if interrupt::pressed() || unwanted || !comparison.goes_on() {
            break;
        }
    }
    let interrupted = interrupt::pressed();
    drop(meter);

    if let Some(table) = table {
        table.finish().map_err(|e| failed("the table", &e))?.finish()?;
    }
    if let Some(mut svg) = svg.take() {
        let page = charts.page(&comparison);
        svg.write_all(page.as_bytes()).map_err(|e| failed("the chart", &e))?;
        svg.finish()?;
    }
    if let Some(mut report) = report.take() {
        let text = json::report(&comparison, args.paper, &watches);
        writeln!(report, "{text:#}").map_err(|e| failed("the report", &e))?;
        report.finish()?;
    }
    if !args.quiet {
        print::summary(&comparison, args.paper, &watches);
    }
    match interrupted {
        true => Err(CliError::Other("interrupted; the outputs are written up to here".into())),
        false => Ok(()),
    }
}

fn start_table(path: &Path, of: &Comparison) -> Result<TableWriter<Output>, CliError> {
    let lines = path.extension().is_some_and(|e| e == "jsonl");
    let format = if lines { TableFormat::JsonLines } else { TableFormat::Csv };
    let output = Output::create(path)?;
    TableWriter::new(output, format, of.columns()).map_err(|e| failed("the table", &e))
}

fn failed(what: &str, error: &std::io::Error) -> CliError {
    CliError::Other(format!("cannot write {what}: {error}"))
}

/// The two-step scheme's name in reports.
fn names(paper: bool) -> [&'static str; 2] {
    if paper { ["two-step, paper", SIDES[1]] } else { SIDES }
}

impl From<CompareError> for CliError {
    fn from(error: CompareError) -> Self {
        Self::Input(error.to_string())
    }
}
