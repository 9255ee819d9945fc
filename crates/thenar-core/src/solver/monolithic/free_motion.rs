//! The velocities without contact.

use crate::math::Vec3;
use crate::model::{Cone, SolverSettings};
use crate::solver::monolithic::pcg::{self, PcgOutcome};
use crate::solver::monolithic::{
    Accuracy, Coordinates, Monolithic, Preconditioner, StepSystem, system,
};
use crate::solver::{Failure, JointBlock};

/// Times that joint limits are let go or held and the step is solved again without contact.
const REVISIONS_MAX: u32 = 6;
/// Fewest iterations with the block diagonal.
pub(super) const WINDOW: u32 = 4;
/// Speed, in tolerances, up to which a world is taken to rest. Where that is wrong some iterations
/// are lost, not the result.
const AT_REST: f64 = 100.0;

/// State of contact at the end of the step before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LastContact {
    /// Nothing touched.
    Free,
    /// All lay still that touched: its contacts may keep their impulses, and need no factor.
    Rested,
    /// Contact will need the factor.
    Touched,
}

impl LastContact {
    /// From the velocities that the step ended with. The law of the linearised cone is not looked
    /// at (`strays`).
    pub fn of(touched: bool, v: &[Vec3], bodies: usize, settings: &SolverSettings) -> Self {
        let rests = || pcg::largest_speed(v, bodies) <= AT_REST * settings.velocity_tolerance;
        match touched {
            false => Self::Free,
            true if settings.cone == Cone::Circular && rests() => Self::Rested,
            true => Self::Touched,
        }
    }
}

impl Monolithic {
    /// Velocities without contact, from those in `v` as a start. Bounds are kept, unless there was
    /// contact: they are left to it then, and where it will need the factor, that preconditions
    /// this solve too.
    ///
    /// # Errors
    /// The system cannot be solved, or not to this accuracy.
    pub fn solve(
        &mut self,
        step: &StepSystem<'_>,
        joints: &[JointBlock],
        h: f64,
        before: LastContact,
        accuracy: &Accuracy,
        v: &mut [Vec3],
    ) -> Result<PcgOutcome, Failure> {
        debug_assert_eq!(v.len(), step.A.rows(), "velocities, block rows");
        debug_assert!(h > 0.0 && h.is_finite(), "a time step of {h} s");
        debug_assert!(accuracy.velocity > 0.0, "an accuracy of {} m/s", accuracy.velocity);
        let touches = before != LastContact::Free;
        let looks = self.all_is_bound && before == LastContact::Rested;
        self.prepare(step, joints, (v, h), touches && !looks)?;
        let scale = self.start(step, touches, v);
        let mut solved = PcgOutcome::default();
        if self.ready == Preconditioner::Jacobi {
            solved = if touches {
                self.iterate_on(step, true, accuracy, scale)
            } else {
                self.iterate_within_bounds(step, accuracy, scale)
            };
            if !solved.converged {
                self.take_the_factor(step);
            }
        }
        let done = solved.iterations;
        if self.ready == Preconditioner::Direct {
            solved = self.iterate_with_factor(step, accuracy, scale);
            solved.iterations += done;
        } else if !solved.converged {
            solved = self.iterate_on(step, false, accuracy, scale);
        }
        let Self { bodies, carried, springs, split, x, .. } = self;
        system(step, bodies, carried, springs, split).velocities(x, v);
        match (solved.error.is_finite(), solved.converged || accuracy.best_effort) {
            (true, true) => Ok(solved),
            (true, false) => Err(Failure::NotConverged { residual: solved.error }),
            (false, _) => Err(Failure::NotFinite),
        }
    }

    /// The bodies' system and a preconditioner.
    fn prepare(
        &mut self,
        step: &StepSystem<'_>,
        joints: &[JointBlock],
        (v, h): (&[Vec3], f64),
        factor: bool,
    ) -> Result<(), Failure> {
        (self.ready, self.left) = (Preconditioner::Nothing, None);
        for c in &self.carried {
            self.springs[c.node as usize] = c.spring;
        }
        if !self.bodies.refresh(step.A, joints, v, h) {
            return Err(Failure::NotPositiveDefinite);
        }
        let Self { bodies, carried, springs, split, coarse, jacobi, direct, ready, .. } = self;
        let system = system(step, bodies, carried, springs, split);
        coarse.refresh(&system, factor);
        if factor && direct.refresh(&system, coarse) {
            *ready = Preconditioner::Direct;
        } else if jacobi.refresh(&system, coarse) {
            *ready = Preconditioner::Jacobi;
        } else {
            return Err(Failure::NotPositiveDefinite);
        }
        Ok(())
    }

    /// Coordinates of the start and their residual; returns the largest speed \[m/s\].
    fn start(&mut self, step: &StepSystem<'_>, touches: bool, v: &[Vec3]) -> f64 {
        let Self { bodies, carried, springs, split, coarse, jacobi, ready, x, held, work, .. } =
            self;
        let system = system(step, bodies, carried, springs, split);
        system.coordinates(v, x, &mut work.v);
        if *ready == Preconditioner::Jacobi && !touches {
            held.guess();
            held.hold(&system, coarse, jacobi, x);
        } else {
            held.release();
        }
        system.residual(step.b, x, &mut work.r, &mut work.v, &mut work.f);
        pcg::largest_speed(&work.v, bodies.bodies())
    }

    /// With the block diagonal, as long as it promises to cost less than the factor, and with the
    /// right bounds held.
    fn iterate_within_bounds(
        &mut self,
        step: &StepSystem<'_>,
        accuracy: &Accuracy,
        scale: f64,
    ) -> PcgOutcome {
        let worth = self.iterations_worth_a_factor.min(accuracy.iterations_max);
        let Self { bodies, carried, springs, split, coarse, jacobi, x, held, work, .. } = self;
        let system = system(step, bodies, carried, springs, split);
        let mut solved = PcgOutcome::default();
        for revision in 0.. {
            let apply = |r: &Coordinates, z: &mut Coordinates| {
                jacobi.apply(&system, coarse, r, z);
                held.project(z);
            };
            let most = worth - solved.iterations;
            let stop =
                pcg::StoppingCriteria { scale, gives_up: true, ..accuracy.stop(WINDOW, most) };
            let before = solved.iterations;
            solved = pcg::solve(&system, apply, x, stop, work);
            solved.iterations += before;
            let tolerance = 0.5 * accuracy.velocity;
            if !solved.converged
                || held.revise(&system, x, &work.r, tolerance)
                || revision == REVISIONS_MAX
            {
                break;
            }
            if solved.iterations >= worth || !held.hold(&system, coarse, jacobi, x) {
                solved.converged = false;
                break;
            }
            system.residual(step.b, x, &mut work.r, &mut work.v, &mut work.f);
        }
        solved
    }

    /// Goes over to the factor where there is one; bounds are then left to contact.
    fn take_the_factor(&mut self, step: &StepSystem<'_>) {
        let Self { bodies, carried, springs, split, coarse, direct, ready, x, held, work, .. } =
            self;
        let system = system(step, bodies, carried, springs, split);
        coarse.complete(&system);
        held.release();
        if direct.refresh(&system, coarse) {
            *ready = Preconditioner::Direct;
            system.residual(step.b, x, &mut work.r, &mut work.v, &mut work.f);
        }
    }

    fn iterate_with_factor(
        &mut self,
        step: &StepSystem<'_>,
        accuracy: &Accuracy,
        scale: f64,
    ) -> PcgOutcome {
        let Self { bodies, carried, springs, split, coarse, direct, x, work, left, .. } = self;
        let system = system(step, bodies, carried, springs, split);
        let apply = |r: &Coordinates, z: &mut Coordinates| direct.apply(&system, coarse, r, z);
        let stop = pcg::StoppingCriteria { scale, ..accuracy.stop(1, accuracy.iterations_max) };
        let solved = pcg::solve(&system, apply, x, stop, work);
        *left = solved.left;
        solved
    }

    /// With the block diagonal and no bounds; where it `gives_up`, as long as it promises to cost
    /// less than the factor.
    fn iterate_on(
        &mut self,
        step: &StepSystem<'_>,
        gives_up: bool,
        accuracy: &Accuracy,
        scale: f64,
    ) -> PcgOutcome {
        let most = accuracy.iterations_max;
        let most = if gives_up { self.iterations_worth_a_factor.min(most) } else { most };
        let Self { bodies, carried, springs, split, coarse, jacobi, x, work, .. } = self;
        let system = system(step, bodies, carried, springs, split);
        let apply = |r: &Coordinates, z: &mut Coordinates| jacobi.apply(&system, coarse, r, z);
        let stop = pcg::StoppingCriteria { scale, gives_up, ..accuracy.stop(WINDOW, most) };
        pcg::solve(&system, apply, x, stop, work)
    }
}
