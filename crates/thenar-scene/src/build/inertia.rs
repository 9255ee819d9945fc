//! Mass and inertia of rigid bodies.

use crate::math::{Mat3, Vec3};
use crate::text::{Fault, Located};
use std::f64::consts::PI;
use thenar_core::shape::Shape;

/// Volume \[m³\] and inertia about the centre at density 1 \[m⁵\] of a primitive in its frame S,
/// its centre of mass at the origin; `None` for shapes that are no primitive.
pub fn of_primitive(shape: &Shape) -> Option<(f64, Mat3)> {
    match shape {
        Shape::Sphere { radius } => {
            let volume = 4.0 / 3.0 * PI * radius.powi(3);
            Some((volume, Mat3::identity() * (0.4 * volume * radius * radius)))
        }
        Shape::Cuboid { half } => {
            let volume = 8.0 * half.x * half.y * half.z;
            let square = half.component_mul(half);
            let about = |a: f64, b: f64| volume * (a + b) / 3.0;
            let diagonal = Vec3::new(
                about(square.y, square.z),
                about(square.x, square.z),
                about(square.x, square.y),
            );
            Some((volume, Mat3::from_diagonal(&diagonal)))
        }
        Shape::Capsule { radius, half_length } => Some(of_capsule(*radius, *half_length)),
        Shape::Cylinder { radius, half_length } => {
            let (square, volume) = (radius * radius, 2.0 * PI * radius * radius * half_length);
            let across = volume * (0.25 * square + half_length * half_length / 3.0);
            let inertia = Vec3::new(across, 0.5 * volume * square, across);
            Some((volume, Mat3::from_diagonal(&inertia)))
        }
        Shape::Ellipsoid { half } => {
            let volume = 4.0 / 3.0 * PI * half.product();
            let square = half.component_mul(half);
            let inertia = square.map(|own| 0.2 * volume * (square.sum() - own));
            Some((volume, Mat3::from_diagonal(&inertia)))
        }
        Shape::Cone { radius, height } => {
            let volume = PI * radius * radius * height / 3.0;
            let (square, rise) = (radius * radius, height * height);
            let across = volume * (0.15 * square + 0.0375 * rise);
            let inertia = Vec3::new(across, 0.3 * volume * square, across);
            Some((volume, Mat3::from_diagonal(&inertia)))
        }
        _ => None,
    }
}

/// A cylinder along y between two hemispheres.
fn of_capsule(r: f64, h: f64) -> (f64, Mat3) {
    let cylinder = 2.0 * PI * r * r * h;
    let ball = 4.0 / 3.0 * PI * r.powi(3);
    let axial = 0.5 * cylinder * r * r + 0.4 * ball * r * r;
    // A hemisphere's centre lies 3r/8 from its flat side.
    let caps = ball * (0.4 * r * r + h * h + 0.75 * h * r);
    let across = cylinder * (0.25 * r * r + h * h / 3.0) + caps;
    (cylinder + ball, Mat3::from_diagonal(&Vec3::new(across, axial, across)))
}

/// The matrix that three or six numbers describe.
pub fn from_numbers(numbers: &Located<Vec<f64>>) -> Result<Mat3, Fault> {
    let n = &numbers.value;
    let (d, p) = match n.len() {
        3 => (&n[..3], [0.0; 3]),
        6 => (&n[..3], [n[3], n[4], n[5]]),
        _ => {
            return Err(numbers.fault(format!(
                "expected [Ixx, Iyy, Izz] or [Ixx, Iyy, Izz, Ixy, Ixz, Iyz], got {} numbers",
                n.len()
            )));
        }
    };
    let inertia = Mat3::new(d[0], p[0], p[1], p[0], d[1], p[2], p[1], p[2], d[2]);
    let principal = inertia.symmetric_eigenvalues();
    let (sum, largest, least) = (principal.sum(), principal.max(), principal.min());
    if least <= 0.0 {
        return Err(numbers.fault("expected a positive definite inertia"));
    }
    if 2.0 * largest > sum * (1.0 + 1e-9) {
        return Err(numbers.fault(format!(
            "no body has such an inertia: its largest principal moment {largest:e} exceeds the sum of the others"
        )));
    }
    Ok(inertia)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::SourcePlace;

    /// Moments by summing small cubes.
    fn by_cubes(shape: &Shape, reach: f64, n: i32) -> (f64, Mat3) {
        let cell = 2.0 * reach / f64::from(n);
        let (mut volume, mut inertia) = (0.0, Mat3::zeros());
        for i in 0..n * n * n {
            let index = Vec3::new(f64::from(i % n), f64::from(i / n % n), f64::from(i / n / n));
            let p = index.map(|k| (k + 0.5) * cell - reach);
            let inside = match shape {
                Shape::Capsule { radius, half_length } => {
                    let y = p.y.clamp(-half_length, *half_length);
                    (p - Vec3::new(0.0, y, 0.0)).norm() <= *radius
                }
                Shape::Sphere { radius } => p.norm() <= *radius,
                Shape::Cuboid { half } => (0..3).all(|k| p[k].abs() <= half[k]),
                Shape::Cylinder { radius, half_length } => {
                    p.x.hypot(p.z) <= *radius && p.y.abs() <= *half_length
                }
                Shape::Ellipsoid { half } => p.component_div(half).norm() <= 1.0,
                Shape::Cone { radius, height } => {
                    let up = p.y / height + 0.25;
                    up >= 0.0 && p.x.hypot(p.z) <= radius * (1.0 - up)
                }
                _ => false,
            };
            if inside {
                volume += cell.powi(3);
                inertia += (Mat3::identity() * p.norm_squared() - p * p.transpose()) * cell.powi(3);
            }
        }
        (volume, inertia)
    }

    #[test]
    fn primitives_match_a_sum_over_cubes() {
        let shapes = [
            Shape::Sphere { radius: 0.9 },
            Shape::Capsule { radius: 0.4, half_length: 0.55 },
            Shape::Cuboid { half: Vec3::new(0.5, 0.75, 0.25) },
            Shape::Cylinder { radius: 0.6, half_length: 0.9 },
            Shape::Ellipsoid { half: Vec3::new(0.9, 0.4, 0.7) },
            Shape::Cone { radius: 0.8, height: 1.2 },
        ];
        for shape in shapes {
            let (volume, inertia) = of_primitive(&shape).unwrap();
            let (v, i) = by_cubes(&shape, 1.0, 120);
            assert!((volume - v).abs() < 0.01 * v, "{shape:?}: {volume} {v}");
            assert!((inertia - i).norm() < 0.01 * i.norm(), "{shape:?}: {inertia} {i}");
        }
    }

    #[test]
    fn impossible_inertias_are_refused() {
        let at = |v: &[f64]| Located {
            value: v.to_vec(),
            place: SourcePlace::Text(0..0),
            key: "inertia".into(),
        };
        assert!(from_numbers(&at(&[1.0, 2.0])).is_err());
        assert!(from_numbers(&at(&[1.0, 1.0, -1.0])).is_err());
        assert!(from_numbers(&at(&[1.0, 1.0, 3.0])).is_err());
        assert!(from_numbers(&at(&[1.0, 2.0, 3.0])).is_ok()); // a flat plate
        let full = from_numbers(&at(&[2.0, 2.0, 2.0, 0.1, 0.2, 0.3])).unwrap();
        assert_eq!((full[(0, 1)], full[(2, 0)], full[(1, 2)]), (0.1, 0.2, 0.3));
    }
}
