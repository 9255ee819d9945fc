//! Signed distance to each shape.

use crate::contact::{PlacedShape, Shape, ellipsoid};
use crate::math::Vec3;
use std::cell::Cell;

/// Signed distance to a surface and its gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Signed distance \[m\], negative inside.
    pub value: f64,
    /// Unit gradient: the outward normal of the nearest surface point.
    pub gradient: Vec3,
}

impl Shape {
    /// Signed distance from `p_S`, a point in the shape frame, to the surface; exact to round-off.
    /// Inside a compound, or a mesh of overlapping pieces, it is the depth in the piece in which
    /// `p_S` lies deepest, which is a lower bound of the depth in the union.
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
            Self::Mesh(mesh) => mesh.distance(p_S),
            Self::Cylinder { radius, half_length } => cylinder(p_S, *radius, *half_length),
            Self::Ellipsoid { half } => ellipsoid::distance(p_S, half),
            Self::Cone { radius, height } => cone(p_S, *radius, *height),
            Self::Compound(parts) => compound(p_S, parts),
        }
    }

    /// Signed distance from `p_S`, a point in the shape frame, where the surface is nearer than
    /// `reach` \[m\] or `p_S` is inside, otherwise `None`. Of a mesh this takes a fraction of the
    /// time far from it.
    #[inline]
    pub fn distance_within(&self, p_S: &Vec3, reach: f64) -> Option<Distance> {
        match self {
            Self::Mesh(mesh) => mesh.distance_within(p_S, reach),
            _ => Some(self.distance(p_S)).filter(|d| d.value < reach),
        }
    }

    /// True for a mesh whose distance changes nowhere by more than the point moves.
    pub(crate) fn is_solid_mesh(&self) -> bool {
        matches!(self, Self::Mesh(mesh) if mesh.index.is_solid)
    }

    /// [`Shape::distance_within`], of a mesh soonest found if near to where it was with the same
    /// `guess`.
    #[inline]
    pub(crate) fn distance_within_near(
        &self,
        p_S: &Vec3,
        reach: f64,
        guess: &Cell<u32>,
    ) -> Option<Distance> {
        match self {
            Self::Mesh(mesh) => mesh.distance_within_near(p_S, reach, guess),
            _ => self.distance_within(p_S, reach),
        }
    }

    /// The distance, given that it is no more than `known` \[m\] on either side: of a mesh, and
    /// near it, this takes a fraction of the time, the less the nearer to where the last one was
    /// asked with the same `guess` (any at first).
    #[inline]
    pub(crate) fn distance_near(&self, p_S: &Vec3, known: f64, guess: &Cell<u32>) -> Distance {
        match self {
            Self::Mesh(mesh) => mesh.distance_near(p_S, known, guess),
            _ => self.distance(p_S),
        }
    }
}

/// The part in which `p` lies deepest, or which is nearest.
fn compound(p: &Vec3, parts: &[PlacedShape]) -> Distance {
    let mut least = Distance { value: f64::INFINITY, gradient: Vec3::y() };
    for part in parts {
        let d = part.shape.distance(&part.pose_SP.inverse_point(p));
        if d.value < least.value {
            least = Distance { value: d.value, gradient: part.pose_SP.vector(&d.gradient) };
        }
    }
    least
}

/// A body of revolution about y: the distance in the half-plane (distance from the axis, y).
fn revolved(p: &Vec3, profile: impl Fn([f64; 2]) -> (f64, [f64; 2])) -> Distance {
    let radial = p.x.hypot(p.z);
    let (value, [out, up]) = profile([radial, p.y]);
    let aside = if radial > 0.0 { Vec3::new(p.x / radial, 0.0, p.z / radial) } else { Vec3::x() };
    Distance { value, gradient: aside * out + Vec3::y() * up }
}

/// A rectangle in the half-plane.
fn cylinder(p: &Vec3, radius: f64, half_length: f64) -> Distance {
    revolved(p, |[r, y]| {
        let (out, up) = (r - radius, y.abs() - half_length);
        let (a, b) = (out.max(0.0), up.max(0.0));
        let length = a.hypot(b);
        if length > 0.0 {
            return (length, [a / length, (b / length).copysign(y)]);
        }
        if out > up { (out, [1.0, 0.0]) } else { (up, [0.0, 1.0_f64.copysign(y)]) }
    })
}

/// A right-angled triangle in the half-plane: outside the nearest point of base or slant, inside
/// the nearer of their two lines.
fn cone(p: &Vec3, radius: f64, height: f64) -> Distance {
    let slant = radius.hypot(height);
    let normal = [height / slant, radius / slant];
    revolved(p, |[r, y]| {
        let y = y + 0.25 * height;
        let to_slant = (r - radius) * normal[0] + y * normal[1];
        if y <= 0.0 && (r <= radius || to_slant <= 0.0) {
            let out = (r - radius).max(0.0);
            let length = out.hypot(y);
            return match length > 0.0 {
                true => (length, [out / length, y / length]),
                false => (0.0, [0.0, -1.0]),
            };
        }
        if to_slant <= 0.0 {
            return if to_slant > -y { (to_slant, normal) } else { (-y, [0.0, -1.0]) };
        }
        // Along the slant from the rim: beyond an end, that end is nearest.
        let along = (y * height - (r - radius) * radius) / slant;
        let from = if along < 0.0 { [r - radius, y] } else { [r, y - height] };
        if (0.0..=slant).contains(&along) {
            return (to_slant, normal);
        }
        let length = from[0].hypot(from[1]);
        (length, from.map(|x| x / length))
    })
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
    use crate::math::Pose;
    use crate::random::Random;

    fn shapes() -> Vec<Shape> {
        vec![
            Shape::Sphere { radius: 0.02 },
            Shape::Capsule { radius: 0.01, half_length: 0.015 },
            Shape::Cuboid { half: Vec3::new(0.01, 0.02, 0.03) },
            Shape::HalfSpace,
            Shape::Cylinder { radius: 0.02, half_length: 0.01 },
            Shape::Cylinder { radius: 0.005, half_length: 0.03 },
            Shape::Ellipsoid { half: Vec3::new(0.03, 0.01, 0.02) },
            Shape::Ellipsoid { half: Vec3::new(0.02, 0.02, 0.001) },
            Shape::Ellipsoid { half: Vec3::repeat(0.015) },
            Shape::Cone { radius: 0.02, height: 0.04 },
            Shape::Cone { radius: 0.03, height: 0.01 },
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
        let cylinder = Shape::Cylinder { radius: 1.0, half_length: 2.0 };
        let d = cylinder.distance(&Vec3::new(0.0, -6.0, 4.0));
        assert_eq!((d.value, d.gradient), (5.0, Vec3::new(0.0, -0.8, 0.6)));
        assert_eq!(cylinder.distance(&Vec3::new(0.5, 0.0, 0.0)).value, -0.5);
        let cone = Shape::Cone { radius: 3.0, height: 4.0 };
        let above = cone.distance(&Vec3::new(0.0, 5.0, 0.0));
        assert_eq!((above.value, above.gradient), (2.0, Vec3::y()));
        assert!((cone.distance(&Vec3::new(7.0, -4.0, 0.0)).value - 5.0).abs() < 1e-14);
        // The centre of the sphere inscribed in the cone: radius r h/(r + √(r² + h²)) = 1.5.
        assert!((cone.distance(&Vec3::new(0.0, 0.5, 0.0)).value + 1.5).abs() < 1e-14);
        let half = Vec3::new(3.0, 2.0, 1.0);
        let ellipsoid = Shape::Ellipsoid { half };
        for (p, value) in [([5.0, 0.0, 0.0], 2.0), ([0.0, 0.0, 0.0], -1.0), ([0.0, 1.9, 0.0], -0.1)]
        {
            let d = ellipsoid.distance(&Vec3::from(p));
            assert!((d.value - value).abs() < 1e-12, "{p:?}: {d:?}");
        }
        let two = [-1.0, 1.0].map(|x| PlacedShape {
            shape: Shape::Sphere { radius: 0.5 },
            pose_SP: Pose::translation(x, 0.0, 0.0),
        });
        let two = Shape::Compound(std::sync::Arc::new(two.to_vec()));
        let d = two.distance(&Vec3::new(3.0, 0.0, 0.0));
        assert_eq!((d.value, d.gradient), (1.5, Vec3::x()));
        assert!(Shape::Sphere { radius: 1.0 }.distance(&Vec3::zeros()).gradient.norm() == 1.0);
    }
}
