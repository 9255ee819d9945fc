//! Dense LU factorisation with partial pivoting, in place: for small or reference systems.

use crate::solver::monolithic::vectors::dot;
use fearless_simd::{Level, Simd, SimdBase, SimdFloat, dispatch, f64x8};
use std::ops::Range;

/// Columns that are factored together.
const PANEL: usize = 16;
/// Numbers in a register.
const LANES: usize = 8;
/// Rows that the rest of the matrix is brought up to date by at a time.
const ROWS: usize = 4;

/// A factored square matrix.
#[derive(Clone, Debug)]
pub struct DenseLu {
    n: usize,
    /// From row to row: whole panels.
    stride: usize,
    /// Row-major; the caller fills it, `factor` overwrites it.
    values: Vec<f64>,
    /// The columns of the present panel, one after the other, from its first row on.
    panel: Vec<f64>,
    pivots: Vec<usize>,
}

impl DenseLu {
    /// The n×n zero matrix.
    pub fn new(n: usize) -> Self {
        let mut lu =
            Self { n: 0, stride: 0, values: Vec::new(), panel: Vec::new(), pivots: Vec::new() };
        lu.restart(n);
        lu
    }

    /// Makes it the n×n zero matrix; allocates only where it has never been so large.
    pub fn restart(&mut self, n: usize) {
        self.n = n;
        self.stride = n.next_multiple_of(PANEL);
        self.values.clear();
        self.values.resize(n * self.stride, 0.0);
        self.panel.resize(PANEL * self.stride, 0.0);
        self.pivots.resize(n, 0);
    }

    /// Number of unknowns.
    pub fn size(&self) -> usize {
        self.n
    }

    /// Adds to entry (i, j), before factoring.
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        self.values[i * self.stride + j] += value;
    }

    /// Row i, to be filled before factoring.
    pub fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.values[i * self.stride..i * self.stride + self.n]
    }

    /// Factors; false when the matrix is singular to working precision.
    pub fn factor(&mut self) -> bool {
        dispatch!(Level::new(), simd => self.factor_by_panels(simd))
    }

    /// Panel by panel: its columns are factored, then all columns beyond are brought up to date at
    /// once.
    #[inline(always)]
    fn factor_by_panels<S: Simd>(&mut self, simd: S) -> bool {
        for first in (0..self.n).step_by(PANEL) {
            let columns = first..(first + PANEL).min(self.n);
            self.load_panel(&columns);
            for k in columns.clone() {
                let Some(pivot) = self.factor_column(simd, &columns, k) else { return false };
                self.pivots[k] = pivot;
                self.swap_rows(k, pivot);
            }
            self.store_panel(&columns);
            if columns.end < self.n {
                self.finish_rows(simd, first);
                self.update(simd, first);
            }
        }
        true
    }

    /// Numbers of a panel's column: whole registers.
    fn height(&self, first: usize) -> usize {
        (self.n - first).next_multiple_of(LANES)
    }

    #[inline(always)]
    fn load_panel(&mut self, columns: &Range<usize>) {
        let height = self.height(columns.start);
        self.panel[..PANEL * height].fill(0.0);
        let rows = self.values[columns.start * self.stride..].chunks_exact(self.stride);
        for (i, row) in rows.enumerate() {
            for (q, x) in row[columns.clone()].iter().enumerate() {
                self.panel[q * height + i] = *x;
            }
        }
    }

    #[inline(always)]
    fn store_panel(&mut self, columns: &Range<usize>) {
        let height = self.height(columns.start);
        let rows = self.values[columns.start * self.stride..].chunks_exact_mut(self.stride);
        for (i, row) in rows.enumerate() {
            for (q, x) in row[columns.clone()].iter_mut().enumerate() {
                *x = self.panel[q * height + i];
            }
        }
    }

    /// Brings the pivot of column k to its place within the panel and takes it off the columns
    /// after it. Returns the row it was in; `None` where it is zero or no number.
    #[inline(always)]
    fn factor_column<S: Simd>(
        &mut self,
        simd: S,
        columns: &Range<usize>,
        k: usize,
    ) -> Option<usize> {
        let (first, height) = (columns.start, self.height(columns.start));
        let (at, rows) = (k - first, self.n - first);
        let panel = &mut self.panel[..columns.len() * height];
        // As bits, what is not a number is larger than all numbers.
        let size = |x: f64| x.abs().to_bits();
        let column = &panel[at * height..at * height + rows];
        let mut pivot = at;
        for i in at + 1..rows {
            if size(column[i]) > size(column[pivot]) {
                pivot = i;
            }
        }
        let d = column[pivot];
        if d == 0.0 || !d.is_finite() {
            return None;
        }
        panel.chunks_exact_mut(height).for_each(|column| column.swap(at, pivot));
        let (done, ahead) = panel.split_at_mut((at + 1) * height);
        let column = &mut done[at * height..];
        column[at + 1..].iter_mut().for_each(|x| *x /= d);
        // From whole registers on; the rows above are put back.
        let start = at - at % LANES;
        for next in ahead.chunks_exact_mut(height) {
            let above: [f64; LANES] = std::array::from_fn(|i| next[start + i]);
            let factor = f64x8::splat(simd, -next[at]);
            add_multiple(simd, &mut next[start..], &column[start..], factor);
            next[start..=at].copy_from_slice(&above[..=at - start]);
        }
        Some(first + pivot)
    }

    fn swap_rows(&mut self, k: usize, pivot: usize) {
        if pivot != k {
            let (above, below) = self.values.split_at_mut(pivot * self.stride);
            above[k * self.stride..(k + 1) * self.stride]
                .swap_with_slice(&mut below[..self.stride]);
        }
    }

    /// The rows of a panel, beyond its columns.
    #[inline(always)]
    fn finish_rows<S: Simd>(&mut self, simd: S, first: usize) {
        let (stride, beyond) = (self.stride, first + PANEL);
        for r in 1..PANEL {
            let (above, below) = self.values.split_at_mut((first + r) * stride);
            let factors: [f64; PANEL] = std::array::from_fn(|q| below[first + q]);
            for (q, factor) in factors[..r].iter().enumerate() {
                let done = &above[(first + q) * stride + beyond..(first + q + 1) * stride];
                let factor = f64x8::splat(simd, -factor);
                add_multiple(simd, &mut below[beyond..stride], done, factor);
            }
        }
    }

    /// Takes a panel's columns times its rows off all that lies below and beyond.
    #[inline(always)]
    fn update<S: Simd>(&mut self, simd: S, first: usize) {
        let stride = self.stride;
        let (above, below) = self.values.split_at_mut((first + PANEL) * stride);
        let panel = &above[first * stride..];
        let mut rows = below.chunks_exact_mut(ROWS * stride);
        for rows in &mut rows {
            update_rows::<S, ROWS>(simd, panel, rows, stride, first);
        }
        for row in rows.into_remainder().chunks_exact_mut(stride) {
            update_rows::<S, 1>(simd, panel, row, stride, first);
        }
    }

    /// Solves in place.
    pub fn solve(&self, x: &mut [f64]) {
        dispatch!(Level::new(), simd => self.substitute(simd, x));
    }

    #[inline(always)]
    fn substitute<S: Simd>(&self, simd: S, x: &mut [f64]) {
        let (n, stride) = (self.n, self.stride);
        for k in 0..n {
            x.swap(k, self.pivots[k]);
        }
        for i in 0..n {
            let row = &self.values[i * stride..i * stride + i];
            x[i] -= dot(simd, row, &x[..i]);
        }
        for i in (0..n).rev() {
            let row = &self.values[i * stride + i + 1..i * stride + n];
            x[i] = (x[i] - dot(simd, row, &x[i + 1..n])) / self.values[i * stride + i];
        }
    }
}

/// `to += factor from`, in whole registers. Indexed on purpose: zipped iterators are not inlined
/// into the vectorised function, and run without its instructions.
#[inline(always)]
fn add_multiple<S: Simd>(simd: S, to: &mut [f64], from: &[f64], factor: f64x8<S>) {
    let (to, from) = (to.as_chunks_mut::<LANES>().0, from.as_chunks::<LANES>().0);
    for i in 0..to.len().min(from.len()) {
        let sum = f64x8::load_array_ref(simd, &to[i]);
        to[i] = f64x8::load_array_ref(simd, &from[i]).mul_add(factor, sum).to_array();
    }
}

/// `rows -= L U` for N rows below a panel: as many columns at a time as keep their sums in
/// registers.
#[inline(always)]
fn update_rows<S: Simd, const N: usize>(
    simd: S,
    panel: &[f64],
    rows: &mut [f64],
    stride: usize,
    first: usize,
) {
    if S::f64s::LEN >= LANES {
        update_columns::<S, N, 2>(simd, panel, rows, stride, first);
    } else {
        update_columns::<S, N, 1>(simd, panel, rows, stride, first);
    }
}

/// Update of N rows, H registers of columns at a time.
#[inline(always)]
fn update_columns<S: Simd, const N: usize, const H: usize>(
    simd: S,
    panel: &[f64],
    rows: &mut [f64],
    stride: usize,
    first: usize,
) {
    let factors: [[f64; PANEL]; N] =
        std::array::from_fn(|r| std::array::from_fn(|q| -rows[r * stride + first + q]));
    let place = |row: usize, column: usize, h: usize| row * stride + column + h * LANES;
    for column in (first + PANEL..stride).step_by(H * LANES) {
        let load = |from: &[f64], at: usize| f64x8::from_slice(simd, &from[at..at + LANES]);
        let mut sums = [[simd.splat_f64x8(0.0); H]; N];
        for r in 0..N {
            for h in 0..H {
                sums[r][h] = load(rows, place(r, column, h));
            }
        }
        for q in 0..PANEL {
            let mut above = [simd.splat_f64x8(0.0); H];
            for h in 0..H {
                above[h] = load(panel, place(q, column, h));
            }
            for r in 0..N {
                let factor = f64x8::splat(simd, factors[r][q]);
                for h in 0..H {
                    sums[r][h] = above[h].mul_add(factor, sums[r][h]);
                }
            }
        }
        for r in 0..N {
            for h in 0..H {
                let at = place(r, column, h);
                sums[r][h].store_slice(&mut rows[at..at + LANES]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use nalgebra::{DMatrix, DVector};

    fn filled(n: usize, random: &mut Random) -> (DenseLu, DMatrix<f64>) {
        let matrix = DMatrix::from_fn(n, n, |_, _| random.range(-1.0, 1.0));
        let mut lu = DenseLu::new(n);
        for i in 0..n {
            for j in 0..n {
                lu.add(i, j, matrix[(i, j)]);
            }
        }
        (lu, matrix)
    }

    /// The residual `A x - b` is round-off, for sizes that fill their panels and for others.
    #[test]
    fn solves_systems_of_any_size() {
        let mut random = Random::new(41);
        for n in (1..40).chain([63, 64, 65, 171, 288]) {
            let (mut lu, matrix) = filled(n, &mut random);
            let b = DVector::from_fn(n, |_, _| random.range(-1.0, 1.0));
            let mut x = b.clone();
            assert!(lu.factor(), "{n} unknowns");
            lu.solve(x.as_mut_slice());
            let left = (&matrix * &x - b).amax() / (matrix.amax() * x.amax());
            assert!(left < 1e-14 * n as f64, "{n} unknowns: {left:e}");
        }
    }

    /// Without a change of rows the first pivot would be zero.
    #[test]
    fn rows_change_places() {
        for n in [2, 9, 24] {
            let mut lu = DenseLu::new(n);
            (0..n).for_each(|i| lu.add(i, n - 1 - i, 1.0 + i as f64));
            assert!(lu.factor());
            let mut x: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
            lu.solve(&mut x);
            assert!(x.iter().all(|x| (x - 1.0).abs() < 1e-15), "{x:?}");
        }
    }

    #[test]
    fn a_singular_matrix_is_refused() {
        for n in [1, 8, 20] {
            let mut lu = DenseLu::new(n);
            (0..n - 1).for_each(|i| lu.add(i, i, 1.0));
            assert!(!lu.factor(), "{n} unknowns");
        }
    }

    /// Whatever was in it before does not matter.
    #[test]
    fn starts_again_at_another_size() {
        let mut random = Random::new(42);
        let (mut lu, _) = filled(30, &mut random);
        assert!(lu.factor());
        lu.restart(11);
        (0..11).for_each(|i| lu.row_mut(i)[i] = 2.0);
        assert!(lu.factor());
        let mut x = [3.0; 11];
        lu.solve(&mut x);
        assert!(x.iter().all(|x| *x == 1.5));
    }
}
