//! A symmetric sparse matrix of 3×3 blocks with a fixed pattern.

use crate::math::{Mat3, Vec3};
use fearless_simd::{Simd, f64x4, f64x8, prelude::*};

/// A 3×3 block, column-major, so that its product with a vector adds whole columns.
pub type Block = [f64; 9];

/// Block compressed sparse rows; both triangles are stored, columns ascending in each row.
#[derive(Clone, Debug)]
pub struct BlockMatrix {
    /// First entry of each row in `columns` and `blocks`; one more at the end.
    pub row_start: Vec<u32>,
    /// Column of each block.
    pub columns: Vec<u32>,
    /// Values of the blocks.
    pub blocks: Vec<Block>,
    /// Entry of each row's diagonal block.
    pub diagonal: Vec<u32>,
}

impl BlockMatrix {
    /// The zero matrix whose pattern is the diagonal, `pairs`, and their transposes.
    pub fn with_pattern(rows: usize, pairs: impl IntoIterator<Item = (u32, u32)>) -> Self {
        let mut entries: Vec<(u32, u32)> = (0..rows as u32).map(|i| (i, i)).collect();
        for (i, j) in pairs {
            entries.extend([(i, j), (j, i)]);
        }
        entries.sort_unstable();
        entries.dedup();

        let mut row_start = vec![0u32; rows + 1];
        for &(i, _) in &entries {
            row_start[i as usize + 1] += 1;
        }
        for i in 0..rows {
            row_start[i + 1] += row_start[i];
        }
        let diagonal =
            entries.iter().enumerate().filter(|(_, (i, j))| i == j).map(|(k, _)| k as u32);
        Self {
            diagonal: diagonal.collect(),
            columns: entries.iter().map(|&(_, j)| j).collect(),
            blocks: vec![[0.0; 9]; entries.len()],
            row_start,
        }
    }

    /// Number of block rows.
    pub fn rows(&self) -> usize {
        self.row_start.len() - 1
    }

    /// Entries of row `i`.
    pub fn row(&self, i: usize) -> std::ops::Range<usize> {
        self.row_start[i] as usize..self.row_start[i + 1] as usize
    }

    /// Returns the place where block (i, j) is stored.
    ///
    /// # Panics
    /// When it is not in the pattern.
    pub fn entry(&self, i: u32, j: u32) -> u32 {
        let row = self.row(i as usize);
        let k = self.columns[row.clone()].binary_search(&j).expect("block in the pattern");
        (row.start + k) as u32
    }

    /// Sets every block to zero.
    pub fn clear(&mut self) {
        bytemuck::fill_zeroes(&mut self.blocks);
    }

    /// Adds `m` to the block stored at `entry`.
    pub fn add(&mut self, entry: u32, m: &Mat3) {
        let block = &mut self.blocks[entry as usize];
        for r in 0..3 {
            for c in 0..3 {
                block[3 * c + r] += m[(r, c)];
            }
        }
    }

    /// Adds a block given as its first eight numbers and its last.
    #[inline(always)]
    pub fn add_lanes<S: Simd>(&mut self, simd: S, entry: u32, first: f64x8<S>, last: f64) {
        let block = &mut self.blocks[entry as usize];
        (f64x8::from_slice(simd, &block[..8]) + first).store_slice(&mut block[..8]);
        block[8] += last;
    }

    /// Adds `s I` to the block stored at `entry`.
    pub fn add_scalar(&mut self, entry: u32, s: f64) {
        let block = &mut self.blocks[entry as usize];
        block[0] += s;
        block[4] += s;
        block[8] += s;
    }

    /// The block stored at `entry`.
    pub fn get(&self, entry: u32) -> Mat3 {
        Mat3::from_column_slice(&self.blocks[entry as usize])
    }

    /// Row `i` of `A x`.
    #[inline]
    pub fn row_times(&self, i: usize, x: &[Vec3]) -> Vec3 {
        self.part_times(self.row_start[i]..self.row_start[i + 1], x)
    }

    /// Product of these entries of one row with x.
    #[inline]
    pub fn part_times(&self, entries: std::ops::Range<u32>, x: &[Vec3]) -> Vec3 {
        let row = entries.start as usize..entries.end as usize;
        let mut y = [0.0; 3];
        for (block, &j) in self.blocks[row.clone()].iter().zip(&self.columns[row]) {
            let x = &x[j as usize];
            for c in 0..3 {
                for r in 0..3 {
                    y[r] += block[3 * c + r] * x[c];
                }
            }
        }
        Vec3::from(y)
    }

    /// Product of these entries of one row with x, in the first three of four lanes.
    #[inline(always)]
    pub fn part_times_lanes<S: Simd>(
        &self,
        simd: S,
        entries: std::ops::Range<u32>,
        x: &[Vec3],
    ) -> f64x4<S> {
        let row = entries.start as usize..entries.end as usize;
        let blocks = self.blocks.as_flattened();
        let mut sums = [simd.splat_f64x4(0.0); 3];
        for (k, &j) in row.clone().zip(&self.columns[row]) {
            add_product(simd, blocks, k, &x[j as usize], &mut sums);
        }
        sums[0] + (sums[1] + sums[2])
    }

    /// `y = A x`.
    pub fn times(&self, x: &[Vec3], y: &mut [Vec3]) {
        debug_assert_eq!(x.len(), self.rows(), "vectors to multiply, block rows");
        debug_assert_eq!(y.len(), self.rows(), "vectors of a product, block rows");
        for (i, y) in y.iter_mut().enumerate() {
            *y = self.row_times(i, x);
        }
    }

    /// Makes unknown `3 i + axis` a given number `value`: its row becomes the identity and its
    /// column moves to the right-hand side, so that the matrix stays symmetric positive definite.
    pub fn hold(&mut self, i: usize, axis: usize, value: f64, rhs: &mut [Vec3]) {
        debug_assert_eq!(rhs.len(), self.rows(), "right-hand sides, block rows");
        debug_assert!(i < self.rows() && axis < 3, "axis {axis} of row {i} of {}", self.rows());
        for k in self.row(i) {
            let j = self.columns[k];
            let transposed = self.entry(j, i as u32) as usize;
            for r in 0..3 {
                rhs[j as usize][r] -= self.blocks[transposed][3 * axis + r] * value;
                self.blocks[transposed][3 * axis + r] = 0.0;
                self.blocks[k][3 * r + axis] = 0.0;
            }
        }
        self.blocks[self.diagonal[i] as usize][4 * axis] = 1.0;
        rhs[i][axis] = value;
    }
}

/// Adds columns of block `k`, among blocks that lie one after the other, times the components of x.
/// Each column is loaded with the number after it, which ends in the fourth lane and counts for
/// nothing.
#[inline(always)]
pub fn add_product<S: Simd>(simd: S, blocks: &[f64], k: usize, x: &Vec3, sums: &mut [f64x4<S>; 3]) {
    if let Some(block) = blocks.get(9 * k..9 * k + 10) {
        for c in 0..3 {
            let column = f64x4::from_slice(simd, &block[3 * c..3 * c + 4]);
            sums[c] = column.mul_add(x[c], sums[c]);
        }
    } else {
        // The last block has nothing after it.
        let last = &blocks[9 * k + 6..9 * k + 9];
        for c in 0..2 {
            let at = 9 * k + 3 * c;
            let column = f64x4::from_slice(simd, &blocks[at..at + 4]);
            sums[c] = column.mul_add(x[c], sums[c]);
        }
        let column = f64x4::load_array(simd, [last[0], last[1], last[2], 0.0]);
        sums[2] = column.mul_add(x[2], sums[2]);
    }
}

/// The first three lanes.
#[inline(always)]
pub fn vector<S: Simd>(lanes: f64x4<S>) -> Vec3 {
    let [x, y, z, _] = lanes.to_array();
    Vec3::new(x, y, z)
}
