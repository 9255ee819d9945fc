//! Contact shapes of rigid bodies.

use super::Files;
use super::{assets, inertia};
use crate::format::Shape as Table;
use crate::math::{Mat3, Pose};
use crate::text::{At, Fault};
use thenar::shape::Shape;
use thenar_rig::TriMesh;
use thenar_rig::object::{Paint, Weight};

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
    pub look: Option<(TriMesh, Vec<Paint>)>,
}

impl Solid {
    fn primitive(shape: Shape) -> Self {
        let moments = inertia::of_primitive(&shape);
        let here = Pose::identity();
        Self { shape, pose_BS: here, pose_MB: here, moments, weighed: None, look: None }
    }
}

/// Makes the shape that a table describes; a mesh gets `weight`.
pub fn solid(table: &At<Table>, weight: Weight, files: &Files) -> Result<Solid, Fault> {
    match &table.value {
        Table::Box(b) => Ok(Solid::primitive(Shape::Cuboid { half: b.size / 2.0 })),
        Table::Sphere(s) => Ok(Solid::primitive(Shape::Sphere { radius: s.radius })),
        Table::Capsule(c) => {
            Ok(Solid::primitive(Shape::Capsule { radius: c.radius, half_length: c.length / 2.0 }))
        }
        Table::Plane(_) => Ok(Solid::primitive(Shape::HalfSpace)),
        Table::Car(car) => assets::car(car, weight, table),
        Table::Mesh(mesh) => assets::rigid_mesh(mesh, weight, files),
    }
}
