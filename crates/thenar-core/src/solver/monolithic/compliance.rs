//! The numbers of W, `W = J_c K⁻¹ J_cᵀ`, row by row in batches of `LANES` columns.

use crate::math::{Mat3, Vec3};
use crate::solver::monolithic::aligned::Aligned;
use crate::solver::monolithic::factor::{LANES, Lanes, Scalar};
use fearless_simd::{Simd, SimdBase, SimdFloat, f32x16, f64x8};

/// W. Contact m has the rows and columns 3m, 3m + 1 and 3m + 2.
#[derive(Clone, Debug)]
pub struct Compliance {
    numbers: Aligned<Scalar>,
    /// From row to row.
    stride: usize,
}

impl Compliance {
    /// Room for `batches` batches of rows and columns.
    pub fn new(batches: usize) -> Self {
        // An odd number of cache lines: numbers below each other do not fall into the same few
        // sets.
        let stride = (batches | 1) * LANES;
        Self { numbers: Aligned::new(stride * batches * LANES), stride }
    }

    /// One entry.
    pub fn at(&self, row: usize, column: usize) -> Scalar {
        self.numbers[row * self.stride + column]
    }

    /// One row.
    pub fn row(&self, row: usize) -> &[Scalar] {
        &self.numbers[row * self.stride..(row + 1) * self.stride]
    }

    /// Returns the response of contact m to itself.
    pub fn own(&self, m: usize) -> Mat3 {
        Mat3::from_fn(|a, b| f64::from(self.at(3 * m + a, 3 * m + b)))
    }

    /// Sets the rows of batch a and the columns of batch b, and by symmetry the other way round.
    pub fn set(&mut self, a: usize, b: usize, block: &[Lanes; LANES]) {
        for (i, line) in block.iter().enumerate() {
            let at = (a * LANES + i) * self.stride + b * LANES;
            self.numbers[at..at + LANES].copy_from_slice(line);
            for (j, value) in line.iter().enumerate().filter(|_| a != b) {
                self.numbers[(b * LANES + j) * self.stride + a * LANES + i] = *value;
            }
        }
    }

    /// One row's part in one batch of columns.
    #[inline(always)]
    pub fn lanes(&self, row: usize, batch: usize) -> &[Scalar] {
        let at = row * self.stride + batch * LANES;
        &self.numbers[at..at + LANES]
    }

    /// One row's numbers in `LANES` columns from `first` on.
    #[inline(always)]
    pub fn window(&self, row: usize, first: usize) -> &[Scalar] {
        let at = row * self.stride + first;
        &self.numbers[at..at + LANES]
    }

    /// One row's numbers in the columns of one batch, to be filled.
    #[inline(always)]
    pub fn lanes_mut(&mut self, row: usize, batch: usize) -> &mut [Scalar] {
        let at = row * self.stride + batch * LANES;
        &mut self.numbers[at..at + LANES]
    }

    /// Fills the rows of a batch, up to the diagonal, with what its columns hold above.
    pub fn mirror(&mut self, batch: usize) {
        let first = batch * LANES;
        for row in 0..first + LANES {
            let line: Lanes = std::array::from_fn(|j| self.numbers[row * self.stride + first + j]);
            for column in first.max(row + 1)..first + LANES {
                self.numbers[column * self.stride + row] = line[column - first];
            }
        }
    }

    /// `to += W δ` for an impulse δ at contact m; `to` has the length that counts, in whole
    /// batches.
    #[inline(always)]
    pub fn add_answer<S: Simd>(&self, simd: S, m: usize, delta: &Vec3, to: &mut [f64]) {
        let row = |a: usize| {
            let at = (3 * m + a) * self.stride;
            self.numbers[at..at + to.len()].as_chunks::<LANES>().0
        };
        let (rows, to) = ([row(0), row(1), row(2)], to.as_chunks_mut::<LANES>().0);
        // Indexed on purpose: zipped iterators are not inlined here, and run without vector
        // instructions.
        for i in 0..to.len() {
            let (low, high) = to[i].split_at_mut(LANES / 2);
            let mut sums = [f64x8::from_slice(simd, low), f64x8::from_slice(simd, high)];
            for a in 0..3 {
                let halves = simd.widen_f32x16(f32x16::from_slice(simd, &rows[a][i]));
                let delta = f64x8::splat(simd, delta[a]);
                sums[0] = halves.0.mul_add(delta, sums[0]);
                sums[1] = halves.1.mul_add(delta, sums[1]);
            }
            sums[0].store_slice(low);
            sums[1].store_slice(high);
        }
    }
}
