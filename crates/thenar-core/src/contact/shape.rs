//! Contact shapes of rigid bodies.

use crate::contact::mesh_index::MeshIndex;
use crate::math::{Pose, Vec3};
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
    /// Axis along y, centre at the origin.
    Cylinder {
        /// Radius \[m\].
        radius: f64,
        /// Half the height \[m\].
        half_length: f64,
    },
    /// Centre at the origin.
    Ellipsoid {
        /// Half the axes along x, y, z \[m\].
        half: Vec3,
    },
    /// Axis along y, apex up. The origin is the centroid: the base lies at y = -height/4, the apex
    /// at y = 3 height/4.
    Cone {
        /// Radius of the base \[m\].
        radius: f64,
        /// Height \[m\].
        height: f64,
    },
    /// The union of several shapes.
    Compound(#[cfg_attr(feature = "serde", serde(with = "shared"))] Arc<Vec<PlacedShape>>),
}

/// A shape in a compound: any but a half-space or another compound.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PlacedShape {
    /// Shape of this part.
    pub shape: Shape,
    /// Placement of its frame in the compound's frame S.
    pub pose_SP: Pose,
}

impl Shape {
    /// The least radius of curvature \[m\] at which its distance is to be sampled: that of a round
    /// shape; of one with edges, half its least extent.
    pub(crate) fn least_radius(&self) -> f64 {
        match self {
            Self::Sphere { radius } | Self::Capsule { radius, .. } => *radius,
            Self::Cuboid { half } => half.min(),
            Self::Cylinder { radius, half_length } => radius.min(*half_length),
            Self::Ellipsoid { half } => half.min() * half.min() / half.max(),
            Self::Cone { radius, height } => 0.5 * radius.min(*height),
            Self::HalfSpace => f64::INFINITY,
            Self::Mesh(mesh) => {
                let (n, cell) = (mesh.grid.dims.map(|n| n - 1), mesh.grid.cell);
                0.5 * cell * f64::from(n.into_iter().min().unwrap_or(1))
            }
            Self::Compound(parts) => {
                parts.iter().map(|part| part.shape.least_radius()).fold(f64::INFINITY, f64::min)
            }
        }
    }
}

/// A rigid triangle mesh made ready for contact.
///
/// A closed mesh is the solid that it encloses; overlapping closed pieces are one body. An open
/// mesh is what its grid says: where that holds an inside, the triangles bound it; where the grid
/// is positive by a constant less than the distance, the mesh is a shell of that half thickness.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "MeshFile"))]
pub struct MeshShape {
    /// Vertices \[m\].
    pub points: Vec<Vec3>,
    /// Triangles over `points`, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Signed distance around the mesh; says what is inside of open meshes and speeds queries up.
    pub grid: DistanceGrid,
    /// Index for queries, made from the above.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) index: MeshIndex,
}

impl MeshShape {
    /// Makes triangles ready for queries. Triangles that name points that are not there are left
    /// out of the index (and refused when a world is built).
    pub fn new(points: Vec<Vec3>, triangles: Vec<[u32; 3]>, grid: DistanceGrid) -> Self {
        let index = MeshIndex::new(&points, &triangles, &grid);
        Self { points, triangles, grid, index }
    }
}

impl PartialEq for MeshShape {
    fn eq(&self, other: &Self) -> bool {
        self.points == other.points && self.triangles == other.triangles && self.grid == other.grid
    }
}

/// A mesh as files hold it.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct MeshFile {
    points: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    grid: DistanceGrid,
}

#[cfg(feature = "serde")]
impl From<MeshFile> for MeshShape {
    fn from(file: MeshFile) -> Self {
        Self::new(file.points, file.triangles, file.grid)
    }
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
