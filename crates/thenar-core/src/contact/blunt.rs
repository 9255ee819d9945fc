//! Directions at sharp edges.
//!
//! Around an edge the nearest place of a shape stays while the direction to it turns, through a
//! right angle within the distance of the point. Of a point that presses an edge that distance is
//! round-off, and so would be the direction. A direction is therefore looked for from a little
//! inside the flesh: as if the edge were rounded by that much, it turns while the point moves by as
//! much as the radius. Gaps stay what they are. Faces and smooth shapes give the directions they
//! gave. Flesh with edges of its own, a block's, has no one direction inward there: the sharper it
//! is the less is rounded.

use crate::contact::triangle::ROUNDED_UP;
use crate::contact::{Distance, Shape};
use crate::math::Vec3;
use std::cell::Cell;

/// Radius of the rounding over the edges of the surface that touches. Measured on things drawn over
/// fingertips: with a third of it the direction at a vertex turns within a step or two of 20 µm,
/// with three times as much a corner beside a vertex turns it.
const RADIUS: f64 = 0.03;
/// A surface as bent as a right-angled edge, of whose two normals the mean has this length, sees
/// edges as they are.
const BENT: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Directions at an edge differ by a right angle, at a corner by somewhat more (125° between the
/// middle of a cube's corner and a face behind it).
const OPPOSITE: f64 = -0.6;
/// In radii: what differs by less is the same plane.
const ROUND_OFF: f64 = 1e-6;

/// Distance to a shape for a point `p` at distance `now`, its direction that of the rounded shape.
/// `outward` gives the mean of the unit normals of its surface around it, where it is needed;
/// `edge` is the length of edges there. All in the shape frame.
pub(crate) fn blunted(
    shape: &Shape,
    p: &Vec3,
    outward: impl FnOnce() -> Vec3,
    edge: f64,
    now: Distance,
) -> Distance {
    // The point looks from no nearer than its own distance.
    let less = now.value.max(0.0);
    if RADIUS * edge <= less {
        return now;
    }
    let outward = outward();
    let length = outward.norm();
    let part = (length - BENT) / (1.0 - BENT);
    let radius = part * RADIUS * edge - less;
    if radius <= 0.0 {
        return now;
    }
    let outward = outward / length;
    let most = (now.value.abs() + radius) * ROUNDED_UP;
    let at = shape.distance_near(&(p - radius * outward), most, &Cell::new(u32::MAX));
    // Deeper than that, the nearest face leads out.
    if at.value <= 0.0 {
        return now;
    }
    let plane = at.value + radius * at.gradient.dot(&outward);
    // No plane that touches a convex shape is farther than the shape: in a hollow that is another
    // wall.
    if plane > now.value + ROUND_OFF * radius {
        return now;
    }
    // Flesh that looks away from a thin edge looks at its far side.
    match at.gradient.dot(&now.gradient) < OPPOSITE {
        true => now,
        false => Distance { gradient: at.gradient, ..now },
    }
}

/// Unit normal at smooth flesh that a sharp part of a shape touches: `way` leads from there to the
/// nearest place of the surface, `gap` \[m\] far. Seen from inside the flesh, as above; what has
/// come in leaves along `outward`, the unit normal of the surface.
pub(crate) fn way_to(way: &Vec3, gap: f64, outward: &Vec3, edge: f64) -> Vec3 {
    if gap <= 0.0 {
        return -outward;
    }
    let radius = (RADIUS * edge - gap).max(0.0);
    (way - outward * radius).try_normalize(0.0).unwrap_or(-outward)
}

/// True when a shape has edges that point outward.
pub(crate) fn has_edges(shape: &Shape) -> bool {
    match shape {
        Shape::Sphere { .. }
        | Shape::Capsule { .. }
        | Shape::Ellipsoid { .. }
        | Shape::HalfSpace => false,
        Shape::Cuboid { .. } | Shape::Cylinder { .. } | Shape::Cone { .. } | Shape::Mesh(_) => true,
        Shape::Compound(parts) => parts.iter().any(|part| has_edges(&part.shape)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::PlacedShape;
    use crate::math::Pose;

    const EDGE: f64 = 8e-3;
    const BOX: Shape = Shape::Cuboid { half: Vec3::new(0.01, 0.02, 0.03) };
    const TIN: Shape = Shape::Cylinder { radius: 0.012, half_length: 0.01 };

    fn seen(shape: &Shape, p: &Vec3, outward: &Vec3) -> Distance {
        blunted(shape, p, || outward.normalize(), EDGE, shape.distance(p))
    }

    /// A sheet of 2 µm, and a point above it that looks up, as flesh does which is cut from the
    /// side.
    #[test]
    fn gaps_stay_and_directions_do_not_turn_back() {
        let sheet = Shape::Cuboid { half: Vec3::new(0.01, 1e-6, 0.01) };
        for height in [1e-6, 20e-6, 45e-6, 70e-6, 200e-6] {
            let p = Vec3::new(0.0, height, 0.0);
            let (d, exact) = (seen(&sheet, &p, &Vec3::y()), sheet.distance(&p));
            assert_eq!(d.value, exact.value, "{height}");
            assert!(d.gradient.dot(&exact.gradient) > -0.6, "{height}: {}", d.gradient);
        }
    }

    #[test]
    fn faces_stay_as_they_are() {
        for tilt in [-0.5, 0.0, 0.9] {
            for height in [-5e-5, 0.0, 1e-6, 1e-4, 2e-3] {
                let outward = Vec3::new(tilt, -1.0, 0.3 * tilt);
                for (shape, p) in [
                    (&BOX, Vec3::new(0.003, 0.02 + height, -0.01)),
                    (&TIN, Vec3::new(0.003, 0.01 + height, -0.005)),
                ] {
                    let (d, exact) = (seen(shape, &p, &outward), shape.distance(&p));
                    assert!((d.value - exact.value).abs() < 1e-17, "{height} {tilt}");
                    assert!((d.gradient - exact.gradient).norm() < 1e-14, "{height} {tilt}");
                }
            }
        }
    }

    /// A floor and a wall, and a point 5 µm in the floor and 20 µm before the wall.
    #[test]
    fn the_floor_of_a_corner_stays_where_a_wall_is_near() {
        let part = |half: Vec3, at: Vec3| PlacedShape {
            shape: Shape::Cuboid { half },
            pose_SP: Pose::translation(at.x, at.y, at.z),
        };
        let corner = Shape::Compound(std::sync::Arc::new(vec![
            part(Vec3::new(0.05, 0.01, 0.05), Vec3::new(0.05, -0.01, 0.0)),
            part(Vec3::new(0.01, 0.05, 0.05), Vec3::new(-0.01, 0.0, 0.0)),
        ]));
        let p = Vec3::new(20e-6, -5e-6, 0.0);
        let d = seen(&corner, &p, &Vec3::new(-0.2, -0.98, 0.0));
        assert!((d.value + 5e-6).abs() < 1e-15 && d.gradient == Vec3::y(), "{d:?}");
    }

    #[test]
    fn what_is_an_edge_itself_sees_edges_as_they_are() {
        // Corners of a block that stands on a box of its own width, to round-off.
        let outward = (Vec3::new(1.0, -1.0, 0.0)) * 0.5;
        for off in [-1e-9, 0.0, 1e-9] {
            let p = Vec3::new(0.01 + off, 0.02 + 1e-6, 0.0);
            let (d, exact) =
                (blunted(&BOX, &p, || outward, EDGE, BOX.distance(&p)), BOX.distance(&p));
            assert_eq!((d.value, d.gradient), (exact.value, exact.gradient));
            assert!(d.gradient.y > 0.999);
        }
    }

    /// Over the rim of a tin, the upper edge and the corner of a box, along a way that leads
    /// through the edge or past it by nanometres, in steps of a micrometre: the direction turns by
    /// no more than a micrometre over half the radius at a time, and gaps are those of the sharp
    /// shape.
    #[test]
    fn directions_turn_slowly_over_edges() {
        let ways = [
            (
                &TIN,
                Vec3::new(0.012, 0.01, 0.0),
                Vec3::new(1.0, -1.0, 0.0),
                Vec3::new(-1.0, -1.0, 0.0),
            ),
            (
                &BOX,
                Vec3::new(0.01, 0.02, 0.0),
                Vec3::new(1.0, -1.0, 0.0),
                Vec3::new(-1.0, -1.0, 0.0),
            ),
            (
                &BOX,
                Vec3::new(0.01, 0.02, 0.03),
                Vec3::new(1.0, -1.0, 0.2),
                Vec3::new(-1.0, -1.0, -1.0),
            ),
        ];
        let step = 1e-6;
        for (shape, edge, way, outward) in ways {
            for past in [0.0, 1e-9, 1e-7, 2e-6] {
                let at = |k: i32| {
                    let p = edge - outward * past + way.normalize() * (f64::from(k) * step);
                    (p, seen(shape, &p, &outward))
                };
                for k in -400..400 {
                    let ((p, a), (_, b)) = (at(k), at(k + 1));
                    let turned = a.gradient.angle(&b.gradient);
                    assert!(turned <= step / (0.5 * RADIUS * EDGE), "{past} {k}: {turned} rad");
                    let off = (a.value - shape.distance(&p).value).abs();
                    assert!(off == 0.0, "{past} {k}: {off} m");
                }
            }
        }
    }
}
