//! A symmetric sparse matrix of 3×3 blocks with a fixed pattern.

use crate::math::{Mat3, Vec3};

/// A 3×3 block, column-major, so that its product with a vector adds whole columns.
pub type Block = [f64; 9];

/// Block compressed sparse rows; both triangles are stored, columns ascending in each row.
#[derive(Clone, Debug)]
pub struct BlockMatrix {
    /// First entry of each row in `columns` and `blocks`; one more at the end.
    pub row_start: Vec<u32>,
    /// Column of each block.
    pub columns: Vec<u32>,
    /// Values.
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

    /// Where block (i, j) is stored.
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
        self.blocks.fill([0.0; 9]);
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

    /// These entries of one row, times x.
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

    /// `y = A x`.
    pub fn times(&self, x: &[Vec3], y: &mut [Vec3]) {
        for (i, y) in y.iter_mut().enumerate() {
            *y = self.row_times(i, x);
        }
    }

    /// Makes unknown `3 i + axis` a given number `value`: its row becomes the identity and its
    /// column moves to the right-hand side, so that the matrix stays symmetric positive definite.
    pub fn hold(&mut self, i: usize, axis: usize, value: f64, rhs: &mut [Vec3]) {
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
