//! The round side of a capsule, cylinder or cone over another convex shape.
//!
//! A ball sweeps such a side: its centre goes along the axis, its radius changes evenly. From the
//! centre the way to the other shape is known well, also where the surfaces touch or overlap, and
//! it leads to the point of the side that is nearest there: two cylinders that cross at a small
//! angle are nearly as close at the ends of their common length as where they cross.

use crate::contact::Shape;
use crate::contact::support::Solid;
use crate::math::{Vec3, tangents};

/// The distance from a point of the side counts where the way from there is that from the axis
/// (cosine of 1.4 mrad): from a point that touches an edge or an end, round-off turns it by more.
const SAME_WAY: f64 = 1.0 - 1e-6;
/// The foot of a point lies on the other shape, and nothing of it is nearer, but for these parts of
/// the gap and of the radius.
const FOOT: [f64; 2] = [1e-3, 1e-4];

/// The balls at the two ends of the side, in the order of the corners of the side's
/// [`Face`](crate::contact::support::Face).
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoundSide {
    centers_W: [Vec3; 2],
    radii: [f64; 2],
    axis_W: Vec3,
    /// Component of the side's normals along the axis.
    along: f64,
    /// The balls at the ends belong to the shape.
    capped: bool,
}

/// A point of a side over another shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Over {
    /// Unit, from the other shape to the side.
    pub normal_W: Vec3,
    pub on_side_W: Vec3,
    /// Along the normal \[m\].
    pub gap: f64,
}

impl RoundSide {
    /// The side of this shape, if round.
    pub fn of(solid: &Solid) -> Option<Self> {
        let axis_W = solid.rotation.column(1).into_owned();
        let at = |y: f64| solid.origin + axis_W * y;
        let even = |radius: f64, half_length: f64, capped: bool| Self {
            centers_W: [at(-half_length), at(half_length)],
            radii: [radius; 2],
            axis_W,
            along: 0.0,
            capped,
        };
        match *solid.shape {
            Shape::Capsule { radius, half_length } => Some(even(radius, half_length, true)),
            Shape::Cylinder { radius, half_length } => Some(even(radius, half_length, false)),
            Shape::Cone { radius, height } => {
                // The ball that touches the slant at the rim has its centre below the base.
                let (slant, below) = (radius.hypot(height), radius * radius / height);
                Some(Self {
                    centers_W: [at(-0.25 * height - below), at(0.75 * height)],
                    radii: [radius * slant / height, 0.0],
                    axis_W,
                    along: radius / slant,
                    capped: false,
                })
            }
            Shape::Sphere { .. }
            | Shape::Cuboid { .. }
            | Shape::Ellipsoid { .. }
            | Shape::HalfSpace
            | Shape::Mesh(_)
            | Shape::Compound(_) => None,
        }
    }

    /// Radius of the larger end \[m\].
    pub fn thickness(&self) -> f64 {
        self.radii[0].max(self.radii[1])
    }

    /// The point nearest to `other` at the part `s` of the way from the first end to the second.
    /// `None` where the axis is inside `other`, and where the point is, too, and nothing of `other`
    /// lies straight above it.
    pub fn over(&self, other: &Solid, s: f64) -> Option<Over> {
        let center = self.centers_W[0].lerp(&self.centers_W[1], s);
        let radius = self.radii[0] + s * (self.radii[1] - self.radii[0]);
        let seen = other.distance(&center);
        if seen.value <= 0.0 {
            return None;
        }
        let on_side_W = center + radius * self.outward(-seen.gradient, s);
        let there = other.distance(&on_side_W);
        let exact = Over { normal_W: there.gradient, on_side_W, gap: there.value };
        if there.gradient.dot(&seen.gradient) > SAME_WAY {
            return Some(exact);
        }
        let normal_W = seen.gradient;
        let gap = seen.value + normal_W.dot(&(on_side_W - center));
        let foot = other.distance(&(on_side_W - gap * normal_W)).value;
        let is_little = |x: f64| x.abs() <= FOOT[0] * gap.abs() + FOOT[1] * radius;
        if is_little(foot) && (there.value <= 0.0 || is_little(gap - there.value)) {
            return Some(Over { normal_W, on_side_W, gap });
        }
        (there.value > 0.0).then_some(exact)
    }

    /// The side's normal nearest to `d_W`, a unit vector.
    fn outward(&self, d_W: Vec3, s: f64) -> Vec3 {
        let along = d_W.dot(&self.axis_W);
        if self.capped && (s <= 0.0 && along < 0.0 || s >= 1.0 && along > 0.0) {
            return d_W;
        }
        let aside = (d_W - along * self.axis_W).try_normalize(f64::EPSILON);
        // What lies straight ahead of an end is as far from all of the circle.
        let aside = aside.unwrap_or_else(|| tangents(&self.axis_W).0);
        aside * (1.0 - self.along * self.along).sqrt() + self.axis_W * self.along
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Quat;
    use crate::random::Random;

    fn at(shape: &Shape, turn: Quat, origin: Vec3) -> Solid<'_> {
        Solid { shape, rotation: turn.to_rotation_matrix().into_inner(), origin }
    }

    /// The point lies on the side, as far from the other shape as the distance found. Its circle
    /// comes nearer elsewhere by no more than the way on the ball from its own nearest point, as
    /// distances grow no faster than ways; and hardly ever by a tenth of a millimetre.
    #[test]
    fn no_point_of_the_circle_is_nearer() {
        let sides = [
            Shape::Capsule { radius: 0.01, half_length: 0.02 },
            Shape::Cylinder { radius: 0.02, half_length: 0.03 },
            Shape::Cone { radius: 0.02, height: 0.06 },
            Shape::Cone { radius: 0.03, height: 0.04 },
        ];
        let others = [
            Shape::Cylinder { radius: 0.005, half_length: 0.04 },
            Shape::Cylinder { radius: 0.02, half_length: 0.04 },
            Shape::Capsule { radius: 0.015, half_length: 0.04 },
            Shape::Cuboid { half: Vec3::new(0.01, 0.05, 0.02) },
            Shape::Cone { radius: 0.02, height: 0.1 },
        ];
        let mut random = Random::new(21);
        let (mut tested, mut beyond) = (0, 0);
        for i in 0..4000 {
            let (shape, other) = (&sides[i % 4], &others[i % 5]);
            let way = Quat::from_axis_angle(&Vec3::y_axis(), 6.3 * random.unit()) * Vec3::x();
            let a = at(shape, Quat::identity(), Vec3::zeros());
            let turn = Quat::from_scaled_axis(random.vector(0.1));
            let b = at(other, turn, way * (0.02 + 0.04 * random.unit()));
            let side = RoundSide::of(&a).expect("round");
            let s = random.unit();
            let Some(over) = side.over(&b, s) else { continue };
            assert!(a.distance(&over.on_side_W).value.abs() < 1e-12, "{shape:?}");
            assert!((over.normal_W.norm() - 1.0).abs() < 1e-12);
            let told = b.distance(&over.on_side_W).value;
            let from = b.distance(&side.centers_W[0].lerp(&side.centers_W[1], s));
            let seen = from.gradient;
            let askew = (seen + side.outward(-seen, s)).norm();
            let radius = side.radii[0] + s * (side.radii[1] - side.radii[0]);
            // Where the ball is inside there may be other ways out; beside a thin tip a small angle
            // is much.
            if told < 0.0
                || from.value < radius
                || askew > 0.1
                || matches!(other, Shape::Cone { .. })
            {
                continue;
            }
            tested += 1;
            let (aside, y) = (over.on_side_W.x.hypot(over.on_side_W.z), over.on_side_W.y);
            let on_circle = |k: u32| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 2000.0).sin_cos();
                b.distance(&Vec3::new(aside * cos, y, aside * sin)).value
            };
            let least = (0..2000).map(on_circle).fold(f64::INFINITY, f64::min);
            let off = (over.gap - told).abs();
            assert!(off < 1e-5, "{i} {shape:?} {other:?}: {} of {told}", over.gap);
            let (off, way) = (told - least, radius * askew);
            assert!(off < way + 1e-9, "{i} {shape:?} {other:?}: {off:e} of {told}, {way} aside");
            beyond += u32::from(off > 1e-4);
        }
        assert!(tested > 1000 && 200 * beyond < tested, "{beyond} of {tested} beyond");
    }

    /// Round sides of equal and other lengths and radii that overlap, level or askew: from the
    /// distance between an axis and a point of the other, less both radii, and never missing.
    #[test]
    fn ends_that_overlap_are_found() {
        let turned = |axis: Vec3, angle: f64| Quat::from_scaled_axis(axis * angle);
        for (radius, other) in [(0.02, 0.02), (0.01, 0.01), (0.002, 0.02), (0.004, 0.004)] {
            for longer in [1.0, 1.5] {
                for depth in [1e-9, 2e-5, 1e-4] {
                    for (pitch, yaw) in [(0.0, 0.0), (3e-3, 0.0), (0.0, 0.03), (1e-3, 0.1)] {
                        let shape = Shape::Cylinder { radius, half_length: 0.02 };
                        let below = Shape::Cylinder { radius: other, half_length: 0.02 * longer };
                        let turn = turned(Vec3::z(), pitch) * turned(Vec3::x(), yaw);
                        let a = at(&shape, turn, Vec3::x() * (radius + other - depth));
                        let b = at(&below, Quat::identity(), Vec3::zeros());
                        let side = RoundSide::of(&a).expect("round");
                        // Askew, an end may lie beyond that of the other, by 60 µm of 40 mm.
                        for s in [0.003, 0.3, 0.997] {
                            let center = side.centers_W[0].lerp(&side.centers_W[1], s);
                            let expected = center.x.hypot(center.z) - radius - other;
                            let over = side.over(&b, s).unwrap_or_else(|| {
                                panic!("{radius} {other} {longer} {depth} {pitch} {yaw} {s}")
                            });
                            // What a ball is off where a circle sweeps is less than half the square
                            // of the angle.
                            let off = (over.gap - expected).abs();
                            assert!(off < 1e-6 + 5e-3 * expected.abs(), "{over:?} {expected}");
                        }
                    }
                }
            }
        }
    }
}
