//! Binding a surface to the tetrahedra around it.

use super::{Lattice, tet};
use crate::{RigError, TriMesh};
use thenar_core::Vec3;
use thenar_core::model::{EmbeddedSurface, SurfaceVertex};

/// How far to look for inside points, in grid steps, nearest first.
const REACHES: [i64; 4] = [1, 2, 4, 8];

impl Lattice {
    /// Embeds a surface that lies on or near the one this lattice was built around. Each vertex
    /// goes to a tetrahedron of its own piece of the body: that of an inside point behind it.
    ///
    /// # Errors
    /// When a vertex is far from the body.
    pub fn embed(&self, surface: &TriMesh) -> Result<EmbeddedSurface, RigError> {
        let normals = surface.normals();
        let vertices = surface
            .positions
            .iter()
            .zip(&normals)
            .enumerate()
            .map(|(i, (p, normal))| {
                self.embed_point(p, normal).ok_or_else(|| {
                    RigError::invalid(format!("surface vertex {i} lies far from the body"))
                })
            })
            .collect::<Result<_, _>>()?;
        Ok(EmbeddedSurface { vertices, triangles: surface.triangles.clone() })
    }

    /// The tetrahedron that holds `p` best among those of the inside points behind it.
    fn embed_point(&self, p: &Vec3, normal: &Vec3) -> Option<SurfaceVertex> {
        let local = self.rotation.inverse_transform_vector(p);
        let inward = -self.rotation.inverse_transform_vector(normal);
        for reach in REACHES {
            // Only points on the inner side: those across a narrow gap are another part's.
            let behind = self
                .samples
                .near(&local, reach)
                .filter(|&i| (self.samples.position(i as usize) - local).dot(&inward) > 0.0);
            let mut tets: Vec<u32> = behind.map(|i| self.of_sample[i as usize]).collect();
            tets.sort_unstable();
            tets.dedup();
            let best = tets
                .into_iter()
                .map(|tet| {
                    let weights = tet::barycentric(&self.corners(tet as usize), p);
                    SurfaceVertex { tet, weights }
                })
                .max_by(|a, b| smallest(a).total_cmp(&smallest(b)));
            if best.is_some() {
                return best;
            }
        }
        None
    }
}

fn smallest(vertex: &SurfaceVertex) -> f64 {
    vertex.weights.iter().copied().fold(f64::INFINITY, f64::min)
}
