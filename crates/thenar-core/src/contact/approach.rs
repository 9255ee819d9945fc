//! From a signed distance to the constraint of one moving point.
//!
//! A point within the margin of a shape is constrained along the gradient of the distance. A
//! farther one is followed along its motion of this step (sphere tracing: the distance says how
//! far it may safely go); if it comes within the margin on the way and nears, the constraint is the
//! tangent plane where it arrives, so that fast points are caught before they cross and points
//! that fly past are left alone. A point inside a thin shape is led out on the side it came in.

use crate::contact::soft_way::HYSTERESIS;
use crate::contact::{Distance, Shape};
use crate::math::Vec3;

/// Steps of one trace at most. Where they end early, a point on its way is constrained by the
/// tangent plane of where it has got to; a point inside finds no way out, and keeps its nearest.
const TRACE_STEPS_MAX: usize = 48;
/// A point that has come in did so where its way of this step came this near to the surface, in
/// parts of that way: the normal is that of the place it came through. No step of a trace is
/// shorter than half of it, so that none creeps.
const ENTERED: f64 = 1e-3;
/// Steps along a segment at most: of one that goes 100 mm in a step each is a quarter of a card's
/// thickness.
const SEGMENT_STEPS_MAX: f64 = 480.0;
/// A nearest face that turns by less than this (cosine of 45°) from the one that was seen is nearer
/// to it than to one that is square to it: the point went on along a surface that bends.
const BENT: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Faces are square to each other within this (cosine): vertices of meshes have single precision.
const SQUARE: f64 = 10.0 * f32::EPSILON as f64;
/// A straight way through a plate goes as deep as its middle, and one that cuts off a rim only as
/// far as that reaches in: half as deep is a quarter of the thickness from the rim.
const THROUGH: f64 = 0.5;
/// Out of a shape within this part of the depth: what all steps of a trace come to on a face at 75°
/// to the way, each of which leaves a part `1 - cos 75°`.
const OUTSIDE: f64 = 1e-6;

/// The side of a shape on which a point was last seen, in the shape frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LastSide {
    /// Outward normal then.
    pub normal: Vec3,
    /// Position of the point then.
    pub place: Vec3,
}

/// The gap and normal of a ball of `radius` about `p` that is about to move by `u`, or `None`
/// when it stays farther than `margin`. All in the shape frame.
pub(crate) fn approach(
    shape: &Shape,
    p: &Vec3,
    u: &Vec3,
    radius: f64,
    margin: f64,
) -> Option<Distance> {
    approach_from(shape, p, shape.distance(p), u, radius, margin)
}

/// Gap and normal that [`approach`] finds, for a centre whose distance `now` is known.
pub(crate) fn approach_from(
    shape: &Shape,
    p: &Vec3,
    now: Distance,
    u: &Vec3,
    radius: f64,
    margin: f64,
) -> Option<Distance> {
    let gap = now.value - radius;
    if gap <= margin {
        return Some(Distance { value: gap, ..now });
    }
    let length = u.norm();
    if gap > margin + length {
        return None;
    }
    trace(shape, p, now, u, length, radius, margin)
}

/// Follows the ball along `u` to the first place within `margin` of the shape that it nears: one
/// that it passes by lies behind its tangent plane there, outside though it is.
fn trace(
    shape: &Shape,
    p: &Vec3,
    now: Distance,
    u: &Vec3,
    length: f64,
    radius: f64,
    margin: f64,
) -> Option<Distance> {
    let mut s = 0.0;
    let mut at = now;
    for _ in 0..TRACE_STEPS_MAX {
        let gap = at.value - radius;
        if gap <= margin && u.dot(&at.gradient) < 0.0 {
            break;
        }
        s += (gap - 0.5 * margin).max(0.5 * margin) / length;
        if s > 1.0 {
            return None;
        }
        at = shape.distance(&(p + s * u));
    }
    if u.dot(&at.gradient) >= 0.0 {
        // Still on its way past a large shape.
        return None;
    }
    // Height of the present place over the tangent plane there.
    let value = at.value - radius - s * u.dot(&at.gradient);
    Some(Distance { value, gradient: at.gradient })
}

/// Corrects the choice of side: `now` is the distance at `p`, which arrived there by about `u`.
pub(crate) fn keep_side(
    shape: &Shape,
    p: &Vec3,
    u: &Vec3,
    now: Distance,
    seen: Option<LastSide>,
) -> Distance {
    if now.value >= 0.0 {
        return match seen {
            Some(side) if side.normal.dot(&now.gradient) < 0.0 => {
                came_through(shape, &side.place, p, &side.normal).unwrap_or(now)
            }
            _ => now,
        };
    }
    let Some(LastSide { normal, place }) = seen.or_else(|| entry(shape, p, u, now.value)) else {
        return now;
    };
    let turned = normal.dot(&now.gradient);
    if turned > BENT {
        return now;
    }
    let found = match turned < -SQUARE {
        true => came_through(shape, &place, p, &normal),
        false => way_out(shape, p, &normal).filter(|out| out.value > HYSTERESIS * now.value),
    };
    found.unwrap_or(now)
}

/// The way back along `normal` of a point that came straight through the shape from `from`; `None`
/// for one that went round its rim: the straight way cuts off no more than that, and lies nowhere
/// as deep as a plate's middle would that is as thick as the way back.
fn came_through(shape: &Shape, from: &Vec3, p: &Vec3, normal: &Vec3) -> Option<Distance> {
    let (out, inside) = way_back(shape, p, normal)?;
    let is_through = inside > 0.0 && lies_as_deep(shape, from, p, 0.5 * THROUGH * inside);
    is_through.then_some(out)
}

/// Normal of the surface where a point now inside came in, if it can have come in by `u`.
fn entry(shape: &Shape, p: &Vec3, u: &Vec3, depth: f64) -> Option<LastSide> {
    let length = u.norm();
    let from = p - u;
    if length <= -depth {
        return None;
    }
    let there = shape.distance(&from);
    if there.value <= 0.0 {
        return None;
    }
    let near = ENTERED * length;
    let arrival = approach_from(shape, &from, there, u, 0.0, near)?;
    Some(LastSide { normal: arrival.gradient, place: from })
}

/// True when the segment between two points lies `depth` \[m\] inside the shape somewhere, as far
/// as the steps of the search tell.
fn lies_as_deep(shape: &Shape, from: &Vec3, to: &Vec3, depth: f64) -> bool {
    let way = to - from;
    let length = way.norm();
    let least = length / SEGMENT_STEPS_MAX;
    let mut s = 0.0;
    loop {
        let part = if length > 0.0 { s / length } else { 0.0 };
        let value = shape.distance(&(from + way * part)).value;
        if value <= least - depth {
            return true;
        }
        if s >= length {
            return false;
        }
        // Nearer than by the difference it is not as deep.
        s = (s + value + depth).min(length);
    }
}

/// Depth of `p` along `normal`: how far it must go that way to be outside on that side.
fn way_out(shape: &Shape, p: &Vec3, normal: &Vec3) -> Option<Distance> {
    way_back(shape, p, normal).map(|(out, _)| out)
}

/// Depth of `p` along `normal` like [`way_out`], and how much of that way lies inside the shape
/// \[m\].
fn way_back(shape: &Shape, p: &Vec3, normal: &Vec3) -> Option<(Distance, f64)> {
    let (mut way, mut before, mut deepest) = (0.0, 0.0, 0.0_f64);
    for _ in 0..TRACE_STEPS_MAX {
        let at = shape.distance(&(p + way * normal));
        deepest = deepest.max(-at.value);
        if at.value >= -OUTSIDE * deepest && at.gradient.dot(normal) > 0.0 {
            let inside = if deepest > 0.0 { way - before } else { 0.0 };
            return Some((Distance { value: at.value - way, gradient: *normal }, inside));
        }
        if deepest == 0.0 {
            before = way + at.value;
        }
        // On the far side to round-off, it goes on, by what is little beside the shape.
        way += at.value.abs().max(OUTSIDE * deepest.max(p.norm()));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const PLATE: Shape = Shape::Cuboid { half: Vec3::new(0.1, 0.001, 0.1) };

    #[test]
    fn slow_and_near_uses_the_distance_itself() {
        let d = approach(&PLATE, &Vec3::new(0.0, 0.0015, 0.0), &Vec3::zeros(), 0.0, 1e-3);
        let d = d.expect("0.5 mm away");
        assert!((d.value - 0.0005).abs() < 1e-15);
        assert_eq!(d.gradient, Vec3::y());
        let far = Vec3::new(0.0, 0.0025, 0.0);
        assert!(approach(&PLATE, &far, &Vec3::zeros(), 0.0, 1e-3).is_none());
    }

    /// 5 m/s in 1/60 s is 83 mm: through a 2 mm plate from any height below that.
    #[test]
    fn a_fast_point_is_caught_before_a_thin_plate() {
        let u = Vec3::new(0.0, -5.0 / 60.0, 0.0);
        for i in 1..80 {
            let height = 1e-3 * f64::from(i);
            let p = Vec3::new(0.02, 0.001 + height, -0.03);
            let d = approach(&PLATE, &p, &u, 0.0, 1e-3).expect("crosses");
            assert!((d.value - height).abs() < 1e-12, "height {height}: {}", d.value);
            assert_eq!(d.gradient, Vec3::y());
        }
        assert!(approach(&PLATE, &Vec3::new(0.0, 0.087, 0.0), &u, 0.0, 1e-3).is_none());
    }

    /// Points that fly past a ball or an edge, however near, and points that hit them, from all
    /// sides: the constraint of one that is outside now never says that it is inside.
    #[test]
    fn no_point_outside_is_told_to_be_inside() {
        let shapes = [
            Shape::Sphere { radius: 0.02 },
            Shape::Cuboid { half: Vec3::new(0.02, 0.01, 0.03) },
            Shape::Capsule { radius: 0.004, half_length: 0.02 },
            Shape::Sphere { radius: 0.1 },
            Shape::Cuboid { half: Vec3::new(0.3, 0.002, 0.2) },
        ];
        let mut noise = Random::new(7);
        let mut arrived = 0;
        for i in 0..50_000 {
            let shape = &shapes[i % 5];
            // Large ones are flown past farther in a step.
            let size = if i % 5 < 3 { 0.04 } else { 0.2 };
            let p = noise.vector(size);
            let u = noise.vector(1.25 * size);
            if shape.distance(&p).value <= 1e-3 {
                continue;
            }
            let Some(d) = approach(shape, &p, &u, 0.0, 1e-3) else { continue };
            arrived += 1;
            assert!(d.value > 0.0, "{shape:?} from {p} by {u}: {}", d.value);
        }
        assert!(arrived > 2000, "{arrived}");
    }

    /// A point that comes in sideways over the edge and lands on the top face is stopped by the
    /// top face; one that passes the edge at a distance is not stopped at all.
    #[test]
    fn the_plane_is_that_of_the_place_of_arrival() {
        let landing =
            approach(&PLATE, &Vec3::new(0.12, 0.03, 0.0), &Vec3::new(-0.06, -0.04, 0.0), 0.0, 1e-3);
        let landing = landing.expect("lands 60 mm inward");
        assert!(landing.gradient.y > 0.99);
        assert!((landing.value - 0.029).abs() < 1e-4);
        let passing =
            approach(&PLATE, &Vec3::new(0.104, 0.03, 0.0), &Vec3::new(0.0, -0.08, 0.0), 0.0, 1e-3);
        assert!(passing.is_none());
    }

    #[test]
    fn a_point_past_the_middle_goes_back_the_way_it_came() {
        for depth in [0.0002, 0.0009, 0.0011, 0.0019, 0.00199999] {
            let p = Vec3::new(0.01, 0.001 - depth, 0.0);
            let now = PLATE.distance(&p);
            let seen = LastSide { normal: Vec3::y(), place: Vec3::new(0.01, 0.0012, 0.0) };
            let d = keep_side(&PLATE, &p, &Vec3::zeros(), now, Some(seen));
            assert!((d.value + depth).abs() < 1e-8, "depth {depth}: {}", d.value);
            assert_eq!(d.gradient, Vec3::y());
            // Without memory, the motion tells.
            let u = Vec3::new(0.0, -0.004, 0.0);
            let d = keep_side(&PLATE, &p, &u, now, None);
            assert!((d.value + depth).abs() < 1e-8 && d.gradient == Vec3::y());
        }
    }

    #[test]
    fn a_point_that_slipped_through_is_called_back_and_one_that_went_round_is_not() {
        let below = Vec3::new(0.01, -0.003, 0.0);
        let seen = LastSide { normal: Vec3::y(), place: Vec3::new(0.01, 0.002, 0.0) };
        let d = keep_side(&PLATE, &below, &Vec3::zeros(), PLATE.distance(&below), Some(seen));
        assert!((d.value + 0.004).abs() < 1e-8 && d.gradient == Vec3::y());

        let seen = LastSide { normal: Vec3::y(), place: Vec3::new(0.103, 0.002, 0.0) };
        let round = Vec3::new(0.103, -0.002, 0.0);
        let now = PLATE.distance(&round);
        assert_eq!(keep_side(&PLATE, &round, &Vec3::zeros(), now, Some(seen)), now);
    }

    /// Round the rim of a plate, with a straight way that cuts off a tenth of its thickness,
    /// outside now or just inside as in contact; and through, three quarters of its thickness from
    /// the rim.
    #[test]
    fn a_rim_that_is_cut_off_is_gone_round() {
        for half in [0.5e-3, 2e-3, 0.01, 0.05] {
            let plate = Shape::Cuboid { half: Vec3::new(10.0 * half, half, 10.0 * half) };
            for (inward, through) in [(0.1, false), (0.2, false), (0.75, true), (4.0, true)] {
                for (above, below) in
                    [(0.1, 1e-2), (0.1, -1e-3), (3.0, 1e-2), (0.0, 5.0), (30.0, 1e-2)]
                {
                    let rim = 10.0 * half - inward * half;
                    let place = Vec3::new(rim, half * (1.0 + above), 0.0);
                    let p = Vec3::new(rim, -half * (1.0 + below), 0.0);
                    let seen = Some(LastSide { normal: Vec3::y(), place });
                    let now = plate.distance(&p);
                    let d = keep_side(&plate, &p, &(p - place), now, seen);
                    let what =
                        format!("{half} m, {inward} from the rim, {above} above, {below} below");
                    if through {
                        let depth = half * (2.0 + below);
                        assert!((d.value / depth + 1.0).abs() < 1e-5, "{what}: {}", d.value);
                        assert_eq!(d.gradient, Vec3::y(), "{what}");
                    } else {
                        assert_eq!(d, now, "{what}");
                    }
                }
            }
        }
    }

    /// Past the side of a ball by 95° in a step, as flesh goes that a fast ball passes by: the way
    /// back along the old normal passes by it, too.
    #[test]
    fn what_flies_round_a_ball_is_not_in_it() {
        for radius in [1e-3, 0.01, 0.3] {
            let ball = Shape::Sphere { radius };
            let at = |degrees: f64| {
                let (sin, cos) = degrees.to_radians().sin_cos();
                1.01 * radius * Vec3::new(cos, sin, 0.0)
            };
            let (place, p) = (at(70.0), at(-25.0));
            let seen = Some(LastSide { normal: place.normalize(), place });
            let now = ball.distance(&p);
            assert_eq!(keep_side(&ball, &p, &(p - place), now, seen), now, "{radius} m");
        }
    }

    #[test]
    fn the_edge_of_a_thick_box_lets_go_sideways() {
        let cube = Shape::Cuboid { half: Vec3::repeat(0.05) };
        let p = Vec3::new(0.0499, 0.045, 0.0);
        let now = cube.distance(&p);
        let seen = LastSide { normal: Vec3::y(), place: p };
        // 5 mm below the top but 0.1 mm from the side.
        assert_eq!(keep_side(&cube, &p, &Vec3::zeros(), now, Some(seen)), now);
    }

    /// A face that bends keeps its nearest place up to 45°, beyond that a point goes back the way
    /// it came if that is less than twice as far. At a depth of a hundredth of the radius it is
    /// `d / cos θ` but for 2 %.
    #[test]
    fn what_bends_by_less_than_45_degrees_is_the_same_side() {
        let (ball, p) = (Shape::Sphere { radius: 0.02 }, Vec3::y() * 0.0198);
        let now = ball.distance(&p);
        for (degrees, same) in [(44.0, true), (46.0, false), (58.0, false), (62.0, true)] {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let seen = LastSide { normal: Vec3::new(sin, cos, 0.0), place: p };
            let d = keep_side(&ball, &p, &Vec3::zeros(), now, Some(seen));
            let way = Distance { value: -2e-4 / cos, gradient: seen.normal };
            let expected = if same { now } else { way };
            assert!((d.value / expected.value - 1.0).abs() < 0.02, "{degrees}°: {}", d.value);
            assert_eq!(d.gradient, expected.gradient, "{degrees}°");
        }
    }

    /// Three times as deep below the top as behind the side, seen from above: the side leads out,
    /// also where a mesh of single precision tells that its faces turn by a little more than a
    /// right angle.
    #[test]
    fn square_faces_are_no_opposite_ones() {
        let cube = Shape::Cuboid { half: Vec3::repeat(0.01) };
        let p = Vec3::new(0.0099, 0.0097, 0.0);
        let now = cube.distance(&p);
        let lead = |tilt: f64| {
            let seen = LastSide { normal: Vec3::new(-tilt, 1.0, 0.0).normalize(), place: p };
            keep_side(&cube, &p, &Vec3::zeros(), now, Some(seen))
        };
        for tilt in [0.0, f64::from(f32::EPSILON), -f64::from(f32::EPSILON)] {
            assert_eq!(lead(tilt), now, "{tilt}");
        }
        assert!((lead(1e-3).value + 3e-4).abs() < 1e-6, "opposite, it goes back");
    }

    /// A shape of any size lets a point out to a millionth of its depth, obliquely too.
    #[test]
    fn ways_out_end_at_the_surface_at_every_size() {
        for size in [1e-6, 1e-3, 1.0, 1e3] {
            let cube = Shape::Cuboid { half: Vec3::repeat(size) };
            for degrees in [0.0, 30.0, 60.0, 75.0] {
                let (sin, cos) = f64::to_radians(degrees).sin_cos();
                let p = Vec3::new(-0.9 * size, 0.7 * size, 0.0);
                let out = way_out(&cube, &p, &Vec3::new(sin, cos, 0.0)).expect("it comes out");
                // The nearest side bounds the first step, the top the way.
                let depth = 0.3 * size / cos;
                assert!(
                    (out.value + depth).abs() <= 1e-5 * size,
                    "{size} {degrees}: {}",
                    out.value
                );
            }
        }
    }
}
