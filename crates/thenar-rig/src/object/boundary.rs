//! The boundary of a set of tetrahedra.

use thenar_core::model::{EmbeddedSurface, SurfaceVertex};

/// Faces of a positively oriented tetrahedron, counter-clockwise from outside.
pub(crate) const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// The faces that belong to one tetrahedron only, as a surface whose vertices are nodes (weight 1,
/// in ascending order of node). Tetrahedra must be positively oriented.
pub fn boundary_surface(tets: &[[u32; 4]]) -> EmbeddedSurface {
    let mut nodes = Vec::new();
    let faces = boundary_faces(tets);
    nodes.extend(faces.iter().flat_map(|&(face, tet)| face.map(|n| (n, tet))));
    nodes.sort_unstable();
    nodes.dedup_by_key(|(n, _)| *n);

    let vertices = nodes
        .iter()
        .map(|&(node, tet)| {
            let weights = tets[tet as usize].map(|n| if n == node { 1.0 } else { 0.0 });
            SurfaceVertex { tet, weights }
        })
        .collect();
    let vertex = |node: u32| nodes.partition_point(|&(n, _)| n < node) as u32;
    let triangles = faces.iter().map(|&(face, _)| face.map(vertex)).collect();
    EmbeddedSurface { vertices, triangles }
}

/// Boundary faces (node indices) and their tetrahedron, in order of tetrahedra.
pub(crate) fn boundary_faces(tets: &[[u32; 4]]) -> Vec<([u32; 3], u32)> {
    let mut all = Vec::with_capacity(4 * tets.len());
    for (t, tet) in tets.iter().enumerate() {
        for face in FACES {
            let face = face.map(|k| tet[k]);
            let mut key = face;
            key.sort_unstable();
            all.push((key, t as u32, face));
        }
    }
    all.sort_unstable();
    let mut faces: Vec<_> = all
        .chunk_by(|a, b| a.0 == b.0)
        .filter_map(|same| match same {
            [(_, t, face)] => Some((*face, *t)),
            _ => None,
        })
        .collect();
    faces.sort_by_key(|&(_, t)| t);
    faces
}
