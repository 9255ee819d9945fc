//! Solids of bones: meshes of shapes, their mass, and capsules along the bones of a plan that has
//! none.

use crate::mesh::{MassProperties, shapes};
use crate::{RigError, TriMesh};
use std::sync::Arc;
use thenar_core::shape::{MeshShape, PlacedShape, Shape};
use thenar_core::{Mat3, Pose, Quat, Vec3};

use super::plan::PlanSolid;

/// Segments of round shapes whose mass is taken from meshes: a circle's area is met within 0.7 %.
const SEGMENTS: u32 = 32;
/// Triangles along an edge of an icosahedron's face, for the same.
const FREQUENCY: u32 = 8;

/// The surface of a shape in its frame S.
///
/// # Errors
/// For half-spaces and compounds, which are no pieces of bones.
pub fn mesh(shape: &Shape) -> Result<TriMesh, RigError> {
    Ok(match shape {
        Shape::Sphere { radius } => shapes::sphere(*radius, FREQUENCY),
        Shape::Capsule { radius, half_length } => shapes::capsule(*radius, *half_length, SEGMENTS),
        Shape::Cuboid { half } => shapes::cuboid(half),
        Shape::Cylinder { radius, half_length: h } => {
            shapes::revolved(&[(*radius, -h), (*radius, *h)], [-h, *h], SEGMENTS)
        }
        Shape::Cone { radius, height } => {
            let base = -0.25 * height;
            shapes::revolved(&[(*radius, base)], [base, 0.75 * height], SEGMENTS)
        }
        Shape::Ellipsoid { half } => {
            let mut ball = shapes::sphere(1.0, FREQUENCY);
            ball.positions.iter_mut().for_each(|p| p.component_mul_assign(half));
            ball
        }
        Shape::Mesh(mesh) => {
            TriMesh { positions: mesh.points.clone(), triangles: mesh.triangles.clone() }
        }
        Shape::HalfSpace | Shape::Compound(_) => {
            return Err(RigError::invalid("a bone is of no plane and no compound"));
        }
    })
}

/// Multiplies all lengths of a shape.
pub fn scale(shape: &mut Shape, by: f64) {
    match shape {
        Shape::Sphere { radius } => *radius *= by,
        Shape::Capsule { radius, half_length } | Shape::Cylinder { radius, half_length } => {
            (*radius, *half_length) = (*radius * by, *half_length * by);
        }
        Shape::Cuboid { half } | Shape::Ellipsoid { half } => *half *= by,
        Shape::Cone { radius, height } => (*radius, *height) = (*radius * by, *height * by),
        // Pieces of plans are neither.
        Shape::HalfSpace | Shape::Compound(_) => {}
        Shape::Mesh(mesh) => *shape = Shape::Mesh(Arc::new(scaled(mesh, by))),
    }
}

fn scaled(mesh: &MeshShape, by: f64) -> MeshShape {
    let mut grid = mesh.grid.clone();
    (grid.origin, grid.cell) = (grid.origin * by, grid.cell * by);
    grid.values.iter_mut().for_each(|value| *value *= by as f32);
    MeshShape::new(mesh.points.iter().map(|p| p * by).collect(), mesh.triangles.clone(), grid)
}

/// Mass, centre and inertia about it of several solids, each of this density, in M. What two have
/// in common counts twice.
///
/// # Errors
/// When they enclose no volume.
pub fn mass(solids: &[PlanSolid], density: f64) -> Result<(f64, Vec3, Mat3), RigError> {
    let each = solids.iter().map(|solid| {
        let mesh = mesh(&solid.shape)?.transformed(&solid.pose_MS);
        MassProperties::of_solid(&mesh, density)
    });
    let each = each.collect::<Result<Vec<_>, _>>()?;
    let mass: f64 = each.iter().map(|m| m.mass).sum();
    let centre = each.iter().map(|m| m.centre * m.mass).sum::<Vec3>() / mass;
    let inertia = each.iter().map(|m| m.inertia + steiner(m.mass, &(m.centre - centre))).sum();
    Ok((mass, centre, inertia))
}

/// Growth of a body's inertia when it is taken about a point `d` off its centre of mass.
fn steiner(mass: f64, d: &Vec3) -> Mat3 {
    (Mat3::identity() * d.norm_squared() - d * d.transpose()) * mass
}

/// A capsule whose segment goes from `a` to `b` in M.
pub fn capsule(a: &Vec3, b: &Vec3, radius: f64) -> PlanSolid {
    let along = b - a;
    let turn = Quat::rotation_between(&Vec3::y(), &along)
        .unwrap_or_else(|| Quat::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI));
    let shape = Shape::Capsule { radius, half_length: 0.5 * along.norm() };
    PlanSolid { shape, pose_MS: Pose::new(0.5 * (a + b), turn) }
}

/// One shape of several pieces, and its frame in M.
pub fn joined(solids: &[PlanSolid]) -> Option<(Shape, Pose)> {
    let (first, rest) = solids.split_first()?;
    if rest.is_empty() {
        return Some((first.shape.clone(), first.pose_MS));
    }
    let middle = solids.iter().map(|s| s.pose_MS.position).sum::<Vec3>() / solids.len() as f64;
    let pose_MS = Pose::new(middle, Quat::identity());
    let part = |solid: &PlanSolid| PlacedShape {
        shape: solid.shape.clone(),
        pose_SP: pose_MS.inverse() * solid.pose_MS,
    };
    Some((Shape::Compound(Arc::new(solids.iter().map(part).collect())), pose_MS))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volumes by formula; those of round shapes from inscribed meshes fall short a little.
    #[test]
    fn shapes_weigh_what_formulas_say() {
        let pi = std::f64::consts::PI;
        let cases = [
            (Shape::Sphere { radius: 0.1 }, 4.0 / 3.0 * pi * 1e-3),
            (Shape::Cuboid { half: Vec3::new(0.1, 0.2, 0.3) }, 8.0 * 6e-3),
            (Shape::Cylinder { radius: 0.1, half_length: 0.2 }, pi * 0.01 * 0.4),
            (Shape::Cone { radius: 0.1, height: 0.3 }, pi * 0.01 * 0.1),
            (Shape::Ellipsoid { half: Vec3::new(0.1, 0.2, 0.3) }, 4.0 / 3.0 * pi * 6e-3),
            (Shape::Capsule { radius: 0.1, half_length: 0.2 }, pi * 0.01 * (0.4 + 0.4 / 3.0)),
        ];
        let at = Pose::new(Vec3::new(0.3, -0.1, 2.0), Quat::from_scaled_axis(Vec3::x() * 0.4));
        for (shape, volume) in cases {
            let what = format!("{shape:?}");
            let (mass, centre, _) = mass(&[PlanSolid { shape, pose_MS: at }], 2.0).unwrap();
            assert!((mass / (2.0 * volume) - 1.0).abs() < 0.015, "{what}: {mass} for {volume}");
            assert!((centre - at.position).norm() < 1e-9, "{what}: {centre:?}");
        }
    }

    /// Two halves of a box weigh as the whole.
    #[test]
    fn parts_add_up() {
        let half = Vec3::new(0.05, 0.1, 0.15);
        let part = |x: f64| PlanSolid {
            shape: Shape::Cuboid { half },
            pose_MS: Pose::new(Vec3::x() * x, Quat::identity()),
        };
        let (whole, centre, inertia) = mass(&[part(-0.05), part(0.05)], 1000.0).unwrap();
        let edges = Vec3::new(0.2, 0.2, 0.3);
        let exact = 1000.0 * edges.product();
        let squares = edges.component_mul(&edges);
        let diagonal = (Vec3::repeat(squares.sum()) - squares) * (exact / 12.0);
        assert!((whole - exact).abs() < 1e-9 * exact && centre.norm() < 1e-12);
        assert!((inertia - Mat3::from_diagonal(&diagonal)).norm() < 1e-9 * diagonal.norm());
    }

    #[test]
    fn a_capsule_ends_where_asked() {
        for (a, b) in [(Vec3::zeros(), Vec3::x()), (Vec3::y(), -Vec3::y()), (Vec3::z(), Vec3::x())]
        {
            let solid = capsule(&a, &b, 0.1);
            let Shape::Capsule { half_length, .. } = solid.shape else { panic!() };
            let ends = [-1.0, 1.0].map(|s| solid.pose_MS.point(&(Vec3::y() * (s * half_length))));
            assert!((ends[0] - a).norm() < 1e-12 && (ends[1] - b).norm() < 1e-12, "{ends:?}");
        }
    }
}
