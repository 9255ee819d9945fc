//! Lists whose copies have as much room: what a cloned world adds to them in a step allocates no
//! more than in the world that it was cloned from.

use std::ops::{Deref, DerefMut};

/// A `Vec` that a clone leaves as much room to grow in.
#[derive(Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct CapacityVec<T>(Vec<T>);

impl<T> CapacityVec<T> {
    /// Empty, with room for `many`.
    pub fn with_capacity(many: usize) -> Self {
        Self(Vec::with_capacity(many))
    }
}

impl<T> Default for CapacityVec<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> From<Vec<T>> for CapacityVec<T> {
    fn from(list: Vec<T>) -> Self {
        Self(list)
    }
}

impl<T: Clone> Clone for CapacityVec<T> {
    fn clone(&self) -> Self {
        let mut copy = Self::with_capacity(self.0.capacity());
        copy.0.extend_from_slice(&self.0);
        copy
    }

    fn clone_from(&mut self, from: &Self) {
        self.0.clear();
        self.0.reserve(from.0.capacity());
        self.0.extend_from_slice(&from.0);
    }
}

impl<T> Deref for CapacityVec<T> {
    type Target = Vec<T>;

    fn deref(&self) -> &Vec<T> {
        &self.0
    }
}

impl<T> DerefMut for CapacityVec<T> {
    fn deref_mut(&mut self) -> &mut Vec<T> {
        &mut self.0
    }
}

impl<'a, T> IntoIterator for &'a CapacityVec<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl<'a, T> IntoIterator for &'a mut CapacityVec<T> {
    type Item = &'a mut T;
    type IntoIter = std::slice::IterMut<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter_mut()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_has_as_much_room() {
        let mut list = CapacityVec::with_capacity(40);
        list.extend([1, 2]);
        let copy = list.clone();
        assert_eq!(*copy, [1, 2]);
        assert!(copy.capacity() >= 40);
        let mut other: CapacityVec<i32> = CapacityVec::with_capacity(50);
        other.clone_from(&list);
        assert!(*other == [1, 2] && other.capacity() >= 50);
    }
}
