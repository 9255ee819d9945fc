//! Builds the system of a step: `A_s`, `A_sf`, `A_f` and the right-hand sides (Eq. 4, 5, 9).
//!
//! Every spring-like force F with stiffness K and damping C adds `Δt² K + Δt C` to A and
//! `Δt F(q₀)` to b; its damping force at the old velocity cancels between `Δt F` and
//! `-Δt ∂F/∂v v₀`.

use crate::coupling::{EffectiveMass, add_part};
use crate::flesh::Tally;
use crate::math::{Mat3, Quat, Vec3};
use crate::model::{Axis, FleshInStep1, JointLimits, WorldDesc};
use crate::skeleton::{JointFrames, axis_states, joint_block, linearise_drive, spring_torque};
use crate::world::model::Model;
use crate::world::parts::StepPart;
use crate::world::state::{Scratch, State};
use crate::world::{Input, JointTarget};

/// The two frames of a joint at this state.
pub fn joint_frames(model: &Model, state: &State, j: usize) -> JointFrames {
    let joint = &model.joints[j];
    let child = &state.poses_WB[joint.child as usize];
    let parent = joint.parent.map(|p| state.poses_WB[p as usize]);
    JointFrames {
        pose_WJ: parent.map_or(joint.pose_PJ, |p| p * joint.pose_PJ),
        pose_WK: *child * joint.pose_CK,
        parent: parent.map_or(joint.pose_PJ.position, |p| p.position),
        child: child.position,
    }
}

/// Bones and joints: `A_s`, `b_s`, `J_s`, `b_λs`, added to an A of zeros. Limits that are rows add
/// nothing here.
pub fn skeleton(
    desc: &WorldDesc,
    model: &Model,
    limits: JointLimits,
    state: &mut State,
    input: &Input,
    part: StepPart,
    scratch: &mut Scratch,
) {
    let h = part.h;
    scratch.b.fill(Vec3::zeros());
    scratch.bones.clear();
    for b in 0..model.rigids.len() {
        if model.rigids[b].moves {
            add_inertia(model, state, input, b, h, scratch);
            // A target that is not finite pulls nowhere: a tracker's bad sample lets go for a step.
            if let (Some(drive), Some(target)) = (&desc.drives[b], input.target(b)) {
                let target = target.earlier(part.left);
                let (diagonal, rhs) = linearise_drive(drive, &target, &state.poses_WB[b], h);
                for i in 0..2 {
                    add_to_body(scratch, b, i, &Mat3::from_diagonal_element(diagonal[i]));
                    scratch.b[2 * b + i] += rhs[i];
                }
            }
        } else {
            state.v[2 * b] = input.prescribed[b][0];
            state.v[2 * b + 1] = input.prescribed[b][1];
        }
    }
    for j in 0..model.joints.len() {
        let frames = joint_frames(model, state, j);
        scratch.joints[j] = joint_block(model.joints[j].kind, &frames);
        scratch.axes[j] = axis_states(model.joints[j].kind, &frames);
        let target = input.joint_target(j).map(|target| target.earlier(part.left));
        let acts = (input.joint_torques[j], target);
        add_joint_springs(model, limits, acts, j, &frames, h, scratch);
    }
}

/// `M_s`, `M_s v_0`, weight and external wrenches. Gyroscopic torque is left to the integration
/// (`skeleton::turn_freely`).
fn add_inertia(
    model: &Model,
    state: &State,
    input: &Input,
    b: usize,
    h: f64,
    scratch: &mut Scratch,
) {
    let body = &model.rigids[b];
    let R = state.poses_WB[b].rotation.to_rotation_matrix().into_inner();
    let inertia_W = R * body.inertia * R.transpose();
    add_to_body(scratch, b, 0, &Mat3::from_diagonal_element(body.mass));
    add_to_body(scratch, b, 1, &inertia_W);
    let [force, torque] = input.wrenches[b];
    scratch.b[2 * b] += (state.v[2 * b] + input.gravity * h) * body.mass + force * h;
    scratch.b[2 * b + 1] += inertia_W * state.v[2 * b + 1] + torque * h;
}

/// Spring and damper of axis `k` of a joint, as the joint's target says.
pub fn relaxed_at(axis: &Axis, target: Option<&JointTarget>, k: usize) -> Axis {
    let Some(target) = target else { return *axis };
    let [stiffness, damping] = [axis.stiffness, axis.damping].map(|x| x * target.gains[k]);
    Axis { rest_angle: target.angles[k], stiffness, damping, ..*axis }
}

/// Springs and dampers of joint `j`, torques from outside, and a target where the springs are
/// relaxed.
fn add_joint_springs(
    model: &Model,
    limits: JointLimits,
    (torques, target): ([f64; 2], Option<JointTarget>),
    j: usize,
    frames: &JointFrames,
    h: f64,
    scratch: &mut Scratch,
) {
    let joint = &model.joints[j];
    if joint.kind == crate::model::JointKind::Ball {
        let turn_WJ = frames.pose_WJ.rotation;
        let relaxed = target.map_or(Quat::identity(), |target| target.rotation_JK);
        let turn = frames.pose_WK.rotation * (turn_WJ * relaxed).inverse();
        let axis = relaxed_at(&joint.axes[0], target.as_ref(), 0);
        let spin_W = target.map_or(Vec3::zeros(), |target| turn_WJ * target.spin_J);
        let torque = crate::math::rotation_vector(&turn) * -axis.stiffness + spin_W * axis.damping;
        let implicit = h * h * axis.stiffness + h * axis.damping;
        add_relative(model, j, &Mat3::from_diagonal_element(implicit), &(torque * h), scratch);
        return;
    }
    for (k, axis) in scratch.axes[j].into_iter().enumerate() {
        let Some(axis) = axis else { continue };
        let spring = relaxed_at(&joint.axes[k], target.as_ref(), k);
        let (torque, stiffness, damping) = spring_torque(&spring, joint, limits, axis.angle);
        let led = target.map_or(0.0, |target| target.rates[k] * spring.damping);
        let a = axis.direction_W;
        let implicit = a * a.transpose() * (h * h * stiffness + h * damping);
        add_relative(model, j, &implicit, &(a * ((torque + led + torques[k]) * h)), scratch);
    }
}

/// A torque between the two bodies of a joint: `impulse` on the child, its opposite on the
/// parent, with the implicit matrix of their relative angular velocity.
fn add_relative(model: &Model, j: usize, implicit: &Mat3, impulse: &Vec3, scratch: &mut Scratch) {
    let joint = &model.joints[j];
    let entries = model.joint_entries[j];
    let child = joint.child as usize;
    scratch.A.add(entries.child, implicit);
    add_part(&mut scratch.bones.diagonal[child], 1, 1, implicit);
    scratch.b[2 * child + 1] += impulse;
    if let (Some(parent), Some(at)) = (joint.parent, entries.with_parent) {
        let parent = parent as usize;
        scratch.A.add(at[0], implicit);
        scratch.A.add(at[1], &-implicit);
        scratch.A.add(at[2], &-implicit);
        add_part(&mut scratch.bones.diagonal[parent], 1, 1, implicit);
        add_part(&mut scratch.bones.edge[j], 1, 1, &-implicit);
        scratch.b[2 * parent + 1] -= impulse;
    }
}

fn add_to_body(scratch: &mut Scratch, b: usize, part: usize, m: &Mat3) {
    let diagonal = scratch.A.diagonal[2 * b + part];
    scratch.A.add(diagonal, m);
    add_part(&mut scratch.bones.diagonal[b], part, part, m);
}

/// The springs between bones and flesh: `A_sf`, `A_fs`, and their parts of `A_s` and `A_f`
/// (Eq. 7-9).
pub fn coupling(
    step1_flesh: FleshInStep1,
    model: &Model,
    state: &State,
    h: f64,
    scratch: &mut Scratch,
) {
    scratch.coupled = true;
    for (n, mass) in scratch.step1_mass.iter_mut().enumerate() {
        let damped = model.flesh.mass[n] * (1.0 + h * model.flesh.mass_damping[n]);
        *mass = if model.is_held[n] { f64::INFINITY } else { damped };
    }
    let step1 = EffectiveMass { flesh: step1_flesh, mass: &scratch.step1_mass };
    let posed = model.coupling.offsets.pose(&state.poses_WB, &mut scratch.shares);
    model.coupling.assemble(
        &state.poses_WB,
        &posed,
        &state.x,
        &state.v[2 * model.rigids.len()..],
        h,
        &step1,
        &mut scratch.A,
        &mut scratch.b,
        &mut scratch.bones,
    );
}

/// Flesh: `A_f`, `b_f` (Eq. 5), weight and nodal forces. Ends with the velocities
/// of prescribed bodies and held nodes being made known.
pub fn flesh(model: &Model, state: &State, input: &Input, h: f64, scratch: &mut Scratch) -> Tally {
    let row0 = 2 * model.rigids.len();
    let v = &state.v[row0..];
    let Scratch { A, b, .. } = scratch;
    let tally = model.flesh.assemble(&state.x, v, &state.faded, h, row0, A, b);
    for (n, mass) in model.flesh.mass.iter().enumerate() {
        scratch.b[row0 + n] += (input.gravity * *mass + input.node_forces[n]) * h;
    }
    for (i, known) in model.known.iter().enumerate() {
        for axis in (0..3).filter(|&axis| known[axis]) {
            scratch.A.hold(i, axis, state.v[i][axis], &mut scratch.b);
        }
    }
    tally
}
