//! Joint limits as inequalities: an axis turns no further than its bound within the step.
//!
//! ```text
//!   0 ≤ λ  ⊥  (θ - bound)/Δt + θ̇ ≥ 0        (mirrored at the upper bound)
//! ```
//!
//! The rows stand behind those of contact and are solved together with them.

use crate::math::Vec3;
use crate::model::{AngleLimit, Limits, SolverKind, SolverSettings};
use crate::skeleton::{AxisState, limit_spring_torque, turned_towards};
use crate::solver::TURN_LEVER;
use crate::solver::exact::Bound;
use crate::world::model::Model;
use crate::world::state::{Scratch, State};
use crate::world::{World, assemble};

/// Whether limits are kept by rows; if not, springs act.
pub fn by_rows(settings: &SolverSettings) -> bool {
    settings.limits == Limits::Rows && settings.kind != SolverKind::TwoStep
}

/// Most rows that limits can need.
pub fn rows_max(model: &Model) -> usize {
    2 * model.joints.iter().map(|joint| joint.kind.angles()).sum::<usize>()
}

/// Tells the exact solver all bounds, in the order of their rows, and what each bore in the last step.
pub fn set_bounds(limits: Limits, model: &Model, state: &State, h: f64, scratch: &mut Scratch) {
    let Some(exact) = &mut scratch.exact else { return };
    let bounds = exact.bounds_mut();
    if limits == Limits::Springs {
        return;
    }
    for (j, joint) in model.joints.iter().enumerate() {
        for (k, axis) in joint.axes[..joint.kind.angles()].iter().enumerate() {
            let (Some(limit), Some(present)) = (axis.limit, scratch.axes[j][k]) else { continue };
            bounds.extend(gaps(&limit, present.angle).map(|(sign, gap)| Bound {
                child: joint.child,
                parent: joint.parent,
                axis_W: present.direction_W * sign,
                wanted: wanted(gap, h),
                impulse: (sign * state.limit_impulses[j][k]).max(0.0) / TURN_LEVER,
            }));
        }
    }
}

/// How fast to turn away from a bound at this distance \[rad\], at [`TURN_LEVER`] \[m/s\]. Beyond a bound
/// an axis turns no further; `push_out` brings it back.
fn wanted(gap: f64, h: f64) -> f64 {
    TURN_LEVER * -gap.max(0.0) / h
}

/// Appends the rows of all bounds, for the velocities without contact in `state`. What the exact
/// solver holds already starts from the impulse in these.
pub fn build_rows(kind: SolverKind, model: &Model, state: &State, h: f64, scratch: &mut Scratch) {
    let mut next = 0;
    for (j, joint) in model.joints.iter().enumerate() {
        for (k, axis) in joint.axes[..joint.kind.angles()].iter().enumerate() {
            let (Some(limit), Some(present)) = (axis.limit, scratch.axes[j][k]) else { continue };
            for (sign, gap) in gaps(&limit, present.angle) {
                let held = scratch.exact.as_ref().filter(|_| kind == SolverKind::Exact);
                let included = held.map_or(0.0, |exact| exact.bounds()[next].impulse);
                next += 1;
                let before = (sign * state.limit_impulses[j][k]).max(0.0);
                let rows = &mut scratch.rows;
                let i = rows.begin_turn(&(present.direction_W * sign), before);
                rows.hold_rigid(joint.child, Vec3::zeros(), 1.0);
                if let Some(parent) = joint.parent {
                    rows.hold_rigid(parent, Vec3::zeros(), -1.0);
                }
                let row = &rows.rows[i];
                let v = row.frame * rows.relative_velocity(row, &state.v);
                rows.rows[i].target = Vec3::new(wanted(gap, h), 0.0, 0.0) - v;
                if included != 0.0 {
                    rows.rows[i].included = included;
                    rows.rows[i].lambda.x = included.max(0.0);
                }
            }
        }
    }
}

/// Appends how far each row's bound was at the start of the step, as its row counts it \[m\].
pub fn list_gaps(model: &Model, axes: &[[Option<AxisState>; 2]], to: &mut Vec<f64>) {
    for (joint, axes) in model.joints.iter().zip(axes) {
        for (axis, present) in joint.axes[..joint.kind.angles()].iter().zip(axes) {
            let (Some(limit), Some(present)) = (axis.limit, present) else { continue };
            to.extend(gaps(&limit, present.angle).map(|(_, gap)| gap * TURN_LEVER));
        }
    }
}

/// Keeps the impulses found for the next step; returns how many bounds bear load. `first` is the
/// first row of a limit.
pub fn keep_impulses(model: &Model, first: usize, state: &mut State, scratch: &Scratch) -> u32 {
    state.limit_impulses.fill([0.0; 2]);
    let (mut row, mut active) = (first, 0);
    for (j, joint) in model.joints.iter().enumerate() {
        for (k, axis) in joint.axes[..joint.kind.angles()].iter().enumerate() {
            let (Some(limit), Some(present)) = (axis.limit, scratch.axes[j][k]) else { continue };
            for (sign, _) in gaps(&limit, present.angle) {
                if row >= scratch.rows.rows.len() {
                    continue;
                }
                let lambda = scratch.rows.rows[row].lambda.x;
                state.limit_impulses[j][k] += sign * lambda * TURN_LEVER;
                active += u32::from(lambda > 0.0);
                row += 1;
            }
        }
    }
    active
}

/// Keeps the impulses that the springs of limits gave in a step which the two-step scheme made for
/// the exact solver: those of the angles and rates at its end, as they are implicit.
pub fn keep_spring_impulses(model: &Model, state: &mut State, h: f64, scratch: &Scratch) {
    for (j, joint) in model.joints.iter().enumerate() {
        let turning = |b: u32| state.v[2 * b as usize + 1];
        let relative = turning(joint.child) - joint.parent.map_or(Vec3::zeros(), turning);
        for (k, axis) in joint.axes[..joint.kind.angles()].iter().enumerate() {
            let Some(present) = scratch.axes[j][k] else { continue };
            let rate = present.direction_W.dot(&relative);
            let torque = limit_spring_torque(axis, joint, present.angle + h * rate, rate);
            state.limit_impulses[j][k] = h * torque;
        }
    }
}

/// Direction in which each bound pushes, and how far the angle is from it \[rad\].
fn gaps(limit: &AngleLimit, angle: f64) -> [(f64, f64); 2] {
    let angle = turned_towards(limit, angle);
    [(1.0, angle - limit.min), (-1.0, limit.max - angle)]
}

impl World {
    /// Torque by which its limits keep each measured axis of joint `j` within range, on the child,
    /// opposite on the parent \[N m\]: its mean in the last step, or, where limits are springs, that
    /// of the present angle and rate. Positive torques turn towards larger angles.
    pub fn joint_limit_torques(&self, j: u32) -> [f64; 2] {
        if by_rows(&self.desc.solver) {
            return self.state.limit_impulses[j as usize].map(|impulse| impulse / self.time_step);
        }
        let joint = &self.model.joints[j as usize];
        let frames = assemble::joint_frames(&self.model, &self.state, j as usize);
        let rates = self.joint_rates(j);
        let axes = crate::skeleton::axis_states(joint.kind, &frames);
        std::array::from_fn(|k| {
            let torque = |axis: crate::skeleton::AxisState| {
                limit_spring_torque(&joint.axes[k], joint, axis.angle, rates[k])
            };
            axes[k].map_or(0.0, torque)
        })
    }
}
