//! Angular momentum of bodies that hang on a fixed joint, kept as they swing.
//!
//! A body that its joint takes round an arc, not along the tangent of its velocity, has less
//! angular momentum about the pivot than before, `Σ m (x̃ - x) × v` less, with x̃ where its
//! velocity alone would have taken it: of second order in the step, which over many steps would
//! damp the swing in first order. The spin that gives it back about the axes that the joint leaves
//! free is added to all that hangs there.

use crate::math::{Mat3, Vec3};
use crate::model::JointKind;
use crate::skeleton::axis_states;
use crate::world::assemble::joint_frames;
use crate::world::joint_tree::Subtree;
use crate::world::keep_momentum::{point_inertia, turned_inertia};
use crate::world::kinematic_advance::UnjointedMotion;
use crate::world::model::Model;
use crate::world::state::State;

/// Gives back what positions have cost.
pub fn keep_swing(hanging: &Subtree, model: &Model, moved: &UnjointedMotion, state: &mut State) {
    let joint = &model.joints[hanging.joint];
    let pivot = state.poses_WB[joint.child as usize].point(&joint.pose_CK.position);
    let (mut inertia, mut lost) = (Mat3::zeros(), Vec3::zeros());
    for &b in &hanging.bodies {
        let (pose, free, m) = (&state.poses_WB[b], &moved.poses_WB[b], model.rigids[b].mass);
        inertia += point_inertia(m, &(pose.position - pivot)) + turned_inertia(model, state, b);
        lost += (free.position - pose.position).cross(&state.v[2 * b]) * m;
    }
    let spin = free_spin(hanging.joint, model, state, &inertia, &lost);
    for &b in &hanging.bodies {
        state.v[2 * b] += spin.cross(&(state.poses_WB[b].position - pivot));
        state.v[2 * b + 1] += spin;
    }
}

/// The spin about the joint's free axes that has this angular momentum about them.
fn free_spin(j: usize, model: &Model, state: &State, inertia: &Mat3, lost: &Vec3) -> Vec3 {
    let kind = model.joints[j].kind;
    if kind == JointKind::Ball {
        return inertia.try_inverse().map_or(Vec3::zeros(), |inverse| inverse * lost);
    }
    let axes = axis_states(kind, &joint_frames(model, state, j));
    let axes: [Vec3; 2] = axes.map(|axis| axis.map_or(Vec3::zeros(), |axis| axis.direction_W));
    let along = |i: usize, k: usize| axes[i].dot(&(inertia * axes[k]));
    let (a, b, d) = (along(0, 0), along(0, 1), along(1, 1));
    let (p, q) = (axes[0].dot(lost), axes[1].dot(lost));
    let determinant = a * d - b * b;
    if determinant > 1e-9 * a * d {
        return (axes[0] * (d * p - b * q) + axes[1] * (a * q - b * p)) / determinant;
    }
    if a > 0.0 { axes[0] * (p / a) } else { Vec3::zeros() }
}
