//! The surface of a level of a field on a grid.
//!
//! Cut from cubes, each of six tetrahedra about its diagonal: of these, whatever the values at
//! their corners, the pieces of surface fit together into a closed one (Bloomenthal,
//! *Polygonization of implicit surfaces*, 1988).

use crate::TriMesh;
use std::collections::HashMap;
use thenar_core::Vec3;

/// Corners of the surface lie at least this part of a grid edge off the ends, so that no triangle
/// is a sliver.
pub(crate) const INSET: f64 = 0.1;

/// Six tetrahedra of a cube around its diagonal from corner 0 to corner 7; bit k of a corner's
/// number is its place along axis k.
const TETS: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];

/// Values on a grid, x fastest.
pub(crate) struct Field {
    pub origin: Vec3,
    pub spacing: f64,
    pub dims: [usize; 3],
    pub values: Vec<f64>,
}

impl Field {
    pub fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.dims[1] + j) * self.dims[0] + i
    }

    pub fn point(&self, at: [usize; 3]) -> Vec3 {
        self.origin + Vec3::from(at.map(|i| i as f64)) * self.spacing
    }

    /// The surface where the value is `level`, lower values inside.
    pub fn surface(&self, level: f64) -> TriMesh {
        let mut cut = IsosurfaceBuilder {
            grid: self,
            level,
            vertices: HashMap::new(),
            mesh: TriMesh::default(),
        };
        let [nx, ny, nz] = self.dims.map(|n| n - 1);
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    cut.cube([i, j, k]);
                }
            }
        }
        cut.mesh
    }
}

/// A surface that is being cut from a grid.
struct IsosurfaceBuilder<'a> {
    grid: &'a Field,
    level: f64,
    /// Vertex on each grid edge, by the edge's ends in ascending order.
    vertices: HashMap<[usize; 2], u32>,
    mesh: TriMesh,
}

impl IsosurfaceBuilder<'_> {
    fn cube(&mut self, at: [usize; 3]) {
        let corner = |c: usize| [0, 1, 2].map(|k| at[k] + (c >> k & 1));
        let corners: [[usize; 3]; 8] = std::array::from_fn(corner);
        let inside = corners.map(|c| self.grid.values[self.grid.index(c)] < self.level);
        if inside == [true; 8] || inside == [false; 8] {
            return;
        }
        for tet in TETS {
            let (within, without): (Vec<usize>, Vec<usize>) =
                tet.into_iter().partition(|&c| inside[c]);
            match (&within[..], &without[..]) {
                (&[a], &[b, c, d]) | (&[b, c, d], &[a]) => {
                    let triangle = [b, c, d].map(|other| self.vertex(corners[a], corners[other]));
                    self.face(triangle, corners[within[0]], corners[without[0]]);
                }
                (&[a, b], &[c, d]) => {
                    let ring = [(a, c), (a, d), (b, d), (b, c)];
                    let [p, q, r, s] = ring.map(|(i, o)| self.vertex(corners[i], corners[o]));
                    self.face([p, q, r], corners[a], corners[c]);
                    self.face([p, r, s], corners[a], corners[c]);
                }
                _ => {}
            }
        }
    }

    /// The vertex on a grid edge that the surface crosses.
    fn vertex(&mut self, a: [usize; 3], b: [usize; 3]) -> u32 {
        let [m, n] = [a, b].map(|c| self.grid.index(c));
        let (a, b, m, n) = if m < n { (a, b, m, n) } else { (b, a, n, m) };
        let next = self.mesh.positions.len() as u32;
        *self.vertices.entry([m, n]).or_insert_with(|| {
            let (from, to) = (self.grid.values[m], self.grid.values[n]);
            let part = ((self.level - from) / (to - from)).clamp(INSET, 1.0 - INSET);
            self.mesh.positions.push(self.grid.point(a).lerp(&self.grid.point(b), part));
            next
        })
    }

    /// Adds a triangle, turned so that it faces from `inside` to `outside`, two corners of its
    /// tetrahedron.
    fn face(&mut self, [a, b, c]: [u32; 3], inside: [usize; 3], outside: [usize; 3]) {
        let p = [a, b, c].map(|v| self.mesh.positions[v as usize]);
        let normal = (p[1] - p[0]).cross(&(p[2] - p[0]));
        let within = normal.dot(&(self.grid.point(inside) - p[0]));
        let without = normal.dot(&(self.grid.point(outside) - p[0]));
        let turned = without < within;
        self.mesh.triangles.push(if turned { [a, c, b] } else { [a, b, c] });
    }
}
