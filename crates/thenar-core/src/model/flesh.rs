//! Deformable bodies: nodes, tetrahedra, materials, and their binding to bones.

use crate::math::Vec3;
use crate::model::{EmbeddedSurface, Relaxation};

/// The constitutive law of an element.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Law {
    /// Linear elasticity in the element's own rotated frame (the paper's).
    Corotational,
    /// `μ/2 (I₁ − 3) − μ ln J + λ/2 ln² J`.
    NeoHookean,
    /// Neo-Hookean that stays finite when an element inverts (Smith et al. 2018).
    StableNeoHookean,
    /// Ogden's of one term, `2μ/α² (Σσᵢ^α − 3)` where volume is kept, that stays finite when an
    /// element inverts: stiffens with stretch.
    Ogden {
        /// Exponent, in [`OGDEN_ALPHA`](crate::model::OGDEN_ALPHA). Poisson's ratio is then not
        /// negative.
        alpha: f64,
    },
}

impl Law {
    /// Number in exported files.
    pub fn number(self) -> i32 {
        match self {
            Self::Corotational => 0,
            Self::NeoHookean => 1,
            Self::StableNeoHookean => 2,
            Self::Ogden { .. } => 3,
        }
    }
}

/// Bounds of Ogden's exponent. Below 4 a crushed element could come to rest; above 20, past what is
/// reported of tissue, a flattened one is stiffer than at rest by more than `exp(α/3)` = 800.
pub const OGDEN_ALPHA: [f64; 2] = [4.0, 20.0];

/// The material of one element.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Material {
    /// Constitutive law.
    pub law: Law,
    /// Young's modulus at small strain \[Pa\].
    pub young: f64,
    /// Poisson's ratio, in (-1, 0.5).
    pub poisson: f64,
    /// Density \[kg/m³\].
    pub density: f64,
}

/// A node held at its place along some world axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FixedNode {
    /// Node index.
    pub node: u32,
    /// World axes x, y, z along which the node is held.
    pub axes: [bool; 3],
}

/// The skinning of one node: a convex combination of at most two adjacent bones (Eq. 6).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Binding {
    /// Bone indices; equal when one bone carries the node.
    pub bones: [u32; 2],
    /// Weights, non-negative, of sum 1; the second is 0 when one bone carries the node.
    pub weights: [f64; 2],
}

/// Rule by which the two bones of a node place its target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Skinning {
    /// Linear blending of places (Eq. 6), the paper's: loses radius in a twist, and depth in a
    /// bend.
    #[default]
    Linear,
    /// Blending of rotations about the joint that the bones share. Bones turned by more than half a
    /// turn to each other, from the rest pose, are blended the shorter way: at half a turn a target
    /// jumps.
    Joint,
}

/// A deformable body in its rest shape.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Flesh {
    /// Rest positions \[m\], in the body's model frame.
    pub nodes: Vec<Vec3>,
    /// Node indices of each tetrahedron, with `det[x1-x0, x2-x0, x3-x0] > 0`.
    pub tets: Vec<[u32; 4]>,
    /// One material per tetrahedron.
    pub materials: Vec<Material>,
    /// One stress relaxation per tetrahedron, or none at all: then nothing has memory.
    pub relaxation: Vec<Relaxation>,
    /// Rayleigh damping: `D = mass_damping M + stiffness_damping K`. This one \[1/s\].
    pub mass_damping: f64,
    /// Rayleigh damping \[s\]. Elements with memory have none of this: their relaxation damps them,
    /// and nothing is to be damped twice.
    pub stiffness_damping: f64,
    /// Held nodes.
    pub fixed: Vec<FixedNode>,
    /// The surface that touches.
    pub collision: EmbeddedSurface,
    /// Coulomb friction coefficient; a pair uses the geometric mean unless overridden.
    pub friction: f64,
}
