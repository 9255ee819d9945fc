//! The step that is made when the monolithic solver fails.
//!
//! First the monolithic solver again, as far as it comes (the equations that it could not solve to
//! tolerance, the contacts that it had room for). Then, where its system has no solution at all,
//! the two-step scheme with flesh that yields. Either way the velocities found are shortened until
//! the step brings in no energy (`Monolithic::limit_energy`), so that steps that fail one after the
//! other cannot build up motion. When neither works [`World::step`](crate::world::World::step) puts
//! all to rest where it is.

use crate::model::SolverSettings;
use crate::solver::Failure;
use crate::solver::monolithic::Monolithic;
use crate::world::monolithic::MonolithicScheme;
use crate::world::step::Step;
use crate::world::two_step::TwoStep;
use crate::world::{StageTimer, StepReport, advance};

/// Tolerance that is asked of the monolithic solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tolerance {
    /// A solution to tolerance, or none.
    Required,
    /// The best that is found, brought to bring in no energy.
    BestEffort,
}

/// Velocities by the monolithic solver, or those that stand in for them; `report` then says why.
///
/// # Errors
/// No velocities were found that make sense.
pub fn solve(
    monolithic: &mut Monolithic,
    settings: &SolverSettings,
    step: &mut Step<'_>,
    timer: &mut impl StageTimer,
    report: &mut StepReport,
) -> Result<(), Failure> {
    let settings = *settings;
    let mut scheme = MonolithicScheme { monolithic, settings, tolerance: Tolerance::Required };
    let Err(failure) = step.find_velocities(&mut scheme, timer, report) else { return Ok(()) };

    begin_again(failure, step, report);
    scheme.tolerance = Tolerance::BestEffort;
    if step.find_velocities(&mut scheme, timer, report).is_ok() {
        return Ok(());
    }

    begin_again(failure, step, report);
    step.find_velocities(&mut TwoStep { settings, stands_in: true }, timer, report)
}

/// Takes back what the attempt before did that ended with this failure.
fn begin_again(failure: Failure, step: &mut Step<'_>, report: &mut StepReport) {
    advance::take_velocities_back(step.state, &step.scratch.before);
    *report = StepReport {
        bad_targets: report.bad_targets,
        parts: report.parts,
        failure: Some(failure),
        fell_back: true,
        ..StepReport::default()
    };
}
