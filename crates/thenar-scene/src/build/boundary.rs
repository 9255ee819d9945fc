//! The boundary of a tetrahedral mesh.

use crate::math::Vec3;
use thenar::model::{EmbeddedSurface, SurfaceVertex};

/// Faces of the positively oriented tetrahedron (0, 1, 2, 3), counter-clockwise from outside.
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// One boundary face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Face {
    /// Nodes, counter-clockwise from outside.
    pub nodes: [u32; 3],
    /// The element it belongs to.
    pub tet: u32,
}

/// The faces that belong to one element only, in the order of elements.
pub fn faces(tets: &[[u32; 4]]) -> Vec<Face> {
    let mut all: Vec<([u32; 3], Face)> = Vec::with_capacity(4 * tets.len());
    for (t, tet) in tets.iter().enumerate() {
        for face in FACES {
            let nodes = face.map(|k| tet[k]);
            let mut key = nodes;
            key.sort_unstable();
            all.push((key, Face { nodes, tet: t as u32 }));
        }
    }
    all.sort();
    let mut single: Vec<Face> = all
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|group| group.len() == 1)
        .map(|group| group[0].1)
        .collect();
    single.sort_by_key(|f| (f.tet, f.nodes));
    single
}

/// The boundary as a surface whose vertices are nodes.
pub fn surface(tets: &[[u32; 4]], faces: &[Face], node_count: usize) -> EmbeddedSurface {
    let mut vertex_of: Vec<Option<u32>> = vec![None; node_count];
    let mut surface = EmbeddedSurface::default();
    for face in faces {
        let triangle = face.nodes.map(|node| {
            *vertex_of[node as usize].get_or_insert_with(|| {
                let corner = tets[face.tet as usize].iter().position(|n| *n == node).unwrap_or(0);
                let mut weights = [0.0; 4];
                weights[corner] = 1.0;
                surface.vertices.push(SurfaceVertex { tet: face.tet, weights });
                surface.vertices.len() as u32 - 1
            })
        });
        surface.triangles.push(triangle);
    }
    surface
}

/// Area times outward normal \[m²\].
pub fn area_vector(x: &[Vec3; 3]) -> Vec3 {
    (x[1] - x[0]).cross(&(x[2] - x[0])) * 0.5
}

/// Six times the signed volume.
pub fn determinant(x: &[Vec3; 4]) -> f64 {
    (x[1] - x[0]).cross(&(x[2] - x[0])).dot(&(x[3] - x[0]))
}
