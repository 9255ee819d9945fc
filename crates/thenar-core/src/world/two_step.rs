//! The paper's two-step solution of Eq. 9.

use crate::coupling::skin_target;
use crate::math::{Mat6, Vec3, Vec6};
use crate::model::{JointLimits, SolverSettings};
use crate::solver::{
    AnticipationSettings, Convergence, Failure, conjugate_gradients, weigh_energy,
};
use crate::world::model::Model;
use crate::world::scheme::Scheme;
use crate::world::state::{Scratch, State};
use crate::world::{assemble, limits, response};

/// A step by the paper's scheme.
pub struct TwoStep {
    pub settings: SolverSettings,
    /// The step is made for the monolithic solver, which has failed: joints are closed, and
    /// velocities shortened until they bring in no energy.
    pub stands_in: bool,
}

impl Scheme for TwoStep {
    type Factored = ();

    /// The scheme has no rows for limits.
    fn limits(&self) -> JointLimits {
        JointLimits::Springs
    }

    fn couple(
        &mut self,
        model: &Model,
        state: &mut State,
        h: f64,
        scratch: &mut Scratch,
    ) -> Result<(), Failure> {
        assemble::coupling(self.settings.step1_flesh, model, state, h, scratch);
        articulated_body(model, state, h, scratch)
    }

    fn free(
        &mut self,
        model: &Model,
        state: &mut State,
        _: f64,
        scratch: &mut Scratch,
    ) -> Result<((), Convergence), Failure> {
        Ok(((), unconstrained_deformation(&self.settings, model, state, scratch)?))
    }

    fn respond(
        &mut self,
        (): &(),
        _: &Model,
        state: &mut State,
        scratch: &mut Scratch,
    ) -> Result<Convergence, Failure> {
        Ok(anticipate(&self.settings, state, scratch))
    }

    fn residual_max(&self) -> f64 {
        self.settings.contact_tolerance
    }

    fn finish(
        &mut self,
        model: &Model,
        state: &mut State,
        h: f64,
        scratch: &mut Scratch,
    ) -> Result<(), Failure> {
        if (self.settings.close_joints || self.stands_in) && !model.joints.is_empty() {
            close_joints(model, state, h, scratch)?;
        }
        if self.stands_in {
            limit_energy(model, state, scratch);
            response::scale_impulses(model, h, state, scratch);
            if self.settings.limits == JointLimits::Rows {
                limits::keep_spring_impulses(model, state, h, scratch);
            }
        }
        Ok(())
    }

    fn pushes_out(&self) -> bool {
        !self.stands_in
    }

    fn push_out(&mut self, (): &(), model: &Model, scratch: &mut Scratch) {
        let Scratch { A, D, rows, wishes, push, anticipation, .. } = scratch;
        rows.begin_push(wishes);
        anticipation.solve(A, D, rows, &anticipation_settings(&self.settings), push);
        rows.end_push();
        keep_joints(model, scratch);
    }
}

/// Step 1 (Eq. 10): bone velocities `v_s,1` that satisfy the joints, with the flesh's velocities
/// as they are. Written for the change `Δ = v_s,1 - v_s,0`:
///
/// ```text
///   [ S   J_sᵀ ] [ Δ   ]   [ b_s - S v_s,0 - S_sf v_f,0 ]
///   [ J_s  0   ] [ λ_s ] = [ -C/Δt - J_s v_s,0          ]
/// ```
///
/// With the flesh frozen S is A_s, S_sf is A_sf, and this is Eq. 10 itself; otherwise both hold
/// what the bones feel of flesh that yields (`coupling::EffectiveMass`). The state's bone
/// velocities become `v_s,1`, and `b_s` becomes `b_s - J_sᵀ λ_s`, which is the `b_s,2` of Eq. 11.
///
/// # Errors
/// A pivot is singular.
fn articulated_body(
    model: &Model,
    state: &mut State,
    h: f64,
    scratch: &mut Scratch,
) -> Result<(), Failure> {
    let moves = |b: usize| model.rigids[b].moves;
    let bones = &mut scratch.bones;
    for b in 0..model.rigids.len() {
        let pull = stack(&bones.pull[b][0], &bones.pull[b][1]);
        let b_s = stack(&scratch.b[2 * b], &scratch.b[2 * b + 1]);
        scratch.r[b] = b_s + pull - bones.diagonal[b] * body_velocity(state, b);
    }
    for (j, joint) in model.joints.iter().enumerate() {
        if let Some(parent) = joint.parent {
            let (parent, child) = (parent as usize, joint.child as usize);
            scratch.r[child] -= bones.edge[j] * body_velocity(state, parent);
            scratch.r[parent] -= bones.edge[j].tr_mul(&body_velocity(state, child));
        }
    }
    for b in (0..model.rigids.len()).filter(|&b| !moves(b)) {
        scratch.bones.diagonal[b] = Mat6::identity();
        scratch.r[b] = Vec6::zeros();
    }
    for j in 0..model.joints.len() {
        scratch.known[j] = known_rates(model, state, j, scratch);
    }
    wanted_rates(model, state, h, scratch);
    scratch.S_kept.copy_from_slice(&scratch.bones.diagonal);
    solve_bones(scratch)?;

    add_change(model, state, scratch);
    scratch.b_kept.copy_from_slice(&scratch.b[..2 * model.rigids.len()]);
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
    Ok(())
}

/// Ends a step with joints that hold: contact moves bones without regard to joints (Eq. 12), so
/// the bones are brought back by the impulses of step 1's system, and the flesh yields to them by
/// its inertia as assumed there: `(m + s) Δv_f = s J Δ`. (The paper leaves this to the next step.)
///
/// # Errors
/// A pivot is singular.
fn close_joints(
    model: &Model,
    state: &mut State,
    h: f64,
    scratch: &mut Scratch,
) -> Result<(), Failure> {
    scratch.r.fill(Vec6::zeros());
    scratch.bones.diagonal.copy_from_slice(&scratch.S_kept);
    wanted_rates(model, state, h, scratch);
    solve_bones(scratch)?;
    add_change(model, state, scratch);
    let row0 = 2 * model.rigids.len();
    let posed = model.coupling.offsets.pose(&state.poses_WB, &mut scratch.shares);
    for (k, bound) in model.coupling.bound.iter().enumerate() {
        let mass = scratch.step1_mass[bound.node as usize];
        let s = h * h * model.coupling.stiffness[k] + h * model.coupling.damping[k];
        if mass.is_finite() {
            let target = skin_target(bound, &state.poses_WB, &posed);
            for j in 0..bound.bone_count() {
                let [lin, ang] = unstack(&scratch.dv[bound.bones[j] as usize]);
                let moved = lin * bound.weights[j] + target.turning.velocity(j, &ang);
                state.v[row0 + bound.node as usize] += moved * (s / (mass + s));
            }
        }
    }
    Ok(())
}

/// Brings the pseudo-velocity of bones back to what joints allow, as step 1 does with velocities.
/// What cannot be brought back pushes nothing.
fn keep_joints(model: &Model, scratch: &mut Scratch) {
    if model.joints.is_empty() {
        return;
    }
    scratch.r.fill(Vec6::zeros());
    scratch.bones.diagonal.copy_from_slice(&scratch.S_kept);
    let moved = |push: &[Vec3], b: u32| stack(&push[2 * b as usize], &push[2 * b as usize + 1]);
    for (j, joint) in model.joints.iter().enumerate() {
        let block = &scratch.joints[j];
        let mut rate = block.J_child * moved(&scratch.push, joint.child);
        if let Some(parent) = joint.parent {
            rate += block.J_parent * moved(&scratch.push, parent);
        }
        scratch.c[j] = -rate;
    }
    if solve_bones(scratch).is_err() {
        scratch.push.fill(Vec3::zeros());
        return;
    }
    for (b, _) in model.rigids.iter().enumerate().filter(|(_, body)| body.moves) {
        let [lin, ang] = unstack(&scratch.dv[b]);
        scratch.push[2 * b] += lin;
        scratch.push[2 * b + 1] += ang;
    }
}

/// `[S Jᵀ; J 0] [Δ; λ] = [r; c]` by the tree.
fn solve_bones(scratch: &mut Scratch) -> Result<(), Failure> {
    let solved = scratch.articulated.solve(
        &mut scratch.bones.diagonal,
        &scratch.bones.edge,
        &scratch.joints,
        &mut scratch.r,
        &scratch.c,
        &mut scratch.dv,
        &mut scratch.lambda,
    );
    if solved { Ok(()) } else { Err(Failure::NotPositiveDefinite) }
}

/// `c = -C/Δt - J v` for the present velocities.
fn wanted_rates(model: &Model, state: &State, h: f64, scratch: &mut Scratch) {
    for (j, joint) in model.joints.iter().enumerate() {
        let block = &scratch.joints[j];
        let mut rate =
            scratch.known[j] + block.J_child * body_velocity(state, joint.child as usize);
        if let Some(parent) = joint.parent {
            rate += block.J_parent * body_velocity(state, parent as usize);
        }
        scratch.c[j] = -block.C / h - rate;
    }
}

/// Adds the change found by step 1's system to the bones' velocities.
fn add_change(model: &Model, state: &mut State, scratch: &Scratch) {
    for (b, body) in model.rigids.iter().enumerate() {
        if body.moves {
            let [lin, ang] = unstack(&scratch.dv[b]);
            state.v[2 * b] += lin;
            state.v[2 * b + 1] += ang;
        }
    }
}

/// Moves what prescribed bodies contribute to `J v` of joint `j` out of its rows: returns it, and
/// zeroes their blocks.
pub fn known_rates(model: &Model, state: &State, j: usize, scratch: &mut Scratch) -> Vec6 {
    let joint = &model.joints[j];
    let block = &mut scratch.joints[j];
    let mut known = Vec6::zeros();
    for (body, J) in [(Some(joint.child), &mut block.J_child), (joint.parent, &mut block.J_parent)]
    {
        let Some(body) = body.map(|b| b as usize) else { continue };
        if !model.rigids[body].moves {
            known += *J * body_velocity(state, body);
            J.fill(0.0);
            scratch.bones.edge[j].fill(0.0);
        }
    }
    known
}

/// Step 2 (Eq. 11): all velocities, joints ignored, by conjugate gradients from `(v_s,1, v_f,0)`
/// less the last step's contact response.
///
/// # Errors
/// The matrix is not positive definite or a number is not finite.
fn unconstrained_deformation(
    settings: &SolverSettings,
    model: &Model,
    state: &mut State,
    scratch: &mut Scratch,
) -> Result<Convergence, Failure> {
    if !scratch.D.refresh(&scratch.A) {
        return Err(Failure::NotPositiveDefinite);
    }
    mask_known(model, scratch);
    // A first guess: what contact gave in the last step it will have to give again.
    for (v, change) in state.v.iter_mut().zip(&state.contact_change) {
        *v -= change;
    }
    let reached = conjugate_gradients(
        &scratch.A,
        &scratch.D,
        &scratch.b,
        &mut state.v,
        settings.cg_tolerance,
        settings.cg_iterations_max,
        &mut scratch.cg,
    );
    if reached.residual.is_finite() { Ok(reached) } else { Err(Failure::NotFinite) }
}

/// Resolves the contacts, `A Δv = Jᵀ λ`, `0 ≤ λ ⊥ J (v + Δv) + g/Δt ≥ 0` with friction, joints
/// ignored as in the paper; leaves Δv in the state's contact change.
fn anticipate(settings: &SolverSettings, state: &mut State, scratch: &mut Scratch) -> Convergence {
    if scratch.rows.rows.is_empty() {
        state.contact_change.fill(Vec3::zeros());
        return Convergence::default();
    }
    scratch.anticipation.solve(
        &scratch.A,
        &scratch.D,
        &mut scratch.rows,
        &anticipation_settings(settings),
        &mut state.contact_change,
    )
}

fn anticipation_settings(settings: &SolverSettings) -> AnticipationSettings {
    AnticipationSettings {
        tolerance: settings.contact_tolerance,
        sweeps_max: settings.contact_sweeps_max,
        inner_passes: settings.contact_inner_passes,
        cone: settings.cone,
    }
}

/// Shortens the velocities of each island so that the step brings in no energy, as
/// `Monolithic::limit_energy` does; joint impulses, which do no work where joints hold, are left
/// out.
fn limit_energy(model: &Model, state: &mut State, scratch: &mut Scratch) {
    let bones = scratch.b_kept.len();
    scratch.b[..bones].copy_from_slice(&scratch.b_kept);
    let Scratch { A, b, cg, islands, rows, .. } = scratch;
    islands.begin(rows);
    weigh_energy(A, b, &model.known, &state.v, cg, islands);
    islands.scale(&model.known, &mut state.v);
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
fn body_velocity(state: &State, b: usize) -> Vec6 {
    stack(&state.v[2 * b], &state.v[2 * b + 1])
}

fn stack(lin: &Vec3, ang: &Vec3) -> Vec6 {
    Vec6::new(lin.x, lin.y, lin.z, ang.x, ang.y, ang.z)
}

fn unstack(v: &Vec6) -> [Vec3; 2] {
    [Vec3::new(v[0], v[1], v[2]), Vec3::new(v[3], v[4], v[5])]
}
