//! The dense kernels of the flesh factor. Panels are stored column by column.

use crate::solver::exact::factor::{LANES, Lanes, Scalar};

/// Factors a panel of `width` columns and `height` rows in place; false when a pivot is not
/// positive.
pub fn factor_panel(panel: &mut [Scalar], height: usize, width: usize) -> bool {
    // Three columns at a time, then their product off all later columns.
    for k0 in (0..width).step_by(3) {
        for k in k0..k0 + 3 {
            let (before, column) = panel.split_at_mut(k * height);
            let column = &mut column[..height];
            for j in k0..k {
                let done = &before[j * height + k..(j + 1) * height];
                let factor = done[0];
                column[k..].iter_mut().zip(done).for_each(|(x, l)| *x -= factor * l);
            }
            let pivot = column[k];
            if !(pivot > 0.0 && pivot.is_finite()) {
                return false;
            }
            let scale = 1.0 / pivot.sqrt();
            column[k..].iter_mut().for_each(|x| *x *= scale);
        }
        let (done, rest) = panel.split_at_mut((k0 + 3) * height);
        let [l0, l1, l2] = [0, 1, 2].map(|c| &done[(k0 + c) * height..(k0 + c + 1) * height]);
        for (j, column) in (k0 + 3..width).zip(rest.chunks_exact_mut(height)) {
            let (f0, f1, f2) = (l0[j], l1[j], l2[j]);
            let lower = l0[j..].iter().zip(&l1[j..]).zip(&l2[j..]);
            for (x, ((a, b), c)) in column[j..].iter_mut().zip(lower) {
                *x -= f0 * a + f1 * b + f2 * c;
            }
        }
    }
    true
}

/// `update = L₂ L₂ᵀ` of the rows below the pivots, lower triangle, column by column.
pub fn outer_product(panel: &[Scalar], height: usize, width: usize, update: &mut [Scalar]) {
    let m = height - width;
    for (j, column) in update[..m * m].chunks_exact_mut(m).enumerate() {
        column[j..].fill(0.0);
        for k0 in (0..width).step_by(3) {
            let [l0, l1, l2] =
                [0, 1, 2].map(|c| &panel[(k0 + c) * height + width + j..(k0 + c + 1) * height]);
            let (f0, f1, f2) = (l0[0], l1[0], l2[0]);
            for (x, ((a, b), c)) in column[j..].iter_mut().zip(l0.iter().zip(l1).zip(l2)) {
                *x += f0 * a + f1 * b + f2 * c;
            }
        }
    }
}

/// `x = L₁⁻¹ x`, `below += L₂ x`.
pub fn forward(panel: &[Scalar], height: usize, x: &mut [Scalar], below: &mut [Scalar]) {
    let width = x.len();
    for (k, column) in panel.chunks_exact(height).enumerate() {
        x[k] /= column[k];
        let value = x[k];
        x[k + 1..].iter_mut().zip(&column[k + 1..width]).for_each(|(x, l)| *x -= l * value);
        below.iter_mut().zip(&column[width..]).for_each(|(x, l)| *x += l * value);
    }
}

/// `x = L₁⁻ᵀ (x - L₂ᵀ below)`.
pub fn backward(panel: &[Scalar], height: usize, x: &mut [Scalar], below: &[Scalar]) {
    let width = x.len();
    for (k, column) in panel.chunks_exact(height).enumerate().rev() {
        let own = dot(&column[k + 1..width], &x[k + 1..]);
        x[k] = (x[k] - own - dot(&column[width..], below)) / column[k];
    }
}

/// Scalar product in eight running sums, so that it can be done in parallel.
fn dot(a: &[Scalar], b: &[Scalar]) -> Scalar {
    let mut sums = [0.0; 8];
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: Scalar = a8.remainder().iter().zip(b8.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a8.zip(b8) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum::<Scalar>() + rest
}

/// `x -= l y` in every lane.
#[inline(always)]
fn subtract(x: &mut Lanes, l: Scalar, y: &Lanes) {
    for k in 0..LANES {
        x[k] -= l * y[k];
    }
}

/// `x *= s` in every lane.
#[inline(always)]
fn scale(x: &mut Lanes, s: Scalar) {
    x.iter_mut().for_each(|x| *x *= s);
}

/// Forward substitution of one supernode for many right-hand sides: its pivots are the rows from
/// `first` on of x, the rows below those of the places `rows`.
pub fn forward_many(
    panel: &[Scalar],
    height: usize,
    width: usize,
    first: usize,
    rows: &[u32],
    x: &mut [Lanes],
) {
    for k in 0..width {
        let mut value = x[first + k];
        for j in 0..k {
            subtract(&mut value, panel[j * height + k], &x[first + j]);
        }
        scale(&mut value, 1.0 / panel[k * height + k]);
        x[first + k] = value;
    }
    for (i, row) in rows.iter().enumerate() {
        let at = 3 * *row as usize;
        let mut values = [x[at], x[at + 1], x[at + 2]];
        for k in 0..width {
            let l = &panel[k * height + width + 3 * i..k * height + width + 3 * i + 3];
            let y = x[first + k];
            for r in 0..3 {
                subtract(&mut values[r], l[r], &y);
            }
        }
        x[at..at + 3].copy_from_slice(&values);
    }
}

/// Backward substitution likewise.
pub fn backward_many(
    panel: &[Scalar],
    height: usize,
    width: usize,
    first: usize,
    rows: &[u32],
    x: &mut [Lanes],
) {
    for k0 in (0..width).step_by(3) {
        let mut values = [x[first + k0], x[first + k0 + 1], x[first + k0 + 2]];
        for (i, row) in rows.iter().enumerate() {
            for r in 0..3 {
                let y = x[3 * *row as usize + r];
                for (c, value) in values.iter_mut().enumerate() {
                    subtract(value, panel[(k0 + c) * height + width + 3 * i + r], &y);
                }
            }
        }
        x[first + k0..first + k0 + 3].copy_from_slice(&values);
    }
    for k in (0..width).rev() {
        let mut value = x[first + k];
        for j in k + 1..width {
            subtract(&mut value, panel[k * height + j], &x[first + j]);
        }
        scale(&mut value, 1.0 / panel[k * height + k]);
        x[first + k] = value;
    }
}
