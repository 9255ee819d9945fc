//! Merging of vertices that lie at the same place.

use crate::TriMesh;
use std::collections::HashMap;
use thenar_core::Vec3;

/// Vertices closer than this part of the mesh's size are one.
pub(crate) const WELD: f64 = 1e-6;

/// A welded mesh.
#[derive(Clone, Debug)]
pub struct Welded {
    /// The mesh; triangles that lost a corner are gone.
    pub mesh: TriMesh,
    /// New index of each old vertex.
    pub map: Vec<u32>,
    /// Number of triangles that were dropped.
    pub dropped: usize,
}

/// Merges every vertex into the first one within `tolerance` \[m\] of it (zero: equal positions
/// only). Vertices keep their order and the position of the first. Triangles left with two equal
/// corners are dropped. Positions must be finite.
pub fn weld(mesh: &TriMesh, tolerance: f64) -> Welded {
    let mut kept = VertexGrid::new(tolerance);
    let map: Vec<u32> = mesh.positions.iter().map(|p| kept.index_of(p)).collect();

    let mut triangles: Vec<[u32; 3]> =
        mesh.triangles.iter().map(|t| t.map(|v| map[v as usize])).collect();
    triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
    let dropped = mesh.triangles.len() - triangles.len();
    Welded { mesh: TriMesh { positions: kept.positions, triangles }, map, dropped }
}

/// The mesh with vertices merged that lie as near to each other as [`WELD`] says, and without those
/// that no triangle uses.
pub(crate) fn weld_near(mesh: &TriMesh) -> TriMesh {
    let [low, high] = mesh.bounds();
    weld(mesh, WELD * (high - low).norm()).mesh.compacted()
}

/// The vertices that stay, with a hash grid over them of cell size `tolerance`.
struct VertexGrid {
    tolerance: f64,
    positions: Vec<Vec3>,
    cells: HashMap<[i64; 3], Vec<u32>>,
}

impl VertexGrid {
    fn new(tolerance: f64) -> Self {
        Self { tolerance: tolerance.max(0.0), positions: Vec::new(), cells: HashMap::new() }
    }

    fn index_of(&mut self, p: &Vec3) -> u32 {
        let key = self.cell(p);
        if let Some(i) = self.near(p, key) {
            return i;
        }
        let i = self.positions.len() as u32;
        self.positions.push(*p);
        self.cells.entry(key).or_default().push(i);
        i
    }

    /// Grid cell, or for zero tolerance the number itself (with -0 as 0).
    fn cell(&self, p: &Vec3) -> [i64; 3] {
        let cell = |x: f64| match self.tolerance {
            0.0 => (x + 0.0).to_bits() as i64,
            tolerance => (x / tolerance).floor() as i64,
        };
        [cell(p.x), cell(p.y), cell(p.z)]
    }

    /// The first kept vertex within tolerance.
    fn near(&self, p: &Vec3, key: [i64; 3]) -> Option<u32> {
        if self.tolerance == 0.0 {
            return self.cells.get(&key).map(|list| list[0]);
        }
        let mut found: Option<u32> = None;
        for offset in 0..27 {
            let d = [offset % 3 - 1, offset / 3 % 3 - 1, offset / 9 - 1];
            let neighbour = std::array::from_fn(|k| key[k].saturating_add(d[k]));
            for &i in self.cells.get(&neighbour).into_iter().flatten() {
                let close = (self.positions[i as usize] - p).norm() <= self.tolerance;
                if close && found.is_none_or(|f| i < f) {
                    found = Some(i);
                }
            }
        }
        found
    }
}
