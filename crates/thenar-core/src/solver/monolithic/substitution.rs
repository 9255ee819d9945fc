//! Forward and backward substitution with one supernode's panel (see `dense` for its layout): for
//! one right-hand side, or for `LANES` of them together.

use crate::solver::monolithic::dense::{
    COLUMNS, has_wide_registers, line, load, load_lines, store,
};
use crate::solver::monolithic::factor::{LANES, Lanes, Scalar};
use crate::solver::monolithic::symbolic::Supernode;
use fearless_simd::{Simd, SimdBase, SimdFloat, f32x16};

/// `x = L₁⁻¹ x`, and `y`, as long as a column, has `L₂ x` taken off from row `x.len()` on. What `y`
/// holds before that row is used up.
#[inline(always)]
pub fn forward<S: Simd>(simd: S, panel: &[Scalar], x: &mut [Scalar], y: &mut [Scalar]) {
    let (width, stride) = (x.len(), y.len());
    y[..width].copy_from_slice(x);
    for k0 in (0..width).step_by(COLUMNS) {
        if width - k0 >= COLUMNS {
            forward_columns::<S, COLUMNS>(simd, &panel[k0 * stride..], k0, x, y);
        } else {
            forward_columns::<S, 3>(simd, &panel[k0 * stride..], k0, x, y);
        }
    }
}

#[inline(always)]
fn forward_columns<S: Simd, const N: usize>(
    simd: S,
    columns: &[Scalar],
    k0: usize,
    x: &mut [Scalar],
    y: &mut [Scalar],
) {
    let stride = y.len();
    let columns = &columns[..N * stride];
    let mut values = [0.0; N];
    for c in 0..N {
        let mut value = y[k0 + c];
        for e in 0..c {
            value -= columns[e * stride + k0 + c] * values[e];
        }
        values[c] = value * columns[c * stride + k0 + c];
    }
    x[k0..k0 + N].copy_from_slice(&values);
    for row in (line(k0 + N)..stride).step_by(LANES) {
        let mut sum = load(simd, y, row);
        for c in 0..N {
            sum -= load(simd, columns, c * stride + row) * values[c];
        }
        store(sum, y, row);
    }
}

/// `x = L₁⁻ᵀ (x - L₂ᵀ y)`, with `y` as long as a column; only its rows from `x.len()` on count.
#[inline(always)]
pub fn backward<S: Simd>(simd: S, panel: &[Scalar], x: &mut [Scalar], y: &mut [Scalar]) {
    let (width, stride) = (x.len(), y.len());
    y[..width].fill(0.0);
    let whole = width / COLUMNS * COLUMNS;
    if whole < width {
        backward_columns::<S, 3>(simd, &panel[whole * stride..], whole, x, y);
    }
    for k0 in (0..whole).step_by(COLUMNS).rev() {
        backward_columns::<S, COLUMNS>(simd, &panel[k0 * stride..], k0, x, y);
    }
}

#[inline(always)]
fn backward_columns<S: Simd, const N: usize>(
    simd: S,
    columns: &[Scalar],
    k0: usize,
    x: &mut [Scalar],
    y: &mut [Scalar],
) {
    let stride = y.len();
    let columns = &columns[..N * stride];
    let mut sums = [f32x16::splat(simd, 0.0); N];
    for row in (line(k0 + N)..stride).step_by(LANES) {
        let below = load(simd, y, row);
        for c in 0..N {
            sums[c] = load(simd, columns, c * stride + row).mul_add(below, sums[c]);
        }
    }
    for c in (0..N).rev() {
        let mut value = x[k0 + c] - sum(&sums[c]);
        for e in c + 1..N {
            value -= columns[c * stride + k0 + e] * x[k0 + e];
        }
        x[k0 + c] = value * columns[c * stride + k0 + c];
    }
    y[k0..k0 + N].copy_from_slice(&x[k0..k0 + N]);
}

/// The sum of a register's numbers, always in the same order.
#[inline(always)]
pub fn sum<S: Simd>(x: &f32x16<S>) -> Scalar {
    let (first, second) = x.simd.split_f32x16(*x);
    let halves = [x.simd.split_f32x8(first), x.simd.split_f32x8(second)];
    let four = (halves[0].0 + halves[0].1) + (halves[1].0 + halves[1].1);
    (four[0] + four[2]) + (four[1] + four[3])
}

/// Forward substitution for many right-hand sides: the pivots are the rows from `first` on of x,
/// the rows below are those of the places `rows`.
#[inline(always)]
pub fn forward_many<S: Simd>(
    simd: S,
    panel: &[Scalar],
    node: &Supernode,
    rows: &[u32],
    x: &mut [Lanes],
) {
    let (stride, width, first) = (node.stride(), node.width(), node.pivots().start);
    for k0 in (0..width).step_by(3) {
        let start = load_lines(
            simd,
            x,
            #[inline(always)]
            |r| first + k0 + r,
        );
        let mut values =
            reduce::<S, 3>(simd, &panel[..k0 * stride], stride, k0, &x[first..], start);
        for c in 0..3 {
            let l = &panel[(k0 + c) * stride + k0..][..3];
            values[c] *= l[c];
            for r in c + 1..3 {
                values[r] -= values[c] * l[r];
            }
            values[c].store_slice(&mut x[first + k0 + c]);
        }
    }
    let panel = &panel[..width * stride];
    let (mut row, mut rest) = (width, rows);
    // As many nodes at a time as keep the arithmetic units busy; AVX2 and NEON have registers for
    // the sums of two.
    while has_wide_registers::<S>()
        && let Some((places, after)) = rest.split_at_checked(4)
    {
        reduce_nodes::<S, 12>(simd, panel, stride, row, first, places, x);
        (row, rest) = (row + 12, after);
    }
    while let Some((places, after)) = rest.split_at_checked(2) {
        reduce_nodes::<S, 6>(simd, panel, stride, row, first, places, x);
        (row, rest) = (row + 6, after);
    }
    for place in rest {
        reduce_nodes::<S, 3>(simd, panel, stride, row, first, std::slice::from_ref(place), x);
        row += 3;
    }
}

/// Takes from the rows of the nodes `places`, R in all, what the panel's rows from `row` on make of
/// the pivots.
#[inline(always)]
fn reduce_nodes<S: Simd, const R: usize>(
    simd: S,
    panel: &[Scalar],
    stride: usize,
    row: usize,
    first: usize,
    places: &[u32],
    x: &mut [Lanes],
) {
    let start = load_lines(
        simd,
        x,
        #[inline(always)]
        |r| 3 * places[r / 3] as usize + r % 3,
    );
    let values = reduce::<S, R>(simd, panel, stride, row, &x[first..], start);
    for r in 0..R {
        values[r].store_slice(&mut x[3 * places[r / 3] as usize + r % 3]);
    }
}

/// `values_r -= Σ_k L[row + r, k] x_k` over all columns k of `panel`.
#[inline(always)]
fn reduce<S: Simd, const R: usize>(
    simd: S,
    panel: &[Scalar],
    stride: usize,
    row: usize,
    x: &[Lanes],
    mut values: [f32x16<S>; R],
) -> [f32x16<S>; R] {
    // Not `zip`: where its calls are not inlined they lack the vector instructions, and `values`
    // stays in memory for them.
    for k in 0..panel.len() / stride {
        let y = -f32x16::from_slice(simd, &x[k]);
        let l = &panel[k * stride + row..][..R];
        for r in 0..R {
            values[r] = y.mul_add(f32x16::splat(simd, l[r]), values[r]);
        }
    }
    values
}
