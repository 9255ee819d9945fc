//! The velocities without contact.

use crate::math::Vec3;
use crate::solver::exact::pcg::{self, Solved};
use crate::solver::exact::{Accuracy, Coordinates, Exact, Ready, StepSystem, system};
use crate::solver::{Failure, JointBlock};

/// Times that joint limits are let go or held and the step is solved again without contact.
const REVISIONS_MAX: u32 = 6;
/// Fewest iterations with the block diagonal.
const WINDOW: u32 = 4;

impl Exact {
    /// Velocities without contact, from the present ones in `v` as a start; bounds are kept, unless
    /// `factor` asks for the direct preconditioner, which contact will need anyway, and with which
    /// they are left to contact.
    ///
    /// # Errors
    /// The system cannot be solved, or not to this accuracy.
    pub fn solve(
        &mut self,
        step: &StepSystem<'_>,
        joints: &[JointBlock],
        h: f64,
        factor: bool,
        accuracy: &Accuracy,
        v: &mut [Vec3],
    ) -> Result<Solved, Failure> {
        self.prepare(step, joints, (v, h), factor)?;
        let scale = self.start(step, v);
        let mut solved = Solved::default();
        if self.ready == Ready::Jacobi {
            solved = self.iterate_within_bounds(step, accuracy, scale);
            if !solved.converged {
                self.take_the_factor(step);
            }
        }
        let before = solved.iterations;
        if self.ready == Ready::Direct {
            solved = self.iterate_with_factor(step, accuracy, scale);
            solved.iterations += before;
        } else if !solved.converged {
            solved = self.iterate_on(step, accuracy, scale);
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
        (self.ready, self.left) = (Ready::Nothing, None);
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
            *ready = Ready::Direct;
        } else if jacobi.refresh(&system, coarse) {
            *ready = Ready::Jacobi;
        } else {
            return Err(Failure::NotPositiveDefinite);
        }
        Ok(())
    }

    /// Coordinates of the start and their residual; returns the largest speed \[m/s\].
    fn start(&mut self, step: &StepSystem<'_>, v: &[Vec3]) -> f64 {
        let Self { bodies, carried, springs, split, coarse, jacobi, ready, x, held, work, .. } =
            self;
        let system = system(step, bodies, carried, springs, split);
        system.coordinates(v, x, &mut work.v);
        if *ready == Ready::Jacobi {
            held.guess();
            held.hold(&system, coarse, jacobi, x);
        } else {
            held.release();
        }
        system.residual(step.b, x, &mut work.r, &mut work.v, &mut work.f);
        pcg::largest_speed(&work.v, bodies.bodies())
    }

    /// With the block diagonal, until it costs more than the factor, and with the right bounds held.
    fn iterate_within_bounds(
        &mut self,
        step: &StepSystem<'_>,
        accuracy: &Accuracy,
        scale: f64,
    ) -> Solved {
        let worth = self.iterations_worth_a_factor.min(accuracy.iterations_max);
        let Self { bodies, carried, springs, split, coarse, jacobi, x, held, work, .. } = self;
        let system = system(step, bodies, carried, springs, split);
        let mut solved = Solved::default();
        for revision in 0.. {
            let apply = |r: &Coordinates, z: &mut Coordinates| {
                jacobi.apply(&system, coarse, r, z);
                held.project(z);
            };
            let stop = pcg::Stop { scale, ..accuracy.stop(WINDOW, worth - solved.iterations) };
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
            *ready = Ready::Direct;
            system.residual(step.b, x, &mut work.r, &mut work.v, &mut work.f);
        }
    }

    fn iterate_with_factor(
        &mut self,
        step: &StepSystem<'_>,
        accuracy: &Accuracy,
        scale: f64,
    ) -> Solved {
        let Self { bodies, carried, springs, split, coarse, direct, x, work, left, .. } = self;
        let system = system(step, bodies, carried, springs, split);
        let apply = |r: &Coordinates, z: &mut Coordinates| direct.apply(&system, coarse, r, z);
        let stop = pcg::Stop { scale, ..accuracy.stop(1, accuracy.iterations_max) };
        let solved = pcg::solve(&system, apply, x, stop, work);
        *left = solved.left;
        solved
    }

    /// With the block diagonal, however long it takes.
    fn iterate_on(&mut self, step: &StepSystem<'_>, accuracy: &Accuracy, scale: f64) -> Solved {
        let Self { bodies, carried, springs, split, coarse, jacobi, x, work, .. } = self;
        let system = system(step, bodies, carried, springs, split);
        let apply = |r: &Coordinates, z: &mut Coordinates| jacobi.apply(&system, coarse, r, z);
        let stop = pcg::Stop { scale, ..accuracy.stop(WINDOW, accuracy.iterations_max) };
        pcg::solve(&system, apply, x, stop, work)
    }
}
