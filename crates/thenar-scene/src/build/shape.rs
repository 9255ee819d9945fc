//! Contact shapes of rigid bodies.

use super::Files;
use super::{assets, inertia, place};
use crate::format::{CompoundPart, CompoundShape, Shape as Table};
use crate::math::{Mat3, Pose, Quat, Vec3};
use crate::text::{Fault, Located};
use std::sync::Arc;
use thenar_core::shape::{PlacedShape, Shape};
use thenar_rig::TriMesh;
use thenar_rig::object::{ColourRun, Weight};

/// A shape with what is known of it.
pub struct Solid {
    /// Contact shape.
    pub shape: Shape,
    /// Shape frame in the body.
    pub pose_BS: Pose,
    /// Body frame (at the centre of mass) in the frame the shape was drawn in.
    pub pose_MB: Pose,
    /// Volume \[m³\] and inertia about the origin at density 1 \[m⁵\], of a primitive.
    pub moments: Option<(f64, Mat3)>,
    /// Mass \[kg\] and inertia in B, of a mesh.
    pub weighed: Option<(f64, Mat3)>,
    /// A mesh to draw, in B, and its colours.
    pub look: Option<(TriMesh, Vec<ColourRun>)>,
}

impl Solid {
    fn primitive(shape: Shape) -> Self {
        let moments = inertia::of_primitive(&shape);
        let here = Pose::identity();
        Self { shape, pose_BS: here, pose_MB: here, moments, weighed: None, look: None }
    }
}

/// A part with its volume \[m³\] (of a mesh in units of its mass), centre, and inertia about it at
/// density 1, both in the compound's frame.
struct PartMass {
    part: PlacedShape,
    volume: f64,
    centre: Vec3,
    inertia: Mat3,
}

/// Puts parts together about their common centre of mass.
fn compound(
    table: &CompoundShape,
    at: &Located<Table>,
    weight: Weight,
    files: &Files,
) -> Result<Solid, Fault> {
    if table.parts.is_empty() {
        return Err(at.fault("a compound needs at least one part"));
    }
    let parts = table.parts.iter().map(|part| weighed(&part.value, files));
    let parts = parts.collect::<Result<Vec<_>, _>>()?;
    let volume: f64 = parts.iter().map(|p| p.volume).sum();
    let centre = parts.iter().map(|p| p.centre * p.volume).sum::<Vec3>() / volume;
    // Steiner's theorem for each part.
    let inertia: Mat3 = parts
        .iter()
        .map(|p| {
            let d = p.centre - centre;
            p.inertia + (Mat3::identity() * d.norm_squared() - d * d.transpose()) * p.volume
        })
        .sum();
    let mass = weight.mass(volume).map_err(|e| at.fault(e.to_string()))?;
    let to_B = Pose::new(-centre, Quat::identity());
    let placed = |p: PartMass| PlacedShape { pose_SP: to_B * p.part.pose_SP, ..p.part };
    Ok(Solid {
        shape: Shape::Compound(Arc::new(parts.into_iter().map(placed).collect())),
        pose_BS: Pose::identity(),
        pose_MB: to_B.inverse(),
        moments: None,
        weighed: Some((mass, inertia * (mass / volume))),
        look: None,
    })
}

fn weighed(part: &CompoundPart, files: &Files) -> Result<PartMass, Fault> {
    let inner = &part.shape;
    if matches!(inner.value, Table::Plane(_) | Table::Car(_) | Table::Compound(_)) {
        return Err(inner.fault("a compound holds no plane, car or compound"));
    }
    let made = solid(inner, Weight::Density(1.0), files)?;
    let Some((volume, inertia)) = made.moments.or(made.weighed) else {
        return Err(inner.fault("a part needs a volume"));
    };
    let pose = place::frame(part.frame.as_ref())? * made.pose_MB;
    let turn = pose.rotation.to_rotation_matrix().into_inner();
    Ok(PartMass {
        part: PlacedShape { shape: made.shape, pose_SP: pose * made.pose_BS },
        volume,
        centre: pose.position,
        inertia: turn * inertia * turn.transpose(),
    })
}

/// Makes the shape that a table describes; a mesh gets `weight`.
pub fn solid(table: &Located<Table>, weight: Weight, files: &Files) -> Result<Solid, Fault> {
    match &table.value {
        Table::Box(b) => Ok(Solid::primitive(Shape::Cuboid { half: b.size / 2.0 })),
        Table::Sphere(s) => Ok(Solid::primitive(Shape::Sphere { radius: s.radius })),
        Table::Capsule(c) => {
            Ok(Solid::primitive(Shape::Capsule { radius: c.radius, half_length: c.length / 2.0 }))
        }
        Table::Cylinder(c) => {
            Ok(Solid::primitive(Shape::Cylinder { radius: c.radius, half_length: c.length / 2.0 }))
        }
        Table::Ellipsoid(e) => Ok(Solid::primitive(Shape::Ellipsoid { half: e.size / 2.0 })),
        Table::Cone(c) => Ok(Solid::primitive(Shape::Cone { radius: c.radius, height: c.height })),
        Table::Compound(c) => compound(c, table, weight, files),
        Table::Plane(_) => Ok(Solid::primitive(Shape::HalfSpace)),
        Table::Car(car) => assets::car(car, weight, table),
        Table::Mesh(mesh) => assets::rigid_mesh(mesh, weight, files),
    }
}
