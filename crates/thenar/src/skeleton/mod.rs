//! The skeleton: bones joined into a tree.

mod angles;
mod kinematics;
#[cfg(test)]
mod noise;

pub use angles::{closest_angles, joint_angles, joint_rotation, joint_spin};
pub use kinematics::{Tree, TreeError, velocity_between};
