//! A fixed number of numbers that begin at a cache line, so that vector loads of them do not
//! straddle two.

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
    /// Zeros.
    pub fn new(len: usize) -> Self {
        let numbers = vec![T::default(); len + LINE / size_of::<T>() - 1];
        // An offset that cannot be had costs speed only.
        let start = numbers.as_ptr().align_offset(LINE);
        let start = if start < LINE / size_of::<T>() { start } else { 0 };
        Self { numbers, start, len }
    }
}

impl<T: Copy + Default> Clone for Aligned<T> {
    /// The copy lies elsewhere, so it begins after another offset.
    fn clone(&self) -> Self {
        let mut copy = Self::new(self.len);
        copy.copy_from_slice(self);
        copy
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
    fn begins_at_a_line_and_copies_what_it_holds() {
        let mut a = Aligned::<f32>::new(40);
        a.iter_mut().enumerate().for_each(|(i, x)| *x = i as f32);
        let copies: Vec<_> = (0..20).map(|_| a.clone()).collect();
        for copy in &copies {
            assert_eq!(**copy, *a);
            assert_eq!(copy.as_ptr() as usize % LINE, 0);
        }
    }
}
