//! The dense kernels that compute the flesh factor.
//!
//! Panels are stored column by column. A column begins at a register's boundary and is padded with
//! zeros to whole registers (`stride` numbers); its first 3p rows are the pivot block, of which the
//! strict upper triangle is zero and the diagonal holds reciprocals, `1 / L_kk`.
//!
//! Everything comes down to one register-blocked product of panel rows ([`products`]): a tile of
//! T registers of rows times N columns stays in registers while the depth is run through.

use crate::solver::monolithic::factor::{LANES, Lanes, Scalar};
use fearless_simd::{Simd, SimdBase, SimdFloat, f32x4, f32x8, f32x16};

/// Columns treated together; widths are multiples of 3.
pub const COLUMNS: usize = 6;

/// True where one register holds a line of [`LANES`] numbers. Where a line takes several, the sums
/// of two lines of six columns would not stay in registers.
#[inline(always)]
pub const fn has_wide_registers<S: Simd>() -> bool {
    S::f32s::LEN >= LANES
}

/// The 16 numbers from `at` on.
#[inline(always)]
pub fn load<S: Simd>(simd: S, x: &[Scalar], at: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &x[at..at + LANES])
}

/// The lines `at(0)`, `at(1)`, .. of 16 numbers each.
#[inline(always)]
pub fn load_lines<S: Simd, const N: usize>(
    simd: S,
    lines: &[Lanes],
    at: impl Fn(usize) -> usize,
) -> [f32x16<S>; N] {
    // Not `array::from_fn`: what it calls would be compiled without the vector instructions.
    let mut loaded = [f32x16::splat(simd, 0.0); N];
    for i in 0..N {
        loaded[i] = f32x16::from_slice(simd, &lines[at(i)]);
    }
    loaded
}

/// Stores 16 numbers from `at` on.
#[inline(always)]
pub fn store<S: Simd>(value: f32x16<S>, x: &mut [Scalar], at: usize) {
    value.store_slice(&mut x[at..at + LANES]);
}

/// The last register's boundary at or before a row.
#[inline(always)]
pub const fn line(row: usize) -> usize {
    row / LANES * LANES
}

/// Rows per column, padded to whole registers.
pub const fn stride(height: usize) -> usize {
    height.div_ceil(LANES) * LANES
}

/// `Σ_k L[row.., k] L[column + c, k]` over all columns k of `panel`: T registers of rows, N
/// columns.
#[inline(always)]
fn products<S: Simd, const T: usize, const N: usize>(
    simd: S,
    panel: &[Scalar],
    stride: usize,
    row: usize,
    column: usize,
) -> [[f32x16<S>; T]; N] {
    let mut sums = [[f32x16::splat(simd, 0.0); T]; N];
    for l in panel.chunks_exact(stride) {
        let mut rows = [f32x16::splat(simd, 0.0); T];
        for t in 0..T {
            rows[t] = load(simd, l, row + LANES * t);
        }
        let factors = &l[column..column + N];
        for c in 0..N {
            let factor = f32x16::splat(simd, factors[c]);
            for t in 0..T {
                sums[c][t] = rows[t].mul_add(factor, sums[c][t]);
            }
        }
    }
    sums
}

/// Factors a panel of `width` columns in place; false when a pivot is not positive.
#[inline(always)]
pub fn factor_panel<S: Simd>(simd: S, panel: &mut [Scalar], stride: usize, width: usize) -> bool {
    for k0 in (0..width).step_by(COLUMNS) {
        let sound = if width - k0 >= COLUMNS {
            factor_columns::<S, COLUMNS>(simd, panel, stride, k0)
        } else {
            factor_columns::<S, 3>(simd, panel, stride, k0)
        };
        if !sound {
            return false;
        }
    }
    true
}

/// Columns `k0..k0 + N`, left-looking: what the columns before take off, then the own block.
#[inline(always)]
fn factor_columns<S: Simd, const N: usize>(
    simd: S,
    panel: &mut [Scalar],
    stride: usize,
    k0: usize,
) -> bool {
    let (done, rest) = panel.split_at_mut(k0 * stride);
    let block = &mut rest[..N * stride];
    let mut row = line(k0);
    while has_wide_registers::<S>() && row + 2 * LANES <= stride && k0 > 0 {
        subtract(products::<S, 2, N>(simd, done, stride, row, k0), simd, block, stride, row);
        row += 2 * LANES;
    }
    while row < stride && k0 > 0 {
        subtract(products::<S, 1, N>(simd, done, stride, row, k0), simd, block, stride, row);
        row += LANES;
    }

    let Some(pivots) = factor_pivots::<N>(block, stride, k0) else { return false };
    for row in (line(k0)..stride).step_by(LANES) {
        let mut x = [f32x16::splat(simd, 0.0); N];
        for c in 0..N {
            let mut value = load(simd, block, c * stride + row);
            for e in 0..c {
                value -= x[e] * pivots[c][e];
            }
            x[c] = value * pivots[c][c];
            store(x[c], block, c * stride + row);
        }
    }
    for (c, column) in block.chunks_exact_mut(stride).enumerate() {
        column[line(k0)..k0 + c].fill(0.0);
        column[k0 + c] = pivots[c][c];
    }
    true
}

#[inline(always)]
fn subtract<S: Simd, const T: usize, const N: usize>(
    sums: [[f32x16<S>; T]; N],
    simd: S,
    block: &mut [Scalar],
    stride: usize,
    row: usize,
) {
    for c in 0..N {
        for t in 0..T {
            let at = c * stride + row + LANES * t;
            store(load(simd, block, at) - sums[c][t], block, at);
        }
    }
}

/// The N×N Cholesky factor at row `k0` of a block of columns, reciprocals on its diagonal.
#[inline(always)]
fn factor_pivots<const N: usize>(
    block: &[Scalar],
    stride: usize,
    k0: usize,
) -> Option<[[Scalar; N]; N]> {
    let mut l = [[0.0; N]; N];
    for c in 0..N {
        for r in c..N {
            let mut value = block[c * stride + k0 + r];
            for e in 0..c {
                value -= l[r][e] * l[c][e];
            }
            if r > c {
                l[r][c] = value * l[c][c];
            } else if value > 0.0 && value.is_finite() {
                l[c][c] = 1.0 / value.sqrt();
            } else {
                return None;
            }
        }
    }
    Some(l)
}

/// `update = L₂ L₂ᵀ` of the rows below the pivots, lower triangle, column by column. A column has
/// as many numbers as one of the panel has from the boundary `line(width)` on.
#[inline(always)]
pub fn outer_product<S: Simd>(
    simd: S,
    panel: &[Scalar],
    stride: usize,
    height: usize,
    width: usize,
    update: &mut [Scalar],
) {
    let mut column = width;
    // More columns for more registers.
    while has_wide_registers::<S>() && height - column >= 2 * COLUMNS {
        product_columns::<S, { 2 * COLUMNS }>(simd, panel, stride, width, column, update);
        column += 2 * COLUMNS;
    }
    while height - column >= COLUMNS {
        product_columns::<S, COLUMNS>(simd, panel, stride, width, column, update);
        column += COLUMNS;
    }
    if column < height {
        product_columns::<S, 3>(simd, panel, stride, width, column, update);
    }
}

#[inline(always)]
fn product_columns<S: Simd, const N: usize>(
    simd: S,
    panel: &[Scalar],
    stride: usize,
    width: usize,
    column: usize,
    update: &mut [Scalar],
) {
    let first = line(width);
    let update_stride = stride - first;
    let update = &mut update[(column - width) * update_stride..][..N * update_stride];
    let mut row = line(column);
    while has_wide_registers::<S>() && row + 2 * LANES <= stride {
        let sums = products::<S, 2, N>(simd, panel, stride, row, column);
        for c in 0..N {
            for t in 0..2 {
                store(sums[c][t], update, c * update_stride + row - first + LANES * t);
            }
        }
        row += 2 * LANES;
    }
    while row < stride {
        let sums = products::<S, 1, N>(simd, panel, stride, row, column);
        for c in 0..N {
            store(sums[c][0], update, c * update_stride + row - first);
        }
        row += LANES;
    }
}

/// `to -= from`, as many numbers as `from` has. Nothing beyond them is written: a load that
/// overlaps a recent store only in part has to wait until that store reaches the cache.
#[inline(always)]
pub fn take_off<S: Simd>(simd: S, from: &[Scalar], to: &mut [Scalar]) {
    let to = &mut to[..from.len()];
    let (from8, from) = from.as_chunks::<8>();
    let (to8, to) = to.as_chunks_mut::<8>();
    for k in 0..from8.len() {
        let left = f32x8::from_slice(simd, &to8[k]) - f32x8::from_slice(simd, &from8[k]);
        left.store_slice(&mut to8[k]);
    }
    let (from4, from) = from.as_chunks::<4>();
    let (to4, to) = to.as_chunks_mut::<4>();
    if let (Some(from), Some(to)) = (from4.first(), to4.first_mut()) {
        (f32x4::from_slice(simd, to) - f32x4::from_slice(simd, from)).store_slice(to);
    }
    for k in 0..from.len() {
        to[k] -= from[k];
    }
}

/// `to -= from` in three columns, `strides` apart in `from` and in `to`: `length` numbers of each.
/// Loops are laid out for runs of one to five nodes, which 94 in 100 of the default hand's are.
#[inline(always)]
pub fn take_off_columns<S: Simd>(
    simd: S,
    from: &[Scalar],
    to: &mut [Scalar],
    strides: [usize; 2],
    length: usize,
) {
    match length {
        3 => take_off_short::<3>(from, to, strides),
        6 => take_off_short::<6>(from, to, strides),
        9 => take_off_short::<9>(from, to, strides),
        12 => take_off_short::<12>(from, to, strides),
        15 => take_off_short::<15>(from, to, strides),
        _ => {
            for c in 0..3 {
                take_off(simd, &from[c * strides[0]..][..length], &mut to[c * strides[1]..]);
            }
        }
    }
}

#[inline(always)]
fn take_off_short<const L: usize>(from: &[Scalar], to: &mut [Scalar], strides: [usize; 2]) {
    let (from, to) = (&from[..2 * strides[0] + L], &mut to[..2 * strides[1] + L]);
    for c in 0..3 {
        let (from, to) = (&from[c * strides[0]..][..L], &mut to[c * strides[1]..][..L]);
        for k in 0..L {
            to[k] -= from[k];
        }
    }
}
