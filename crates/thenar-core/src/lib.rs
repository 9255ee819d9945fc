//! Thenar simulates a soft hand: a jointed skeleton inside finite-element flesh,
//! in frictional contact with rigid and deformable objects.
//!
//! Units are SI (m, kg, s, N, Pa, rad); frames are right-handed. `pose_AB` is the
//! pose of frame B in frame A, so that `p_A = pose_AB * p_B`.

mod capacity_vec;
pub mod condensed;
mod contact;
mod coupling;
mod flesh;
pub mod histogram;
pub mod math;
pub mod model;
mod processor;
pub mod random;
pub mod readout;
mod skeleton;
mod solver;
#[cfg(test)]
mod testing;
pub mod world;

pub use math::{Mat3, Pose, Quat, Vec3};
pub use processor::vector_instructions;
pub use world::World;

/// Shapes of rigid bodies.
pub mod shape {
    pub use crate::contact::{Distance, DistanceGrid, MeshShape, PlacedShape, Shape};
}

/// Angles, axes and poses of jointed bones, outside any simulation.
pub mod kinematics {
    pub use crate::skeleton::{
        Tree, TreeError, closest_angles, joint_angles, joint_rotation, joint_spin, stretch,
        velocity_between,
    };
}

/// The kernels of a step, one by one: benches time them, `thenar validate` holds them against
/// differences of energies, probes measure stress by them, and touch resolves contact and couplings
/// by them. Stepping a world needs none of them.
pub mod kernels {
    pub use crate::contact::{
        Detector, HeldPlace, Reach, RigidPlace, SeenSide, SeenSides, Site, SurfaceState,
    };
    pub use crate::coupling::{BoneSystem, EffectiveMass, skin_target};
    pub use crate::flesh::{PAIRS, RestTet, respond, rotation_of, signed_svd};
    pub use crate::skeleton::{
        JointFrames, axis_states, drive_energy, drive_force, joint_block, spring_torque,
        turn_freely,
    };
    pub use crate::solver::{
        BlockDiagonal, BlockMatrix, CgWorkspace, conjugate_gradients, project,
    };
}
