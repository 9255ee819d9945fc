//! What each soft vertex remembers of the bodies it last touched.

use crate::contact::approach::Seen;
use crate::math::Vec3;

#[derive(Clone, Copy, Debug)]
struct Slot {
    other: u32,
    step: u32,
    seen: Seen,
}

const EMPTY: Slot = Slot {
    other: u32::MAX,
    step: 0,
    seen: Seen { normal: Vec3::new(0.0, 0.0, 0.0), place: Vec3::new(0.0, 0.0, 0.0) },
};

/// Two memories per vertex: a vertex between two bodies keeps both.
#[derive(Clone, Debug)]
pub(crate) struct Memory {
    slots: Vec<[Slot; 2]>,
    step: u32,
}

impl Memory {
    pub fn new(vertices: usize) -> Self {
        Self { slots: vec![[EMPTY; 2]; vertices], step: 1 }
    }

    /// Begins a step: what was not seen in the last one is forgotten.
    pub fn advance(&mut self) {
        self.step = self.step.wrapping_add(1);
    }

    /// Forgets everything: bodies were put elsewhere.
    pub fn forget(&mut self) {
        self.step = self.step.wrapping_add(2);
    }

    /// What `vertex` saw of `other` in the last step.
    pub fn recall(&self, vertex: usize, other: u32) -> Option<Seen> {
        let fresh = |s: &&Slot| s.other == other && self.step.wrapping_sub(s.step) <= 1;
        self.slots[vertex].iter().find(fresh).map(|s| s.seen)
    }

    /// Notes what `vertex` sees of `other` now, in place of the same or of the older memory.
    pub fn note(&mut self, vertex: usize, other: u32, seen: Seen) {
        let slots = &mut self.slots[vertex];
        let age = |s: &Slot| self.step.wrapping_sub(s.step);
        let k = match slots.iter().position(|s| s.other == other) {
            Some(k) => k,
            None => usize::from(age(&slots[1]) > age(&slots[0])),
        };
        slots[k] = Slot { other, step: self.step, seen };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_step_is_remembered_and_older_ones_are_not() {
        let seen = |x: f64| Seen { normal: Vec3::y(), place: Vec3::repeat(x) };
        let mut memory = Memory::new(2);
        memory.advance();
        memory.note(0, 7, seen(1.0));
        memory.note(0, 8, seen(2.0));
        assert_eq!(memory.recall(1, 7), None);
        memory.advance();
        assert_eq!(memory.recall(0, 7), Some(seen(1.0)));
        memory.note(0, 8, seen(3.0));
        memory.note(0, 9, seen(4.0));
        assert_eq!(memory.recall(0, 7), None, "the older memory made room");
        assert_eq!(memory.recall(0, 8), Some(seen(3.0)));
        memory.advance();
        memory.advance();
        assert_eq!(memory.recall(0, 9), None);
    }
}
