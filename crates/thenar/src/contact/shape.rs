//! Contact shapes of rigid bodies.

use crate::math::Vec3;
use std::sync::Arc;

/// The contact shape of a rigid body, in its shape frame S.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Shape {
    /// Centre at the origin.
    Sphere {
        /// Radius \[m\].
        radius: f64,
    },
    /// Segment along y, rounded.
    Capsule {
        /// Radius \[m\].
        radius: f64,
        /// Half the segment's length, caps excluded \[m\].
        half_length: f64,
    },
    /// Centre at the origin.
    Cuboid {
        /// Half the edge lengths \[m\].
        half: Vec3,
    },
    /// All points with y ≤ 0; the normal is +y. Only for prescribed bodies.
    HalfSpace,
    /// A triangle mesh.
    Mesh(#[cfg_attr(feature = "serde", serde(with = "shared"))] Arc<MeshShape>),
}

impl Shape {
    /// The least radius of curvature \[m\] at which its distance is to be sampled: that of a round
    /// shape; of one with edges, half its least extent.
    pub(crate) fn least_radius(&self) -> f64 {
        match self {
            Self::Sphere { radius } | Self::Capsule { radius, .. } => *radius,
            Self::Cuboid { half } => half.min(),
            Self::HalfSpace => f64::INFINITY,
            Self::Mesh(mesh) => {
                let (n, cell) = (mesh.grid.dims.map(|n| n - 1), mesh.grid.cell);
                0.5 * cell * f64::from(n.into_iter().min().unwrap_or(1))
            }
        }
    }
}

/// A rigid triangle mesh made ready for contact.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MeshShape {
    /// Surface points tested against other bodies \[m\].
    pub points: Vec<Vec3>,
    /// Triangles over `points`, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Signed distance around the mesh.
    pub grid: DistanceGrid,
}

/// Signed distance to a surface on a regular grid, negative inside.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DistanceGrid {
    /// Position of value (0,0,0) \[m\].
    pub origin: Vec3,
    /// Spacing \[m\].
    pub cell: f64,
    /// Number of values along x, y, z, each at least 2.
    pub dims: [u32; 3],
    /// Values \[m\], x fastest, then y, then z.
    pub values: Vec<f32>,
}

#[cfg(feature = "serde")]
mod shared {
    //! Serialises an `Arc` as what it holds.
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::sync::Arc;

    pub fn serialize<T: Serialize, S: Serializer>(value: &Arc<T>, s: S) -> Result<S::Ok, S::Error> {
        value.as_ref().serialize(s)
    }

    pub fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
        d: D,
    ) -> Result<Arc<T>, D::Error> {
        T::deserialize(d).map(Arc::new)
    }
}
