//! Deformable bodies: nodes, tetrahedra, materials, and their binding to bones.

use crate::math::Vec3;
use crate::model::EmbeddedSurface;

/// The constitutive law of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Law {
    /// Linear elasticity in the element's own rotated frame (the paper's).
    Corotational,
    /// `μ/2 (I₁ − 3) − μ ln J + λ/2 ln² J`.
    NeoHookean,
    /// Neo-Hookean that stays finite when an element inverts (Smith et al. 2018).
    StableNeoHookean,
}

/// The material of one element.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Material {
    /// Law.
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
    /// Which of x, y, z are held.
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
    /// Rayleigh damping: `D = mass_damping M + stiffness_damping K`. This one \[1/s\].
    pub mass_damping: f64,
    /// Rayleigh damping \[s\].
    pub stiffness_damping: f64,
    /// Held nodes.
    pub fixed: Vec<FixedNode>,
    /// The surface that touches.
    pub collision: EmbeddedSurface,
    /// Coulomb friction coefficient; a pair uses the geometric mean unless overridden.
    pub friction: f64,
}
