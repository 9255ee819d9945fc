//! The reference solution of a step: Eq. 9 in one piece.

use crate::model::Cone;
use crate::solver::{Convergence, Monolithic};
use crate::world::model::Model;
use crate::world::state::{Scratch, State};
use crate::world::two_step::known_rates;

/// Velocities of skeleton and flesh together, joints included: replaces steps 1 and 2. Leaves
/// the factored system for contact. `None` when the system is singular.
pub fn solve(
    model: &Model,
    state: &mut State,
    h: f64,
    scratch: &mut Scratch,
) -> Option<Monolithic> {
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
    let system = Monolithic::new(&scratch.A, &J)?;
    state.v = system.solve(&scratch.b, &c).0;
    Some(system)
}

/// Contact through the compliance of the whole system, joints held; leaves Δv in the state's
/// contact change.
pub fn respond(
    system: &Monolithic,
    model: &Model,
    cone: Cone,
    state: &mut State,
    scratch: &mut Scratch,
) -> Convergence {
    let (change, convergence) = system.contact(&mut scratch.rows, &model.known, cone, 1e-12);
    state.contact_change = change;
    convergence
}
