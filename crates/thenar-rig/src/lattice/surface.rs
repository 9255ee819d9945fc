//! Binding a surface to the tetrahedra around it.

use super::{Lattice, tet};
use crate::size::place_in_words;
use crate::{RigError, TriMesh};
use thenar_core::Vec3;
use thenar_core::model::{EmbeddedSurface, SurfaceVertex};

/// Reaches of the search for inside points, in grid steps, nearest first.
const REACHES: [i64; 4] = [1, 2, 4, 8];

impl Lattice {
    /// Embeds a surface that lies on or near the one this lattice was built around. Each vertex
    /// goes to a tetrahedron of its own piece of the body: that of an inside point behind it.
    ///
    /// # Errors
    /// When a vertex is far from the body.
    pub fn embed(&self, surface: &TriMesh) -> Result<EmbeddedSurface, RigError> {
        self.embed_near(surface, |_| None)
    }

    /// [`Lattice::embed`]; `near` names what lies next to a place, for the error.
    ///
    /// # Errors
    /// As there.
    pub fn embed_near(
        &self,
        surface: &TriMesh,
        near: impl Fn(&Vec3) -> Option<String>,
    ) -> Result<EmbeddedSurface, RigError> {
        let normals = surface.normals();
        let vertices = surface
            .positions
            .iter()
            .zip(&normals)
            .enumerate()
            .map(|(i, (p, normal))| self.embed_point(p, normal).ok_or_else(|| far(i, p, near(p))))
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

/// A vertex with no inside behind it, and what helps.
fn far(i: usize, p: &Vec3, near: Option<String>) -> RigError {
    let near = near.map_or_else(String::new, |what| format!(", near {what}"));
    RigError::invalid(format!(
        "the surface has no flesh behind it at {} m{near} (vertex {i}): it is folded, a spike or a sheet there; mend \
         it in a program for meshes, or ask for more tetrahedra (`--tets` or `--detail`)",
        place_in_words(p)
    ))
}

fn smallest(vertex: &SurfaceVertex) -> f64 {
    vertex.weights.iter().copied().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::LatticeOptions;
    use crate::mesh::shapes;
    use thenar_core::Quat;

    #[test]
    fn a_vertex_without_flesh_behind_it_is_told_with_its_place_and_what_lies_there() {
        let mesh = shapes::sphere(0.1, 6);
        let options = LatticeOptions { tets: 100, rotation: Quat::identity() };
        let lattice = Lattice::new(&mesh, &options).unwrap();
        // Turned inside out, a ball has no inside behind any vertex.
        let mut turned = mesh.clone();
        turned.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let near = |p: &Vec3| Some(format!("bone {:.3}", p.norm()));
        let error = lattice.embed_near(&turned, near).err().map(|e| e.to_string()).unwrap();
        let p = mesh.positions[0];
        let place = format!("({:.4}, {:.4}, {:.4}) m, near bone 0.100 (vertex 0)", p.x, p.y, p.z);
        for part in [&place[..], "--tets"] {
            assert!(error.contains(part), "{error}");
        }
        assert!(lattice.embed(&mesh).is_ok());
    }
}
