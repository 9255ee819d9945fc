//! Triangle meshes: topology, distance, simplification, refinement, mass.

mod bvh;
mod closest;
mod decimate;
mod edges;
mod grid;
mod holes;
pub(crate) mod level;
mod load;
mod mass;
mod nesting;
mod obj;
mod off;
mod orient;
mod ply;
mod polygon;
mod quadric;
mod sample;
pub mod shapes;
mod stl;
mod subdivide;
mod topology;
mod weld;
mod winding;

pub use bvh::Bvh;
pub use closest::{Closest, Feature, closest_on_triangle};
pub use decimate::{decimate, decimate_within};
pub use grid::{GridOptions, Inside, distance_grid, mass_of_grid};
pub use holes::{Hole, close_holes};
pub use load::{load_mesh, read_file};
pub use mass::MassProperties;
pub use obj::read_obj;
pub use off::read_off;
pub use orient::Orientation;
pub use ply::read_ply;
pub use sample::resampled;
pub use stl::{read_stl, write_stl};
pub use subdivide::{Refined, subdivide, subdivide_to};
pub use topology::Topology;
pub(crate) use topology::{components, find, join};
pub(crate) use weld::{WELD, weld_near};
pub use weld::{Welded, weld};

use crate::RigError;
use thenar_core::{Pose, Vec3};

/// Largest admissible coordinate \[m\]; keeps every product of coordinates finite.
pub(crate) const COORDINATE_MAX: f64 = 1e6;

/// Most triangles and vertices of a file's mesh: building from them stays below a gigabyte.
const TRIANGLES_MAX: usize = 1_000_000;
const VERTICES_MAX: usize = 3 * TRIANGLES_MAX;

/// A triangle mesh. Triangles are counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TriMesh {
    /// Vertex positions \[m\].
    pub positions: Vec<Vec3>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl TriMesh {
    /// A mesh that passes [`TriMesh::check`].
    pub fn new(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self, RigError> {
        let mesh = Self { positions, triangles };
        mesh.check()?;
        Ok(mesh)
    }

    /// Errs unless there is a triangle, every number is finite and within 1e6 m, and every index in
    /// range.
    pub fn check(&self) -> Result<(), RigError> {
        if self.triangles.is_empty() {
            return Err(RigError::invalid("the mesh has no triangles"));
        }
        if self.positions.len() >= u32::MAX as usize {
            return Err(RigError::invalid("the mesh has more vertices than an index can hold"));
        }
        if let Some(i) = self.positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(RigError::invalid(format!("vertex {i} is not finite")));
        }
        if let Some(i) = self.positions.iter().position(|p| p.amax() > COORDINATE_MAX) {
            return Err(RigError::invalid(format!(
                "vertex {i} lies beyond {COORDINATE_MAX:e} m (is the scale right?)"
            )));
        }
        let count = self.positions.len();
        for (t, triangle) in self.triangles.iter().enumerate() {
            if let Some(v) = triangle.iter().find(|&&v| v as usize >= count) {
                return Err(RigError::invalid(format!(
                    "triangle {t} names vertex {v}, but there are only {count}"
                )));
            }
        }
        Ok(())
    }

    /// Errs when a file holds more than a body can be built from in a sensible time.
    pub(crate) fn check_count(&self) -> Result<(), RigError> {
        let (triangles, vertices) = (self.triangles.len(), self.positions.len());
        if triangles > TRIANGLES_MAX || vertices > VERTICES_MAX {
            return Err(RigError::invalid(format!(
                "the mesh has {triangles} triangles and {vertices} vertices or more, at most \
                 {TRIANGLES_MAX} and {VERTICES_MAX} can be used: simplify it"
            )));
        }
        Ok(())
    }

    /// Corner positions of triangle `t`.
    pub fn corners(&self, t: usize) -> [Vec3; 3] {
        self.triangles[t].map(|v| self.positions[v as usize])
    }

    /// Area times unit normal of triangle `t` \[m²\].
    pub fn area_vector(&self, t: usize) -> Vec3 {
        let [a, b, c] = self.corners(t);
        (b - a).cross(&(c - a)) * 0.5
    }

    /// Surface area \[m²\].
    pub fn area(&self) -> f64 {
        (0..self.triangles.len()).map(|t| self.area_vector(t).norm()).sum()
    }

    /// Enclosed volume \[m³\], by the divergence theorem; means something for closed meshes only.
    pub fn volume(&self) -> f64 {
        // Relative to a vertex, so that a mesh far from the origin loses no digits.
        let Some(&o) = self.positions.first() else { return 0.0 };
        (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t).map(|p| p - o);
                a.dot(&b.cross(&c)) / 6.0
            })
            .sum()
    }

    /// Smallest and largest coordinates of the vertices that triangles use.
    pub fn bounds(&self) -> [Vec3; 2] {
        let mut bounds = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
        for &v in self.triangles.iter().flatten() {
            let p = &self.positions[v as usize];
            bounds = [bounds[0].inf(p), bounds[1].sup(p)];
        }
        bounds
    }

    /// Vertex normals, weighted by area; zero for unused vertices.
    pub fn normals(&self) -> Vec<Vec3> {
        let mut normals = vec![Vec3::zeros(); self.positions.len()];
        for (t, triangle) in self.triangles.iter().enumerate() {
            let n = self.area_vector(t);
            for &v in triangle {
                normals[v as usize] += n;
            }
        }
        for n in &mut normals {
            let length = n.norm();
            if length > 0.0 {
                *n /= length;
            }
        }
        normals
    }

    /// The mesh with every position `scale` times itself.
    pub fn scaled(mut self, scale: f64) -> Self {
        self.positions.iter_mut().for_each(|p| *p *= scale);
        self
    }

    /// The mesh with every point of B moved to A by `pose_AB`.
    pub fn transformed(mut self, pose_AB: &Pose) -> Self {
        self.positions.iter_mut().for_each(|p| *p = pose_AB.point(p));
        self
    }

    /// Adds a copy of another mesh.
    pub fn append(&mut self, other: &TriMesh) {
        let offset = self.positions.len() as u32;
        self.positions.extend_from_slice(&other.positions);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + offset)));
    }

    /// Drops vertices that no triangle uses; the rest keep their order.
    pub fn compacted(self) -> Self {
        let mut map = vec![u32::MAX; self.positions.len()];
        for &v in self.triangles.iter().flatten() {
            map[v as usize] = 0;
        }
        let mut positions = Vec::new();
        for (v, p) in self.positions.iter().enumerate() {
            if map[v] == 0 {
                map[v] = positions.len() as u32;
                positions.push(*p);
            }
        }
        let triangles = self.triangles.iter().map(|t| t.map(|v| map[v as usize])).collect();
        Self { positions, triangles }
    }
}
