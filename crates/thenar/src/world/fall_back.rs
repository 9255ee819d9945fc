//! The step that is made when the exact solver fails.
//!
//! First the exact solver again, as far as it comes (the equations that it could not solve to
//! tolerance, the contacts that it had room for). Then, where its system has no solution at all, the
//! two-step scheme with flesh that yields. Either way the velocities found are shortened until the
//! step brings in no energy (`Exact::calm`), so that steps that fail one after the other cannot
//! build up motion. When neither works [`World::step`] puts all to rest
//! where it is.

use crate::model::SolverKind;
use crate::solver::Failure;
use crate::world::{Input, StageTimer, StepReport, World, advance};

/// What is asked of a solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Care {
    /// A solution to tolerance, or none.
    Accurate,
    /// The best that is found, brought to bring in no energy.
    Safe,
}

impl World {
    /// Velocities after the exact solver has failed with what `report` says.
    ///
    /// # Errors
    /// There are none that make sense.
    pub(super) fn fall_back(
        &mut self,
        input: &Input,
        timer: &mut impl StageTimer,
        report: &mut StepReport,
    ) -> Result<(), Failure> {
        let mut found = Err(Failure::NotFinite);
        for kind in [SolverKind::Exact, SolverKind::TwoStep] {
            advance::take_velocities_back(&mut self.state, &self.scratch.before);
            *report = StepReport {
                bad_targets: report.bad_targets,
                failure: report.failure,
                fell_back: true,
                ..StepReport::default()
            };
            found = self.find_velocities(kind, Care::Safe, input, timer, report);
            if found.is_ok() {
                break;
            }
        }
        found
    }
}
