//! Convex shapes by their support: the point farthest in a direction, and the face there.
//!
//! A core is a shape moved inward by some way; spheres, capsules and ellipsoids are their cores
//! rounded by that way exactly, boxes, cylinders and cones but for their edges.

use crate::contact::Shape;
use crate::contact::features::rim;
use crate::math::{Mat3, Vec3};

/// Corners of the polygon that stands for a disc. Between two of them the rim is 2 % of the radius
/// beyond it; there the point of least distance stands for it.
pub(crate) const DISC_CORNERS: usize = 16;

/// A shape without compounds, at a place in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solid<'a> {
    pub shape: &'a Shape,
    pub rotation: Mat3,
    pub origin: Vec3,
}

/// Points of a shape that are farthest in a direction, to first order: a polygon in circular
/// order, a segment or a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    corners: [Vec3; DISC_CORNERS],
    count: usize,
    /// Outward normal of a flat face.
    pub normal: Option<Vec3>,
    /// Farthest point of the end `.0` of a round-ended line: on its ball, beside the line.
    pub tip: Option<(usize, Vec3)>,
}

impl Face {
    fn new(points: impl IntoIterator<Item = Vec3>, normal: Option<Vec3>) -> Self {
        let mut face = Self { corners: [Vec3::zeros(); DISC_CORNERS], count: 0, normal, tip: None };
        for p in points {
            if face.count < DISC_CORNERS {
                face.corners[face.count] = p;
                face.count += 1;
            }
        }
        face
    }

    pub fn corners(&self) -> &[Vec3] {
        &self.corners[..self.count]
    }
}

/// Largest ball inside, or of an ellipsoid its least radius of curvature \[m\].
pub(crate) fn inradius(shape: &Shape) -> f64 {
    match shape {
        Shape::Sphere { radius } | Shape::Capsule { radius, .. } => *radius,
        Shape::Cuboid { half } => half.min(),
        Shape::Cylinder { radius, half_length } => radius.min(*half_length),
        Shape::Cone { radius, height } => radius * height / (radius + radius.hypot(*height)),
        Shape::Ellipsoid { half } => half.min() * half.min() / half.max(),
        Shape::HalfSpace | Shape::Mesh(_) | Shape::Compound(_) => f64::INFINITY,
    }
}

/// Returns the radius by which a shape is exactly a rounded core \[m\].
pub(crate) fn rounding(shape: &Shape) -> f64 {
    match shape {
        Shape::Sphere { radius } | Shape::Capsule { radius, .. } => *radius,
        // Less than all, so that the core has no cusp.
        Shape::Ellipsoid { .. } => 0.5 * inradius(shape),
        Shape::Cuboid { .. }
        | Shape::Cylinder { .. }
        | Shape::Cone { .. }
        | Shape::HalfSpace
        | Shape::Mesh(_)
        | Shape::Compound(_) => 0.0,
    }
}

/// The point of the shape, moved inward by `inward`, farthest along `d` (any length but zero), in
/// the shape frame. Meshes, compounds and half-spaces have none: their origin is returned.
pub(crate) fn support(shape: &Shape, d: &Vec3, inward: f64) -> Vec3 {
    let disc = |radius: f64| {
        let aside = d.x.hypot(d.z);
        let scale = if aside > 0.0 { radius / aside } else { 0.0 };
        Vec3::new(d.x * scale, 0.0, d.z * scale)
    };
    match shape {
        Shape::Sphere { radius } => d.normalize() * (radius - inward),
        Shape::Capsule { radius, half_length } => {
            Vec3::y() * half_length.copysign(d.y) + d.normalize() * (radius - inward)
        }
        Shape::Cuboid { half } => Vec3::from_fn(|k, _| (half[k] - inward).copysign(d[k])),
        Shape::Cylinder { radius, half_length } => {
            disc(radius - inward) + Vec3::y() * (half_length - inward).copysign(d.y)
        }
        Shape::Cone { radius, height } => {
            let ball = inradius(shape);
            let middle = Vec3::y() * (ball - 0.25 * height);
            let apex = Vec3::y() * (0.75 * height);
            let base = disc(*radius) - Vec3::y() * (0.25 * height);
            let farthest = if d.dot(&apex) > d.dot(&base) { apex } else { base };
            middle + (farthest - middle) * (1.0 - inward / ball)
        }
        Shape::Ellipsoid { half } => {
            let scaled = half.component_mul(d);
            half.component_mul(&scaled) / scaled.norm() - d.normalize() * inward
        }
        Shape::HalfSpace | Shape::Mesh(_) | Shape::Compound(_) => Vec3::zeros(),
    }
}

/// The face that looks along unit vector `d` most, in the shape frame.
fn face(shape: &Shape, d: &Vec3) -> Face {
    let aside = Vec3::new(d.x, 0.0, d.z);
    let out = aside.try_normalize(1e-12).unwrap_or_else(Vec3::x);
    let disc = |radius: f64, y: f64, up: f64| {
        Face::new(rim(radius, y, DISC_CORNERS), Some(Vec3::y() * up))
    };
    match shape {
        Shape::Capsule { radius, half_length } => {
            let ends = [-half_length, *half_length].map(|y| Vec3::y() * y);
            // The end ahead is touched at its ball, wherever it is looked for.
            let ahead = usize::from(d.y > 0.0);
            let tip = (d.y != 0.0).then_some((ahead, ends[ahead] + *radius * d));
            Face { tip, ..Face::new(ends.map(|end| end + *radius * out), None) }
        }
        Shape::Cuboid { half } => {
            let k = d.iamax();
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let corner = |(a, b): (f64, f64)| {
                let mut p = Vec3::zeros();
                (p[k], p[i], p[j]) = (half[k].copysign(d[k]), a * half[i], b * half[j]);
                p
            };
            let mut normal = Vec3::zeros();
            normal[k] = 1.0_f64.copysign(d[k]);
            let around = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
            Face::new(around.map(corner), Some(normal))
        }
        Shape::Cylinder { radius, half_length } => {
            if d.y.abs() > std::f64::consts::FRAC_1_SQRT_2 {
                return disc(*radius, half_length.copysign(d.y), 1.0_f64.copysign(d.y));
            }
            let ends = [-half_length, *half_length].map(|y| Vec3::new(0.0, y, 0.0) + out * *radius);
            Face::new(ends, None)
        }
        Shape::Cone { radius, height } => {
            let slant = radius.hypot(*height);
            let beside = (height * aside.norm() + radius * d.y) / slant;
            if -d.y > beside {
                return disc(*radius, -0.25 * height, -1.0);
            }
            let rim = out * *radius - Vec3::y() * (0.25 * height);
            Face::new([rim, Vec3::y() * (0.75 * height)], None)
        }
        Shape::Sphere { .. }
        | Shape::Ellipsoid { .. }
        | Shape::HalfSpace
        | Shape::Mesh(_)
        | Shape::Compound(_) => Face::new([support(shape, d, 0.0)], None),
    }
}

impl Solid<'_> {
    /// The point of the core farthest along `d_W`, in the world.
    pub fn support(&self, d_W: &Vec3, inward: f64) -> Vec3 {
        self.origin + self.rotation * support(self.shape, &self.rotation.tr_mul(d_W), inward)
    }

    /// The face that looks along unit vector `d_W` most, in the world.
    pub fn face(&self, d_W: &Vec3) -> Face {
        let mut face = face(self.shape, &self.rotation.tr_mul(d_W));
        let count = face.count;
        face.corners[..count].iter_mut().for_each(|p| *p = self.origin + self.rotation * *p);
        face.normal = face.normal.map(|n| self.rotation * n);
        face.tip = face.tip.map(|(end, p)| (end, self.origin + self.rotation * p));
        face
    }

    /// Signed distance of a point of the world, with its gradient in the world.
    pub fn distance(&self, p_W: &Vec3) -> crate::contact::Distance {
        let d = self.shape.distance(&self.shape_point(p_W));
        crate::contact::Distance { gradient: self.rotation * d.gradient, ..d }
    }

    /// A point of the world in the shape frame.
    pub fn shape_point(&self, p_W: &Vec3) -> Vec3 {
        self.rotation.tr_mul(&(p_W - self.origin))
    }

    /// A point of the shape frame in the world.
    pub fn world_point(&self, p_S: &Vec3) -> Vec3 {
        self.rotation * p_S + self.origin
    }

    /// The surface point nearest to a point of the world that is near the surface.
    pub fn nearest(&self, p_W: &Vec3) -> Vec3 {
        let d = self.distance(p_W);
        p_W - d.value * d.gradient
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// No surface point is farther along a direction, and the face holds points as far.
    #[test]
    fn supports_are_the_farthest_points_and_faces_lie_on_the_surface() {
        let shapes = [
            Shape::Sphere { radius: 0.02 },
            Shape::Capsule { radius: 0.01, half_length: 0.02 },
            Shape::Cuboid { half: Vec3::new(0.01, 0.02, 0.03) },
            Shape::Cylinder { radius: 0.02, half_length: 0.01 },
            Shape::Cone { radius: 0.02, height: 0.03 },
            Shape::Ellipsoid { half: Vec3::new(0.01, 0.02, 0.03) },
        ];
        let mut random = Random::new(6);
        for shape in &shapes {
            for _ in 0..200 {
                let d = random.vector(1.0).normalize();
                let p = support(shape, &d, 0.0);
                assert!(shape.distance(&p).value.abs() < 1e-15, "{shape:?}");
                let inward = 0.3 * inradius(shape);
                let core = support(shape, &d, inward);
                assert!(shape.distance(&core).value < -inward + 1e-15, "{shape:?}");
                for _ in 0..50 {
                    let q = random.vector(0.05);
                    let on = shape.distance(&q);
                    assert!(d.dot(&(q - on.value * on.gradient)) < d.dot(&p) + 1e-15);
                }
                for corner in face(shape, &d).corners() {
                    assert!(shape.distance(corner).value.abs() < 1e-15, "{shape:?}");
                }
            }
        }
    }
}
