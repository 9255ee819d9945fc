//! Vectors, under the name that the core's files know.

pub use thenar_core::math::Vec3;
