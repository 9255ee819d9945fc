//! One surface of several meshes.

use crate::RigError;
use crate::TriMesh;
use crate::embed::check_closed;
use crate::mesh::level::Field;
use crate::mesh::{Bvh, GridOptions, Inside, components, distance_grid, weld_near};
use crate::size::sensible_size;
use crate::work::phase;
use thenar_core::Vec3;

/// Cells of the grid along the longest side of several skins: 9 mm of a person, 1 mm of a hand.
const CELLS: u32 = 200;
/// Values of the grid at most.
const VALUES_MAX: usize = 5_000_000;

/// Body that several meshes enclose together.
pub(crate) struct United {
    /// Closed surface of one piece, its outside out.
    pub mesh: TriMesh,
    /// Separate pieces that were left out.
    pub left_out: usize,
    /// Edge of the cells of the grid that it was found on, in the unit of the meshes.
    pub cell: f64,
}

/// The body that several meshes enclose together, whether they are closed or not: where their
/// winding number is at least a half. A sleeve around an arm that ends in it so becomes one with
/// the arm.
///
/// # Errors
/// When they enclose nothing.
pub(crate) fn united(mesh: &TriMesh) -> Result<United, RigError> {
    mesh.check()?;
    sensible_size(mesh.bounds())?;
    phase("joining the meshes of the skin")?;
    let mut welded = weld_near(mesh);
    if welded.triangles.is_empty() {
        return Err(RigError::invalid("all triangles of the skin are without extent"));
    }
    welded.orient()?;
    let options =
        GridOptions { cells: CELLS, padding: 2, cells_across_min: 1, values_max: VALUES_MAX };
    let grid = distance_grid(&welded, &Bvh::new(&welded), Inside::Winding, &options)?;
    // A sheet has an inside too, of no thickness.
    let deep = grid.values.iter().any(|&d| f64::from(d) < -grid.cell);
    let cell = grid.cell;
    let field = Field {
        origin: grid.origin,
        spacing: grid.cell,
        dims: grid.dims.map(|n| n as usize),
        values: grid.values.into_iter().map(f64::from).collect(),
    };
    let surface = field.surface(0.0);
    let (of_vertex, count) = components(&surface);
    let body = largest_piece(&surface, &of_vertex, count);
    if !deep || body.triangles.is_empty() {
        return Err(RigError::invalid(
            "the meshes of the skin enclose nothing together: they are sheets, or thinner than a hundredth of their size",
        ));
    }
    check_closed("what the meshes of the skin enclose", &body)?;
    Ok(United { mesh: body, left_out: count.saturating_sub(1), cell })
}

/// The piece of greatest extent; of equals the first.
pub(crate) fn largest_piece(mesh: &TriMesh, of_vertex: &[u32], count: usize) -> TriMesh {
    let mut bounds = vec![[Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)]; count];
    for &v in mesh.triangles.iter().flatten() {
        let p = &mesh.positions[v as usize];
        let [low, high] = &mut bounds[of_vertex[v as usize] as usize];
        (*low, *high) = (low.inf(p), high.sup(p));
    }
    let size = |k: usize| (bounds[k][1] - bounds[k][0]).norm();
    let largest = (0..count).reduce(|a, b| if size(b) > size(a) { b } else { a });
    let of_it = |t: &&[u32; 3]| Some(of_vertex[t[0] as usize] as usize) == largest;
    let triangles = mesh.triangles.iter().filter(of_it).copied().collect();
    TriMesh { positions: mesh.positions.clone(), triangles }.compacted()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    /// Two boxes, the lid of each gone where it lies in the other, enclose what their union does: 3
    /// of length by 1 by 1; a ball apart is left out, and one inside changes nothing.
    #[test]
    fn open_boxes_that_cross_are_one_body() {
        let half = Vec3::new(1.0, 0.5, 0.5);
        let without_lid = |x: f64, lid: f64| {
            let mut cuboid = shapes::cuboid(&half);
            let places = cuboid.positions.clone();
            cuboid
                .triangles
                .retain(|t| !t.iter().all(|&v| (places[v as usize].x - lid).abs() < 1e-9));
            cuboid.transformed(&thenar_core::Pose::translation(x, 0.0, 0.0))
        };
        let mut mesh = without_lid(-0.5, 1.0);
        mesh.append(&without_lid(0.5, -1.0));
        let ball = |x: f64| {
            shapes::sphere(0.2, 4).transformed(&thenar_core::Pose::translation(x, 0.0, 0.0))
        };
        mesh.append(&ball(0.0));
        mesh.append(&ball(2.5));
        let skin = united(&mesh).unwrap();
        assert_eq!(skin.left_out, 1);
        assert!((skin.cell - 4.2 / 200.0).abs() < 1e-3, "{}", skin.cell);
        // Edges are cut off by less than a cell of 4.2/200.
        let volume = skin.mesh.volume();
        assert!((volume / 3.0 - 1.0).abs() < 0.01, "{volume}");
        let [low, high] = skin.mesh.bounds();
        assert!((low.x + 1.5).abs() < 0.03 && (high.x - 1.5).abs() < 0.03, "{low} {high}");
    }

    #[test]
    fn sheets_enclose_nothing() {
        let mut sheet = shapes::cuboid(&Vec3::repeat(0.5));
        sheet.triangles.truncate(2);
        let error = united(&sheet.compacted()).err().unwrap().to_string();
        assert!(error.contains("enclose nothing"), "{error}");
    }
}
