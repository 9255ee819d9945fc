//! The pseudo-velocity that undoes overlaps, on the compliance that contact found.

use crate::math::Vec3;
use crate::model::Cone;
use crate::solver::monolithic::delassus::NextPass;
use crate::solver::monolithic::{Accuracy, Monolithic, StepSystem};
use crate::solver::{ContactRows, Failure, PushTarget};

/// Rounds in which contacts join that the push would close, or W is corrected.
const ROUNDS_MAX: u32 = 6;

impl Monolithic {
    /// Finds the pseudo-velocity that these wishes ask for, after [`Monolithic::respond`] of the
    /// same step; the rows are left as they are. What does not converge is taken as it is: the next
    /// step goes on with what is left of the overlap.
    ///
    /// # Errors
    /// The flesh cannot be factored.
    pub fn push_out(
        &mut self,
        step: &StepSystem<'_>,
        contacts: &mut ContactRows,
        wishes: &[PushTarget],
        accuracy: &Accuracy,
        push: &mut [Vec3],
    ) -> Result<(), Failure> {
        debug_assert_eq!(wishes.len(), contacts.rows.len(), "wishes, rows");
        debug_assert_eq!(push.len(), step.A.rows(), "pseudo-velocities, block rows");
        if std::mem::take(&mut self.kept) {
            // Those that press are in W first, as after other steps.
            self.factor_if_needed(step)?;
            self.delassus.begin(contacts, &self.direct);
        }
        contacts.begin_push(wishes);
        let found = self.find_push(step, contacts, accuracy, push);
        contacts.end_push();
        found
    }

    fn find_push(
        &mut self,
        step: &StepSystem<'_>,
        contacts: &mut ContactRows,
        accuracy: &Accuracy,
        push: &mut [Vec3],
    ) -> Result<(), Failure> {
        let accuracy = &Accuracy { best_effort: true, ..*accuracy };
        self.factor_if_needed(step)?;
        push.fill(Vec3::zeros());
        self.x.clear();
        self.work.r.clear();
        if !self.delassus.begin_push(contacts, push, accuracy.velocity, &self.direct) {
            return Ok(());
        }
        for _ in 0..ROUNDS_MAX {
            self.sweep(step, contacts, Cone::Circular, false, accuracy);
            self.follow(step, contacts, accuracy, push)?;
            let (cone, tolerance) = (Cone::Circular, accuracy.velocity);
            let verdict = self.delassus.check(contacts, push, cone, tolerance, &self.direct);
            if matches!(verdict.next, NextPass::Done | NextPass::Full) {
                break;
            }
        }
        Ok(())
    }
}
