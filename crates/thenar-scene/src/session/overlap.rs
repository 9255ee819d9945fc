//! Overlaps of bodies where a scene begins.

use super::{PARTS, Session};
use crate::math::Vec3;
use std::fmt;
use thenar_core::model::BodyId;
use thenar_core::world::Overlap;

/// Two bodies that a scene starts inside each other.
#[derive(Clone, Debug, PartialEq)]
pub struct StartOverlap {
    /// Names of the bodies in the scene; of a hand, its name and the part that is deepest:
    /// `right (thumb)`.
    pub bodies: [String; 2],
    /// Depth of the overlap \[m\].
    pub depth: f64,
    /// Place where they are deepest, world \[m\].
    pub place_W: Vec3,
}

impl fmt::Display for StartOverlap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([a, b], [x, y, z]) = (&self.bodies, [self.place_W.x, self.place_W.y, self.place_W.z]);
        let depth = self.depth * 1e3;
        write!(
            f,
            "{a} and {b} overlap by {depth:.3} mm at the start, at [{x:.4}, {y:.4}, {z:.4}] m"
        )
    }
}

impl Session {
    /// The pairs of bodies that overlapped when the session was opened, the deepest first; see
    /// [`thenar_core::World::overlaps`].
    pub fn start_overlaps(&self) -> &[StartOverlap] {
        &self.start_overlaps
    }

    /// Pairs of bodies that overlap in the present state, the deepest first.
    pub(super) fn find_overlaps(&self) -> Vec<StartOverlap> {
        // Bones lie in flesh, which overlaps before they do.
        let is_bone = |body: &BodyId| match body {
            BodyId::Rigid(i) => self
                .hands()
                .iter()
                .any(|hand| hand.flesh().is_some() && hand.handle.bones.contains(i)),
            BodyId::Soft(_) => false,
        };
        let overlaps = self.world.overlaps();
        let told = overlaps.iter().filter(|overlap| !overlap.bodies.iter().any(is_bone));
        told.map(|overlap| self.named(overlap)).collect()
    }

    fn named(&self, overlap: &Overlap) -> StartOverlap {
        let name = |k: usize| self.name_of(overlap.bodies[k], overlap.vertices[k]);
        StartOverlap { bodies: [name(0), name(1)], depth: overlap.depth, place_W: overlap.place_W }
    }

    fn name_of(&self, body: BodyId, vertex: Option<u32>) -> String {
        let desc = self.world.desc();
        let soft = match body {
            BodyId::Rigid(i) => return desc.rigids[i as usize].name.clone(),
            BodyId::Soft(i) => i,
        };
        let Some(hand) = self.hands().iter().find(|hand| hand.flesh() == Some(soft)) else {
            return desc.softs[soft as usize].name.clone();
        };
        let digit = vertex.and_then(|v| hand.model.collision_digits.get(v as usize));
        match digit.filter(|digit| PARTS.contains(digit)) {
            Some(digit) => format!("{} ({})", hand.name, digit.name()),
            None => hand.name.clone(),
        }
    }
}
