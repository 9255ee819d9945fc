//! Thenar simulates a soft hand: a jointed skeleton inside finite-element flesh,
//! in frictional contact with rigid and deformable objects.
//!
//! Units are SI (m, kg, s, N, Pa, rad); frames are right-handed. `pose_AB` is the
//! pose of frame B in frame A, so that `p_A = pose_AB * p_B`.

pub mod contact;
pub mod coupling;
pub mod flesh;
pub mod haptic;
pub mod math;
pub mod model;
mod processor;
pub mod readout;
pub mod skeleton;
pub mod solver;
#[cfg(test)]
mod testing;
pub mod world;

pub use math::{Mat3, Pose, Quat, Vec3};
pub use processor::vector_instructions;
pub use world::World;
