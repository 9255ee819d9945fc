//! The response that touch works on between two frames: how the bones of a hand and its contacts
//! answer about the state after a step ([`condensed`](crate::condensed)).
//!
//! The bones answer as they would at rest, so the system is assembled anew for a step that is long
//! beside all damping. What hangs on no drive and on no bones, an object, would not come to rest in
//! the hand's motion alone: it has its inertia over one time step, and goes on for as long at its
//! velocity.

use crate::condensed::{BoneFrame, CondensedContact, RigidState};
use crate::contact::Site;
use crate::math::{Mat3, Vec3};
use crate::model::{Drive, JointLimits, WorldDesc};
use crate::solver::TURN_LEVER;
use crate::solver::monolithic::{
    Accuracy, Monolithic, PRESSING_MAX, ReducedCompliance, StepSystem,
};
use crate::world::parts::StepPart;
use crate::world::readout::Readout;
use crate::world::scheme::Solver;
use crate::world::state::{Scratch, State};
use crate::world::{Input, Model, World, assemble, monolithic};
use std::cmp::Ordering;
use std::ops::Range;

/// A step after which all is at rest \[s\]: dampings of a hand act within milliseconds.
const REST: f64 = 10.0;
/// Accuracy of the state at rest: a micrometre.
const AT_REST: Accuracy =
    Accuracy { best_effort: true, velocity: 1e-6 / REST, iterations_max: 20, sweeps_max: 0 };

/// A drive that is let go: nothing pulls.
const LOOSE: Drive =
    Drive { stiffness: 0.0, damping: 0.0, angular_stiffness: 0.0, angular_damping: 0.0 };

impl World {
    /// Fills a frame for touch after a step: the bones, and how they answer, with the contacts that
    /// touch or may touch before the next frame. `input` is that of the step; `bones` are the
    /// hand's among the rigid bodies. The caller sets time and step. Costs an assembly and a
    /// factor; changes nothing that is simulated, allocates nothing.
    ///
    /// Returns whether there is a response. There is none, and a haptic loop goes on as in
    /// multirate, with another solver than the monolithic one, when the system cannot be factored,
    /// or when the frame is for another number of bones.
    pub fn condense(&mut self, bones: Range<u32>, input: &Input, to: &mut BoneFrame) -> bool {
        to.response.clear();
        let bones = bones.start as usize..(bones.end as usize).min(self.model.rigids.len());
        if to.bones.len() != bones.len() || to.response.bones() != bones.len() {
            return false;
        }
        for (state, b) in to.bones.iter_mut().zip(bones.clone()) {
            *state = RigidState::of(self, b as u32);
        }
        let Self { desc, model, state, scratch, readout, solver, time_step: h, .. } = self;
        let Solver::Monolithic(monolithic) = solver else { return false };
        let mut rest = RestInputs { desc, model, state, scratch, readout, input, h: *h };
        rest.choose(to.response.contacts_max());
        rest.assemble(monolithic);
        for b in bones.clone() {
            let held = desc.drives[b].zip(input.target(b));
            let (spring, pose_WB) =
                held.map_or((LOOSE, state.poses_WB[b]), |(drive, target)| (drive, target.pose_WB));
            to.response.springs.push(spring);
            to.response.targets.push(RigidState::at_rest(pose_WB));
        }
        let Scratch { A, b, joints, chosen, gaps, before, .. } = scratch;
        let Readout { rows, sites, part_length, .. } = &*readout;
        let is_turned = |i: usize| -> bool {
            let on = |site| is_on(desc, &bones, site);
            sites.get(i).is_some_and(|contact| !on(&contact.a) && on(&contact.b))
        };
        let step = StepSystem { A, b, known: &model.known };
        // What is moved from outside stays where it is.
        let motion = &mut before.v;
        motion.fill(Vec3::zeros());
        let (compliance, lift, delassus) = to.response.products();
        let mut reduced_compliance =
            ReducedCompliance { bodies: compliance, lift, contacts: delassus };
        let order = monolithic.reduced_compliance(
            &step,
            joints,
            (motion, REST),
            chosen,
            rows,
            bones.clone(),
            &mut reduced_compliance,
        );
        let Some(order) = order else {
            to.response.clear();
            return false;
        };
        chosen.clear();
        chosen.extend_from_slice(order);
        monolithic.solve_factored(&step, &AT_REST, motion);
        for b in bones.clone() {
            let parts = motion[2 * b..][..2].iter().flatten();
            to.response.rest.extend(parts.map(|rate| REST * rate));
            to.response.loads.extend(input.wrenches[b].iter().flatten());
        }
        let contacts = chosen.iter().map(|&i| {
            let (i, row) = (i as usize, &rows.rows[i as usize]);
            let force = row.lambda / *part_length;
            // What bears force touches, though the solver left a trace of a gap.
            let gap = if force.x > 0.0 { 0.0 } else { gaps[i].max(0.0) };
            let moves = row.frame * rows.relative_velocity(row, motion) * REST;
            CondensedContact {
                // The hand's normal points away from what it touches.
                frame: if is_turned(i) { -row.frame } else { row.frame },
                value: moves + Vec3::x() * gap,
                friction: row.friction,
                force,
            }
        });
        to.response.contacts.extend(contacts);
        to.response.limits.extend(chosen.iter().map(|&i| i as usize >= sites.len()));
        to.response.finish()
    }
}

/// Inputs from which the system at rest is made.
struct RestInputs<'a> {
    desc: &'a WorldDesc,
    model: &'a Model,
    state: &'a mut State,
    scratch: &'a mut Scratch,
    readout: &'a Readout,
    input: &'a Input,
    /// Time step of the simulation \[s\].
    h: f64,
}

impl RestInputs<'_> {
    /// Lists the contacts and joint limits of the last step by what they matter, at most `most`:
    /// those that bear force, then the nearest.
    fn choose(&mut self, most: usize) {
        let Self { desc, state, scratch, readout, .. } = self;
        let Readout { rows, part_length, .. } = readout;
        let Scratch { gaps, chosen, .. } = &mut **scratch;
        chosen.clear();
        gaps.clear();
        gaps.extend(readout.sites.iter().map(|contact| contact.gap));
        if desc.solver.limits == JointLimits::Rows {
            gaps.extend(readout.limits.iter().map(|limit| limit.gap * TURN_LEVER));
        }
        let push = readout.push();
        for (gap, row) in gaps.iter_mut().zip(&rows.rows) {
            let pushed = push.map_or(Vec3::zeros(), |push| rows.relative_velocity(row, push));
            *gap += *part_length * (row.frame * (rows.relative_velocity(row, &state.v) + pushed)).x;
        }
        chosen.extend(0..gaps.len().min(rows.rows.len()) as u32);
        let by_weight = |&i: &u32, &j: &u32| -> Ordering {
            let [(f, g), (k, l)] =
                [i, j].map(|i| (rows.rows[i as usize].lambda.x, gaps[i as usize]));
            k.total_cmp(&f).then(g.total_cmp(&l)).then(i.cmp(&j))
        };
        chosen.sort_unstable_by(by_weight);
        chosen.truncate(most.min(PRESSING_MAX));
    }

    /// The system whose solution is where all comes to rest under the contact forces of the last
    /// step.
    fn assemble(&mut self, monolithic: &mut Monolithic) {
        let Self { desc, model, state, scratch, input, .. } = self;
        scratch.before.v.copy_from_slice(&state.v);
        monolithic::clear(monolithic, scratch);
        let rest = StepPart { h: REST, left: 0.0, reach: 0.0 };
        assemble::skeleton(desc, model, desc.solver.limits, state, input, rest, scratch);
        monolithic::couple(monolithic, model, state, REST, &mut scratch.shares);
        assemble::flesh(model, state, input, REST, scratch);
        // Prescribed bodies were given this input's velocities.
        state.v.copy_from_slice(&scratch.before.v);
        self.hold_targets();
        self.add_objects();
        let Self { scratch: Scratch { b, .. }, readout: Readout { rows, part_length, .. }, .. } =
            self;
        for row in rows.rows.iter().filter(|row| row.lambda != Vec3::zeros()) {
            let impulse = row.frame.tr_mul(&row.lambda) * (REST / *part_length);
            rows.scatter(row, &impulse, b);
        }
    }

    /// Targets stay where they are: takes the damping of drives towards their velocity out again.
    fn hold_targets(&mut self) {
        for (i, drive) in self.desc.drives.iter().enumerate() {
            let Some((drive, target)) = drive.as_ref().zip(self.input.target(i)) else { continue };
            let b = &mut self.scratch.b[2 * i..][..2];
            b[0] -= target.velocity_W * (drive.damping * REST);
            b[1] -= target.angular_velocity_W * (drive.angular_damping * REST);
        }
    }

    /// Adds bodies that hang on no drive and no bones, which move by `h v + h² f/m` in a time step
    /// of h.
    fn add_objects(&mut self) {
        let Self { desc, model, state, scratch, input, h, .. } = self;
        let steps = REST / *h;
        let Scratch { A, b: rhs, .. } = &mut **scratch;
        for (b, body) in model.rigids.iter().enumerate() {
            let driven = desc.drives[b].is_some() && input.target(b).is_some();
            if body.moves && !driven {
                let R = state.poses_WB[b].rotation.to_rotation_matrix().into_inner();
                let inertia_W = R * body.inertia * R.transpose() * steps;
                A.add(A.diagonal[2 * b], &Mat3::from_diagonal_element(steps * steps * body.mass));
                A.add(A.diagonal[2 * b + 1], &(inertia_W * steps));
                rhs[2 * b] += state.v[2 * b] * (steps * body.mass);
                rhs[2 * b + 1] += inertia_W * state.v[2 * b + 1];
            }
        }
        let row0 = 2 * model.rigids.len();
        for (soft, nodes) in desc.softs.iter().zip(&model.soft_nodes) {
            for n in nodes.clone().filter(|_| soft.coupling.is_none()) {
                let inertia = steps * model.flesh.mass[n];
                A.add(A.diagonal[row0 + n], &Mat3::from_diagonal_element(steps * inertia));
                rhs[row0 + n] += state.v[row0 + n] * inertia;
            }
        }
    }
}

/// True when a place is on one of these bones or on their flesh.
fn is_on(desc: &WorldDesc, bones: &Range<usize>, site: &Site) -> bool {
    match site {
        Site::Rigid { body, .. } => bones.contains(&(*body as usize)),
        Site::Soft(point) => {
            let coupling = desc.softs[point.soft as usize].coupling.as_ref();
            let binding = coupling.and_then(|coupling| coupling.bindings.first());
            binding.is_some_and(|binding| bones.contains(&(binding.bones[0] as usize)))
        }
    }
}
