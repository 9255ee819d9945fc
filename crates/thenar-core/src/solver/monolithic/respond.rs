//! Change of the velocities by contact.

use crate::math::Vec3;
use crate::model::Cone;
use crate::solver::monolithic::decay::SAFETY;
use crate::solver::monolithic::delassus::{NextPass, SweepOutcome, Verdict, within};
use crate::solver::monolithic::free_motion::WINDOW;
use crate::solver::monolithic::{
    Accuracy, Coordinates, Monolithic, PRESSING_MAX, Preconditioner, StepSystem, pcg, system,
};
use crate::solver::{ContactRow, ContactRows, Convergence, Failure};

/// Sweeps go on to this part of the tolerance. Impulses that are within it stay as they are while
/// the load changes, and are found anew once they are not: the force of a body that rests jumps
/// then by up to what the tolerance makes of its weight, `10 µm/s / (g h)`, 0.1 % at 1 ms. A
/// quarter of that is not seen, and takes 3 to 10 % more sweeps in grasps.
const SWEPT_TO: f64 = 0.25;
/// The true velocities are found to this part of the tolerance.
const FOLLOWED_TO: f64 = 0.25;
/// Times that contact is solved, compared with the true velocities, and solved again.
const ROUNDS_MAX: u32 = 8;
/// Times, besides, that sweeps which ran out go on, from the true velocities and with a new
/// history.
pub(super) const RESUMED_MAX: u32 = 7;
/// Times, besides, that contacts join which the ones before left to close.
const JOINS_MAX: u32 = 32;

impl Monolithic {
    /// Finds the change that contact makes to the velocities just found, left in `change`, and its
    /// impulses. Both start from those of the step before: the old `change`, and the impulses in
    /// `contacts`.
    ///
    /// # Errors
    /// The flesh cannot be factored, too many contacts press, or the velocities do not converge.
    pub fn respond(
        &mut self,
        step: &StepSystem<'_>,
        contacts: &mut ContactRows,
        cone: Cone,
        accuracy: &Accuracy,
        change: &mut [Vec3],
    ) -> Result<Convergence, Failure> {
        debug_assert_eq!(change.len(), step.A.rows(), "changes of velocity, block rows");
        debug_assert_eq!(contacts.rigids, self.bodies.bodies(), "bodies of rows, of the solver");
        debug_assert!(accuracy.velocity > 0.0, "an accuracy of {} m/s", accuracy.velocity);
        self.kept = false;
        if contacts.rows.iter().all(|row| is_kept(row, accuracy.velocity)) {
            self.delassus.leave();
            return Ok(rest(contacts, change));
        }
        self.start_from(step, contacts, cone, change);
        // What the impulses of the step before truly do tells best what presses.
        let error = self.follow(step, contacts, accuracy, change)?;
        self.delassus.measure(contacts, change);
        if self.ready == Preconditioner::Jacobi {
            // Impulses that obey the law as they are need no compliance.
            let residual = SAFETY * self.delassus.strays(contacts, cone) + error;
            if residual <= accuracy.velocity {
                self.delassus.leave();
                self.kept = true;
                return Ok(Convergence { iterations: 0, residual });
            }
        }
        self.factor_if_needed(step)?;
        self.delassus.begin(contacts, &self.direct);
        let mut total = Convergence::default();
        let mut rounds = Rounds::default();
        let mut ran_out = false;
        loop {
            let SweepOutcome { found, settled } =
                self.sweep(step, contacts, cone, ran_out, accuracy);
            ran_out = !settled;
            total.iterations += found.iterations;
            self.follow(step, contacts, accuracy, change)?;
            let tolerance = accuracy.velocity;
            let verdict = self.delassus.check(contacts, change, cone, tolerance, &self.direct);
            total.residual = verdict.violation.max(found.residual);
            let more = !self.delassus.is_spent();
            if !rounds.go_on(&verdict, settled, more, accuracy)? {
                return Ok(total);
            }
        }
    }

    pub(super) fn factor_if_needed(&mut self, step: &StepSystem<'_>) -> Result<(), Failure> {
        let Self { bodies, carried, springs, split, coarse, direct, ready, .. } = self;
        let system = system(step, bodies, carried, springs, split);
        coarse.complete(&system);
        if *ready != Preconditioner::Direct && !direct.refresh(&system, coarse) {
            return Err(Failure::NotPositiveDefinite);
        }
        *ready = Preconditioner::Direct;
        Ok(())
    }

    /// The change of the step before as a start, with its residual, when any impulses remain of it.
    fn start_from(
        &mut self,
        step: &StepSystem<'_>,
        contacts: &mut ContactRows,
        cone: Cone,
        change: &mut [Vec3],
    ) {
        let Self { bodies, carried, springs, split, ready, x, delassus, work, .. } = self;
        let system = system(step, bodies, carried, springs, split);
        if *ready == Preconditioner::Jacobi {
            // They may stay as they are: normals have turned since.
            let rows = contacts.rows.iter_mut().filter(|row| !row.turns);
            rows.for_each(|row| row.lambda = within(cone, row.friction, &row.lambda));
        }
        work.r.clear();
        if delassus.start(contacts) {
            system.coordinates_of_change(change, x, &mut work.v);
            system.product(x, &mut work.q, &mut work.v, &mut work.f);
            work.r.add(-1.0, &work.q);
        } else {
            x.clear();
            change.fill(Vec3::zeros());
        }
    }

    /// The true change of velocities under the present impulses, `K Δ = Jᵀ λ`; returns what it may
    /// be off \[m/s\].
    pub(super) fn follow(
        &mut self,
        step: &StepSystem<'_>,
        contacts: &ContactRows,
        accuracy: &Accuracy,
        change: &mut [Vec3],
    ) -> Result<f64, Failure> {
        if !self.load_more(step, contacts) {
            return Ok(0.0);
        }
        let mut solved = pcg::PcgOutcome::default();
        if self.ready != Preconditioner::Direct {
            solved = self.follow_with_diagonal(step, accuracy, true);
            if !solved.converged && self.factor_if_needed(step).is_err() {
                // Single precision is not enough for this matrix, and there is nothing else.
                solved = self.follow_with_diagonal(step, accuracy, false);
                if !solved.converged {
                    return Err(Failure::NotPositiveDefinite);
                }
            }
        }
        if self.ready == Preconditioner::Direct {
            solved = self.follow_with_factor(step, accuracy);
        }
        if !solved.converged && !accuracy.best_effort {
            return Err(Failure::NotConverged { residual: solved.error });
        }
        let Self { bodies, carried, springs, split, x, .. } = self;
        system(step, bodies, carried, springs, split).spread(x, change);
        Ok(solved.error)
    }

    fn load_more(&mut self, step: &StepSystem<'_>, contacts: &ContactRows) -> bool {
        let Self { bodies, carried, springs, split, delassus, work, .. } = self;
        let system = system(step, bodies, carried, springs, split);
        delassus.load_more(&system, contacts, work)
    }

    /// With the block diagonal; where it `gives_up`, as long as it promises to cost less than the
    /// factor.
    fn follow_with_diagonal(
        &mut self,
        step: &StepSystem<'_>,
        accuracy: &Accuracy,
        gives_up: bool,
    ) -> pcg::PcgOutcome {
        let most = accuracy.iterations_max;
        let most = if gives_up { self.iterations_worth_a_factor.min(most) } else { most };
        let Self { bodies, carried, springs, split, coarse, jacobi, x, work, .. } = self;
        let system = system(step, bodies, carried, springs, split);
        let apply = |r: &Coordinates, z: &mut Coordinates| jacobi.apply(&system, coarse, r, z);
        let tolerance = FOLLOWED_TO * accuracy.velocity;
        let stop = pcg::StoppingCriteria { tolerance, gives_up, ..accuracy.stop(WINDOW, most) };
        pcg::solve(&system, apply, x, stop, work)
    }

    fn follow_with_factor(
        &mut self,
        step: &StepSystem<'_>,
        accuracy: &Accuracy,
    ) -> pcg::PcgOutcome {
        let Self { bodies, carried, springs, split, coarse, direct, x, work, left, .. } = self;
        let system = system(step, bodies, carried, springs, split);
        let apply = |r: &Coordinates, z: &mut Coordinates| direct.apply(&system, coarse, r, z);
        let tolerance = FOLLOWED_TO * accuracy.velocity;
        let stop = pcg::StoppingCriteria {
            tolerance,
            left: *left,
            ..accuracy.stop(1, accuracy.iterations_max)
        };
        let solved = pcg::solve(&system, apply, x, stop, work);
        *left = solved.left;
        solved
    }

    /// The compliance of all members, and the impulses on it.
    pub(super) fn sweep(
        &mut self,
        step: &StepSystem<'_>,
        contacts: &mut ContactRows,
        cone: Cone,
        ran_out: bool,
        accuracy: &Accuracy,
    ) -> SweepOutcome {
        let Self { bodies, carried, springs, split, coarse, direct, delassus, .. } = self;
        let system = system(step, bodies, carried, springs, split);
        delassus.extend(&system, coarse, direct, contacts);
        let tolerance = SWEPT_TO * accuracy.velocity;
        let mut swept =
            delassus.solve(contacts, cone, tolerance, accuracy.sweeps_max, ran_out, direct);
        // Short of a part of the tolerance is not short of all of it.
        swept.settled |= swept.found.residual <= accuracy.velocity;
        if !swept.settled {
            // Sweeps that ran out do not pass for converged, whatever the part.
            swept.found.residual = swept.found.residual.max(SAFETY * accuracy.velocity);
        }
        swept
    }
}

/// Numbers of times that contact was solved again, by cause.
#[derive(Clone, Copy, Debug, Default)]
struct Rounds {
    corrections: u32,
    resumed: u32,
    joins: u32,
}

impl Rounds {
    /// False when all is well, or rounds or the work for `more` run out. Contacts that are left to
    /// close join all the same: an answer may be rough, but leaves none out.
    fn go_on(
        &mut self,
        verdict: &Verdict,
        settled: bool,
        more: bool,
        accuracy: &Accuracy,
    ) -> Result<bool, Failure> {
        match verdict.next {
            NextPass::Done | NextPass::Correct
                if more && !settled && self.resumed < RESUMED_MAX =>
            {
                self.resumed += 1;
            }
            NextPass::Correct if more && self.corrections + 1 < ROUNDS_MAX => self.corrections += 1,
            NextPass::Joined if self.joins < JOINS_MAX => self.joins += 1,
            NextPass::Full if !accuracy.best_effort => {
                return Err(Failure::TooManyContacts { most: PRESSING_MAX as u32 });
            }
            _ => return Ok(false),
        }
        Ok(true)
    }
}

/// The velocities without contact keep every gap open: nothing more presses.
fn rest(contacts: &mut ContactRows, change: &mut [Vec3]) -> Convergence {
    let mut residual = 0.0_f64;
    for row in &mut contacts.rows {
        row.lambda = Vec3::new(row.included, 0.0, 0.0);
        residual = residual.max(row.target.x);
    }
    change.fill(Vec3::zeros());
    Convergence { iterations: 0, residual }
}

/// True when the velocities without contact obey this row: a gap stays open, a turn keeps within
/// its bound up to the tolerance, or is held there by an impulse that pushes.
fn is_kept(row: &ContactRow, tolerance: f64) -> bool {
    if row.included == 0.0 {
        row.target.x <= if row.turns { tolerance } else { 0.0 }
    } else {
        row.included > 0.0 && row.target.x.abs() <= tolerance
    }
}
