//! Bones and joints: kinematics, limits, springs, and the flesh that hangs on them.

mod coupled_finger;
mod joint_limits;
mod joint_positions;
mod joint_springs;
mod joint_targets;
mod many_freedoms;
mod rigid_chains;
