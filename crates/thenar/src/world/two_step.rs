//! The paper's two-step solution of Eq. 9.

use crate::math::{Vec3, Vec6};
use crate::model::SolverSettings;
use crate::solver::{Convergence, conjugate_gradients};
use crate::world::model::Model;
use crate::world::state::{Scratch, State};

/// Step 1 (Eq. 10): bone velocities `v_s,1` that satisfy the joints, with the flesh's velocities
/// as they are. Written for the change `Δ = v_s,1 - v_s,0`:
///
/// ```text
///   [ S   J_sᵀ ] [ Δ   ]   [ b_s - A_s v_s,0 - A_sf v_f,0 ]
///   [ J_s  0   ] [ λ_s ] = [ -C/Δt - J_s v_s,0            ]
/// ```
///
/// With the flesh frozen S is A_s and this is Eq. 10 itself. The state's bone velocities become
/// `v_s,1`, and `b_s` becomes `b_s - J_sᵀ λ_s`, which is the `b_s,2` of Eq. 11. Returns false when
/// a pivot is singular.
pub fn articulated_body(model: &Model, state: &mut State, h: f64, scratch: &mut Scratch) -> bool {
    let moves = |b: usize| model.rigids[b].moves;
    for b in 0..model.rigids.len() {
        scratch.r[b] = Vec6::zeros();
        if moves(b) {
            let lin = scratch.b[2 * b] - scratch.A.row_times(2 * b, &state.v);
            let ang = scratch.b[2 * b + 1] - scratch.A.row_times(2 * b + 1, &state.v);
            scratch.r[b] = stack(&lin, &ang);
        }
    }
    for (j, joint) in model.joints.iter().enumerate() {
        let block = &mut scratch.joints[j];
        let child = joint.child as usize;
        let mut rate = block.J_child * body_velocity(state, child);
        if !moves(child) {
            block.J_child.fill(0.0);
        }
        if let Some(parent) = joint.parent.map(|p| p as usize) {
            rate += block.J_parent * body_velocity(state, parent);
            if !moves(parent) {
                block.J_parent.fill(0.0);
            }
            if !moves(parent) || !moves(child) {
                scratch.S_edge[j].fill(0.0);
            }
        }
        scratch.c[j] = -block.C / h - rate;
    }

    let solved = scratch.articulated.solve(
        &mut scratch.S_diagonal,
        &scratch.S_edge,
        &scratch.joints,
        &mut scratch.r,
        &scratch.c,
        &mut scratch.dv,
        &mut scratch.lambda,
    );
    if !solved {
        return false;
    }

    for b in (0..model.rigids.len()).filter(|&b| moves(b)) {
        let [lin, ang] = unstack(&scratch.dv[b]);
        state.v[2 * b] += lin;
        state.v[2 * b + 1] += ang;
    }
    for (j, joint) in model.joints.iter().enumerate() {
        let (block, lambda) = (&scratch.joints[j], &scratch.lambda[j]);
        let mut take = |body: usize, impulse: Vec6| {
            let [lin, ang] = unstack(&impulse);
            scratch.b[2 * body] -= lin;
            scratch.b[2 * body + 1] -= ang;
        };
        take(joint.child as usize, block.J_child.tr_mul(lambda));
        if let Some(parent) = joint.parent {
            take(parent as usize, block.J_parent.tr_mul(lambda));
        }
    }
    true
}

/// Step 2 (Eq. 11): all velocities, joints ignored, by conjugate gradients from `(v_s,1, v_f,0)`.
/// Returns `None` when the matrix is not positive definite.
pub fn unconstrained_deformation(
    settings: &SolverSettings,
    model: &Model,
    state: &mut State,
    scratch: &mut Scratch,
) -> Option<Convergence> {
    if !scratch.D.refresh(&scratch.A) {
        return None;
    }
    mask_known(model, scratch);
    Some(conjugate_gradients(
        &scratch.A,
        &scratch.D,
        &scratch.b,
        &mut state.v,
        settings.cg_tolerance,
        settings.cg_iterations_max,
        &mut scratch.cg,
    ))
}

/// Known velocities do not respond: their rows and columns of D⁻¹ are zero.
fn mask_known(model: &Model, scratch: &mut Scratch) {
    for (b, body) in model.rigids.iter().enumerate() {
        if !body.moves {
            scratch.D.rigid[b].fill(0.0);
        }
    }
    for (node, axes) in &model.held {
        for axis in (0..3).filter(|&axis| axes[axis]) {
            let inverse = &mut scratch.D.node[*node as usize];
            inverse.row_mut(axis).fill(0.0);
            inverse.column_mut(axis).fill(0.0);
        }
    }
}

/// Linear above angular velocity.
pub fn body_velocity(state: &State, b: usize) -> Vec6 {
    stack(&state.v[2 * b], &state.v[2 * b + 1])
}

fn stack(lin: &Vec3, ang: &Vec3) -> Vec6 {
    Vec6::new(lin.x, lin.y, lin.z, ang.x, ang.y, ang.z)
}

fn unstack(v: &Vec6) -> [Vec3; 2] {
    [Vec3::new(v[0], v[1], v[2]), Vec3::new(v[3], v[4], v[5])]
}
