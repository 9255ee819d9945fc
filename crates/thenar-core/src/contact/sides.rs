//! Side of a body on which each soft vertex was, and places where skin was held.

use crate::capacity_vec::CapacityVec;
use crate::contact::approach::LastSide;
use crate::contact::places::{HeldPlace, PlaceKey, Places};
use crate::math::Vec3;
use std::ops::Range;

/// Side of a body that a surface vertex near it last saw.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SeenSide {
    /// Vertex, counted over all deformable bodies.
    pub vertex: u32,
    /// The other body: rigid bodies count first, then deformable ones.
    pub other: u32,
    /// The outward normal then: in the frame of a rigid body's shape, in the world for a
    /// deformable one.
    pub normal: Vec3,
    /// Position of the vertex, in the same frame \[m\].
    pub place: Vec3,
}

impl SeenSide {
    fn key(&self) -> (u32, u32) {
        (self.vertex, self.other)
    }
}

/// The sides seen in one step. It tells the next step from which side a vertex came that has sunk
/// into a thin body; part of the state.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SeenSides {
    /// Sorted by vertex, then body, once the search is over.
    seen: CapacityVec<SeenSide>,
    /// Places that follow round parts. What writes a state down keeps them apart: they came last to
    /// it.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) places: Places,
    /// No more are kept; a state that was read back holds what it holds.
    #[cfg_attr(feature = "serde", serde(skip))]
    most: usize,
}

impl SeenSides {
    /// Room for `sides` sides.
    pub fn with_capacity(sides: usize) -> Self {
        Self {
            seen: CapacityVec::with_capacity(sides),
            places: Places { held: CapacityVec::with_capacity(sides) },
            most: sides,
        }
    }

    /// All, in order.
    pub fn as_slice(&self) -> &[SeenSide] {
        &self.seen
    }

    /// Places that follow round parts, in order.
    pub fn places(&self) -> &[HeldPlace] {
        &self.places.held
    }

    /// Sides as they are, with other places.
    pub fn with_places(self, held: Vec<HeldPlace>) -> Self {
        Self { places: Places { held: held.into() }, ..self }
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.seen.clear();
        self.places.held.clear();
    }

    /// Remembers what `other` does; its own room stays if it is larger.
    pub fn copy_from(&mut self, other: &Self) {
        self.seen.clear();
        self.seen.extend_from_slice(&other.seen);
        self.places.held.clear();
        self.places.held.extend_from_slice(&other.places.held);
        self.most = self.most.max(other.most);
    }

    /// Returns what some vertices saw of `other`, in their order.
    pub(crate) fn of(&self, vertices: Range<usize>, other: u32) -> impl Iterator<Item = &SeenSide> {
        let start = self.seen.partition_point(|side| (side.vertex as usize) < vertices.start);
        // A state that was read back may not be in order.
        let wanted = move |side: &&SeenSide| {
            side.other == other && vertices.contains(&(side.vertex as usize))
        };
        self.seen[start..].iter().filter(wanted)
    }

    /// Returns what `vertex` saw of `other`.
    fn recall(&self, vertex: usize, other: u32) -> Option<LastSide> {
        let at = self.seen.binary_search_by_key(&(vertex as u32, other), SeenSide::key).ok()?;
        let SeenSide { normal, place, .. } = self.seen[at];
        Some(LastSide { normal, place })
    }

    /// Puts the notes of a search in order.
    pub(crate) fn sort(&mut self) {
        self.seen.sort_unstable_by_key(SeenSide::key);
        self.places.held.sort_unstable_by_key(|held| held.key);
    }
}

/// The sides of the step before, and room for those of this one.
pub(crate) struct Sight<'a> {
    pub before: &'a SeenSides,
    /// `None` when only looking.
    pub now: Option<&'a mut SeenSides>,
}

impl Sight<'_> {
    /// Returns what `vertex` saw of `other` in the step before.
    pub fn recall(&self, vertex: usize, other: u32) -> Option<LastSide> {
        self.before.recall(vertex, other)
    }

    /// Notes what it sees now; beyond the room it is not kept.
    pub fn note(&mut self, vertex: usize, other: u32, LastSide { normal, place }: LastSide) {
        if let Some(now) = self.now.as_mut().filter(|now| now.seen.len() < now.most) {
            now.seen.push(SeenSide { vertex: vertex as u32, other, normal, place });
        }
    }

    /// Returns the place at which a triangle is held whose nearest place is `nearest`. A search
    /// that only looks takes the nearest.
    pub fn hold(
        &mut self,
        key: PlaceKey,
        nearest: [f64; 3],
        x: &[Vec3; 3],
        edge: f64,
        farther: impl Fn(&[f64; 3]) -> f64,
    ) -> [f64; 3] {
        let Some(now) = self.now.as_mut().filter(|now| now.places.held.len() < now.most) else {
            return nearest;
        };
        let held = match self.before.places.recall(&key) {
            Some(before) => before.follow(nearest, x, edge, farther),
            None => HeldPlace::new(key, nearest),
        };
        now.places.held.push(held);
        held.weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_noted_is_recalled_for_its_vertex_and_body_only() {
        let seen = |x| LastSide { normal: Vec3::y(), place: Vec3::repeat(x) };
        let (before, mut now) = (SeenSides::default(), SeenSides::with_capacity(3));
        let mut sight = Sight { before: &before, now: Some(&mut now) };
        for (vertex, other, x) in [(4, 1, 1.0), (0, 8, 2.0), (0, 7, 3.0), (9, 9, 4.0)] {
            sight.note(vertex, other, seen(x));
        }
        now.sort();
        assert_eq!(now.recall(0, 7), Some(seen(3.0)));
        assert_eq!(now.recall(4, 1), Some(seen(1.0)));
        assert_eq!(now.recall(4, 7), None);
        assert_eq!(now.recall(9, 9), None, "no room was left");
    }
}
