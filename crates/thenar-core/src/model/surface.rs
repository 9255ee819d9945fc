//! Surfaces embedded in a tetrahedral mesh.

use crate::math::Vec3;

/// A surface vertex: a barycentric combination of one tetrahedron's nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SurfaceVertex {
    /// Tetrahedron index.
    pub tet: u32,
    /// Barycentric weights of its four nodes, of sum 1 (slightly negative outside).
    pub weights: [f64; 4],
}

/// A triangle mesh that moves with the tetrahedra around it. Triangles are
/// counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EmbeddedSurface {
    /// Vertices of the surface.
    pub vertices: Vec<SurfaceVertex>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl EmbeddedSurface {
    /// Vertex positions for these node positions; `out` has one entry per vertex.
    pub fn positions(&self, tets: &[[u32; 4]], nodes: &[Vec3], out: &mut [Vec3]) {
        for (vertex, out) in self.vertices.iter().zip(out) {
            let tet = tets[vertex.tet as usize];
            *out = (0..4).map(|k| nodes[tet[k] as usize] * vertex.weights[k]).sum();
        }
    }
}
