//! Repeatable numbers for tests whose figures hang on the series.

use crate::math::{Pose, Quat, Vec3};

/// A linear congruential generator (upper bits of 64, Knuth).
pub struct Noise(pub u64);

impl Noise {
    /// The series of a small seed, from a state far from those of its neighbours.
    pub fn seeded(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// Uniform in [-1, 1).
    pub fn next(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in the cube of half edge `size`.
    pub fn vector(&mut self, size: f64) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next()) * size
    }

    /// A place in the cube of half edge `size`, turned about any axis.
    pub fn pose(&mut self, size: f64) -> Pose {
        Pose::new(self.vector(size), Quat::from_scaled_axis(self.vector(2.0)))
    }
}
