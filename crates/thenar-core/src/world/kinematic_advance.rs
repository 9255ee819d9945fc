//! Moves the state by its new velocities with the joints closed: what the monolithic solver's
//! coordinates mean over a step of any length.
//!
//! Velocities that obey the joints do so where the step began; bodies moved by them one by one
//! would part by `(Δt ω)² r/2`, 4 mm at a joint of a fist clenched in 0.2 s at 60 Hz. Here
//!
//! 1. bodies without a joint, and flesh, move by their own velocities;
//! 2. each joint turns about its axes by its rates, and bodies follow outwards along the tree;
//!    loops are closed by Newton's method in the same coordinates (`joint_tree`);
//! 3. a node keeps its place relative to its skinned target, `x₁ = x₀ + Δt v_f + a` with
//!    `a = f(q₁) - f(q₀) - Δt J v_s`, so that its coupling spring is stretched by `Δt w`, as the
//!    solver said, and flesh that no spring binds turns with what is bound;
//! 4. what floats freely is turned and shifted as a whole to where momentum would have taken it,
//!    and its angular momentum is kept (`keep_momentum`).
//!
//! Steps 2 to 4 correct positions by second order in Δt and leave velocities as the solver found
//! them.

use crate::coupling::{KernelValue, skin_target};
use crate::math::{Pose, Quat, Vec3};
use crate::skeleton::joint_block;
use crate::solver::JointBlock;
use crate::solver::monolithic::Monolithic;
use crate::world::advance::move_each;
use crate::world::assemble::joint_frames;
use crate::world::keep_momentum::{keep_course, keep_spin};
use crate::world::keep_swing::keep_swing;
use crate::world::model::Model;
use crate::world::state::{Scratch, State};

/// Loops are closed to this, in metres and radians: a thousandth of a micrometre.
const CLOSED: f64 = 1e-9;
/// Newton's method squares the error in each round: four of them for an error of a tenth, and as
/// many in which steps are halved.
const ROUNDS_MAX: u32 = 8;

/// Motion of all bodies as if no joint held them, and memory to close the joints.
#[derive(Clone, Debug)]
pub struct UnjointedMotion {
    /// Rotation of each joint at the end of the step.
    rotations_JK: Vec<Quat>,
    /// Pose of each body without joints.
    pub poses_WB: Vec<Pose>,
    /// Position of each node without joints.
    pub x: Vec<Vec3>,
    /// For each carried node, `f(q₀) + Δt J v_s`.
    targets_W: Vec<Vec3>,
    /// Poses and joints while loops are closed.
    tried: Vec<Pose>,
    joints: Vec<JointBlock>,
    still: Vec<Vec3>,
}

impl UnjointedMotion {
    /// Room for this model.
    pub fn new(model: &Model) -> Self {
        let (bodies, joints) = (model.rigids.len(), model.joints.len());
        Self {
            rotations_JK: vec![Quat::identity(); joints],
            poses_WB: vec![Pose::identity(); bodies],
            x: vec![Vec3::zeros(); model.flesh.mass.len()],
            targets_W: vec![Vec3::zeros(); model.coupling.carried().count()],
            tried: vec![Pose::identity(); bodies],
            joints: vec![JointBlock::empty(); joints],
            still: vec![Vec3::zeros(); 2 * bodies],
        }
    }
}

/// Moves all by its velocities and, where given, by `push`, which moves but is not kept.
pub fn advance_jointed(
    model: &Model,
    state: &mut State,
    push: Option<&[Vec3]>,
    h: f64,
    monolithic: Option<&mut Monolithic>,
    scratch: &mut Scratch,
) {
    let moved = &mut scratch.moved;
    let velocity = |i: usize| state.v[i] + push.map_or(Vec3::zeros(), |push| push[i]);
    let spin = |b: usize| velocity(2 * b + 1);
    model.tree.turn(model, &state.poses_WB, spin, h, &mut moved.rotations_JK);
    let posed = model.coupling.offsets.pose(&state.poses_WB, &mut scratch.shares);
    for (bound, target_W) in model.coupling.carried().zip(&mut moved.targets_W) {
        let target = skin_target(bound, &state.poses_WB, &posed);
        *target_W = target.position_W;
        for j in 0..bound.bone_count() {
            let b = 2 * bound.bones[j] as usize;
            let turned = target.turning.velocity(j, &velocity(b + 1));
            *target_W += (velocity(b) * bound.weights[j] + turned) * h;
        }
    }

    move_each(model, state, push, h);
    moved.poses_WB.copy_from_slice(&state.poses_WB);
    moved.x.copy_from_slice(&state.x);
    model.tree.place(model, &moved.rotations_JK, &mut state.poses_WB);
    if let Some(monolithic) = monolithic.filter(|_| !model.tree.cuts.is_empty()) {
        close_loops(monolithic, model, state, scratch);
    }
    let Scratch { moved, shares, .. } = scratch;
    let moved = &*moved;
    carry(model, state, moved, shares);
    model.tree.floating.iter().for_each(|floating| keep_course(floating, model, moved, state));
    keep_own_spins(model, state, moved);
    model.tree.floating.iter().for_each(|floating| keep_spin(floating, model, moved, state));
    model.tree.hanging.iter().for_each(|hanging| keep_swing(hanging, model, moved, state));
}

/// Closes the joints that the tree leaves out, by motions that the tree allows. Where a round does
/// not bring them together (a linkage that is nearly stretched out) half of it is tried next.
fn close_loops(
    monolithic: &mut Monolithic,
    model: &Model,
    state: &mut State,
    scratch: &mut Scratch,
) {
    let Scratch { moved, A, .. } = scratch;
    let (mut open, mut share) = (largest_error(model, state), 1.0);
    for _ in 0..ROUNDS_MAX {
        if open <= CLOSED {
            return;
        }
        for (j, joint) in model.joints.iter().enumerate() {
            moved.joints[j] = joint_block(joint.kind, &joint_frames(model, state, j));
        }
        // The motion over a step of 1 s that would end with all joints closed.
        let Some(motion) = monolithic.closing_motion(A, &moved.joints, &moved.still) else {
            return;
        };
        moved.tried.copy_from_slice(&state.poses_WB);
        let spin = |b: usize| motion.offset(b)[1];
        model.tree.turn(model, &state.poses_WB, spin, share, &mut moved.rotations_JK);
        for (b, pose) in state.poses_WB.iter_mut().enumerate() {
            let [shift, turn] = motion.offset(b).map(|part| part * share);
            pose.position += shift;
            pose.rotation = Quat::from_scaled_axis(turn) * pose.rotation;
        }
        model.tree.place(model, &moved.rotations_JK, &mut state.poses_WB);
        let now = largest_error(model, state);
        if now < open {
            (open, share) = (now, 1.0);
        } else {
            state.poses_WB.copy_from_slice(&moved.tried);
            share *= 0.5;
        }
    }
}

/// The largest error of a joint that closes a loop, metres and radians alike.
fn largest_error(model: &Model, state: &State) -> f64 {
    let error = |&j: &usize| {
        let block = joint_block(model.joints[j].kind, &joint_frames(model, state, j));
        block.C.rows(0, block.rows).amax()
    };
    model.tree.cuts.iter().map(error).fold(0.0, f64::max)
}

/// A body turned otherwise than it would by itself keeps its own angular momentum.
fn keep_own_spins(model: &Model, state: &mut State, moved: &UnjointedMotion) {
    for (b, body) in model.rigids.iter().enumerate().filter(|(_, body)| body.moves) {
        let (free, now) = (&moved.poses_WB[b], &state.poses_WB[b]);
        if free.rotation == now.rotation {
            continue;
        }
        let momentum = free.vector(&(body.inertia * free.inverse_vector(&state.v[2 * b + 1])));
        state.v[2 * b + 1] = now.vector(&(body.inverse_inertia * now.inverse_vector(&momentum)));
    }
}

/// Takes each carried node along with its target by what the target moves beyond first order.
fn carry(model: &Model, state: &mut State, moved: &UnjointedMotion, shares: &mut Vec<KernelValue>) {
    let row0 = 2 * model.rigids.len();
    let posed = model.coupling.offsets.pose(&state.poses_WB, shares);
    for (bound, target_W) in model.coupling.carried().zip(&moved.targets_W) {
        let n = bound.node as usize;
        let arc = skin_target(bound, &state.poses_WB, &posed).position_W - target_W;
        let held = &model.known[row0 + n];
        state.x[n] += Vec3::from_fn(|k, _| if held[k] { 0.0 } else { arc[k] });
    }
}
