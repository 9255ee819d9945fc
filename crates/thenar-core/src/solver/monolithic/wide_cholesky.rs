//! Cholesky factor of a dense block of hundreds of rows, in place and row by row, at the vector
//! width of the machine.

use crate::solver::monolithic::vectors::{add, dot};
use fearless_simd::Simd;

/// Factors the lower triangle of the n×n matrix `m`; false unless it is positive definite.
#[inline(always)]
pub fn factor<S: Simd>(simd: S, m: &mut [f64], n: usize) -> bool {
    for i in 0..n {
        let (above, row) = m.split_at_mut(i * n);
        for (j, other) in above.chunks_exact(n).enumerate() {
            row[j] = (row[j] - dot(simd, &row[..j], &other[..j])) / other[j];
        }
        let rest = row[i] - dot(simd, &row[..i], &row[..i]);
        if !(rest > 0.0 && rest.is_finite()) {
            return false;
        }
        row[i] = rest.sqrt();
    }
    true
}

/// `x = L⁻ᵀ L⁻¹ x`.
#[inline(always)]
pub fn solve<S: Simd>(simd: S, l: &[f64], n: usize, x: &mut [f64]) {
    if n == 0 {
        return;
    }
    for (i, row) in l.chunks_exact(n).enumerate() {
        x[i] = (x[i] - dot(simd, &row[..i], &x[..i])) / row[i];
    }
    for (i, row) in l.chunks_exact(n).enumerate().rev() {
        let (before, at) = x.split_at_mut(i);
        at[0] /= row[i];
        add(simd, before, -at[0], &row[..i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use fearless_simd::{Level, dispatch};

    /// Sizes that fill no whole register and several.
    #[test]
    fn what_is_solved_multiplies_back() {
        let mut random = Random::new(71);
        for n in [0, 1, 2, 7, 33, 138] {
            let a: Vec<f64> = (0..n * n).map(|_| random.range(-1.0, 1.0)).collect();
            let entry = |i: usize, j: usize| {
                let product: f64 = (0..n).map(|k| a[i * n + k] * a[j * n + k]).sum();
                product + f64::from(i == j)
            };
            let m: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
            let b: Vec<f64> = (0..n).map(|_| random.range(-1.0, 1.0)).collect();
            let (mut l, mut x) = (m.clone(), b.clone());
            dispatch!(Level::new(), simd => {
                assert!(factor(simd, &mut l, n));
                solve(simd, &l, n, &mut x);
            });
            for (i, want) in b.iter().enumerate() {
                let is: f64 = (0..n).map(|j| m[i * n + j] * x[j]).sum();
                assert!((is - want).abs() < 1e-9, "{n}: {is} instead of {want}");
            }
        }
    }

    #[test]
    fn what_is_not_positive_definite_is_refused() {
        for (last, sound) in [(1.01, true), (1.0, false), (0.5, false), (f64::NAN, false)] {
            let mut m = vec![1.0, 0.0, 1.0, last];
            assert_eq!(dispatch!(Level::new(), simd => factor(simd, &mut m, 2)), sound, "{last}");
        }
    }
}
