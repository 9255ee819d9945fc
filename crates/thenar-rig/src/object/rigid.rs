//! A rigid body ready to be put into a world.

use crate::TriMesh;
use thenar_core::model::{Motion, RigidDesc};
use thenar_core::shape::Shape;
use thenar_core::{Mat3, Pose, Vec3};

/// A rigid body in its frame B: origin at the centre of mass, axes those of the mesh frame M it
/// was made from.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct RigidModel {
    /// Name of the body.
    pub name: String,
    /// Mass \[kg\]; zero for bodies that cannot move (a plane).
    pub mass: f64,
    /// Inertia about the centre of mass, in B \[kg m²\].
    pub inertia: Mat3,
    /// B in M.
    pub pose_MB: Pose,
    /// Contact shape.
    pub shape: Shape,
    /// Shape frame S in B.
    pub pose_BS: Pose,
    /// Surface for drawing, in B.
    pub render: TriMesh,
    /// Colours of runs of render triangles, in order; empty for one colour.
    pub paint: Vec<ColourRun>,
    /// Coulomb friction coefficient.
    pub friction: f64,
}

/// The colour of the render triangles from `first` to the next run.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ColourRun {
    /// First triangle.
    pub first: u32,
    /// Red, green, blue in 0..1 (sRGB).
    pub colour: [f32; 3],
}

impl RigidModel {
    /// The body at rest in the world, its mesh frame at `pose_WM`.
    pub fn placed(&self, pose_WM: &Pose, motion: Motion) -> RigidDesc {
        RigidDesc {
            name: self.name.clone(),
            motion,
            mass: self.mass,
            inertia: self.inertia,
            pose_WB: *pose_WM * self.pose_MB,
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
            shape: Some(self.shape.clone()),
            pose_BS: self.pose_BS,
            friction: self.friction,
        }
    }
}
