//! The reference solution of a step: Eq. 9 in one piece.

use crate::model::{JointLimits, SolverSettings};
use crate::solver::{Convergence, DenseSystem, Failure};
use crate::world::assemble;
use crate::world::model::Model;
use crate::world::scheme::Scheme;
use crate::world::state::{Scratch, State};
use crate::world::two_step::known_rates;

/// Impulses may change by this part of the largest in the last sweep.
const TOLERANCE: f64 = 1e-12;

/// A step by the dense reference.
pub struct DenseReference {
    pub settings: SolverSettings,
}

impl Scheme for DenseReference {
    /// The factored system.
    type Factored = DenseSystem;

    fn limits(&self) -> JointLimits {
        self.settings.limits
    }

    fn couple(
        &mut self,
        model: &Model,
        state: &mut State,
        h: f64,
        scratch: &mut Scratch,
    ) -> Result<(), Failure> {
        assemble::coupling(self.settings.step1_flesh, model, state, h, scratch);
        Ok(())
    }

    fn free(
        &mut self,
        model: &Model,
        state: &mut State,
        h: f64,
        scratch: &mut Scratch,
    ) -> Result<(DenseSystem, Convergence), Failure> {
        let system = solve(model, state, h, scratch).ok_or(Failure::NotPositiveDefinite)?;
        Ok((system, Convergence::default()))
    }

    /// Contact through the compliance of the whole system, joints held.
    fn respond(
        &mut self,
        system: &DenseSystem,
        model: &Model,
        state: &mut State,
        scratch: &mut Scratch,
    ) -> Result<Convergence, Failure> {
        let (change, convergence) =
            system.contact(&mut scratch.rows, &model.known, self.settings.cone, TOLERANCE);
        state.contact_change = change;
        Ok(convergence)
    }

    fn residual_max(&self) -> f64 {
        self.settings.contact_tolerance
    }

    fn push_out(&mut self, system: &DenseSystem, model: &Model, scratch: &mut Scratch) {
        let Scratch { rows, wishes, push, .. } = scratch;
        rows.begin_push(wishes);
        let (found, _) = system.contact(rows, &model.known, self.settings.cone, TOLERANCE);
        push.copy_from_slice(&found);
        rows.end_push();
    }
}

/// Velocities of skeleton and flesh together, joints included, and the factored system. `None` when
/// it is singular.
fn solve(model: &Model, state: &mut State, h: f64, scratch: &mut Scratch) -> Option<DenseSystem> {
    let unknowns = 3 * model.rows();
    let (mut J, mut c) = (Vec::new(), Vec::new());
    for (j, joint) in model.joints.iter().enumerate() {
        let known = known_rates(model, state, j, scratch);
        let block = &scratch.joints[j];
        for r in 0..block.rows {
            let mut row = vec![0.0; unknowns];
            let child = 6 * joint.child as usize;
            for k in 0..6 {
                row[child + k] = block.J_child[(r, k)];
                if let Some(parent) = joint.parent {
                    row[6 * parent as usize + k] = block.J_parent[(r, k)];
                }
            }
            J.push(row);
            c.push(-block.C[r] / h - known[r]);
        }
    }
    let system = DenseSystem::new(&scratch.A, &J)?;
    state.v = system.solve(&scratch.b, &c).0;
    Some(system)
}
