//! What of a rigid shape comes between the vertices of a deformable surface: its sharp points, and,
//! where it is round, its centre line.
//!
//! Every contact made here stands for a point of one surface and its true distance to the other, so
//! none holds what does not meet. A sharp point touches the triangle that is nearest to it. A round
//! part touches *every* triangle near it, each at its own nearest point: contacts then move along with
//! the bodies, and a large ball does not rest on one triangle after another.

use crate::contact::Shape;
use crate::contact::collector::{Collector, feature_key};
use crate::contact::features::capsule_axis;
use crate::contact::near::{Arrival, Near};
use crate::contact::soft_rigid::{KEY_POINT, KEY_SEGMENT, SoftRigid, VertexScratch};
use crate::contact::triangle::{Closest, Feature, segment_parameter};
use crate::contact::{Contact, Site, SurfacePoint};
use crate::math::Vec3;

const NONE: u32 = u32::MAX;

/// Work space of the search.
#[derive(Clone, Debug, Default)]
pub(crate) struct FeatureScratch {
    /// Per sharp point the nearest triangle, and the one that arrives first.
    meets: Vec<Meet>,
    /// Points with an entry in `meets`, in the order they were met.
    met: Vec<u32>,
    /// Per triangle, the round in which it was last visited.
    visited: Vec<u32>,
    round: u32,
    /// Of round parts.
    touches: Vec<Touch>,
}

/// What comes near to a sharp point.
#[derive(Clone, Copy, Debug)]
struct Meet {
    /// Squared distance \[m²\] and triangle.
    nearest: (f64, u32),
    /// Part of the step and triangle.
    arriving: (f64, u32),
}

const UNMET: Meet = Meet { nearest: (f64::INFINITY, NONE), arriving: (f64::INFINITY, NONE) };

impl FeatureScratch {
    pub fn with_size(points: usize, triangles: usize) -> Self {
        Self {
            meets: vec![UNMET; points],
            met: Vec::with_capacity(points),
            visited: vec![0; triangles],
            round: 0,
            touches: Vec::with_capacity(ROUND_PLACES * triangles),
        }
    }
}

/// A point of the surface that touches, in the shape frame.
#[derive(Clone, Copy, Debug)]
struct Touch {
    key: [u32; 2],
    triangle: u32,
    weights: [f64; 3],
    /// The sharp point, if it is one.
    sharp: Option<Vec3>,
    /// From the shape to the surface.
    normal: Vec3,
    gap: f64,
}

/// How deep a feature may lie and still be taken as having come through the triangle \[m\]: the
/// search looks one triangle deep.
pub(crate) fn depth_max(pair: &SoftRigid) -> f64 {
    pair.margin.max(pair.surface.edge_mean)
}

/// Adds the contacts of sharp points and of the round part.
pub(crate) fn find(
    pair: &SoftRigid,
    vertices: &VertexScratch,
    scratch: &mut FeatureScratch,
    out: &mut Collector,
) {
    scratch.round = scratch.round.wrapping_add(1);
    scratch.touches.clear();
    let axis = round_part(&pair.body.shape);
    let mut inmost = Inmost::default();
    for &v in &vertices.near {
        for &t in pair.surface.around(v) {
            if std::mem::replace(&mut scratch.visited[t as usize], scratch.round) == scratch.round {
                continue;
            }
            let near = Near::new(pair, t);
            meet_sharp(pair, &near, scratch);
            if let Some((axis, radius)) = &axis {
                meet_round(pair, &near, axis, *radius, &mut inmost, &mut scratch.touches);
            }
        }
    }
    settle_sharp(pair, scratch, out);
    settle_round(pair, &inmost, scratch, out);
}

/// The line about which a shape is round, and its radius there.
fn round_part(shape: &Shape) -> Option<([Vec3; 2], f64)> {
    match shape {
        Shape::Sphere { radius } => Some(([Vec3::zeros(); 2], *radius)),
        Shape::Capsule { radius, half_length } => Some((capsule_axis(*half_length), *radius)),
        Shape::Cuboid { .. } | Shape::HalfSpace | Shape::Mesh(_) => None,
    }
}

// Sharp points.

/// Offers a triangle to every sharp point around it.
fn meet_sharp(pair: &SoftRigid, near: &Near, scratch: &mut FeatureScratch) {
    let reach = depth_max(pair);
    let around = near.swept().inflate(reach);
    pair.body.sharp.tree.overlapping(&around, |i| {
        let p = &pair.body.sharp.points[i as usize];
        if !around.contains(p) {
            return;
        }
        let Meet { mut nearest, mut arriving } = scratch.meets[i as usize];
        let squared = near.closest(p).distance_squared;
        if squared <= reach * reach {
            // Of equally near triangles the lowest index.
            nearest = least(nearest, (squared, near.index));
        }
        if near.travel > pair.margin
            && squared > pair.margin * pair.margin
            && let Some(arrival) = near.arrival(p, 0.0, pair.margin)
        {
            arriving = least(arriving, (arrival.at, near.index));
        }
        let known = scratch.meets[i as usize];
        if known.nearest.1 == NONE && known.arriving.1 == NONE {
            if nearest.1 == NONE && arriving.1 == NONE {
                return;
            }
            scratch.met.push(i);
        }
        scratch.meets[i as usize] = Meet { nearest, arriving };
    });
}

fn least(a: (f64, u32), b: (f64, u32)) -> (f64, u32) {
    if b < a { b } else { a }
}

/// Turns what each point met into a contact, in the order of the points.
fn settle_sharp(pair: &SoftRigid, scratch: &mut FeatureScratch, out: &mut Collector) {
    scratch.met.sort_unstable();
    for m in 0..scratch.met.len() {
        let i = scratch.met[m];
        let Meet { nearest, arriving } = std::mem::replace(&mut scratch.meets[i as usize], UNMET);
        let p = pair.body.sharp.points[i as usize];
        let touch = sharp_at_nearest(pair, &p, i, nearest.1)
            .or_else(|| sharp_that_arrives(pair, &p, i, arriving.1));
        touch.iter().for_each(|touch| out.push(contact(pair, touch)));
    }
    scratch.met.clear();
}

/// The contact of a sharp point with its nearest triangle, if that is within the margin or the point
/// has come in through it.
fn sharp_at_nearest(pair: &SoftRigid, p: &Vec3, i: u32, t: u32) -> Option<Touch> {
    if t == NONE {
        return None;
    }
    let near = Near::new(pair, t);
    let closest = near.closest(p);
    let x = pair.state.positions;
    let to_shape = |normal_W: Vec3| pair.placed.rotation.tr_mul(&normal_W);
    let outward = to_shape(pair.surface.pseudonormal(t, closest.feature, x));
    let distance = closest.distance_squared.sqrt();
    let gap = distance.copysign((p - closest.point).dot(&outward));
    if gap > pair.margin || is_free(&pair.body.shape, &closest, gap) {
        return None;
    }
    let smooth = to_shape(pair.surface.smooth_normal(t, &closest.weights, x));
    let normal = -if smooth == Vec3::zeros() { outward } else { smooth };
    (normal != Vec3::zeros()).then_some(Touch {
        key: [KEY_POINT, i],
        triangle: t,
        weights: closest.weights,
        sharp: Some(*p),
        normal,
        gap,
    })
}

/// A point that has come in through a place of the surface has taken that place: the shape is there.
/// Near the far side of a thin or folded part a point lies inside as well, but the place is free: it
/// lies outside the shape, not only beside the point (within 45° of the way there).
fn is_free(shape: &Shape, closest: &Closest, gap: f64) -> bool {
    gap < 0.0 && shape.distance(&closest.point).value > -gap * std::f64::consts::FRAC_1_SQRT_2
}

fn sharp_that_arrives(pair: &SoftRigid, p: &Vec3, i: u32, t: u32) -> Option<Touch> {
    if t == NONE {
        return None;
    }
    let Arrival { weights, normal, gap, .. } = Near::new(pair, t).arrival(p, 0.0, pair.margin)?;
    let (key, sharp) = ([KEY_POINT, i], Some(*p));
    Some(Touch { key, triangle: t, weights, sharp, normal, gap })
}

// The round part.

/// Places on the centre line that one triangle may touch.
const ROUND_PLACES: usize = 3;

/// The place on the centre line that is nearest to the surface from inside.
#[derive(Clone, Copy, Debug)]
struct Inmost {
    distance: f64,
    inside: Option<Touch>,
}

impl Default for Inmost {
    fn default() -> Self {
        Self { distance: f64::INFINITY, inside: None }
    }
}

/// Lets a triangle touch a round part wherever it is nearest.
fn meet_round(
    pair: &SoftRigid,
    near: &Near,
    axis: &[Vec3; 2],
    radius: f64,
    inmost: &mut Inmost,
    touches: &mut Vec<Touch>,
) {
    let (places, count) = places_on(axis, &near.x, radius);
    for (k, &at) in places[..count].iter().enumerate() {
        let over = axis[0] + at * (axis[1] - axis[0]);
        let closest = near.closest(&over);
        // The place on the line nearest to that point tells its distance.
        let c =
            axis[0] + segment_parameter(&closest.point, &axis[0], &axis[1]) * (axis[1] - axis[0]);
        let key = [KEY_SEGMENT | k as u32, near.index];
        let to_line = closest.point - c;
        let distance = to_line.norm();
        if distance - radius > pair.margin + near.travel {
            continue;
        }
        if distance - radius > pair.margin {
            if let Some(a) = near.arrival(&c, radius, pair.margin) {
                let Arrival { weights, normal, gap, .. } = a;
                let (triangle, sharp) = (near.index, None);
                offer(touches, Touch { key, triangle, weights, sharp, normal, gap });
            }
            continue;
        }
        let x = pair.state.positions;
        let outward_W = pair.surface.pseudonormal(near.index, closest.feature, x);
        let outward = pair.placed.rotation.tr_mul(&outward_W);
        let faces = outward.dot(&to_line) < 0.0;
        let direction = to_line.try_normalize(0.0).unwrap_or(-outward);
        let touch = |normal: Vec3, gap: f64| Touch {
            key,
            triangle: near.index,
            weights: closest.weights,
            sharp: None,
            normal,
            gap,
        };
        if distance < inmost.distance {
            let inside = !faces && distance <= depth_max(pair);
            *inmost =
                Inmost { distance, inside: inside.then(|| touch(-direction, -distance - radius)) };
        }
        if faces && is_nearest_around(pair, near, &closest, &over) {
            offer(touches, touch(direction, distance - radius));
        }
    }
}

fn offer(touches: &mut Vec<Touch>, touch: Touch) {
    if touches.len() < touches.capacity() {
        touches.push(touch);
    }
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
fn places_on(axis: &[Vec3; 2], x: &[Vec3; 3], radius: f64) -> ([f64; ROUND_PLACES], usize) {
    let along = axis[1] - axis[0];
    let length = along.norm();
    if length == 0.0 {
        return ([0.0; ROUND_PLACES], 1);
    }
    let at = |p: &Vec3| segment_parameter(p, &axis[0], &axis[1]);
    let point = |t: f64| axis[0] + t * along;
    let mut nearest = at(&((x[0] + x[1] + x[2]) / 3.0));
    for _ in 0..NEAREST_ROUNDS {
        nearest = at(&crate::contact::triangle::closest_on_triangle(&point(nearest), x).point);
    }
    let mut places = [nearest; ROUND_PLACES];
    let mut count = 1;
    let normal = (x[1] - x[0]).cross(&(x[2] - x[0]));
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for k in 0..3 {
        let inward = normal.cross(&(x[(k + 1) % 3] - x[k]));
        let (start, slope) = (inward.dot(&(axis[0] - x[k])), inward.dot(&along));
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

/// Alternations between line and triangle on the way to their nearest points.
const NEAREST_ROUNDS: usize = 8;

/// Hands over the contacts of the round part: all of them, or, where its centre is inside the surface,
/// the one that leads it out.
fn settle_round(
    pair: &SoftRigid,
    inmost: &Inmost,
    scratch: &mut FeatureScratch,
    out: &mut Collector,
) {
    if let Some(touch) = &inmost.inside {
        out.push(contact(pair, touch));
        return;
    }
    scratch.touches.sort_unstable_by_key(|touch| (touch.triangle, touch.key));
    scratch.touches.iter().for_each(|touch| out.push(contact(pair, touch)));
}

fn contact(pair: &SoftRigid, touch: &Touch) -> Contact {
    let vertices = pair.surface.triangles[touch.triangle as usize];
    let point = SurfacePoint { soft: pair.soft, vertices, weights: touch.weights };
    let on_surface_W = point.interpolate(pair.state.positions);
    let position_W = touch.sharp.map_or(on_surface_W, |p| pair.placed.world_point(&p));
    let [kind, feature] = touch.key;
    Contact {
        key: feature_key([kind, pair.soft, pair.rigid, feature]),
        a: Site::Soft(point),
        b: Site::Rigid { body: pair.rigid, offset_W: on_surface_W - pair.placed.center_of_mass },
        position_W,
        normal_W: pair.placed.rotation * touch.normal,
        gap: touch.gap,
        friction: pair.friction,
    }
}
