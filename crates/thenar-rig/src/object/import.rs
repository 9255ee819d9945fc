//! Rigid bodies from triangle meshes of any quality.
//!
//! The method, in order:
//! 1. Vertices closer than 1e-6 of the size are welded and triangles given several times are taken
//!    once; triangles are made to agree on their outside, and closed pieces face outward (cavities
//!    stay). Open pieces keep the side they have: one that faces inward encloses nothing and
//!    becomes a shell (4).
//! 2. The inside is where the generalised winding number is at least ½, on a grid of distances.
//!    Overlapping parts so become one body, and holes are closed by the surface that the
//!    remaining mesh suggests.
//! 3. Mass properties are the exact polyhedral integrals if the mesh is closed and their volume
//!    agrees with that of the grid; otherwise they are integrated over the grid.
//!    Holes with a simple border are closed by fans in the surface that others touch.
//! 4. A mesh with no inside (a sheet, a strip, scattered triangles) becomes a shell: all points
//!    nearer to it than half a stated thickness.

use super::rigid::RigidModel;
use crate::error::positive;
use crate::mesh::{
    Bvh, GridOptions, Inside, MassProperties, Orientation, Topology, WELD, close_holes,
    distance_grid, mass_of_grid, resampled, weld,
};
use crate::size::sensible_size;
use crate::work::phase;
use crate::{RigError, TriMesh};
use std::sync::Arc;
use thenar_core::shape::{DistanceGrid, MeshShape, Shape};
use thenar_core::{Pose, Quat, Vec3};

/// Quantity that decides the mass of a body.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Weight {
    /// Density \[kg/m³\].
    Density(f64),
    /// Mass \[kg\].
    Mass(f64),
}

impl Weight {
    /// The mass of a body of this volume \[m³\].
    pub fn mass(self, volume: f64) -> Result<f64, RigError> {
        match self {
            Self::Density(density) => Ok(positive("density", density)? * volume),
            Self::Mass(mass) => positive("mass", mass),
        }
    }
}

/// Options for turning a mesh into a rigid body.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ImportOptions {
    /// Distance grid.
    pub grid: GridOptions,
    /// Vertices of the surface that others touch; a mesh of more is simplified.
    pub points_max: usize,
    /// Thickness of a mesh without inside \[m\]; `None` is 1/25 of its longest side.
    pub shell_thickness: Option<f64>,
    /// Coulomb friction coefficient.
    pub friction: f64,
}

impl Default for ImportOptions {
    fn default() -> Self {
        let grid = GridOptions::default();
        Self { grid, points_max: 100_000, shell_thickness: None, friction: 0.5 }
    }
}

/// Method by which the inside of a mesh was found.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub enum Interior {
    /// Closed without overlaps: exact integrals.
    Closed,
    /// Open or overlapping: winding number at least ½, integrated over the grid.
    Winding,
    /// None: a shell of this thickness \[m\] around the surface.
    Shell(f64),
}

/// Report on an imported mesh.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct MeshReport {
    /// After welding and orienting.
    pub topology: Topology,
    /// Result of orienting the triangles.
    pub orientation: Orientation,
    /// Vertices merged into others.
    pub welded_vertices: usize,
    /// Triangles dropped as degenerate.
    pub dropped_triangles: usize,
    /// Method by which the inside was found.
    pub interior: Interior,
    /// Volume \[m³\].
    pub volume: f64,
    /// Vertices of the surface that others touch.
    pub contact_points: usize,
    /// Spacing of the distance grid \[m\].
    pub grid_cell: f64,
    /// Values of the distance grid.
    pub grid_values: usize,
}

/// Exact and grid volume agree when they differ by less than this part.
const VOLUME_AGREEMENT: f64 = 0.03;

/// Makes a rigid body of a mesh, by the method of this module's head. The mesh may be open, of
/// many parts, or a sheet.
///
/// # Errors
/// When the mesh is malformed, a single point or line, or outside sensible scale.
pub fn rigid_from_mesh(
    name: &str,
    mesh: &TriMesh,
    weight: Weight,
    options: &ImportOptions,
) -> Result<(RigidModel, MeshReport), RigError> {
    weight.mass(1.0)?;
    mesh.check()?;
    let size = sensible_size(mesh.bounds())?;
    phase("welding the mesh")?;
    let welded = weld(mesh, WELD * size);
    let mut clean = welded.mesh.compacted();
    clean.triangles.retain({
        let positions = clean.positions.clone();
        move |t| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            (b - a).cross(&(c - a)).norm() > 0.0
        }
    });
    drop_repeated(&mut clean.triangles);
    if clean.triangles.is_empty() {
        return Err(RigError::invalid("all triangles of the mesh are without area"));
    }
    let orientation = clean.orient()?;
    phase("looking at the mesh's edges")?;
    let topology = Topology::of(&clean);

    let (interior, grid, body) = inside_of(&clean, &topology, size, options)?;
    let mass = weight.mass(body.mass)?;
    let pose_MB = Pose::new(body.centre, Quat::identity());
    let body_of_mass = body.with_mass(mass);
    let surfaces = [mesh, &clean];
    let model = assemble(name, surfaces, interior, grid, body_of_mass, pose_MB, options)?;
    let Shape::Mesh(shape) = &model.shape else {
        return Err(RigError::invalid("a mesh must have a mesh shape"));
    };
    let report = MeshReport {
        topology,
        orientation,
        welded_vertices: mesh.positions.len() - clean.positions.len(),
        dropped_triangles: mesh.triangles.len() - clean.triangles.len(),
        interior,
        volume: body.mass,
        contact_points: shape.points.len(),
        grid_cell: shape.grid.cell,
        grid_values: shape.grid.values.len(),
    };
    Ok((model, report))
}

/// Keeps the first of triangles that have the same corners in the same sense of rotation.
fn drop_repeated(triangles: &mut Vec<[u32; 3]>) {
    let turned = |t: &[u32; 3]| {
        let first = (0..3).fold(0, |best, k| if t[k] < t[best] { k } else { best });
        [t[first], t[(first + 1) % 3], t[(first + 2) % 3]]
    };
    let mut seen: Vec<([u32; 3], u32)> =
        (0..).zip(&*triangles).map(|(i, t)| (turned(t), i)).collect();
    seen.sort_unstable();
    seen.dedup_by_key(|(corners, _)| *corners);
    let mut keep = vec![false; triangles.len()];
    seen.iter().for_each(|&(_, i)| keep[i as usize] = true);
    let mut keep = keep.into_iter();
    triangles.retain(|_| keep.next().unwrap_or(true));
}

/// Interior, grid and mass properties at density 1.
fn inside_of(
    mesh: &TriMesh,
    topology: &Topology,
    size: f64,
    options: &ImportOptions,
) -> Result<(Interior, DistanceGrid, MassProperties), RigError> {
    phase("sorting the triangles into boxes")?;
    let bvh = Bvh::new(mesh);
    let [min, max] = mesh.bounds();
    // What is as thin as welding reaches encloses nothing.
    let flat = (max - min).min() <= WELD * size;
    if !flat && let Some(found) = enclosed(mesh, &bvh, topology, options)? {
        return Ok(found);
    }
    let thickness = match options.shell_thickness {
        Some(t) => positive("shell_thickness", t)?,
        None => size / 25.0,
    };
    let grid = distance_grid(mesh, &bvh, Inside::Shell(thickness), &options.grid)?;
    let body = mass_of_grid(&grid, 1.0)?;
    Ok((Interior::Shell(thickness), grid, body))
}

/// Interior, grid of distances and mass properties of a mesh that has an inside; none for others.
fn enclosed(
    mesh: &TriMesh,
    bvh: &Bvh,
    topology: &Topology,
    options: &ImportOptions,
) -> Result<Option<(Interior, DistanceGrid, MassProperties)>, RigError> {
    let grid = distance_grid(mesh, bvh, Inside::Winding, &options.grid)?;
    let on_grid = mass_of_grid(&grid, 1.0);
    let exact = MassProperties::of_solid(mesh, 1.0);

    if topology.closed() && topology.oriented() {
        if let (Ok(exact), Ok(on_grid)) = (&exact, &on_grid)
            && (exact.mass / on_grid.mass - 1.0).abs() < VOLUME_AGREEMENT
        {
            return Ok(Some((Interior::Closed, grid, *exact)));
        }
        // Thinner than the grid resolves, but of one piece and sound.
        if let (Ok(exact), 1) = (exact, topology.components) {
            return Ok(Some((Interior::Closed, grid, exact)));
        }
    }
    // A sheet too has half of each crossed cell inside: ask for more. Of parts upon each other only
    // what the grid can tell apart counts.
    let crossed = grid.values.iter().filter(|&&d| f64::from(d.abs()) < 0.5 * grid.cell).count();
    let sheet = 0.75 * mesh.area().min(crossed as f64 * grid.cell.powi(2)) * grid.cell;
    let body = on_grid.ok().filter(|body| deep_values(&grid) > 0 && body.mass > 0.1 * sheet);
    Ok(body.map(|body| (Interior::Winding, grid, body)))
}

/// Number of grid points more than half a cell inside.
fn deep_values(grid: &DistanceGrid) -> usize {
    grid.values.iter().filter(|&&d| f64::from(d) < -0.5 * grid.cell).count()
}

fn assemble(
    name: &str,
    [drawn, clean]: [&TriMesh; 2],
    interior: Interior,
    grid: DistanceGrid,
    body: MassProperties,
    pose_MB: Pose,
    options: &ImportOptions,
) -> Result<RigidModel, RigError> {
    let to_B = |p: &Vec3| p - pose_MB.position;
    // The surface itself: bodies touch it exactly. Only what is too fine is simplified.
    let closed;
    let contact = match interior {
        Interior::Winding => {
            closed = close_holes(clean).0;
            &closed
        }
        _ => clean,
    };
    let coarse;
    let contact = if contact.positions.len() <= options.points_max.max(16) {
        contact
    } else {
        coarse = resampled(contact, f64::INFINITY, options.points_max.max(16))?;
        &coarse
    };
    phase("preparing the surface that others touch")?;
    let shape = MeshShape::new(
        contact.positions.iter().map(to_B).collect(),
        contact.triangles.clone(),
        DistanceGrid { origin: to_B(&grid.origin), ..grid },
    );
    Ok(RigidModel {
        name: name.to_owned(),
        mass: body.mass,
        inertia: body.inertia,
        pose_MB,
        shape: Shape::Mesh(Arc::new(shape)),
        pose_BS: Pose::identity(),
        render: drawn.clone().transformed(&pose_MB.inverse()),
        paint: Vec::new(),
        friction: options.friction,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use thenar_core::random::Random;

    /// A scan without its bottom, as most are: the rest is touched where it is, and the hole is
    /// closed where its border lies flat.
    #[test]
    fn a_ball_cut_open_is_closed_flat_and_exact_elsewhere() {
        let mut mesh = shapes::sphere(0.03, 12);
        let positions = mesh.positions.clone();
        mesh.triangles.retain(|t| t.iter().all(|&v| positions[v as usize].y > -0.02));
        let mesh = mesh.compacted();
        let weight = Weight::Density(1000.0);
        let (model, report) =
            rigid_from_mesh("scan", &mesh, weight, &ImportOptions::default()).unwrap();
        assert_eq!(report.interior, Interior::Winding);
        let Shape::Mesh(shape) = &model.shape else { panic!("a mesh") };
        assert!(
            Topology::of(&TriMesh::new(shape.points.clone(), shape.triangles.clone()).unwrap())
                .closed()
        );
        let at = |p: Vec3| model.shape.distance(&(p - model.pose_MB.position)).value;
        for height in [0.031, 0.05, 0.3] {
            let exact = Bvh::new(&mesh).closest(&(Vec3::y() * height)).distance;
            assert!((at(Vec3::y() * height) - exact).abs() < 1e-9);
        }
        assert!(at(Vec3::zeros()) < -0.015 && at(Vec3::y() * -0.025) > 0.0);
    }

    #[test]
    fn a_triangle_given_again_is_taken_once() {
        let mut triangles = vec![[0, 1, 2], [2, 0, 1], [0, 2, 1], [3, 1, 2], [1, 2, 0], [1, 2, 3]];
        drop_repeated(&mut triangles);
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 1], [3, 1, 2]]);
    }

    /// Copies at one place change nothing, and copies nearby are one body with them.
    #[test]
    fn a_cube_given_a_hundred_times_is_a_cube() {
        let cube = shapes::cuboid(&Vec3::new(0.01, 0.02, 0.03));
        let (mut same, mut shifted) = (cube.clone(), cube.clone());
        for i in 1..100 {
            same.append(&cube);
            if i <= 20 {
                let mut other = cube.clone();
                other.positions.iter_mut().for_each(|p| p.x += 5e-6 * f64::from(i));
                shifted.append(&other);
            }
        }
        let weight = Weight::Density(1000.0);
        let of = |mesh| rigid_from_mesh("x", mesh, weight, &ImportOptions::default()).unwrap();
        let (one, again) = (of(&cube), of(&same));
        assert_eq!((one.1.interior, again.1.interior), (Interior::Closed, Interior::Closed));
        assert!((one.0.mass - again.0.mass).abs() < 1e-15 * one.0.mass);
        assert_eq!(again.1.dropped_triangles, 99 * 12);
        // 20.1 mm instead of 20 along x.
        let (body, report) = of(&shifted);
        assert_eq!(report.interior, Interior::Winding);
        assert!((body.mass / one.0.mass / 1.005 - 1.0).abs() < 0.01, "{}", body.mass);
    }

    /// A hundred thousand triangles across the whole body: refused before anything is spent.
    #[test]
    fn a_thicket_is_refused_with_its_cost() {
        let mut thicket = TriMesh::default();
        let mut random = Random::new(1);
        for t in 0..100_000 {
            thicket.positions.extend((0..3).map(|_| Vec3::from_fn(|_, _| random.unit())));
            thicket.triangles.push([3 * t, 3 * t + 1, 3 * t + 2]);
        }
        let options = ImportOptions::default();
        let error = rigid_from_mesh("x", &thicket, Weight::Mass(1.0), &options).unwrap_err();
        let error = error.to_string();
        assert!(error.contains("would take") && error.contains("simplify the mesh"), "{error}");
    }
}
