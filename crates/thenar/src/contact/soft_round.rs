//! Round parts of a rigid shape against the triangles of a deformable surface.
//!
//! A triangle touches a round part wherever it is nearest to it. Along a line of balls (a sphere, a
//! capsule) that place is found directly, and a line that lies along the triangle is held at both ends of
//! what lies over it; other curved parts are asked for their nearest place.

use crate::contact::approach::approach;
use crate::contact::near::{Arrival, Near};
use crate::contact::soft_feature::{ROUND_PLACES, Touch, depth_max};
use crate::contact::soft_rigid::{KEY_SEGMENT, SoftRigid};
use crate::contact::soft_samples::PLACES;
use crate::contact::triangle::{Closest, Feature, closest_on_triangle, segment_parameter};
use crate::contact::{Distance, Part};
use crate::math::Vec3;

/// Alternations between line and triangle on the way to their nearest points.
const NEAREST_ROUNDS: usize = 8;
/// A weight below this counts as none: the point lies on an edge.
const ON_EDGE: f64 = 1e-9;

/// The place on a centre line that is nearest to the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inmost {
    distance: f64,
    /// The contact that leads it out, where it is inside.
    pub inside: Option<Touch>,
}

impl Default for Inmost {
    fn default() -> Self {
        Self { distance: f64::INFINITY, inside: None }
    }
}

/// Where contacts of round parts go.
pub(crate) struct Touches<'a> {
    pub kept: &'a mut Vec<Touch>,
    pub inmost: &'a mut Inmost,
}

impl Touches<'_> {
    pub fn offer(&mut self, touch: Touch) {
        if self.kept.len() < self.kept.capacity() {
            self.kept.push(touch);
        }
    }
}

/// Lets a triangle touch part `r`, a line of balls of this radius (shape frame).
pub(crate) fn meet_line(
    pair: &SoftRigid,
    near: &Near,
    r: u32,
    line: &[Vec3; 2],
    radius: f64,
    touches: &mut Touches,
) {
    let (places, count) = places_on(line, &near.x, radius);
    for (k, &at) in places[..count].iter().enumerate() {
        let over = line[0] + at * (line[1] - line[0]);
        let closest = near.closest(&over);
        // The place on the line nearest to that point tells its distance.
        let c =
            line[0] + segment_parameter(&closest.point, &line[0], &line[1]) * (line[1] - line[0]);
        let key = [KEY_SEGMENT | (r * PLACES + k as u32), near.index];
        let to_line = closest.point - c;
        let distance = to_line.norm();
        let touch = |weights, normal, gap| Touch {
            key,
            triangle: near.index,
            weights,
            sharp: None,
            normal,
            gap,
        };
        if distance - radius > pair.margin {
            if distance - radius <= pair.margin + near.travel
                && let Some(Arrival { weights, normal, gap, .. }) =
                    near.arrival(&c, radius, pair.margin)
            {
                touches.offer(touch(weights, normal, gap));
            }
            continue;
        }
        let outward = outward(pair, near, closest.feature);
        let faces = outward.dot(&to_line) < 0.0;
        let direction = to_line.try_normalize(0.0).unwrap_or(-outward);
        if distance < touches.inmost.distance {
            let inside = !faces && distance <= depth_max(pair);
            let out = touch(closest.weights, -direction, -distance - radius);
            *touches.inmost = Inmost { distance, inside: inside.then_some(out) };
        }
        if faces && is_nearest_around(pair, near, &closest, &over) {
            touches.offer(touch(closest.weights, direction, distance - radius));
        }
    }
}

/// Lets a triangle touch part `r` at the place nearest to it.
pub(crate) fn meet_curved(
    pair: &SoftRigid,
    near: &Near,
    r: u32,
    part: &Part,
    touches: &mut Touches,
) {
    let x = near.x.map(|p| part.pose_SP.inverse_point(&p));
    let weights = part.shape.nearest_on_triangle(&x);
    let Some(feature) = owned_feature(pair, near, &weights) else { return };
    let p: Vec3 = (0..3).map(|k| x[k] * weights[k]).sum();
    let now = part.shape.distance(&p);
    let found = if now.value <= pair.margin {
        Some(now)
    } else {
        let u_S: Vec3 = near.motion(&weights);
        approach(&part.shape, &p, &part.pose_SP.inverse_vector(&u_S), 0.0, pair.margin)
    };
    let Some(Distance { value: gap, gradient }) = found else { return };
    let normal = part.pose_SP.vector(&gradient);
    if outward(pair, near, feature).dot(&normal) < 0.0 {
        let key = [KEY_SEGMENT | (r * PLACES), near.index];
        touches.offer(Touch { key, triangle: near.index, weights, sharp: None, normal, gap });
    }
}

/// The feature of the triangle on which a point with these weights lies; `None` at a vertex, which is a
/// contact of its own, and on an edge for which the triangle across it speaks.
fn owned_feature(pair: &SoftRigid, near: &Near, weights: &[f64; 3]) -> Option<Feature> {
    let without = |k: usize| weights[k] <= ON_EDGE;
    let feature = match (0..3).filter(|&k| without(k)).count() {
        0 => Feature::Face,
        1 => Feature::Edge((0..3).find(|&k| without((k + 2) % 3))?),
        _ => return None,
    };
    pair.surface.owns(near.index, feature).then_some(feature)
}

/// Outward normal of the soft surface, in the shape frame.
pub(crate) fn outward(pair: &SoftRigid, near: &Near, feature: Feature) -> Vec3 {
    let outward_W = pair.surface.pseudonormal(near.index, feature, pair.state.positions);
    pair.placed.rotation.tr_mul(&outward_W)
}

/// False where the neighbour across the edge is nearer, or speaks for the edge; vertices are contacts
/// of their own.
fn is_nearest_around(pair: &SoftRigid, near: &Near, closest: &Closest, c: &Vec3) -> bool {
    match closest.feature {
        Feature::Face => true,
        Feature::Vertex(_) => false,
        Feature::Edge(k) => {
            pair.surface.owns(near.index, closest.feature)
                && pair.surface.across(near.index, k).is_none_or(|other| {
                    let beyond = Near::new(pair, other).closest(c).distance_squared;
                    beyond >= closest.distance_squared * (1.0 - 1e-9)
                })
        }
    }
}

/// Where along its centre line a round part comes near to a triangle: at the place nearest to it, and
/// where it enters and leaves what lies over it. A line along the triangle is thus held at both ends.
fn places_on(line: &[Vec3; 2], x: &[Vec3; 3], radius: f64) -> ([f64; ROUND_PLACES], usize) {
    let along = line[1] - line[0];
    let length = along.norm();
    if length == 0.0 {
        return ([0.0; ROUND_PLACES], 1);
    }
    let at = |p: &Vec3| segment_parameter(p, &line[0], &line[1]);
    let point = |t: f64| line[0] + t * along;
    let mut nearest = at(&((x[0] + x[1] + x[2]) / 3.0));
    for _ in 0..NEAREST_ROUNDS {
        nearest = at(&closest_on_triangle(&point(nearest), x).point);
    }
    let mut places = [nearest; ROUND_PLACES];
    let mut count = 1;
    let normal = (x[1] - x[0]).cross(&(x[2] - x[0]));
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for k in 0..3 {
        let inward = normal.cross(&(x[(k + 1) % 3] - x[k]));
        let (start, slope) = (inward.dot(&(line[0] - x[k])), inward.dot(&along));
        if slope.abs() <= 1e-12 * inward.norm() * length {
            if start < 0.0 {
                return (places, count);
            }
        } else if slope > 0.0 {
            from = from.max(-start / slope);
        } else {
            to = to.min(-start / slope);
        }
    }
    if from < to {
        // Nearer together than this they are one: a ball of the radius is as good as flat there.
        let same = 1e-3 * radius / length;
        for end in [from, to] {
            if places[..count].iter().all(|p| (p - end).abs() > same) {
                places[count] = end;
                count += 1;
            }
        }
    }
    (places, count)
}
