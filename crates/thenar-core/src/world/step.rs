//! One step by any scheme: the paper's Sec. 4.

use crate::contact::{Detector, Reach, RigidPlace};
use crate::model::WorldDesc;
use crate::solver::Failure;
use crate::world::model::Model;
use crate::world::parts::StepPart;
use crate::world::scheme::{Scheme, Solver};
use crate::world::state::{Scratch, State};
use crate::world::two_step::TwoStep;
use crate::world::{
    Input, Stage, StageTimer, StepReport, World, assemble, fall_back, friction, limits, push_out,
    response,
};

/// Inputs and outputs of a step.
pub struct Step<'a> {
    desc: &'a WorldDesc,
    model: &'a Model,
    pub state: &'a mut State,
    pub scratch: &'a mut Scratch,
    detector: &'a mut Detector,
    places: &'a mut [RigidPlace],
    input: &'a Input,
    part: StepPart,
}

impl World {
    /// The velocities at the end of a part of the step, by the solver that the settings choose.
    ///
    /// # Errors
    /// No velocities were found that make sense.
    pub(super) fn find_velocities(
        &mut self,
        part: StepPart,
        input: &Input,
        timer: &mut impl StageTimer,
        report: &mut StepReport,
    ) -> Result<(), Failure> {
        let Self { desc, model, state, scratch, detector, places, solver, .. } = self;
        let settings = desc.solver;
        let mut step = Step { desc, model, state, scratch, detector, places, input, part };
        match solver {
            Solver::Monolithic(monolithic) => {
                fall_back::solve(monolithic, &settings, &mut step, timer, report)
            }
            Solver::TwoStep => {
                let mut scheme = TwoStep { settings, stands_in: false };
                step.find_velocities(&mut scheme, timer, report)
            }
            #[cfg(any(test, feature = "reference"))]
            Solver::DenseReference => step.find_velocities(
                &mut super::reference::DenseReference { settings },
                timer,
                report,
            ),
        }
    }
}

impl Step<'_> {
    /// The velocities at the end of the step, contact included.
    ///
    /// # Errors
    /// This scheme fails.
    pub fn find_velocities<S: Scheme>(
        &mut self,
        scheme: &mut S,
        timer: &mut impl StageTimer,
        report: &mut StepReport,
    ) -> Result<(), Failure> {
        let Self { desc, model, state, scratch, detector, places, input, part } = self;
        let h = part.h;

        timer.begin(Some(Stage::Skeleton));
        scratch.pushes = false;
        scheme.clear(scratch);
        assemble::skeleton(desc, model, scheme.limits(), state, input, *part, scratch); // A_s, b_s, J_s (4)
        scratch.islands.still(&mut scratch.b);
        scratch.islands.still(&mut state.v);
        limits::list(scheme.limits(), model, scratch);
        scheme.couple(model, state, h, scratch)?; //    A_sf, A_fs (7-9); in two steps v_s,1 (10)

        timer.begin(Some(Stage::Flesh));
        let tally = assemble::flesh(model, state, input, h, scratch); //              A_f, b_f (5)
        report.inverted_tets = tally.inverted;
        scratch.islands.still(&mut scratch.b);
        let (factored, free) = scheme.free(model, state, h, scratch)?; // v without contact (9, 11)
        (report.cg_iterations, report.cg_residual) = (free.iterations, free.residual);
        state.check()?;

        timer.begin(Some(Stage::Detect));
        let reach = Reach { h, margin: desc.solver.contact_margin.max(part.reach) };
        let found = response::detect(reach, model, state, detector, places, scratch);
        report.contacts_dropped = found.dropped;

        timer.begin(Some(Stage::Contact));
        response::build_rows(model, state, h, scratch); //                               J_c (12)
        friction::set_coefficients(model, state, scratch);
        limits::build_rows(model, state, h, scratch);
        let contact = scheme.respond(&factored, model, state, scratch)?; //            λ, Δv (12)
        report.contact_unconverged = contact.residual > scheme.residual_max();
        response::apply(state, scratch);
        state.check()?;
        friction::keep_loads(model, &scratch.found, &scratch.rows, h, &mut state.patch_loads);
        report.limits_active = limits::keep_impulses(state, scratch);
        scheme.finish(model, state, h, scratch)?;
        push_out::find(scheme, &factored, &desc.solver, model, state, h, scratch); //    overlaps
        response::report(state, h, desc.solver.cone, contact, scratch, report);
        Ok(())
    }
}
