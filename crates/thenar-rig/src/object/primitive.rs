//! Boxes, spheres, capsules and planes.

use super::import::Weight;
use super::rigid::RigidModel;
use crate::error::positive;
use crate::mesh::shapes;
use crate::{RigError, TriMesh};
use std::f64::consts::PI;
use thenar_core::shape::Shape;
use thenar_core::{Mat3, Pose, Vec3};

const FRICTION: f64 = 0.5;

fn model(name: &str, shape: Shape, mass: f64, inertia: Mat3, render: TriMesh) -> RigidModel {
    RigidModel {
        name: name.to_owned(),
        mass,
        inertia,
        pose_MB: Pose::identity(),
        shape,
        pose_BS: Pose::identity(),
        render,
        paint: Vec::new(),
        friction: FRICTION,
    }
}

/// A box of these edge lengths \[m\], centred: `I_xx = m/12 (b² + c²)`.
pub fn rigid_box(size: &Vec3, weight: Weight) -> Result<RigidModel, RigError> {
    for &edge in size.iter() {
        positive("size", edge)?;
    }
    let mass = weight.mass(size.product())?;
    let square = size.component_mul(size);
    let inertia = (Mat3::identity() * square.sum() - Mat3::from_diagonal(&square)) * (mass / 12.0);
    let half = size * 0.5;
    Ok(model("box", Shape::Cuboid { half }, mass, inertia, shapes::cuboid(&half)))
}

/// A sphere \[m\], centred: `I = 2/5 m r²`.
pub fn rigid_sphere(radius: f64, weight: Weight) -> Result<RigidModel, RigError> {
    positive("radius", radius)?;
    let mass = weight.mass(4.0 / 3.0 * PI * radius.powi(3))?;
    let inertia = Mat3::from_diagonal_element(0.4 * mass * radius * radius);
    Ok(model("sphere", Shape::Sphere { radius }, mass, inertia, shapes::sphere(radius, 12)))
}

/// A capsule along y \[m\], centred; `half_length` is half the segment between the cap centres.
/// Cylinder and two half balls (of centroid 3/8 r beyond the segment's ends) are summed.
pub fn rigid_capsule(
    radius: f64,
    half_length: f64,
    weight: Weight,
) -> Result<RigidModel, RigError> {
    positive("radius", radius)?;
    positive("half_length", half_length)?;
    let (r, h) = (radius, half_length);
    let (rod, balls) = (2.0 * PI * r * r * h, 4.0 / 3.0 * PI * r.powi(3));
    let mass = weight.mass(rod + balls)?;
    let density = mass / (rod + balls);
    let along = density * (rod * r * r / 2.0 + balls * 0.4 * r * r);
    let across = density
        * (rod * (r * r / 4.0 + h * h / 3.0) + balls * (0.4 * r * r + 0.75 * r * h + h * h));
    let inertia = Mat3::from_diagonal(&Vec3::new(across, along, across));
    let shape = Shape::Capsule { radius, half_length };
    Ok(model("capsule", shape, mass, inertia, shapes::capsule(r, h, 32)))
}

/// The half space y ≤ 0, for prescribed bodies only, drawn as a square of this edge \[m\].
pub fn static_plane(drawn_size: f64) -> Result<RigidModel, RigError> {
    let s = positive("drawn_size", drawn_size)? / 2.0;
    let corner = |x: f64, z: f64| Vec3::new(x * s, 0.0, z * s);
    let positions =
        vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
    let render = TriMesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]] };
    Ok(model("plane", Shape::HalfSpace, 0.0, Mat3::zeros(), render))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::MassProperties;

    #[test]
    fn formulas_agree_with_integrals_over_fine_meshes() {
        let check = |model: RigidModel, mesh: TriMesh| {
            let exact = MassProperties::of_solid(&mesh, 500.0).unwrap();
            assert!((model.mass / exact.mass - 1.0).abs() < 3e-3);
            assert!((model.inertia - exact.inertia).norm() < 5e-3 * exact.inertia.norm());
        };
        let density = Weight::Density(500.0);
        let size = Vec3::new(0.02, 0.05, 0.1);
        check(rigid_box(&size, density).unwrap(), shapes::cuboid(&(size / 2.0)));
        check(rigid_sphere(0.03, density).unwrap(), shapes::sphere(0.03, 40));
        check(rigid_capsule(0.01, 0.03, density).unwrap(), shapes::capsule(0.01, 0.03, 160));
        assert_eq!(rigid_box(&size, Weight::Mass(0.3)).unwrap().mass, 0.3);
    }

    #[test]
    fn senseless_sizes_and_weights_are_refused() {
        let message = |r: Result<RigidModel, RigError>| r.unwrap_err().to_string();
        assert!(message(rigid_sphere(-1.0, Weight::Mass(1.0))).contains("radius"));
        assert!(message(rigid_sphere(1.0, Weight::Mass(0.0))).contains("mass"));
        assert!(message(rigid_sphere(1.0, Weight::Density(f64::NAN))).contains("density"));
        assert!(message(rigid_box(&Vec3::zeros(), Weight::Mass(1.0))).contains("size"));
    }
}
