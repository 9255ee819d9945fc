//! Work space of a fixed size that begins at a cache line, so that vector loads from it do not
//! straddle two. A clone has zeros: nothing in work space outlives a step.

use std::ops::{Deref, DerefMut};

/// Bytes of a cache line.
const LINE: usize = 64;

/// An array that begins at a cache line. It is made up of `T` that divide a line.
#[derive(Debug)]
pub struct Aligned<T> {
    /// With room to begin late.
    numbers: Vec<T>,
    start: usize,
    len: usize,
}

impl<T: Copy + Default> Aligned<T> {
    /// Zeros of this length.
    pub fn new(len: usize) -> Self {
        let numbers = vec![T::default(); len + LINE / size_of::<T>() - 1];
        // An offset that cannot be had costs speed only.
        let start = numbers.as_ptr().align_offset(LINE);
        let start = if start < LINE / size_of::<T>() { start } else { 0 };
        Self { numbers, start, len }
    }
}

impl<T: Copy + Default> Clone for Aligned<T> {
    fn clone(&self) -> Self {
        Self::new(self.len)
    }
}

impl<T> Deref for Aligned<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        &self.numbers[self.start..self.start + self.len]
    }
}

impl<T> DerefMut for Aligned<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.numbers[self.start..self.start + self.len]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn begins_at_a_line() {
        let spaces: Vec<_> = (1..40).map(Aligned::<f32>::new).collect();
        for (space, len) in spaces.iter().zip(1..) {
            assert_eq!(space.len(), len);
            assert_eq!(space.as_ptr() as usize % LINE, 0);
            assert_eq!(space.clone().as_ptr() as usize % LINE, 0);
        }
    }
}
