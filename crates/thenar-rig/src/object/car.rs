//! A toy car: lower body, cabin, bumpers, lights and four wheels, each a closed part.
//!
//! Frame M: x forward, y up, z to the right; the wheels stand on y = 0.

use super::import::{ImportOptions, MeshReport, Weight, rigid_from_mesh};
use super::rigid::{ColourRun, RigidModel};
use crate::error::positive;
use crate::mesh::shapes;
use crate::{RigError, TriMesh};
use std::f64::consts::{FRAC_PI_2, PI};
use thenar_core::{Pose, Quat, Vec3};

/// A toy car.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Car {
    /// Length over the bumpers \[m\]; everything else is in proportion.
    pub length: f64,
    /// Mass \[kg\].
    pub mass: f64,
}

impl Default for Car {
    fn default() -> Self {
        Self { length: 0.072, mass: 0.1 }
    }
}

const RED: [f32; 3] = [0.78, 0.11, 0.10];
const GLASS: [f32; 3] = [0.16, 0.24, 0.32];
const CHROME: [f32; 3] = [0.75, 0.76, 0.78];
const LAMP: [f32; 3] = [0.98, 0.93, 0.70];
const RUBBER: [f32; 3] = [0.10, 0.10, 0.11];

/// The rigid toy car.
pub fn toy_car(car: &Car) -> Result<(RigidModel, MeshReport), RigError> {
    positive("length", car.length)?;
    let (mesh, paint) = parts();
    // Drawn in millimetres, 72 mm long.
    let mesh = mesh.scaled(car.length / 72.0);
    let options = ImportOptions { friction: 0.6, ..ImportOptions::default() };
    let (mut model, report) = rigid_from_mesh("toy car", &mesh, Weight::Mass(car.mass), &options)?;
    model.paint = paint;
    Ok((model, report))
}

/// All parts \[mm\] with their colours.
fn parts() -> (TriMesh, Vec<ColourRun>) {
    let mut mesh = TriMesh::default();
    let mut paint = Vec::new();
    let mut add = |part: &TriMesh, colour| {
        paint.push(ColourRun { first: mesh.triangles.len() as u32, colour });
        mesh.append(part);
    };
    add(&lower_body(), RED);
    add(&cabin(), GLASS);
    add(&roof(), RED);
    add(&bumper(34.0), CHROME);
    add(&bumper(-34.0), CHROME);
    for z in [-9.5, 9.5] {
        add(&lamp(Vec3::new(33.2, 11.0, z)), LAMP);
    }
    for x in [-20.5, 20.5] {
        for z in [-13.2, 13.2] {
            add(&wheel(Vec3::new(x, 7.0, z)), RUBBER);
            add(&hub(Vec3::new(x, 7.0, z + 3.2 * f64::signum(z))), CHROME);
        }
    }
    (mesh, paint)
}

/// Bonnet, doors and boot: rounded sections from tail to nose. Each is
/// (x, bottom, top, half width).
fn lower_body() -> TriMesh {
    let sections = [
        (-34.0, 7.5, 12.0, 11.5),
        (-33.0, 6.0, 14.0, 13.0),
        (-30.0, 5.2, 15.2, 14.0),
        (-22.0, 5.0, 15.8, 14.6),
        (-10.0, 5.0, 16.0, 15.0),
        (6.0, 5.0, 16.0, 15.0),
        (14.0, 5.0, 15.3, 14.8),
        (24.0, 5.0, 14.0, 14.4),
        (30.5, 5.2, 12.8, 13.6),
        (33.2, 6.0, 11.6, 12.4),
        (34.0, 7.5, 10.2, 11.0),
    ];
    let rings = sections.map(|(x, bottom, top, half_width)| {
        let (middle, half_height) = ((bottom + top) / 2.0, (top - bottom) / 2.0);
        rounded(32, 5.0)
            .map(|(u, v)| Vec3::new(x, middle + half_height * u, half_width * v))
            .collect()
    });
    loft(&rings)
}

/// Windows: slopes back from the windscreen and less from the rear window.
/// Levels are (y, rear x, front x, half width).
fn cabin() -> TriMesh {
    upright(&[
        (12.0, -25.0, 13.5, 13.0),
        (15.5, -24.0, 11.5, 13.0),
        (20.0, -20.8, 5.6, 11.7),
        (23.5, -18.2, 1.0, 10.7),
    ])
}

fn roof() -> TriMesh {
    upright(&[
        (23.2, -19.2, 2.2, 11.2),
        (24.0, -19.0, 1.8, 11.2),
        (24.9, -17.5, 0.2, 10.2),
        (25.3, -14.5, -3.0, 8.0),
    ])
}

fn bumper(x: f64) -> TriMesh {
    let rings = [-13.8, -13.0, 0.0, 13.0, 13.8].map(|z: f64| {
        let r = if z.abs() > 13.4 { 0.9 } else { 1.8 };
        rounded(16, 2.5).map(|(u, v)| Vec3::new(x + 2.0 * u * r / 1.8, 7.6 + r * v, z)).collect()
    });
    loft(&rings)
}

fn lamp(centre: Vec3) -> TriMesh {
    let mut ball = shapes::sphere(2.0, 4);
    ball.positions.iter_mut().for_each(|p| *p = Vec3::new(0.6 * p.x, p.y, p.z) + centre);
    ball
}

/// A tyre with rounded shoulders, its axle along z.
fn wheel(centre: Vec3) -> TriMesh {
    let profile = [(6.0, -3.2), (6.8, -2.6), (7.0, -1.6), (7.0, 1.6), (6.8, 2.6), (6.0, 3.2)];
    along_z(&shapes::revolved(&profile, [-3.2, 3.2], 32), centre)
}

fn hub(centre: Vec3) -> TriMesh {
    along_z(&shapes::revolved(&[(3.8, -0.6), (3.8, 0.2), (3.0, 0.6)], [-0.6, 0.6], 24), centre)
}

/// Turns the y axis to z and moves.
fn along_z(mesh: &TriMesh, centre: Vec3) -> TriMesh {
    let turn = Quat::from_axis_angle(&Vec3::x_axis(), FRAC_PI_2);
    mesh.clone().transformed(&Pose::new(centre, turn))
}

/// A body of levels (y, rear x, front x, half width) from the bottom up.
fn upright(levels: &[(f64, f64, f64, f64)]) -> TriMesh {
    let ring = |&(y, rear, front, half_width): &(f64, f64, f64, f64)| {
        let (middle, half_length) = ((rear + front) / 2.0, (front - rear) / 2.0);
        rounded(40, 6.0)
            .map(|(u, v)| Vec3::new(middle + half_length * v, y, half_width * u))
            .collect()
    };
    loft(&levels.iter().map(ring).collect::<Vec<_>>())
}

/// `n` points (u, v) around a square of half edge 1 with rounded corners (a superellipse),
/// from (0, 1) towards (1, 0).
fn rounded(n: u32, exponent: f64) -> impl Iterator<Item = (f64, f64)> {
    (0..n).map(move |k| {
        let (sin, cos) = (2.0 * PI * f64::from(k) / f64::from(n)).sin_cos();
        let radius = (sin.abs().powf(exponent) + cos.abs().powf(exponent)).powf(-1.0 / exponent);
        (radius * sin, radius * cos)
    })
}

/// The closed body through rings of equally many points, its ends closed by fans. Rings turn
/// clockwise seen from the last towards the first, so that the outside is out.
fn loft(rings: &[Vec<Vec3>]) -> TriMesh {
    let n = rings[0].len() as u32;
    let mut mesh = TriMesh { positions: rings.concat(), triangles: Vec::new() };
    let at = |ring: usize, k: u32| ring as u32 * n + k % n;
    for ring in 0..rings.len() - 1 {
        for k in 0..n {
            let [a, b] = [at(ring, k), at(ring, k + 1)];
            let [c, d] = [at(ring + 1, k), at(ring + 1, k + 1)];
            mesh.triangles.extend([[a, c, b], [b, c, d]]);
        }
    }
    for (ring, turned) in [(0, false), (rings.len() - 1, true)] {
        let centre = mesh.positions.len() as u32;
        mesh.positions.push(rings[ring].iter().sum::<Vec3>() / f64::from(n));
        for k in 0..n {
            let (a, b) = if turned { (k + 1, k) } else { (k, k + 1) };
            mesh.triangles.push([centre, at(ring, a), at(ring, b)]);
        }
    }
    if mesh.volume() < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{MassProperties, Topology};
    use thenar_core::shape::Shape;

    #[test]
    fn the_car_is_of_closed_parts_and_stands_on_its_wheels() {
        let (mesh, paint) = parts();
        let t = Topology::of(&mesh);
        assert!(t.closed() && t.manifold() && t.oriented() && t.degenerate_triangles == 0, "{t:?}");
        assert_eq!((t.components, paint.len()), (15, 15));
        assert_eq!(t.genus(), Some(0));
        let [min, max] = mesh.bounds();
        assert!(min.y.abs() < 1e-9 && (max.x - min.x - 72.0).abs() < 1e-9, "{min} {max}");
        // Symmetric from left to right.
        assert!((min.z + max.z).abs() < 1e-9);
    }

    #[test]
    fn the_model_has_the_mass_and_a_low_centre() {
        let (model, report) = toy_car(&Car::default()).unwrap();
        assert!((model.mass - 0.1).abs() < 1e-15);
        let centre = model.pose_MB.position;
        assert!(centre.z.abs() < 1e-4 && centre.x.abs() < 0.004, "{centre}");
        assert!(centre.y > 0.007 && centre.y < 0.015, "{centre}");
        // Overlaps count once: less than the parts' sum, more than the lower body.
        let lower = MassProperties::of_solid(&lower_body(), 1e-9).unwrap().mass;
        let sum = parts().0.volume() * 1e-9;
        assert!(report.volume < 0.97 * sum && report.volume > lower, "{report:?}");
        let Shape::Mesh(shape) = &model.shape else { panic!("not a mesh") };
        // Its true surface, not sampled anew.
        assert_eq!(shape.points.len(), parts().0.positions.len());
        assert!(toy_car(&Car { length: -1.0, mass: 0.1 }).is_err());
        assert!(toy_car(&Car { length: 0.07, mass: 0.0 }).is_err());
    }
}
