//! A step that fails in some islands of the world is made in the others.

use crate::math::Vec3;
use crate::solver::Failure;
use crate::world::parts::StepPart;
use crate::world::state::{is_sound_pose, is_sound_position, is_sound_velocity};
use crate::world::{Input, StageTimer, StepReport, World, advance};

impl World {
    /// Makes the step that has just failed once more, without what made it fail: islands with
    /// numbers that make no sense stay where they are, at rest. False when that is nothing, or all,
    /// or does not help.
    pub(super) fn step_without_what_fails(
        &mut self,
        part: StepPart,
        input: &Input,
        timer: &mut impl StageTimer,
        report: &mut StepReport,
    ) -> bool {
        self.hold_what_fails();
        if !self.scratch.islands.hold_some() {
            return false;
        }
        let Self { state, scratch, .. } = self;
        advance::take_positions_back(state, &scratch.before);
        advance::take_velocities_back(state, &scratch.before);
        let failure = report.failure;
        let StepReport { bad_targets, parts, .. } = *report;
        *report = StepReport { bad_targets, parts, ..StepReport::default() };
        let sound = self.attempt(part, input, timer, report);
        report.failure = failure.or(report.failure).or(Some(Failure::NotFinite));
        report.non_finite = true;
        sound
    }

    /// Holds the islands in which positions, velocities or forces make no sense.
    fn hold_what_fails(&mut self) {
        let Self { state, scratch, model, .. } = self;
        let row0 = 2 * model.rigids.len();
        let islands = &mut scratch.islands;
        // A force that is no number spoils velocities everywhere, so it is looked for first.
        let is_force = |b: &Vec3| b.iter().all(|b| b.is_finite());
        let forces = scratch.b.iter().enumerate().filter(|(_, b)| !is_force(b));
        forces.for_each(|(row, _)| islands.hold(row));
        if islands.hold_some() {
            return;
        }
        let speeds = state.v.iter().enumerate().filter(|(_, v)| !is_sound_velocity(v));
        speeds.for_each(|(row, _)| islands.hold(row));
        for (body, pose) in state.poses_WB.iter().enumerate() {
            if !is_sound_pose(pose) {
                islands.hold(2 * body);
            }
        }
        for (node, x) in state.x.iter().enumerate() {
            if !is_sound_position(x) {
                islands.hold(row0 + node);
            }
        }
    }

    /// Brings the islands that are held to rest.
    pub(super) fn rest_what_is_held(&mut self) {
        let Self { state, scratch, .. } = self;
        scratch.islands.still(&mut state.v);
        scratch.islands.still(&mut state.contact_change);
        if scratch.pushes {
            scratch.islands.still(&mut scratch.push);
        }
    }
}
