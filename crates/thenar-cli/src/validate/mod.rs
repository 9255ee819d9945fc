//! `thenar validate`: figures that theory gives, beside those that we compute. Every case runs
//! scene files of `scenes/validation` and reads their probes; nothing in it knows the solver.

mod a;
mod b;
mod c;
mod case;
mod d;
mod report;
mod run;

use case::Case;
use report::Finding;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Runs cases whose results are known from theory, and prints expected beside measured.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Also the cases that take long.
    #[arg(long)]
    full: bool,
    /// Only these cases, e.g. `A3`, or a whole letter, e.g. `B`; also those that take long.
    #[arg(long = "case", value_name = "CASE")]
    cases: Vec<String>,
    /// Also writes the table as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Runs the command. The exit code is 1 when a case fails, and 2 when the request is wrong.
pub fn run(args: &Args) -> ExitCode {
    let chosen = match choose(args) {
        Ok(chosen) => chosen,
        Err(problem) => {
            eprintln!("error: {problem}");
            return ExitCode::from(2);
        }
    };
    println!("{}", report::head());
    let findings: Vec<Finding> = chosen
        .into_iter()
        .map(|case| {
            let finding = examine(case);
            println!("{}", report::rows(&finding));
            finding
        })
        .collect();
    println!("{}", report::tally(&findings));
    if let Some(file) = &args.json {
        let text = format!("{:#}\n", report::to_json(&findings));
        if let Err(e) = std::fs::write(file, text) {
            eprintln!("error: {}: {e}", file.display());
            return ExitCode::from(2);
        }
    }
    if findings.iter().all(Finding::passes) { ExitCode::SUCCESS } else { ExitCode::from(1) }
}

/// All cases, in order.
fn cases() -> impl Iterator<Item = &'static Case> {
    [a::CASES, b::CASES, c::CASES, d::CASES].into_iter().flatten()
}

fn choose(args: &Args) -> Result<Vec<Case>, String> {
    if args.cases.is_empty() {
        return Ok(cases().filter(|c| args.full || !c.full).copied().collect());
    }
    let matches = |case: &Case, wanted: &str| {
        let (id, wanted) = (case.id, wanted.to_ascii_uppercase());
        id == wanted || (wanted.len() == 1 && id.starts_with(&wanted))
    };
    if let Some(unknown) = args.cases.iter().find(|w| !cases().any(|c| matches(c, w))) {
        let known: Vec<&str> = cases().map(|c| c.id).collect();
        return Err(format!("no case `{unknown}`; there are {}", known.join(", ")));
    }
    Ok(cases().filter(|c| args.cases.iter().any(|w| matches(c, w))).copied().collect())
}

fn examine(case: Case) -> Finding {
    let start = Instant::now();
    let figures = (case.measure)();
    Finding { case, figures, wall_s: start.elapsed().as_secs_f64() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every case of a letter that the default run has.
    fn check(letter: char) {
        let of_letter = cases().filter(|c| c.id.starts_with(letter) && !c.full);
        let findings: Vec<Finding> = of_letter.map(|c| examine(*c)).collect();
        let failed: Vec<String> =
            findings.iter().filter(|f| !f.passes()).map(report::rows).collect();
        assert!(failed.is_empty(), "\n{}", failed.join("\n"));
    }

    #[test]
    fn rigid_bodies_joints_and_integrator_meet_their_figures() {
        check('A');
    }

    #[test]
    fn elastic_solids_meet_their_figures() {
        check('B');
    }

    #[test]
    fn contact_and_friction_meet_their_figures() {
        check('C');
    }

    #[test]
    fn coupling_and_skinning_meet_their_figures() {
        check('D');
    }

    #[test]
    fn case_names_are_unique() {
        let mut ids: Vec<&str> = cases().map(|c| c.id).collect();
        ids.sort_unstable();
        assert!(ids.windows(2).all(|w| w[0] != w[1]), "{ids:?}");
    }
}
