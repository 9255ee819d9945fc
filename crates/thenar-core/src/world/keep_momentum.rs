//! Momentum of free-floating bodies, kept when their parts are brought together.
//!
//! Closing joints moves masses relative to each other. Inner forces cannot shift their common
//! centre nor turn them as a whole, so with `δ_i = x̃_i - x_i` from where a part is to where its
//! own velocity would have taken it, all are shifted by `t` and turned by `φ` about the centre c,
//!
//! ```text
//!   t = Σ m δ / M,   I φ = Σ m (x - c) × δ + Σ I_b log(R̃ Rᵀ)
//! ```
//!
//! The momentum of velocities left as they are then stays, but for the angular momentum
//! `Σ m (x - x̃) × v`, of third order in the step; it is given back by turning all velocities
//! alike.

use crate::math::{Mat3, Quat, Vec3, rotation_vector, skew};
use crate::world::joint_tree::FloatingGroup;
use crate::world::kinematic_advance::UnjointedMotion;
use crate::world::model::Model;
use crate::world::state::State;

/// Brings what floats to where its momentum would have taken it.
pub fn keep_course(
    floating: &FloatingGroup,
    model: &Model,
    moved: &UnjointedMotion,
    state: &mut State,
) {
    let (mass, shift) = shift_of(floating, model, moved, state);
    let centre = centre_of(floating, model, state, mass);
    let (inertia, moment) = turn_of(floating, model, moved, state, &centre);
    let Some(turn) = inertia.try_inverse().map(|inverse| inverse * moment) else { return };
    move_all(floating, state, &centre, &(shift / mass), &turn);
}

/// Gives velocities the angular momentum that positions have cost.
pub fn keep_spin(
    floating: &FloatingGroup,
    model: &Model,
    moved: &UnjointedMotion,
    state: &mut State,
) {
    let (mass, _) = shift_of(floating, model, moved, state);
    let centre = centre_of(floating, model, state, mass);
    let (inertia, lost) = lost_spin(floating, model, moved, state, &centre);
    let Some(spin) = inertia.try_inverse().map(|inverse| inverse * lost) else { return };
    let row0 = 2 * model.rigids.len();
    for &b in &floating.bodies {
        state.v[2 * b] += spin.cross(&(state.poses_WB[b].position - centre));
        state.v[2 * b + 1] += spin;
    }
    for n in floating.nodes.iter().cloned().flatten() {
        state.v[row0 + n] += spin.cross(&(state.x[n] - centre));
    }
}

/// M and `Σ m δ`.
fn shift_of(
    floating: &FloatingGroup,
    model: &Model,
    moved: &UnjointedMotion,
    state: &State,
) -> (f64, Vec3) {
    let (mut mass, mut shift) = (0.0, Vec3::zeros());
    for &b in &floating.bodies {
        let m = model.rigids[b].mass;
        mass += m;
        shift += (moved.poses_WB[b].position - state.poses_WB[b].position) * m;
    }
    for n in floating.nodes.iter().cloned().flatten() {
        let m = model.flesh.mass[n];
        mass += m;
        shift += (moved.x[n] - state.x[n]) * m;
    }
    (mass, shift)
}

/// `Σ m x / M`.
fn centre_of(floating: &FloatingGroup, model: &Model, state: &State, mass: f64) -> Vec3 {
    let bodies = floating.bodies.iter();
    let sum: Vec3 = bodies.map(|&b| state.poses_WB[b].position * model.rigids[b].mass).sum();
    let nodes = floating.nodes.iter().cloned().flatten();
    (sum + nodes.map(|n| state.x[n] * model.flesh.mass[n]).sum::<Vec3>()) / mass
}

/// I about the centre and `I φ`.
fn turn_of(
    floating: &FloatingGroup,
    model: &Model,
    moved: &UnjointedMotion,
    state: &State,
    centre: &Vec3,
) -> (Mat3, Vec3) {
    let (mut inertia, mut moment) = (Mat3::zeros(), Vec3::zeros());
    for &b in &floating.bodies {
        let (pose, free) = (&state.poses_WB[b], &moved.poses_WB[b]);
        let lever = pose.position - centre;
        let own = turned_inertia(model, state, b);
        inertia += point_inertia(model.rigids[b].mass, &lever) + own;
        moment += lever.cross(&(free.position - pose.position)) * model.rigids[b].mass;
        moment += own * rotation_vector(&(free.rotation * pose.rotation.inverse()));
    }
    for n in floating.nodes.iter().cloned().flatten() {
        let (m, lever) = (model.flesh.mass[n], state.x[n] - centre);
        inertia += point_inertia(m, &lever);
        moment += lever.cross(&(moved.x[n] - state.x[n])) * m;
    }
    (inertia, moment)
}

/// Shifts and turns all about the centre.
fn move_all(floating: &FloatingGroup, state: &mut State, centre: &Vec3, shift: &Vec3, turn: &Vec3) {
    let rotation = Quat::from_scaled_axis(*turn);
    let place = |x: &Vec3| centre + shift + rotation * (x - centre);
    for &b in &floating.bodies {
        let pose = &mut state.poses_WB[b];
        pose.position = place(&pose.position);
        pose.rotation = Quat::new_normalize((rotation * pose.rotation).into_inner());
    }
    for n in floating.nodes.iter().cloned().flatten() {
        state.x[n] = place(&state.x[n]);
    }
}

/// I about the centre and the angular momentum that velocities have lost to positions.
fn lost_spin(
    floating: &FloatingGroup,
    model: &Model,
    moved: &UnjointedMotion,
    state: &State,
    centre: &Vec3,
) -> (Mat3, Vec3) {
    let row0 = 2 * model.rigids.len();
    let (mut inertia, mut lost) = (Mat3::zeros(), Vec3::zeros());
    for &b in &floating.bodies {
        let (pose, free, m) = (&state.poses_WB[b], &moved.poses_WB[b], model.rigids[b].mass);
        inertia += point_inertia(m, &(pose.position - centre)) + turned_inertia(model, state, b);
        lost += (free.position - pose.position).cross(&state.v[2 * b]) * m;
    }
    for n in floating.nodes.iter().cloned().flatten() {
        let m = model.flesh.mass[n];
        inertia += point_inertia(m, &(state.x[n] - centre));
        lost += (moved.x[n] - state.x[n]).cross(&state.v[row0 + n]) * m;
    }
    (inertia, lost)
}

/// Inertia of a body about its own centre, world \[kg m²\].
pub(super) fn turned_inertia(model: &Model, state: &State, b: usize) -> Mat3 {
    let R = state.poses_WB[b].rotation.to_rotation_matrix().into_inner();
    R * model.rigids[b].inertia * R.transpose()
}

/// Inertia of a mass \[kg\] at the end of a lever \[m\].
pub(super) fn point_inertia(mass: f64, lever: &Vec3) -> Mat3 {
    let cross = skew(lever);
    cross.tr_mul(&cross) * mass
}
