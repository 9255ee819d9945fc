//! Rigid bodies.

use crate::contact::Shape;
use crate::math::{Mat3, Pose, Vec3};

/// Kind of motion of a rigid body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Motion {
    /// By forces.
    Dynamic,
    /// By the velocity that the input prescribes (zero: the body is static).
    Prescribed,
}

/// One rigid body. Its frame B has its origin at the centre of mass.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RigidDesc {
    /// Name, unique in the scene.
    pub name: String,
    /// Dynamic or prescribed.
    pub motion: Motion,
    /// Mass \[kg\], positive when dynamic.
    pub mass: f64,
    /// Inertia about the centre of mass, in B \[kg m²\], symmetric positive definite when dynamic.
    pub inertia: Mat3,
    /// Start pose in the world.
    pub pose_WB: Pose,
    /// Start velocity of the centre of mass, world \[m/s\].
    pub velocity_W: Vec3,
    /// Start angular velocity, world \[rad/s\].
    pub angular_velocity_W: Vec3,
    /// Contact shape in B; `None` touches nothing (bones: their flesh touches).
    pub shape: Option<Shape>,
    /// Placement of the shape in B.
    pub pose_BS: Pose,
    /// Coulomb friction coefficient; a pair uses the geometric mean unless overridden.
    pub friction: f64,
}
