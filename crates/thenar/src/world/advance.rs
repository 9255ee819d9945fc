//! Moves the state by its new velocities, and measures it.

use crate::math::{Quat, Vec3};
use crate::skeleton::{misalignment, turn_freely};
use crate::world::assemble::joint_frames;
use crate::world::model::Model;
use crate::world::state::State;

/// `q₁ = q₀ + Δt (v₁ + p)` with the pseudo-velocity p of this step, where there is one. Rigid bodies turn
/// with their angular momentum fixed in the world, but for p, which turns their motion with them: so
/// it changes no kinetic energy.
pub fn advance(model: &Model, state: &mut State, push: Option<&[Vec3]>, h: f64) {
    let row0 = 2 * model.rigids.len();
    for (b, body) in model.rigids.iter().enumerate() {
        let pose = &mut state.poses_WB[b];
        pose.position += state.v[2 * b] * h;
        let omega = &mut state.v[2 * b + 1];
        if body.moves {
            (pose.rotation, *omega) =
                turn_freely(&pose.rotation, omega, &body.inertia, &body.inverse_inertia, h);
        } else {
            let turn = Quat::from_scaled_axis(*omega * h) * pose.rotation;
            pose.rotation = Quat::new_normalize(turn.into_inner());
        }
    }
    for (x, v) in state.x.iter_mut().zip(&state.v[row0..]) {
        *x += v * h;
    }
    if let Some(push) = push {
        displace(model, state, push, h);
    }
    state.time += h;
}

/// Moves all by `Δt p`.
fn displace(model: &Model, state: &mut State, push: &[Vec3], h: f64) {
    let (bones, nodes) = push.split_at(2 * model.rigids.len());
    for (b, _) in model.rigids.iter().enumerate().filter(|(_, body)| body.moves) {
        let pose = &mut state.poses_WB[b];
        pose.position += bones[2 * b] * h;
        let turn = Quat::from_scaled_axis(bones[2 * b + 1] * h);
        pose.rotation = Quat::new_normalize((turn * pose.rotation).into_inner());
        state.v[2 * b + 1] = turn * state.v[2 * b + 1];
    }
    for (x, p) in state.x.iter_mut().zip(nodes) {
        *x += p * h;
    }
}

/// Largest joint gap \[m\] and axis misalignment \[rad\].
pub fn joint_errors(model: &Model, state: &State) -> (f64, f64) {
    let mut errors = (0.0_f64, 0.0_f64);
    for (j, joint) in model.joints.iter().enumerate() {
        if joint.kind.rows() == 0 {
            continue;
        }
        let frames = joint_frames(model, state, j);
        errors.0 = errors.0.max(frames.gap().norm());
        errors.1 = errors.1.max(misalignment(joint.kind, &frames));
    }
    errors
}

/// Undoes what a solver did before another one tries.
pub fn take_velocities_back(state: &mut State, before: &State) {
    state.v.copy_from_slice(&before.v);
    state.contact_change.copy_from_slice(&before.contact_change);
    state.impulses.clear();
    state.impulses.extend_from_slice(&before.impulses);
    state.limit_impulses.copy_from_slice(&before.limit_impulses);
    state.patch_loads.clone_from(&before.patch_loads);
}

/// Undoes a failed step: positions as before, everything at rest.
pub fn take_back(state: &mut State, before: &State) {
    state.time = before.time;
    state.poses_WB.copy_from_slice(&before.poses_WB);
    state.x.copy_from_slice(&before.x);
    state.v.fill(Vec3::zeros());
    state.contact_change.fill(Vec3::zeros());
    state.impulses.clear();
    state.limit_impulses.fill([0.0; 2]);
    state.patch_loads.clear();
}
