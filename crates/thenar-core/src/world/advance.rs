//! Moves the state by its new velocities, and measures it.

use crate::math::{Quat, Vec3};
use crate::skeleton::{misalignment, turn_freely};
use crate::world::assemble::joint_frames;
use crate::world::kinematic_advance::advance_jointed;
use crate::world::model::Model;
use crate::world::scheme::Solver;
use crate::world::state::{Scratch, State};

/// `q₁ = q₀ + Δt (v₁ + push)`, along the joints (`kinematic_advance`) but for the two-step scheme,
/// whose velocities do not obey them. `push` moves things and is not kept: velocities without
/// contact's rows of the state's shape, which push out what overlaps.
pub fn advance(
    solver: &mut Solver,
    model: &Model,
    state: &mut State,
    push: Option<&[Vec3]>,
    h: f64,
    scratch: &mut Scratch,
) {
    match solver {
        Solver::TwoStep => move_each(model, state, push, h),
        #[cfg(any(test, feature = "reference"))]
        Solver::DenseReference => advance_jointed(model, state, push, h, None, scratch),
        Solver::Monolithic(monolithic) => {
            advance_jointed(model, state, push, h, Some(monolithic), scratch)
        }
    }
    state.time += h;
}

/// Moves each body and each node by itself. Rigid bodies turn with their angular momentum fixed in
/// the world.
pub fn move_each(model: &Model, state: &mut State, push: Option<&[Vec3]>, h: f64) {
    let row0 = 2 * model.rigids.len();
    for (b, body) in model.rigids.iter().enumerate() {
        let pose = &mut state.poses_WB[b];
        pose.position += state.v[2 * b] * h;
        let omega = &mut state.v[2 * b + 1];
        if body.moves {
            (pose.rotation, *omega) =
                turn_freely(&pose.rotation, omega, &body.inertia, &body.inverse_inertia, h);
        } else {
            let turn = Quat::from_scaled_axis(*omega * h);
            pose.rotation = Quat::new_normalize((turn * pose.rotation).into_inner());
        }
    }
    for (x, v) in state.x.iter_mut().zip(&state.v[row0..]) {
        *x += v * h;
    }
    if let Some(push) = push {
        displace(model, state, push, h);
    }
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

/// Undoes that a step moved all.
pub fn take_positions_back(state: &mut State, before: &State) {
    state.time = before.time;
    state.poses_WB.copy_from_slice(&before.poses_WB);
    state.x.copy_from_slice(&before.x);
}

/// Undoes a failed step: positions as before, everything at rest.
pub fn take_back(state: &mut State, before: &State) {
    take_positions_back(state, before);
    state.v.fill(Vec3::zeros());
    state.contact_change.fill(Vec3::zeros());
    state.impulses.clear();
    state.limit_impulses.fill([0.0; 2]);
    state.patch_loads.clear();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Mat3;
    use crate::model::{Motion, RigidDesc, SolverKind, WorldDesc};
    use crate::world::World;

    fn body(motion: Motion, spin: Vec3) -> RigidDesc {
        RigidDesc {
            name: format!("{motion:?}"),
            motion,
            mass: 0.2,
            inertia: Mat3::from_diagonal(&Vec3::new(1e-4, 2e-4, 3e-4)),
            pose_WB: crate::math::Pose::identity(),
            velocity_W: Vec3::new(0.1, -0.2, 0.3),
            angular_velocity_W: spin,
            shape: None,
            pose_BS: crate::math::Pose::identity(),
            friction: 0.5,
        }
    }

    /// About a principal axis a free body turns by ω t, one that is led turns so about any.
    #[test]
    fn bodies_go_and_turn_at_their_rates() {
        let (h, steps) = (1e-3, 500);
        for kind in [SolverKind::Monolithic, SolverKind::TwoStep] {
            let mut desc = WorldDesc { time_step: h, ..WorldDesc::default() };
            desc.add_rigid(body(Motion::Dynamic, Vec3::z() * 4.0));
            desc.add_rigid(body(Motion::Prescribed, Vec3::new(2.0, 1.0, -3.0)));
            let mut world = World::new(desc).unwrap();
            world.set_solver(kind);
            let World { model, state, scratch, solver, .. } = &mut world;
            let before = state.v.clone();
            (0..steps).for_each(|_| advance(solver, model, state, None, h, scratch));
            let t = h * f64::from(steps);
            assert!((state.time - t).abs() < 1e-12);
            for (b, pose) in state.poses_WB.iter().enumerate() {
                let off = pose.position - before[2 * b] * t;
                assert!(off.norm() < 1e-12, "{kind:?}, body {b}: {off}");
                // The turn of a step is 2 atan(h ω/2), of third order in h ω.
                let off = pose.rotation.angle_to(&Quat::from_scaled_axis(before[2 * b + 1] * t));
                assert!(off < 1e-5, "{kind:?}, body {b}: {off} rad of {}", 4.0 * t);
                assert!((state.v[2 * b + 1] - before[2 * b + 1]).norm() < 1e-12);
            }
        }
    }

    /// A push moves and turns, and leaves velocities as they are.
    #[test]
    fn a_push_is_not_kept() {
        for kind in [SolverKind::Monolithic, SolverKind::TwoStep] {
            let mut desc = WorldDesc::default();
            desc.add_rigid(body(Motion::Dynamic, Vec3::zeros()));
            let mut world = World::new(desc).unwrap();
            world.set_solver(kind);
            let World { model, state, scratch, solver, .. } = &mut world;
            let push = [Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.5, -0.5, 1.0)];
            let before = state.v.clone();
            advance(solver, model, state, Some(&push), 0.01, scratch);
            assert_eq!(state.v, before);
            let pose = &state.poses_WB[0];
            assert!((pose.position - (before[0] + push[0]) * 0.01).norm() < 1e-15);
            assert!((pose.rotation.scaled_axis() - push[1] * 0.01).norm() < 1e-12);
        }
    }
}
