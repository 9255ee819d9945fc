//! Inputs and results of contact detection.

use crate::math::{Pose, Vec3};

/// A point on a deformable surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Index into `WorldDesc::softs`.
    pub soft: u32,
    /// Three collision-surface vertices; all equal when the point is a vertex.
    pub vertices: [u32; 3],
    /// Barycentric weights, of sum 1; `[1, 0, 0]` when the point is a vertex.
    pub weights: [f64; 3],
}

impl SurfacePoint {
    /// The surface vertex `vertex`.
    pub fn vertex(soft: u32, vertex: u32) -> Self {
        Self { soft, vertices: [vertex; 3], weights: [1.0, 0.0, 0.0] }
    }

    /// The combination of a quantity given per surface vertex.
    pub fn interpolate(&self, values: &[Vec3]) -> Vec3 {
        let of = |k: usize| values[self.vertices[k] as usize] * self.weights[k];
        Vec3::zeros() + of(0) + of(1) + of(2)
    }
}

/// One side of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Site {
    /// A point moving with a rigid body.
    Rigid {
        /// Index into `WorldDesc::rigids`.
        body: u32,
        /// From the centre of mass to the point, world \[m\].
        offset_W: Vec3,
    },
    /// A point of a deformable surface.
    Soft(SurfacePoint),
}

/// Two surfaces that touch, or may touch within the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Names the pair of features; the same from step to step while they stay in contact.
    pub key: u64,
    /// Side A: the deformable side when only one is deformable.
    pub a: Site,
    /// Side B.
    pub b: Site,
    /// The point whose distance to the other surface the gap is, world \[m\]: a vertex of side A or
    /// the sharp point of a rigid side; between rigid bodies and between edges the middle.
    pub position_W: Vec3,
    /// Unit normal, from B to A, world.
    pub normal_W: Vec3,
    /// Distance along the normal \[m\], negative when penetrating.
    pub gap: f64,
    /// Coulomb friction coefficient of the pair.
    pub friction: f64,
}

/// Place and motion of a rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidPlace {
    /// Pose of the body frame (origin at the centre of mass) in the world.
    pub pose_WB: Pose,
    /// Velocity of the centre of mass, world \[m/s\].
    pub velocity_W: Vec3,
    /// Angular velocity, world \[rad/s\].
    pub angular_velocity_W: Vec3,
}

/// Place and motion of collision surfaces, one entry per vertex.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceState<'a> {
    /// Positions, world \[m\].
    pub positions: &'a [Vec3],
    /// Velocities, world \[m/s\].
    pub velocities: &'a [Vec3],
}

/// Report of a search for contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SearchReport {
    /// Contacts delivered.
    pub contacts: u32,
    /// Contacts left out because the capacity was reached (the deepest were kept), and pairs of
    /// rigid bodies that were not looked at in a crowd.
    pub dropped: u32,
    /// Pairs of bodies near enough to be looked at.
    pub pairs: u32,
    /// Deepest penetration \[m\], zero when nothing penetrates.
    pub penetration: f64,
}
