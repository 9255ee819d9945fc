//! A rig's joints as WebXR has them, in the wrist's frame M: those that it lacks are made.

use super::{Frames, RigJoints};
use crate::RigError;
use crate::glb::RigJoint;
use crate::hand::digits::leave;
use crate::hand::names;
use crate::mesh::Bvh;
use crate::size::place_in_words;
use thenar_core::model::Digit;
use thenar_core::{Pose, Quat, Vec3};
use thenar_input::quoted;

/// Bases of metacarpals that a rig lacks: parts of the knuckle's place in the wrist's frame, aside
/// and along, of index to little finger. Those of the WebXR generic hand.
const METACARPAL_BASES: [[f64; 2]; 4] = [[0.43, 0.33], [0.43, 0.32], [0.46, 0.32], [0.66, 0.46]];

/// A rig and how it is read.
#[derive(Clone, Copy)]
pub(in crate::hand) struct Posed<'a> {
    found: &'a RigJoints,
    joints: &'a [RigJoint],
    frames: &'a Frames,
    pose_MR: Pose,
}

impl<'a> Posed<'a> {
    pub fn new(found: &'a RigJoints, joints: &'a [RigJoint], frames: &'a Frames) -> Self {
        let pose_MR = frames.wrist(&joints[found.wrist].pose).inverse();
        Self { found, joints, frames, pose_MR }
    }

    /// Takes the rig's frame to M.
    pub fn pose_MR(&self) -> &Pose {
        &self.pose_MR
    }

    /// Point at which a thumb's ray leaves the wrist, in M.
    pub fn thumb_base(&self) -> Vec3 {
        match self.frames {
            // So it was when rigs had WebXR's frames alone; the shipped hands rest on it.
            Frames::Own => self.pose_MR.position,
            Frames::Places(..) => Vec3::zeros(),
        }
    }

    /// Poses of a digit's joints in M, from the metacarpal (of a thumb, the first that moves) to
    /// the tip. `surface` is the hand's skin.
    ///
    /// # Errors
    /// Two joints lie at the same place.
    pub fn digit(&self, digit: Digit, surface: &Bvh) -> Result<Vec<Pose>, RigError> {
        let chain = &self.found.digits[digit as usize - 1];
        let own = |k: usize| self.pose_MR * self.joints[k].pose;
        let [a, b, c] = chain.moving.map(own);
        let tip = chain.tip.map_or_else(|| self.made_tip(&b, &c, surface), own);
        let places = [a.position, b.position, c.position, tip.position];
        let [first, second, third] = chain.moving.map(Some);
        self.apart(digit, &[first, second, third, chain.tip], &places)?;
        let rotations = self.frames.moving(
            digit == Digit::Thumb,
            &places,
            [a.rotation, b.rotation, c.rotation],
        );
        let mut poses: Vec<Pose> =
            (0..3).map(|k| Pose::new(places[k], rotations[k])).chain([tip]).collect();
        if digit != Digit::Thumb {
            let base = chain.metacarpal.map_or_else(
                || {
                    let [aside, along] = METACARPAL_BASES[digit as usize - 2];
                    let parts = Vec3::new(aside, along, along);
                    Pose::new(a.position.component_mul(&parts), Quat::identity())
                },
                own,
            );
            let first = [chain.metacarpal, Some(chain.moving[0])];
            self.apart(digit, &first, &[base.position, a.position])?;
            poses.insert(0, base);
        }
        Ok(poses)
    }

    /// The tip of a digit whose last joints these are: where the line through them leaves the skin.
    fn made_tip(&self, before: &Pose, last: &Pose, surface: &Bvh) -> Pose {
        let along = match self.frames {
            Frames::Own => last.vector(&-Vec3::z()),
            Frames::Places(..) => (last.position - before.position).normalize(),
        };
        let length = last.position.norm();
        Pose::new(leave(surface, &last.position, &along, length), last.rotation)
    }

    /// WebXR's names of what was made.
    pub fn made(&self) -> Vec<String> {
        let of = |digit: &Digit| {
            let chain = &self.found.digits[*digit as usize - 1];
            let base = chain.metacarpal.is_none() && *digit != Digit::Thumb;
            let prefix = names::prefix(*digit);
            let made = [(base, "metacarpal"), (chain.tip.is_none(), "tip")];
            made.into_iter().filter(|(is, _)| *is).map(move |(_, what)| format!("{prefix}-{what}"))
        };
        Digit::FINGERS.iter().flat_map(of).collect()
    }

    /// Errs if two joints of a digit in a row lie at the same place, or nearly; one that was made
    /// is none of the rig's.
    fn apart(
        &self,
        digit: Digit,
        joints: &[Option<usize>],
        places: &[Vec3],
    ) -> Result<(), RigError> {
        let far = places.iter().map(|p| p.norm()).fold(0.0, f64::max);
        let near = |pair: &[Vec3]| (pair[1] - pair[0]).norm() < 1e-3 * far;
        let Some(k) = places.windows(2).position(near) else { return Ok(()) };
        let digit = digit.name();
        let first = joints[k].unwrap_or(self.found.wrist);
        let place = place_in_words(&self.joints[first].pose.position);
        let name = quoted(&self.joints[first].name);
        Err(RigError::invalid(match joints[k + 1] {
            Some(next) => format!(
                "joints {name} and {} of the {digit} lie at the same place, {place} m: say which are its joints \
                 (`--joint-names`; `thenar hand --list FILE` shows them)",
                quoted(&self.joints[next].name)
            ),
            None => format!(
                "the skin is not around {name}, the last joint of the {digit}, at {place} m: is it the mesh of one hand \
                 (`--mesh` names another), and are these its joints (`thenar hand --list FILE` shows them)?"
            ),
        }))
    }
}
