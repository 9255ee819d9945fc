//! Signed distance to a mesh on a regular grid.

use super::edges::Edges;
use super::mass::{MassProperties, Moments};
use crate::mesh::Bvh;
use crate::work::{STAGE_MAX, Stage};
use crate::{RigError, TriMesh};
use thenar_core::Vec3;
use thenar_core::shape::DistanceGrid;

/// Resolution of a distance grid.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct GridOptions {
    /// Cells along the longest side of the mesh, 4 to 256.
    pub cells: u32,
    /// Cells around the mesh.
    pub padding: u32,
    /// The grid is refined until this many cells span the thinnest side, ...
    pub cells_across_min: u32,
    /// ... as long as it has no more values than this (4 bytes each).
    pub values_max: usize,
}

impl Default for GridOptions {
    fn default() -> Self {
        Self { cells: 56, padding: 3, cells_across_min: 6, values_max: 1_000_000 }
    }
}

/// Definition of a mesh's inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Inside {
    /// Points whose generalised winding number is at least ½.
    Winding,
    /// Points nearer to the surface than half this thickness \[m\].
    Shell(f64),
}

/// The grid of a mesh: distances to its triangles, exact at every grid point. `reach` \[m\] is
/// added around the padding (half the thickness of a shell).
///
/// # Errors
/// The options are out of range, or the triangles overlap so much that the grid would take longer
/// than [`STAGE_MAX`](crate::work::STAGE_MAX).
pub fn distance_grid(
    mesh: &TriMesh,
    bvh: &Bvh,
    inside: Inside,
    options: &GridOptions,
) -> Result<DistanceGrid, RigError> {
    let reach = if let Inside::Shell(thickness) = inside { thickness / 2.0 } else { 0.0 };
    let mut grid = layout(mesh, reach, options)?;
    let mut laying =
        GridFill { bvh, inside, balanced: balanced(mesh), values: Vec::new(), near: 0 };
    let stage = Stage::new(
        "laying a grid of distances",
        grid.dims[2] as usize,
        laying.cost(&grid),
        "its triangles are too large for their number, or overlap too much; simplify the mesh",
    )?;
    laying.values.reserve_exact(grid.dims.iter().map(|&n| n as usize).product());
    for k in 0..grid.dims[2] {
        laying.layer(&grid, k);
        stage.at(k as usize + 1)?;
    }
    grid.values = laying.values.iter().map(|d| (d - reach) as f32).collect();
    Ok(grid)
}

/// True if as many triangles run along each edge one way as the other: the surface then has no
/// border, and its winding number is a whole number that changes only across it.
fn balanced(mesh: &TriMesh) -> bool {
    let edges = Edges::new(&mesh.triangles);
    (0..edges.list.len()).all(|e| {
        let sides = edges.sides(e);
        2 * sides.iter().filter(|side| side.forward).count() == sides.len()
    })
}

/// A grid while it is laid, x fastest.
struct GridFill<'a> {
    bvh: &'a Bvh,
    inside: Inside,
    balanced: bool,
    /// Signed distances so far \[m\].
    values: Vec<f64>,
    /// A triangle near the last point.
    near: u32,
}

/// Points along each axis at which the cost of a grid is looked at beforehand.
const PROBES: u32 = 5;

impl GridFill<'_> {
    /// One layer of constant z.
    fn layer(&mut self, grid: &DistanceGrid, k: u32) {
        for j in 0..grid.dims[1] {
            for i in 0..grid.dims[0] {
                let found = self.bvh.closest_from(&place(grid, [i, j, k]), self.near);
                self.near = found.triangle;
                let inside = match self.inside {
                    Inside::Shell(_) => false,
                    Inside::Winding => self.is_inside(grid, [i, j, k], found.distance),
                };
                self.values.push(if inside { -found.distance } else { found.distance });
            }
        }
    }

    /// Between two points farther from a surface without border than their spacing, the winding
    /// number cannot change.
    fn is_inside(&self, grid: &DistanceGrid, at: [u32; 3], distance: f64) -> bool {
        if self.balanced {
            let mut back = 1;
            for axis in 0..3 {
                if at[axis] > 0 {
                    let before = self.values[self.values.len() - back];
                    if before.abs() + distance > 1.001 * grid.cell {
                        return before < 0.0;
                    }
                }
                back *= grid.dims[axis] as usize;
            }
        }
        self.bvh.contains(&place(grid, at))
    }

    /// Comparisons that the whole grid will take, estimated from a few points; a lower bound where
    /// it exceeds what is allowed.
    fn cost(&self, grid: &DistanceGrid) -> f64 {
        let points: f64 = grid.dims.iter().map(|&n| f64::from(n)).product();
        let each = points / f64::from(PROBES.pow(3));
        let mut sum = 0.0;
        let spread = |k: usize, n: u32| (2 * n + 1) * (grid.dims[k] - 1) / (2 * PROBES);
        for probe in 0..PROBES.pow(3) {
            let at = [probe % PROBES, probe / PROBES % PROBES, probe / PROBES.pow(2)];
            let p = place(grid, std::array::from_fn(|k| spread(k, at[k])));
            let distance = self.bvh.closest(&p).distance;
            sum += each * self.bvh.closest_cost(&p, distance) as f64;
            let skipped = self.balanced && distance > grid.cell;
            if matches!(self.inside, Inside::Winding) && !skipped {
                sum += each * self.bvh.winding_cost(&p) as f64;
            }
            // What is too much already need not be known better.
            if sum > STAGE_MAX {
                break;
            }
        }
        sum
    }
}

/// Position of a grid point.
fn place(grid: &DistanceGrid, at: [u32; 3]) -> Vec3 {
    grid.origin + Vec3::from(at.map(f64::from)) * grid.cell
}

/// Origin, spacing and dimensions of the grid around a mesh.
fn layout(mesh: &TriMesh, reach: f64, options: &GridOptions) -> Result<DistanceGrid, RigError> {
    if !(4..=256).contains(&options.cells) || options.padding > 64 {
        return Err(RigError::invalid(format!(
            "a distance grid needs 4 to 256 cells and a padding of at most 64, not {} and {}",
            options.cells, options.padding
        )));
    }
    let [min, max] = mesh.bounds();
    let (min, max) = (min - Vec3::repeat(reach), max + Vec3::repeat(reach));
    let extent = max - min;
    let longest = extent.max();
    if longest <= 0.0 {
        return Err(RigError::invalid("the mesh is a single point"));
    }
    let dims =
        |cell: f64| [0, 1, 2].map(|k| (extent[k] / cell).ceil() as u32 + 1 + 2 * options.padding);
    let count = |cell: f64| dims(cell).iter().map(|&n| n as usize).product::<usize>();
    let coarse = longest / f64::from(options.cells);
    let fine = extent.min() / f64::from(options.cells_across_min.max(1));
    let mut cell = coarse;
    while cell > fine && count(cell * 0.9) <= options.values_max {
        cell *= 0.9;
    }
    while count(cell) > options.values_max {
        cell *= 1.1;
    }
    let dims = dims(cell);
    let size = Vec3::from_fn(|k, _| f64::from(dims[k] - 1)) * cell;
    let origin = (min + max - size) * 0.5;
    Ok(DistanceGrid { origin, cell, dims, values: Vec::new() })
}

/// Mass properties of the inside of a grid: each grid point stands for a cube, of which the part
/// `½ - d / cell` (between 0 and 1) is inside.
pub fn mass_of_grid(grid: &DistanceGrid, density: f64) -> Result<MassProperties, RigError> {
    let [nx, ny, _] = grid.dims.map(|n| n as usize);
    let size = Vec3::from_fn(|k, _| f64::from(grid.dims[k] - 1)) * grid.cell;
    let middle = size * 0.5;
    let mut moments = Moments::default();
    for (index, &d) in grid.values.iter().enumerate() {
        let part = (0.5 - f64::from(d) / grid.cell).clamp(0.0, 1.0);
        if part > 0.0 {
            let (i, j, k) = (index % nx, index / nx % ny, index / (nx * ny));
            let p = Vec3::new(i as f64, j as f64, k as f64) * grid.cell - middle;
            moments.add_cube(part * grid.cell.powi(3), grid.cell, &p);
        }
    }
    moments.finish(&(grid.origin + middle), density)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn build(mesh: &TriMesh, inside: Inside, options: &GridOptions) -> DistanceGrid {
        distance_grid(mesh, &Bvh::new(mesh), inside, options).unwrap()
    }

    fn for_each(grid: &DistanceGrid, mut f: impl FnMut(Vec3, f64)) {
        let [nx, ny, nz] = grid.dims;
        assert_eq!(grid.values.len(), (nx * ny * nz) as usize);
        for (index, &d) in grid.values.iter().enumerate() {
            let i = index as u32;
            let at = [i % nx, i / nx % ny, i / (nx * ny)].map(f64::from);
            f(grid.origin + Vec3::from(at) * grid.cell, f64::from(d));
        }
    }

    #[test]
    fn a_sphere_and_a_box_have_their_analytic_distance() {
        let options = GridOptions { cells: 24, ..GridOptions::default() };
        let ball = shapes::sphere(0.5, 40);
        for_each(&build(&ball, Inside::Winding, &options), |p, d| {
            assert!((d - (p.norm() - 0.5)).abs() < 4e-4, "{d} at {p}");
        });
        let half = Vec3::new(0.1, 0.2, 0.3);
        for_each(&build(&shapes::cuboid(&half), Inside::Winding, &options), |p, d| {
            let q = p.abs() - half;
            let exact = q.sup(&Vec3::zeros()).norm() + q.max().min(0.0);
            assert!((d - exact).abs() < 1e-6, "{d} {exact} at {p}");
        });
    }

    #[test]
    fn the_mesh_lies_inside_the_grid_and_memory_is_bounded() {
        let plate = shapes::cuboid(&Vec3::new(0.1, 0.1, 0.0005));
        let options = GridOptions { values_max: 60_000, ..GridOptions::default() };
        let grid = build(&plate, Inside::Winding, &options);
        assert!(grid.values.len() <= 60_000);
        let top = grid.origin + Vec3::from(grid.dims.map(|n| f64::from(n - 1))) * grid.cell;
        let [min, max] = plate.bounds();
        for k in 0..3 {
            assert!(grid.origin[k] + 2.9 * grid.cell < min[k] && max[k] < top[k] - 2.9 * grid.cell);
        }
    }

    #[test]
    fn integration_over_the_grid_finds_the_mass_of_overlapping_parts() {
        // Two equal boxes that overlap by half make one of length 3.
        let mut mesh = shapes::cuboid(&Vec3::repeat(1.0));
        let mut other = shapes::cuboid(&Vec3::repeat(1.0));
        other.positions.iter_mut().for_each(|p| p.x += 1.0);
        mesh.append(&other);
        let body =
            mass_of_grid(&build(&mesh, Inside::Winding, &GridOptions::default()), 2.0).unwrap();
        assert!((body.mass / 24.0 - 1.0).abs() < 0.01, "{}", body.mass);
        assert!((body.centre - Vec3::new(0.5, 0.0, 0.0)).norm() < 0.01);
        let expected = [8.0, 13.0, 13.0].map(|x| x * 24.0 / 12.0);
        for k in 0..3 {
            assert!((body.inertia[(k, k)] / expected[k] - 1.0).abs() < 0.02);
        }
    }

    #[test]
    fn a_sheet_becomes_a_shell() {
        let mut square = TriMesh::new(
            vec![Vec3::zeros(), Vec3::x(), Vec3::x() + Vec3::y(), Vec3::y()],
            vec![[0, 1, 2], [0, 2, 3]],
        )
        .unwrap();
        square.positions.iter_mut().for_each(|p| p.z = 5.0);
        let grid = build(&square, Inside::Shell(0.1), &GridOptions::default());
        for_each(&grid, |p, d| {
            let q = Vec3::new((p.x - 0.5).abs() - 0.5, (p.y - 0.5).abs() - 0.5, 0.0);
            let aside = q.sup(&Vec3::zeros());
            let exact = f64::hypot(aside.norm(), p.z - 5.0) - 0.05;
            assert!((d - exact).abs() < 1e-6);
        });
    }
}
