//! `thenar compare --sweep`: the error of splitting over coupling stiffness and time step.

use super::Args;
use crate::chart::{Axis, Dash, Line, Panel, page};
use crate::error::CliError;
use crate::run::{file, open};
use serde_json::{Value, json};
use std::io::Write;
use thenar_output::Output;
use thenar_scene::compare::Scheme;
use thenar_scene::compare::sweep::{Plan, SCHEMES, SchemeResult, SweepError, SweepPoint, sweep};

/// Stiffnesses and time steps of a sweep.
#[derive(Debug, clap::Args)]
pub struct Options {
    /// Measure over coupling stiffness and time step instead.
    #[arg(long, conflicts_with_all = ["paper", "single_steps", "csv"])]
    pub sweep: bool,
    /// Coupling stiffnesses per volume of flesh [N/m⁴].
    #[arg(long, value_name = "K,K", value_delimiter = ',', requires = "sweep",
          default_values_t = [1e6, 1e7, 1e8, 1e9, 1e10])]
    stiffness: Vec<f64>,
    /// Time steps [ms].
    #[arg(long, value_name = "MS,MS", value_delimiter = ',', requires = "sweep",
          default_values_t = [1.0, 5.0, 16.7])]
    steps_ms: Vec<f64>,
    /// Simulated time at which comparing begins, the monolithic solver up to there [s].
    #[arg(long, value_name = "S", requires = "sweep", default_value_t = 1.0)]
    from: f64,
}

/// Makes the sweep and prints it as a table in Markdown.
///
/// # Errors
/// The scene or a value is wrong, or an output cannot be written.
pub fn run(args: &Args) -> Result<(), CliError> {
    let options = &args.sweep;
    let wrong = |what: &str| Err(CliError::Input(what.into()));
    if options.stiffness.iter().any(|k| !(1.0..=1e15).contains(k)) {
        return wrong("--stiffness must be from 1 to 1e15 N/m⁴");
    }
    if options.steps_ms.iter().any(|h| !(1e-4..=1e4).contains(h)) {
        return wrong("--steps-ms must be from 1e-4 to 1e4 ms");
    }
    if !(0.0..=1e6).contains(&options.from) {
        return wrong("--from must be from 0 to 1e6 s");
    }
    let session = open(&args.scene, &args.set)?;
    let plan = Plan {
        stiffness: options.stiffness.clone(),
        time_steps: options.steps_ms.iter().map(|ms| ms * 1e-3).collect(),
        from: options.from,
        seconds: args.seconds.unwrap_or(0.5),
    };
    let svg = args.svg.as_deref().map(Output::create).transpose()?;
    let report = args.report.as_deref().map(Output::create).transpose()?;

    if !args.quiet {
        println!("{}", HEAD.trim_end());
    }
    let tell = |point: &SweepPoint| {
        if !args.quiet {
            rows(point).iter().for_each(|row| println!("{row}"));
        }
    };
    let points = sweep(session.scene(), &file(&args.scene)?, &plan, tell)?;
    if let Some(mut svg) = svg {
        let text = charts(session.name(), &plan, &points);
        svg.write_all(text.as_bytes()).map_err(|e| super::failed("the chart", &e))?;
        svg.finish()?;
    }
    if let Some(mut report) = report {
        let text = json!({
            "scene": session.name(),
            "from_s": plan.from,
            "seconds": plan.seconds,
            "points": points.iter().map(as_json).collect::<Vec<_>>(),
            "version": env!("CARGO_PKG_VERSION"),
        });
        writeln!(report, "{text:#}").map_err(|e| super::failed("the report", &e))?;
        report.finish()?;
    }
    Ok(())
}

const HEAD: &str = "\
| step [ms] | κ [N/m⁴] | γ | scheme | bones, one step: mean / largest [µm] | joint gap (monolithic) [µm] | drive force [N] | on its own |
|---|---|---|---|---|---|---|---|
";

fn rows(point: &SweepPoint) -> Vec<String> {
    let um = |x: f64| super::print::digits(x * 1e6).trim().to_string();
    let row = |((_, name), m): (&(Scheme, &str), &SchemeResult)| {
        let alone = match m.diverged {
            Some(d) => format!("**diverges** at {:.3} s", d.time),
            None => format!("stable, {} mm apart", super::print::digits(m.drift.max * 1e3).trim()),
        };
        let failed = if m.failed > 0 { format!(" ({} failed)", m.failed) } else { String::new() };
        format!(
            "| {:.1} | {:.0e} | {:.2} | {name} | {} / {}{failed} | {} ({}) | {} | {alone} |",
            point.time_step * 1e3,
            point.stiffness,
            point.over_correction,
            um(m.position.mean),
            um(m.position.max),
            um(m.joint_gap),
            um(point.monolithic_joint_gap),
            super::print::digits(m.drive_force.max).trim(),
        )
    };
    SCHEMES.iter().zip(&point.schemes).map(row).collect()
}

fn as_json(point: &SweepPoint) -> Value {
    let scheme = |((_, name), m): (&(Scheme, &str), &SchemeResult)| {
        json!({
            "scheme": name,
            "position_mean_m": m.position.mean,
            "position_max_m": m.position.max,
            "rotation_mean_rad": m.rotation.mean,
            "rotation_max_rad": m.rotation.max,
            "joint_gap_max_m": m.joint_gap,
            "drive_force_max_n": m.drive_force.max,
            "steps_taken_back": m.failed,
            "diverged_s": m.diverged.map(|d| d.time),
            "drift_max_m": m.drift.max,
        })
    };
    json!({
        "stiffness_n_per_m4": point.stiffness,
        "dt_s": point.time_step,
        "over_correction": point.over_correction,
        "monolithic_joint_gap_max_m": point.monolithic_joint_gap,
        "schemes": SCHEMES.iter().zip(&point.schemes).map(scheme).collect::<Vec<_>>(),
    })
}

/// Error of a step and joint gap over stiffness, a row of panels for each time step; a cross where
/// the scheme diverges on its own.
fn charts(name: &str, plan: &Plan, points: &[SweepPoint]) -> String {
    const COLOURS: [usize; 3] = [0, 2, 1];
    type Value = fn(&SchemeResult) -> f64;
    let of: [(&str, Value); 2] = [
        ("bones after one step, largest error", |m| m.position.max),
        ("joint gap, largest", |m| m.joint_gap),
    ];
    let mut panels = Vec::new();
    for &h in &plan.time_steps {
        for (what, value) in of {
            let here: Vec<&SweepPoint> = points.iter().filter(|p| p.time_step == h).collect();
            let line = |(k, (_, name)): (usize, &(Scheme, &str))| {
                let place = |p: &&SweepPoint| (p.stiffness, value(&p.schemes[k]) * 1e6);
                let diverges = |p: &&&SweepPoint| p.schemes[k].diverged.is_some();
                let mut line =
                    Line::new(*name, COLOURS[k], Dash::Solid, here.iter().map(place).collect());
                line.crosses = here.iter().filter(diverges).map(place).collect();
                line.dots = here.iter().filter(|p| !diverges(p)).map(place).collect();
                line
            };
            let mut lines: Vec<Line> = SCHEMES.iter().enumerate().map(line).collect();
            if what.starts_with("joint gap") {
                let place = |p: &&SweepPoint| (p.stiffness, p.monolithic_joint_gap * 1e6);
                lines.push(Line::new(
                    "monolithic",
                    6,
                    Dash::Dashed,
                    here.iter().map(place).collect(),
                ));
            }
            panels.push(Panel {
                title: format!("Step {:.1} ms: {what} [µm]", h * 1e3),
                x_label: "coupling stiffness κ [N/m⁴]".into(),
                x: Axis::log(plan.stiffness.iter().copied(), 20.0),
                y: Axis::log(
                    points.iter().flat_map(|p| p.schemes.iter().map(|m| value(m) * 1e6)),
                    9.0,
                ),
                lines,
                marks: Vec::new(),
            });
        }
    }
    let subtitle =
        "from the monolithic state; a cross: left alone, the scheme diverges; a dot: it is stable";
    page(&format!("{name}: error of splitting"), subtitle, &panels)
}

impl From<SweepError> for CliError {
    fn from(error: SweepError) -> Self {
        match error {
            SweepError::Monolithic(..) => Self::Other(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}
