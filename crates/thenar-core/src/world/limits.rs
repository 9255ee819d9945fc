//! Joint limits as inequalities: an axis turns no further than its bound within the step.
//!
//! ```text
//!   0 ≤ λ  ⊥  (θ - bound)/Δt + θ̇ ≥ 0        (mirrored at the upper bound)
//! ```
//!
//! The bounds of a step are listed once ([`list`]). Their rows stand behind those of contact, in
//! the order of the list, and are solved together with them.

use crate::math::Vec3;
use crate::model::{AngleLimit, JointLimits, SolverKind, SolverSettings};
use crate::skeleton::{AxisState, limit_spring_torque, turned_towards};
use crate::solver::TURN_LEVER;
use crate::solver::monolithic::Bound;
use crate::world::model::Model;
use crate::world::state::{Scratch, State};
use crate::world::{World, assemble};

/// One bound of one axis of a joint.
#[derive(Clone, Copy, Debug)]
pub struct LimitRow {
    /// Index of the joint.
    pub joint: u32,
    /// Measured axis of the joint, 0 or 1.
    pub axis: u32,
    /// The sign of torques that push away from the bound: 1 at the lower bound, -1 at the upper.
    pub sign: f64,
    /// Distance of the angle from the bound, negative beyond it \[rad\].
    pub gap: f64,
    /// The turn of the child that leads away from the bound, world, of unit length.
    pub direction_W: Vec3,
    /// The impulse that the velocities without contact have in them already, at [`TURN_LEVER`] \[N
    /// s\].
    pub included: f64,
}

/// Returns the mechanism that keeps limits.
pub fn kind(settings: &SolverSettings) -> JointLimits {
    if by_rows(settings) { JointLimits::Rows } else { JointLimits::Springs }
}

/// True when limits are kept by rows; if not, springs act.
pub fn by_rows(settings: &SolverSettings) -> bool {
    settings.limits == JointLimits::Rows && settings.kind != SolverKind::TwoStep
}

/// Most rows that limits can need.
pub fn rows_max(model: &Model) -> usize {
    2 * model.joints.iter().map(|joint| joint.kind.angles()).sum::<usize>()
}

/// Lists the bounds of the step, none where springs keep them.
pub fn list(limits: JointLimits, model: &Model, scratch: &mut Scratch) {
    let Scratch { limits: list, axes, .. } = scratch;
    list.clear();
    if limits == JointLimits::Springs {
        return;
    }
    for (j, k, limit, present) in limited(model, axes) {
        list.extend(gaps(&limit, present.angle).map(|(sign, gap)| LimitRow {
            joint: j as u32,
            axis: k as u32,
            sign,
            gap,
            direction_W: present.direction_W * sign,
            included: 0.0,
        }));
    }
}

/// Joint, axis, limit and present state of each axis that has a limit.
fn limited<'a>(
    model: &'a Model,
    axes: &'a [[Option<AxisState>; 2]],
) -> impl Iterator<Item = (usize, usize, AngleLimit, AxisState)> + 'a {
    model.joints.iter().zip(axes).enumerate().flat_map(|(j, (joint, present))| {
        let axes = joint.axes[..joint.kind.angles()].iter().zip(present).enumerate();
        axes.filter_map(move |(k, (axis, present))| Some((j, k, axis.limit?, (*present)?)))
    })
}

/// Direction in which each bound pushes, and how far the angle is from it \[rad\].
fn gaps(limit: &AngleLimit, angle: f64) -> [(f64, f64); 2] {
    let angle = turned_towards(limit, angle);
    [(1.0, angle - limit.min), (-1.0, limit.max - angle)]
}

impl LimitRow {
    /// The bound as the monolithic solver takes it, with what it bore in the last step.
    pub fn bound(&self, model: &Model, state: &State, h: f64) -> Bound {
        let joint = &model.joints[self.joint as usize];
        Bound {
            child: joint.child,
            parent: joint.parent,
            axis_W: self.direction_W,
            wanted: wanted(self.gap, h),
            impulse: self.borne(state) / TURN_LEVER,
        }
    }

    /// The impulse by which the bound pushed in the last step \[N m s\].
    fn borne(&self, state: &State) -> f64 {
        (self.sign * state.limit_impulses[self.joint as usize][self.axis as usize]).max(0.0)
    }
}

/// Appends the rows of all bounds, for the velocities without contact in `state`. What these have
/// in them already starts from there.
pub fn build_rows(model: &Model, state: &State, h: f64, scratch: &mut Scratch) {
    let Scratch { limits, rows, .. } = scratch;
    for limit in limits.iter() {
        let joint = &model.joints[limit.joint as usize];
        let i = rows.begin_turn(&limit.direction_W, limit.borne(state));
        rows.hold_rigid(joint.child, Vec3::zeros(), 1.0);
        if let Some(parent) = joint.parent {
            rows.hold_rigid(parent, Vec3::zeros(), -1.0);
        }
        let row = &rows.rows[i];
        let v = row.frame * rows.relative_velocity(row, &state.v);
        let row = &mut rows.rows[i];
        row.target = Vec3::new(wanted(limit.gap, h), 0.0, 0.0) - v;
        if limit.included != 0.0 {
            row.included = limit.included;
            row.lambda.x = limit.included.max(0.0);
        }
    }
}

/// Returns the speed to turn away from a bound at this distance \[rad\], at [`TURN_LEVER`] \[m/s\].
/// Beyond a bound an axis turns no further; `push_out` brings it back.
fn wanted(gap: f64, h: f64) -> f64 {
    TURN_LEVER * -gap.max(0.0) / h
}

/// Keeps the impulses found for the next step; returns how many bounds bear load.
pub fn keep_impulses(state: &mut State, scratch: &Scratch) -> u32 {
    state.limit_impulses.fill([0.0; 2]);
    let Scratch { limits, rows, found, .. } = scratch;
    let mut active = 0;
    for (limit, row) in limits.iter().zip(&rows.rows[found.len()..]) {
        let impulse = limit.sign * row.lambda.x * TURN_LEVER;
        state.limit_impulses[limit.joint as usize][limit.axis as usize] += impulse;
        active += u32::from(row.lambda.x > 0.0);
    }
    active
}

/// Keeps the impulses that the springs of limits gave in a step which the two-step scheme made for
/// the monolithic solver: those of the angles and rates at its end, as they are implicit.
pub fn keep_spring_impulses(model: &Model, state: &mut State, h: f64, scratch: &Scratch) {
    for (j, k, _, present) in limited(model, &scratch.axes) {
        let joint = &model.joints[j];
        let turning = |b: u32| state.v[2 * b as usize + 1];
        let relative = turning(joint.child) - joint.parent.map_or(Vec3::zeros(), turning);
        let rate = present.direction_W.dot(&relative);
        let angle = present.angle + h * rate;
        state.limit_impulses[j][k] = h * limit_spring_torque(&joint.axes[k], joint, angle, rate);
    }
}

impl World {
    /// Torque by which its limits keep each measured axis of joint `j` within range, on the child,
    /// opposite on the parent \[N m\]: its mean in the last step, or, where limits are springs,
    /// that of the present angle and rate. Positive torques turn towards larger angles.
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
