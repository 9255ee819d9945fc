//! The inside of a closed surface as a fine grid of points, with the links that do not cross it.
//!
//! Rays along x, y and z through the grid points are cut with the triangles. The winding along a
//! ray says which points are inside; a cut between two neighbours says that they are not linked,
//! however thin the gap between two parts of the surface is there.

use crate::work::Stage;
use crate::{RigError, TriMesh};
use thenar_core::Vec3;

/// Grid points inside a surface.
pub(super) struct Samples {
    /// Place of point (0,0,0) \[m\].
    pub origin: Vec3,
    /// Spacing \[m\].
    pub spacing: f64,
    /// Number of points along x, y, z.
    pub dims: [usize; 3],
    /// Per grid point (x fastest): index into `cells`, or `u32::MAX` outside.
    index: Vec<u32>,
    /// Grid coordinates of each inside point.
    pub cells: Vec<[u32; 3]>,
    /// Per inside point: whether it is linked to its next neighbour along x, y, z.
    links: Vec<[bool; 3]>,
}

/// A surface may not be sampled with more grid points than this.
const POINTS_MAX: f64 = 4e7;

impl Samples {
    /// Samples the inside of a closed, outward-facing mesh every `spacing` metres.
    pub fn new(mesh: &TriMesh, spacing: f64) -> Result<Self, RigError> {
        let [low, high] = mesh.bounds();
        let extent = (high - low) / spacing;
        let points = (extent.x + 2.0) * (extent.y + 2.0) * (extent.z + 2.0);
        if points.is_nan() || points > POINTS_MAX {
            return Err(RigError::invalid(
                "the mesh is too large for its volume to be filled with elements",
            ));
        }
        let dims: [usize; 3] = std::array::from_fn(|d| extent[d].floor() as usize + 1);
        // Centred on the mesh, so that a symmetric body is sampled symmetrically; the small uneven
        // offset keeps rays off vertices that lie on round coordinates.
        let half = Vec3::from(dims.map(|n| (n as f64 - 1.0) / 2.0)) * spacing;
        let offset = Vec3::new(1.17e-4, 1.31e-4, 1.47e-4) * spacing;
        let origin = (low + high) / 2.0 - half + offset;
        let rays = Stage::new(
            "sampling the inside of the mesh",
            3,
            mesh_crossings(mesh, spacing),
            "its triangles are too large for their number, or overlap too much; simplify the mesh",
        )?;
        let mut grid = RayGrid { origin, spacing, dims, inside: Vec::new(), cut: Vec::new() };
        grid.cast(mesh, &rays)?;
        let samples = grid.into_samples();
        if samples.cells.is_empty() {
            return Err(RigError::invalid("the mesh encloses no volume"));
        }
        Ok(samples)
    }

    /// Place of inside point `i`.
    pub fn position(&self, i: usize) -> Vec3 {
        self.origin + Vec3::from(self.cells[i].map(f64::from)) * self.spacing
    }

    /// The inside neighbour of point `i` along +x, +y or +z that it is linked to.
    pub fn next(&self, i: usize, axis: usize) -> Option<u32> {
        if !self.links[i][axis] {
            return None;
        }
        let mut cell = self.cells[i].map(|c| c as usize);
        cell[axis] += 1;
        self.at(cell)
    }

    /// The inside neighbour of point `i` along -x, -y or -z that is linked to it.
    pub fn previous(&self, i: usize, axis: usize) -> Option<u32> {
        let mut cell = self.cells[i].map(|c| c as usize);
        cell[axis] = cell[axis].checked_sub(1)?;
        self.at(cell).filter(|&before| self.links[before as usize][axis])
    }

    /// Inside points within `reach` grid steps of `p` along each axis.
    pub fn near(&self, p: &Vec3, reach: i64) -> impl Iterator<Item = u32> + '_ {
        let centre = ((p - self.origin) / self.spacing).map(|x| x.round() as i64);
        let range = move |d: usize| {
            let last = self.dims[d] as i64 - 1;
            (centre[d] - reach).clamp(0, last)..=(centre[d] + reach).clamp(0, last)
        };
        range(2).flat_map(move |z| {
            range(1).flat_map(move |y| {
                range(0).filter_map(move |x| self.at([x as usize, y as usize, z as usize]))
            })
        })
    }

    fn at(&self, [x, y, z]: [usize; 3]) -> Option<u32> {
        let [nx, ny, nz] = self.dims;
        if x >= nx || y >= ny || z >= nz {
            return None;
        }
        Some(self.index[(z * ny + y) * nx + x]).filter(|&i| i != u32::MAX)
    }
}

/// Memory of the crossings of rays along one axis is kept below 320 MB: 16 bytes each.
const CROSSINGS_MAX: f64 = 2e7;

/// Rays that the triangles' boxes meet, along three axes; infinite where their crossings would take
/// too much memory.
fn mesh_crossings(mesh: &TriMesh, spacing: f64) -> f64 {
    let mut sums = [0.0; 3];
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t);
        let steps = (a.sup(&b).sup(&c) - a.inf(&b).inf(&c)) / spacing + Vec3::repeat(1.0);
        for axis in 0..3 {
            sums[axis] += steps[(axis + 1) % 3] * steps[(axis + 2) % 3];
        }
    }
    // A triangle covers half of its box.
    let most = sums.iter().copied().fold(0.0, f64::max) / 2.0;
    if most > CROSSINGS_MAX { f64::INFINITY } else { sums.iter().sum() }
}

/// The grid while rays are cast.
struct RayGrid {
    origin: Vec3,
    spacing: f64,
    dims: [usize; 3],
    inside: Vec<bool>,
    /// Per point: a cut between it and the next along x, y, z.
    cut: Vec<[bool; 3]>,
}

impl RayGrid {
    fn cast(&mut self, mesh: &TriMesh, stage: &Stage) -> Result<(), RigError> {
        let count = self.dims.iter().product();
        self.inside = vec![false; count];
        self.cut = vec![[false; 3]; count];
        // In grid coordinates, so that point (i, j, k) lies at (i, j, k).
        let positions: Vec<Vec3> =
            mesh.positions.iter().map(|p| (p - self.origin) / self.spacing).collect();
        for axis in 0..3 {
            let rays = cast_rays(&positions, &mesh.triangles, axis, self.dims);
            for (ray, mut hits) in rays.into_iter().enumerate() {
                hits.sort_by(|a, b| a.0.total_cmp(&b.0));
                self.mark(axis, ray, &hits);
            }
            stage.at(axis + 1)?;
        }
        Ok(())
    }

    /// Enters one ray's hits (depth, +1 entering or -1 leaving).
    fn mark(&mut self, axis: usize, ray: usize, hits: &[(f64, i32)]) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut cell = [0; 3];
        cell[u] = ray % self.dims[u];
        cell[v] = ray / self.dims[u];
        let [nx, ny, _] = self.dims;
        let mut at = |i: usize| {
            cell[axis] = i;
            (cell[2] * ny + cell[1]) * nx + cell[0]
        };
        for hit in hits {
            let before = hit.0.floor();
            if before >= 0.0 && (before as usize) < self.dims[axis] {
                self.cut[at(before as usize)][axis] = true;
            }
        }
        if axis == 0 && hits.iter().map(|h| h.1).sum::<i32>() == 0 {
            let mut winding = 0;
            let mut next = hits.iter().peekable();
            for i in 0..self.dims[0] {
                while let Some(hit) = next.next_if(|h| h.0 <= i as f64) {
                    winding += hit.1;
                }
                self.inside[at(i)] = winding > 0;
            }
        }
    }

    fn into_samples(self) -> Samples {
        let mut index = vec![u32::MAX; self.inside.len()];
        let (mut cells, mut links) = (Vec::new(), Vec::new());
        let [nx, ny, _] = self.dims;
        for (i, _) in self.inside.iter().enumerate().filter(|(_, inside)| **inside) {
            index[i] = cells.len() as u32;
            cells.push([(i % nx) as u32, (i / nx % ny) as u32, (i / nx / ny) as u32]);
            links.push(self.cut[i].map(|cut| !cut));
        }
        let Self { origin, spacing, dims, .. } = self;
        Samples { origin, spacing, dims, index, cells, links }
    }
}

/// Depth along the ray and direction of crossing of every hit, for each ray along `axis`.
/// Ray (a, b) through the next two coordinates has index `a + b * dims[axis + 1]`.
fn cast_rays(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    axis: usize,
    dims: [usize; 3],
) -> Vec<Vec<(f64, i32)>> {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut rays = vec![Vec::new(); dims[u] * dims[v]];
    for triangle in triangles {
        let p = triangle.map(|i| positions[i as usize]);
        let span = |d: usize| {
            let low = p[0][d].min(p[1][d]).min(p[2][d]).ceil().max(0.0) as usize;
            let high = p[0][d].max(p[1][d]).max(p[2][d]).floor().max(-1.0) as i64;
            (low as i64)..=high.min(dims[d] as i64 - 1)
        };
        for b in span(v) {
            for a in span(u) {
                if let Some(hit) = hit(triangle, &p, axis, a as f64, b as f64) {
                    rays[a as usize + b as usize * dims[u]].push(hit);
                }
            }
        }
    }
    rays
}

/// Returns where the ray through (a, b) meets a triangle. Side tests use each edge's vertices in
/// index order, so that two triangles that share an edge agree exactly on which of them is hit.
fn hit(triangle: &[u32; 3], p: &[Vec3; 3], axis: usize, a: f64, b: f64) -> Option<(f64, i32)> {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut area = [0.0; 3];
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let swap = triangle[i] > triangle[j];
        let (s, t) = if swap { (&p[j], &p[i]) } else { (&p[i], &p[j]) };
        let side = (t[u] - s[u]) * (b - s[v]) - (t[v] - s[v]) * (a - s[u]);
        let side = if side == 0.0 { f64::MIN_POSITIVE } else { side };
        area[k] = if swap { -side } else { side };
    }
    let left = area.iter().all(|&x| x > 0.0);
    if !left && !area.iter().all(|&x| x < 0.0) {
        return None;
    }
    let sum = area[0] + area[1] + area[2];
    let depth = (0..3).map(|k| area[k] / sum * p[k][axis]).sum();
    // Counter-clockwise seen from +axis: the outward normal points up the ray, which leaves.
    Some((depth, if left { -1 } else { 1 }))
}
