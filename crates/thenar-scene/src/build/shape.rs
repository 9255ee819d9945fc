//! Contact shapes of rigid bodies.

use super::{assets, inertia};
use crate::format::Shape as Table;
use crate::math::{Mat3, Vec3};
use crate::text::{At, Fault};
use std::path::Path;
use thenar::contact::Shape;

/// A shape with what is known of it.
pub struct Solid {
    /// Contact shape.
    pub shape: Shape,
    /// Centre of mass in the shape's frame \[m\].
    pub centre: Vec3,
    /// Volume \[m³\] and inertia about `centre` at density 1 \[m⁵\], of a shape that has them.
    pub moments: Option<(f64, Mat3)>,
    /// A finer mesh to draw, in the shape's frame.
    pub look: Option<super::rigid::LookMesh>,
}

impl Solid {
    fn primitive(shape: Shape) -> Self {
        let moments = inertia::of_primitive(&shape);
        Self { shape, centre: Vec3::zeros(), moments, look: None }
    }
}

/// Makes the shape that a table describes.
pub fn solid(table: &At<Table>, folder: &Path) -> Result<Solid, Fault> {
    match &table.value {
        Table::Box(b) => Ok(Solid::primitive(Shape::Cuboid { half: b.size / 2.0 })),
        Table::Sphere(s) => Ok(Solid::primitive(Shape::Sphere { radius: s.radius })),
        Table::Capsule(c) => {
            Ok(Solid::primitive(Shape::Capsule { radius: c.radius, half_length: c.length / 2.0 }))
        }
        Table::Plane(_) => Ok(Solid::primitive(Shape::HalfSpace)),
        Table::Car(car) => assets::car(car, table),
        Table::Mesh(mesh) => assets::rigid_mesh(mesh, folder),
    }
}
