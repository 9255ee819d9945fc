//! Fixed points of a deformable surface against a round part that is large beside its triangles.
//!
//! The place where a flat triangle is nearest to a ball of radius R moves by `R θ` when the triangle
//! tilts by θ. Held at that place alone, a triangle under a load F rocks from step to step for ever
//! where `R F` exceeds its stiffness against tilting; held at fixed points it does not. Points so near to
//! each other that the ball bulges by less than [`TOUCHING`] between them hold it as well as all of the
//! triangle would.

use crate::contact::approach::approach_from;
use crate::contact::area::TOUCHING;
use crate::contact::near::Near;
use crate::contact::soft_feature::Touch;
use crate::contact::soft_rigid::{KEY_SEGMENT, SoftRigid};
use crate::contact::soft_round::{ROUND_PLACES, Touches, blunted_on, outward};
use crate::contact::triangle::Feature;
use crate::contact::{Distance, Part, Shape};
use crate::math::Vec3;

/// Most parts of an edge: a ball for which they are not enough is small, and held at its nearest place.
const PARTS_MAX: u32 = 16;
/// Points of a triangle with so many.
const POINTS_MAX: usize = ((PARTS_MAX + 1) * (PARTS_MAX + 2) / 2) as usize;
/// Of the points of one triangle those touch that are farther than the nearest by no more than this part of the margin,
/// and what the triangle travels: it holds them apart as long as it does not turn by that much. The margin is what a
/// step may move beside what is foreseen of it; of turning a quarter is allowed for. Tests of detection alone hold with
/// none, too.
const BEHIND: f64 = 0.25;
/// Numbers for the places of one part, these and those on its centre line.
pub(crate) const PLACES: u32 = 512;
/// The first number of a fixed point; those before are of places that move.
const FIRST: u32 = ROUND_PLACES as u32;

/// A part with a radius of so many edges is flat there: the nearest place goes as far for each radian that the
/// triangle tilts. A smaller one touches at places that move: drawn over fixed points it would hand its load from
/// one to the next, and the normal at these differs by the angle that the part turns between them (a capsule of
/// 3 mm over triangles of 7 mm had 1 to 2.5 % of its force above 50 Hz at 20 mm/s; 0.2 % with places that move).
const FLAT: f64 = 0.5;
/// A flat part is held at fixed points if it bulges between them by no more than this, in lengths of the edge:
/// what gaps are good for.
const BULGE_MAX: f64 = 0.01;

/// Into how many parts to divide the edges of a triangle under a round part, so that it bulges by no
/// more than [`TOUCHING`] between points; `None` where these would be too many, or the place nearest to the
/// part does not go far. Lengths at rest alone decide.
pub(crate) fn parts(pair: &SoftRigid, near: &Near, part: &Part) -> Option<u32> {
    division(pair.surface.edge_of[near.index as usize], &part.shape)
}

/// The same for a triangle whose longest edge is `edge` \[m\].
fn division(edge: f64, shape: &Shape) -> Option<u32> {
    if matches!(shape, Shape::Cylinder { radius, .. } if *radius < edge) {
        // Drawn along with its rim it would let go of one fixed point after the other: the nearest place goes along.
        return None;
    }
    let [least, greatest] = radii(shape);
    if greatest < FLAT * edge {
        return None;
    }
    let needed = (edge / (8.0 * least * TOUCHING).sqrt()).ceil().max(1.0);
    if needed <= f64::from(PARTS_MAX) {
        return Some(needed as u32);
    }
    let bulge = (edge / f64::from(PARTS_MAX)).powi(2) / (8.0 * least);
    (bulge <= BULGE_MAX * edge).then_some(PARTS_MAX)
}

/// The least and the greatest radius of curvature \[m\]. Along its axis a capsule is held at both ends of what lies
/// over a triangle, so that its flatness there does not count.
fn radii(shape: &Shape) -> [f64; 2] {
    let least = shape.least_radius();
    match shape {
        Shape::Ellipsoid { half } => [least, half.max() * half.max() / half.min()],
        _ => [least; 2],
    }
}

/// Lets the fixed points of a triangle touch part `r`; its corners are contacts of their own. Of those that
/// only arrive in this step the one that would get deepest stands for all: once there, the others are
/// within the margin.
pub(crate) fn meet_samples(
    pair: &SoftRigid,
    near: &Near,
    r: u32,
    part: &Part,
    parts: u32,
    touches: &mut Touches,
) {
    let x = near.x.map(|p| part.pose_SP.inverse_point(&p));
    let at = |weights: &[f64; 3]| -> Vec3 { (0..3).map(|k| x[k] * weights[k]).sum() };
    let mut distances = [None; POINTS_MAX];
    let mut nearest = f64::INFINITY;
    for ((_, weights), distance) in places(parts).zip(&mut distances) {
        let now = part.shape.distance(&at(&weights));
        nearest = nearest.min(now.value);
        *distance = Some(now);
    }
    if nearest > pair.margin + near.travel {
        return;
    }
    let reach = pair.margin.min(nearest.max(0.0) + BEHIND * pair.margin + near.travel);
    let mut arriving: Option<(f64, Touch)> = None;
    for ((place, weights), now) in places(parts).zip(distances) {
        let (Some(now), p) = (now, at(&weights)) else { break };
        let feature = feature_at(&weights);
        let touch = |found: Distance| {
            let normal = part.pose_SP.vector(&found.gradient);
            let key = [KEY_SEGMENT | (r * PLACES + place), near.index];
            let faces = outward(pair, near, feature).dot(&normal) < 0.0;
            let (triangle, gap) = (near.index, found.value);
            let touch = Touch { key, triangle, weights, sharp: None, normal, gap };
            (faces && pair.surface.owns(near.index, feature)).then_some(touch)
        };
        if now.value <= pair.margin {
            if now.value <= reach {
                let now = blunted_on(pair, near, part, (&p, &weights), now);
                touch(now).into_iter().for_each(|touch| touches.offer(touch));
            }
            continue;
        }
        if now.value > pair.margin + near.travel {
            continue;
        }
        let u_P = part.pose_SP.inverse_vector(&near.motion(&weights));
        let found = approach_from(&part.shape, &p, now, &u_P, 0.0, pair.margin);
        let Some(found) = found else { continue };
        let end = found.value + found.gradient.dot(&u_P);
        if arriving.is_none_or(|(least, _)| end < least)
            && let Some(touch) = touch(found)
        {
            arriving = Some((end, touch));
        }
    }
    if let Some((_, touch)) = arriving {
        touches.offer(touch);
    }
}

/// Numbers and weights of the fixed points of a triangle whose edges are divided so; its corners left out.
fn places(parts: u32) -> impl Iterator<Item = (u32, [f64; 3])> {
    let of_row = move |i| (0..=parts - i).map(move |j| (i, j));
    (0..=parts).flat_map(of_row).filter_map(move |(i, j)| {
        let counts = [parts - i - j, i, j];
        let place = FIRST + i * (PARTS_MAX + 1) + j;
        let weights = counts.map(|n| f64::from(n) / f64::from(parts));
        (!counts.contains(&parts)).then_some((place, weights))
    })
}

/// The face, or the edge opposite to the corner without weight.
fn feature_at(weights: &[f64; 3]) -> Feature {
    let opposite = weights.iter().position(|w| *w == 0.0);
    opposite.map_or(Feature::Face, |k| Feature::Edge((k + 1) % 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_large_beside_a_triangle_is_held_at_fixed_points() {
        // Parts of an edge of e: e / √(8 R · 20 µm), rounded up.
        let ball = |radius: f64| Shape::Sphere { radius };
        assert_eq!(division(0.016, &ball(0.03)), Some(8));
        assert_eq!(division(0.016, &ball(0.008)), Some(15));
        assert_eq!(division(0.016, &ball(0.005)), None);
        // Too large for its number of points, and flat.
        assert_eq!(division(0.036, &ball(0.03)), Some(PARTS_MAX));
        assert_eq!(division(0.001, &ball(0.05)), Some(1));
        // A tin narrower than the triangle, and a column.
        let cylinder = |radius: f64| Shape::Cylinder { radius, half_length: 0.06 };
        assert_eq!(division(0.016, &cylinder(0.012)), None);
        assert_eq!(division(0.016, &cylinder(0.06)), Some(6));
        // A pebble rocks about its flat side, of 50 mm, though its tip has 3.2; a needle's tip is too sharp.
        let pebble = Shape::Ellipsoid { half: Vec3::new(0.02, 0.008, 0.014) };
        assert_eq!(division(0.016, &pebble), Some(PARTS_MAX));
        let needle = Shape::Ellipsoid { half: Vec3::new(0.04, 0.003, 0.003) };
        assert_eq!(division(0.016, &needle), None);
    }

    #[test]
    fn places_have_numbers_of_their_own() {
        for parts in 1..=PARTS_MAX {
            let mut numbers: Vec<u32> = places(parts).map(|(place, _)| place).collect();
            assert!(numbers.iter().all(|n| (FIRST..PLACES).contains(n)));
            let count = numbers.len();
            assert_eq!(count as u32, (parts + 1) * (parts + 2) / 2 - 3);
            numbers.dedup();
            assert_eq!(numbers.len(), count);
            assert!(count <= POINTS_MAX);
        }
    }
}
