//! Signed distance to each shape.

use crate::contact::Shape;
use crate::math::Vec3;

/// Signed distance to a surface and its gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Signed distance \[m\], negative inside.
    pub value: f64,
    /// Unit gradient: the outward normal of the nearest surface point.
    pub gradient: Vec3,
}

impl Shape {
    /// Signed distance from `p_S`, a point in the shape frame. Exact, except for meshes, which
    /// are sampled from their grid; beyond that grid the value is a lower bound.
    #[inline]
    pub fn distance(&self, p_S: &Vec3) -> Distance {
        match self {
            Self::Sphere { radius } => round(*p_S, *radius),
            Self::Capsule { radius, half_length } => {
                let on_axis = p_S.y.clamp(-half_length, *half_length);
                round(p_S - Vec3::new(0.0, on_axis, 0.0), *radius)
            }
            Self::Cuboid { half } => cuboid(p_S, half),
            Self::HalfSpace => Distance { value: p_S.y, gradient: Vec3::y() },
            Self::Mesh(mesh) => mesh.grid.sample(p_S),
        }
    }
}

/// Distance to a ball of `radius`, given the vector from its centre.
fn round(from_center: Vec3, radius: f64) -> Distance {
    let length = from_center.norm();
    // At the very centre every direction is as good; sideways suits a capsule.
    let gradient = if length > 0.0 { from_center / length } else { Vec3::x() };
    Distance { value: length - radius, gradient }
}

/// Outside: the vector from the nearest point of the box. Inside: the nearest face.
fn cuboid(p: &Vec3, half: &Vec3) -> Distance {
    let beyond = p.abs() - half;
    let outside = beyond.sup(&Vec3::zeros());
    let length = outside.norm();
    if length > 0.0 {
        let gradient = Vec3::from_fn(|k, _| (outside[k] / length).copysign(p[k]));
        return Distance { value: length, gradient };
    }
    let axis = beyond.imax();
    let mut gradient = Vec3::zeros();
    gradient[axis] = 1.0_f64.copysign(p[axis]);
    Distance { value: beyond[axis], gradient }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::triangle::tests::Random;

    fn shapes() -> Vec<Shape> {
        vec![
            Shape::Sphere { radius: 0.02 },
            Shape::Capsule { radius: 0.01, half_length: 0.015 },
            Shape::Cuboid { half: Vec3::new(0.01, 0.02, 0.03) },
            Shape::HalfSpace,
        ]
    }

    /// Central differences, away from the creases where the distance has no gradient.
    #[test]
    fn gradients_match_finite_differences() {
        let mut random = Random::new(7);
        let step = 1e-7;
        for shape in shapes() {
            let mut tested = 0;
            for _ in 0..500 {
                let p = random.vector(0.04);
                let d = shape.distance(&p);
                let numeric = Vec3::from_fn(|k, _| {
                    let mut dp = Vec3::zeros();
                    dp[k] = step;
                    (shape.distance(&(p + dp)).value - shape.distance(&(p - dp)).value)
                        / (2.0 * step)
                });
                assert!((d.gradient.norm() - 1.0).abs() < 1e-12);
                if (numeric.norm() - 1.0).abs() < 1e-4 {
                    assert!((numeric - d.gradient).norm() < 1e-4, "{shape:?} at {p}");
                    tested += 1;
                }
            }
            assert!(tested > 450, "{shape:?}: only {tested} points away from creases");
        }
    }

    /// Moving by the distance against the gradient lands on the surface, and no surface point
    /// found by sampling is nearer.
    #[test]
    fn distance_is_that_of_the_nearest_surface_point() {
        let mut random = Random::new(11);
        for shape in shapes() {
            for _ in 0..200 {
                let p = random.vector(0.05);
                let d = shape.distance(&p);
                let foot = p - d.value * d.gradient;
                assert!(shape.distance(&foot).value.abs() < 1e-12, "{shape:?}");
                for _ in 0..50 {
                    let q = random.vector(0.05);
                    let on_q = shape.distance(&q);
                    let surface = q - on_q.value * on_q.gradient;
                    assert!((surface - p).norm() > d.value.abs() - 1e-12, "{shape:?}");
                }
            }
        }
    }

    #[test]
    fn known_values() {
        let cuboid = Shape::Cuboid { half: Vec3::new(1.0, 2.0, 3.0) };
        let d = cuboid.distance(&Vec3::new(4.0, -6.0, 0.0));
        assert_eq!((d.value, d.gradient), (5.0, Vec3::new(0.6, -0.8, 0.0)));
        let d = cuboid.distance(&Vec3::new(0.0, -1.5, 0.0));
        assert_eq!((d.value, d.gradient), (-0.5, -Vec3::y()));
        let capsule = Shape::Capsule { radius: 1.0, half_length: 2.0 };
        assert_eq!(capsule.distance(&Vec3::new(0.0, 5.0, 0.0)).value, 2.0);
        assert_eq!(capsule.distance(&Vec3::new(3.0, 1.0, 4.0)).value, 4.0);
        assert_eq!(Shape::HalfSpace.distance(&Vec3::new(9.0, -0.25, 1.0)).value, -0.25);
        assert!(Shape::Sphere { radius: 1.0 }.distance(&Vec3::zeros()).gradient.norm() == 1.0);
    }
}
