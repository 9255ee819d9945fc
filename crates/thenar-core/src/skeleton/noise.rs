//! Repeatable random numbers for tests.

use crate::math::{Pose, Quat, Vec3};

/// A small generator of repeatable numbers in [-1, 1).
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub fn vector(&mut self, size: f64) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next()) * size
    }

    pub fn pose(&mut self, size: f64) -> Pose {
        Pose::new(self.vector(size), Quat::from_scaled_axis(self.vector(2.0)))
    }
}
