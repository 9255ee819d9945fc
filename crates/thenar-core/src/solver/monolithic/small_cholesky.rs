//! Cholesky factor of the small dense blocks, in place and row by row.

use crate::solver::monolithic::factor::{Lanes, Scalar};

/// Factors the lower triangle of the n×n matrix `m`; false unless it is positive definite.
pub fn factor(m: &mut [f64], n: usize) -> bool {
    for i in 0..n {
        for j in 0..=i {
            let (above, row) = m.split_at_mut(i * n);
            let done: f64 = if j < i {
                row[..j].iter().zip(&above[j * n..j * n + j]).map(|(a, b)| a * b).sum()
            } else {
                row[..i].iter().map(|a| a * a).sum()
            };
            let rest = row[j] - done;
            if j < i {
                row[j] = rest / above[j * n + j];
            } else if rest > 0.0 && rest.is_finite() {
                row[i] = rest.sqrt();
            } else {
                return false;
            }
        }
    }
    true
}

/// `x = L⁻¹ x`.
pub fn forward(l: &[f64], n: usize, x: &mut [f64]) {
    for i in 0..n {
        let done: f64 = l[i * n..i * n + i].iter().zip(x.iter()).map(|(a, b)| a * b).sum();
        x[i] = (x[i] - done) / l[i * n + i];
    }
}

/// `x = L⁻¹ x` for many right-hand sides.
pub fn forward_many(l: &[f64], n: usize, x: &mut [Lanes]) {
    for i in 0..n {
        let (done, rest) = x.split_at_mut(i);
        let scale = (1.0 / l[i * n + i]) as Scalar;
        for (l, done) in l[i * n..i * n + i].iter().zip(done) {
            let l = *l as Scalar;
            rest[0].iter_mut().zip(done).for_each(|(x, y)| *x -= l * *y);
        }
        rest[0].iter_mut().for_each(|x| *x *= scale);
    }
}

/// `x = L⁻ᵀ x`.
pub fn backward(l: &[f64], n: usize, x: &mut [f64]) {
    for i in (0..n).rev() {
        let (before, at) = x.split_at_mut(i);
        at[0] /= l[i * n + i];
        before.iter_mut().zip(&l[i * n..i * n + i]).for_each(|(x, a)| *x -= a * at[0]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn solves_what_it_factored() {
        let (n, mut random) = (9, Random::new(5));
        let a: Vec<f64> = (0..n * n).map(|_| random.range(-1.0, 1.0)).collect();
        let entry = |i: usize, j: usize| -> f64 {
            (0..n).map(|k| a[i * n + k] * a[j * n + k]).sum::<f64>() + f64::from(u8::from(i == j))
        };
        let mut l: Vec<f64> = (0..n * n).map(|e| entry(e / n, e % n)).collect();
        let want: Vec<f64> = (0..n).map(|_| random.range(-1.0, 1.0)).collect();
        let mut x: Vec<f64> = (0..n).map(|i| (0..n).map(|j| entry(i, j) * want[j]).sum()).collect();
        assert!(factor(&mut l, n));
        forward(&l, n, &mut x);
        backward(&l, n, &mut x);
        assert!(x.iter().zip(&want).all(|(x, w)| (x - w).abs() < 1e-12));
        l[0] = -1.0;
        assert!(!factor(&mut l, n), "an indefinite matrix must be refused");
    }
}
