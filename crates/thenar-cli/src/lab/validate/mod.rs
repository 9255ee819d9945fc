//! `thenar validate`: figures that theory gives, and bands of people, beside those that we compute.
//! Every case but those of touch runs scene files of `scenes/validation` in this crate and reads
//! their probes; nothing in it knows the solver.

mod bodies;
mod case;
mod contact;
mod coupling;
mod fingers;
mod hands;
mod report;
mod run;
mod solids;
mod tissue;
mod touch;

use crate::error::CliError;
use case::Case;
use report::Finding;
use run::Solver;
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;
use thenar_output::Output;

/// Runs cases whose results are known from theory, and prints expected beside measured.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Also the cases that take long.
    #[arg(long)]
    full: bool,
    /// Only these cases, e.g. `A3`, or a whole letter, e.g. `B`; also those that take long.
    #[arg(long = "case", value_name = "CASE")]
    cases: Vec<String>,
    /// Solver of all cases.
    #[arg(long, value_enum, default_value_t = Solver::Monolithic)]
    solver: Solver,
    /// Also writes the table as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// The request is wrong, a case fails, or the table cannot be written.
pub fn run(args: &Args) -> Result<(), CliError> {
    let chosen = choose(args)?;
    let json = args.json.as_deref().map(Output::create).transpose()?;
    println!("{}", report::head());
    let findings =
        examine_all(&chosen, args.solver, |finding| println!("{}", report::rows(finding)));
    println!("{}", report::tally(&findings));
    if let Some(mut json) = json {
        writeln!(json, "{:#}", report::to_json(&findings))
            .map_err(|e| CliError::Other(format!("cannot write the table: {e}")))?;
        json.finish()?;
    }
    let failed: Vec<&str> = findings.iter().filter(|f| !f.passes()).map(|f| f.case.id).collect();
    match failed.is_empty() {
        true => Ok(()),
        false => Err(CliError::Other(format!("these cases fail: {}", failed.join(", ")))),
    }
}

/// All cases, in order.
fn cases() -> impl Iterator<Item = &'static Case> {
    let letters = [
        bodies::CASES,
        solids::CASES,
        contact::CASES,
        coupling::CASES,
        touch::CASES,
        fingers::CASES,
        hands::CASES,
        tissue::CASES,
    ];
    letters.into_iter().flatten()
}

fn choose(args: &Args) -> Result<Vec<Case>, CliError> {
    if args.cases.is_empty() {
        return Ok(cases().filter(|c| args.full || !c.full).copied().collect());
    }
    let matches = |case: &Case, wanted: &str| {
        let (id, wanted) = (case.id, wanted.to_ascii_uppercase());
        id == wanted || (wanted.len() == 1 && id.starts_with(&wanted))
    };
    if let Some(unknown) = args.cases.iter().find(|w| !cases().any(|c| matches(c, w))) {
        let known: Vec<&str> = cases().map(|c| c.id).collect();
        let known = known.join(", ");
        return Err(CliError::Input(format!("no case `{unknown}`; there are {known}")));
    }
    Ok(cases().filter(|c| args.cases.iter().any(|w| matches(c, w))).copied().collect())
}

/// Runs cases on all processors; `tell` hears of each in their order. The figures do not depend
/// on the number of processors: each case runs on one.
fn examine_all(chosen: &[Case], solver: Solver, mut tell: impl FnMut(&Finding)) -> Vec<Finding> {
    let next = AtomicUsize::new(0);
    let workers = std::thread::available_parallelism().map_or(1, usize::from).min(chosen.len());
    let (send, receive) = std::sync::mpsc::channel();
    let mut found: Vec<Option<Finding>> = chosen.iter().map(|_| None).collect();
    std::thread::scope(|scope| {
        for _ in 0..workers {
            let (send, next) = (send.clone(), &next);
            scope.spawn(move || {
                let take = || next.fetch_add(1, Ordering::Relaxed);
                let mut i = take();
                while let Some(case) = chosen.get(i) {
                    if send.send((i, examine(*case, solver))).is_err() {
                        return;
                    }
                    i = take();
                }
            });
        }
        drop(send);
        let mut told = 0;
        for (i, finding) in receive {
            found[i] = Some(finding);
            while let Some(Some(finding)) = found.get(told) {
                tell(finding);
                told += 1;
            }
        }
    });
    found.into_iter().flatten().collect()
}

fn examine(case: Case, solver: Solver) -> Finding {
    let start = Instant::now();
    let figures = (case.measure)(solver);
    Finding { case, figures, wall_s: start.elapsed().as_secs_f64() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every case of a letter that the default run has.
    fn check(letter: char) {
        let of_letter = cases().filter(|c| c.id.starts_with(letter) && !c.full);
        let chosen: Vec<Case> = of_letter.copied().collect();
        let findings = examine_all(&chosen, Solver::Monolithic, |_| ());
        let failed: Vec<String> =
            findings.iter().filter(|f| !f.passes()).map(report::rows).collect();
        assert!(!findings.is_empty() && failed.is_empty(), "\n{}", failed.join("\n"));
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
    fn touch_meets_its_figures() {
        check('E');
    }

    #[test]
    fn fingers_meet_their_bands_or_say_why_not() {
        check('F');
    }

    #[test]
    fn dimensions_meet_their_bands_or_say_why_not() {
        check('G');
    }

    #[test]
    fn tissue_meets_its_figures_or_says_why_not() {
        check('T');
    }

    #[test]
    fn case_names_are_unique() {
        let mut ids: Vec<&str> = cases().map(|c| c.id).collect();
        ids.sort_unstable();
        assert!(ids.windows(2).all(|w| w[0] != w[1]), "{ids:?}");
    }
}
