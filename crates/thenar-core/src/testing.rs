//! Tools that tests share: seeded random numbers and finite differences.

use crate::math::{Quat, Vec3};

/// xorshift64* (Vigna 2016), seeded.
pub struct Random(u64);

impl Random {
    /// A generator; the seed must not be zero.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// 64 random bits.
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    /// Uniform in [a, b).
    pub fn range(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in the cube of half edge `r`.
    pub fn vec3(&mut self, r: f64) -> Vec3 {
        Vec3::new(self.range(-r, r), self.range(-r, r), self.range(-r, r))
    }

    /// A rotation about a random axis by up to `angle` \[rad\].
    pub fn rotation(&mut self, angle: f64) -> Quat {
        let axis = self.vec3(1.0).normalize();
        Quat::from_scaled_axis(axis * self.range(-angle, angle))
    }
}

/// Central differences of a vector function of a vector: entry `[i][j]` is ∂f_i/∂x_j.
pub fn jacobian(f: impl Fn(&[f64]) -> Vec<f64>, x: &[f64], step: f64) -> Vec<Vec<f64>> {
    let columns: Vec<Vec<f64>> = (0..x.len())
        .map(|j| {
            let at = |s: f64| {
                let mut x = x.to_vec();
                x[j] += s;
                f(&x)
            };
            at(step).iter().zip(at(-step)).map(|(a, b)| (a - b) / (2.0 * step)).collect()
        })
        .collect();
    (0..columns[0].len()).map(|i| columns.iter().map(|c| c[i]).collect()).collect()
}

/// Asserts that two matrices agree to `tolerance` relative to the larger one's largest entry.
pub fn assert_close(got: &[Vec<f64>], want: &[Vec<f64>], tolerance: f64) {
    let largest = |m: &[Vec<f64>]| m.iter().flatten().fold(0.0_f64, |a, x| a.max(x.abs()));
    let scale = largest(want).max(largest(got)).max(1e-300);
    assert_eq!(got.len(), want.len());
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        for (j, (g, w)) in got.iter().zip(want).enumerate() {
            assert!((g - w).abs() <= tolerance * scale, "entry ({i},{j}): {g} against {w}");
        }
    }
}
