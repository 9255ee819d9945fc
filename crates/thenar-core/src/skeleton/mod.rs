//! The jointed skeleton (Sec. 3.1): kinematics, joint constraints, springs, limits and drives.

mod angles;
mod drives;
mod free_body;
mod joint_rows;
mod joint_springs;
mod kinematics;

pub use angles::{closest_angles, joint_angles, joint_rotation, joint_spin, turn_joint};
pub use drives::{drive_energy, drive_force, linearise_drive};
pub use free_body::turn_freely;
pub use joint_rows::{JointFrames, joint_block, misalignment};
pub use joint_springs::{
    AxisState, axis_states, limit_spring_torque, spring_energy, spring_torque, stretch,
    turned_towards,
};
pub use kinematics::{Tree, TreeError, velocity_between};
