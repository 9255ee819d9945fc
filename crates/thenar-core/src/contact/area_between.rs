//! The area over which soft surfaces touch, each other or themselves: half of what touches on
//! either side.
//!
//! A triangle of one surface is held against those of the other that contacts say it meets:
//! whatever is near makes one.

use crate::capacity_vec::CapacityVec;
use crate::contact::aabb::Aabb;
use crate::contact::area::{AreaScratch, Skin, TOUCHING, WEIGHT_MIN, soft_point};
use crate::contact::area_samples::{PARTS_MAX, area_below};
use crate::contact::nearest::longest_edge;
use crate::contact::triangle::{
    Closest, Feature, ROUNDED_UP, are_beyond, area_vector, closest_on_triangle,
};
use crate::contact::{Contact, Distance, SurfacePoint};
use crate::math::Vec3;

/// Each triangle is divided into parts half as long as an edge of the other surface: each then
/// meets an edge or two.
const PARTS_OF_EDGE: f64 = 2.0;

const NONE: u32 = u32::MAX;

/// Points of contacts by the first vertex they lie at, as lists.
#[derive(Clone, Debug)]
pub(super) struct AtVertices {
    first: Vec<u32>,
    /// Next point in the list of each point. A point's number is twice that of its contact, and one
    /// more on side B.
    next: CapacityVec<u32>,
    /// Vertices with a list.
    listed: CapacityVec<u32>,
    /// Distance of each contact at the end of the step \[m\].
    gaps: CapacityVec<f64>,
    /// Touch at each point on one side, in the order of `points_on`: true where the contact
    /// touches, false where it only is near.
    touching: CapacityVec<Option<bool>>,
    /// Triangles that one of the other surface meets.
    facing: CapacityVec<FacingTriangle>,
}

impl AtVertices {
    pub fn with_size(vertices: usize, contacts: usize, triangles: usize) -> Self {
        Self {
            first: vec![NONE; vertices],
            next: CapacityVec::with_capacity(2 * contacts),
            listed: CapacityVec::with_capacity(vertices),
            gaps: CapacityVec::with_capacity(contacts),
            touching: CapacityVec::with_capacity(2 * contacts),
            facing: CapacityVec::with_capacity(triangles),
        }
    }

    pub fn clear(&mut self) {
        for v in self.listed.drain(..) {
            self.first[v as usize] = NONE;
        }
        self.next.clear();
        self.gaps.clear();
        self.touching.clear();
    }

    fn list(&mut self, skin: &Skin, of: &[Contact], gap: impl Fn(&Contact) -> f64) {
        self.gaps.extend(of.iter().map(gap));
        self.next.resize(2 * of.len(), NONE);
        for k in 0..self.next.len() as u32 {
            let Some(point) = point(of, k).filter(|p| p.soft == skin.surface.soft) else {
                continue;
            };
            let Some(v) = vertices(point).next() else { continue };
            let first = &mut self.first[v as usize];
            if *first == NONE {
                self.listed.push(v);
            }
            self.next[k as usize] = std::mem::replace(first, k);
        }
    }
}

/// A point of a contact.
fn point(of: &[Contact], k: u32) -> Option<&SurfacePoint> {
    let contact = &of[k as usize / 2];
    soft_point(if k.is_multiple_of(2) { &contact.a } else { &contact.b })
}

/// The vertices a point lies between.
fn vertices(point: &SurfacePoint) -> impl Iterator<Item = u32> + '_ {
    (0..3).filter(|k| point.weights[*k] > WEIGHT_MIN).map(|k| point.vertices[k])
}

/// Areas of contacts between two soft surfaces (or one and itself). `gap` gives each contact's
/// distance at the end of the step, `bears` says which bore load in it.
pub(crate) fn between_soft(
    skins: [Skin; 2],
    of: &[Contact],
    gap: impl Fn(&Contact) -> f64,
    areas: &mut [f64],
    bears: impl Fn(usize) -> bool,
    scratch: &mut AreaScratch,
) {
    areas.fill(0.0);
    let itself = skins[0].surface.soft == skins[1].surface.soft;
    for (skin, other) in
        [(skins[0], skins[1]), (skins[1], skins[0])].iter().take(2 - usize::from(itself))
    {
        scratch.at_vertices.list(skin, of, &gap);
        // Whether a contact touches at a point, or else is near there.
        let touches = |i: usize, gap: f64, point: &SurfacePoint| {
            let is_near = || gap <= skin.edge_longest(point) + TOUCHING;
            if gap <= TOUCHING || bears(i) { Some(true) } else { is_near().then_some(false) }
        };
        for (i, contact) in of.iter().enumerate() {
            let gap = scratch.at_vertices.gaps[i];
            for point in points_on(contact, skin.surface.soft) {
                let touches = touches(i, gap, point);
                match touches {
                    Some(true) => skin.triangles_of(point, |t| scratch.touch(t)),
                    Some(false) => skin.triangles_of(point, |t| scratch.come_near(t)),
                    None => {}
                }
                scratch.at_vertices.touching.push(touches);
            }
        }
        for i in 0..scratch.touched.len() {
            let t = scratch.touched[i];
            let x = skin.corners(t);
            let depth = face((t, &x), [skin, other], of, &mut scratch.at_vertices);
            let facing = &scratch.at_vertices.facing;
            let parts =
                (PARTS_OF_EDGE * longest_edge(&x) / other.surface.edge_mean).ceil() as usize;
            let farthest = 2.0 * depth + TOUCHING;
            let area = match facing.iter().all(|f| f.is_beyond(&x, farthest)) {
                true => 0.0,
                false => area_below(
                    &x,
                    parts.clamp(1, PARTS_MAX),
                    |p, _| distance(p, facing, other, farthest),
                    |_| false,
                ),
            };
            scratch.share_out(t, 0.5 * scratch.at_least(skin, t, area));
        }
        let mut touching = scratch.at_vertices.touching.iter();
        for (contact, area) in of.iter().zip(areas.iter_mut()) {
            for (point, touches) in points_on(contact, skin.surface.soft).zip(&mut touching) {
                if let Some(touches) = touches {
                    skin.triangles_of(point, |t| *area += scratch.share_of(t, *touches));
                }
            }
        }
        scratch.clear();
    }
}

/// The points of a contact on this soft body: a vertex, the face that one touches, places of edges.
fn points_on(contact: &Contact, soft: u32) -> impl Iterator<Item = &SurfacePoint> + '_ {
    let sites = [&contact.a, &contact.b].into_iter();
    sites.filter_map(soft_point).filter(move |p| p.soft == soft)
}

/// A triangle that another may touch.
#[derive(Clone, Copy, Debug)]
struct FacingTriangle {
    triangle: u32,
    x: [Vec3; 3],
    normal: Vec3,
    /// A ball around it \[m\].
    middle: Vec3,
    radius: f64,
}

impl FacingTriangle {
    fn new(triangle: u32, x: [Vec3; 3]) -> Self {
        let middle = (x[0] + x[1] + x[2]) / 3.0;
        let radius = x.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
        let normal = area_vector(&x).try_normalize(0.0).unwrap_or_default();
        Self { triangle, x, normal, middle, radius }
    }

    /// True where the planes of the two tell that all of triangle `y` lies farther from this one
    /// than `reach` \[m\].
    fn is_beyond(&self, y: &[Vec3; 3], reach: f64) -> bool {
        let normal = area_vector(y).try_normalize(0.0).unwrap_or_default();
        [(&self.normal, &self.x, y), (&normal, y, &self.x)].iter().any(|(normal, x, y)| {
            are_beyond(&y.map(|p| normal.dot(&(p - x[0]))), reach * ROUNDED_UP)
        })
    }
}

/// Lists the triangles that contacts say triangle `t` with corners `x` meets, and those beside
/// them, as far as they may be nearer than [`TOUCHING`], or as deep as these contacts. Returns how
/// deep these are \[m\].
fn face(
    (t, x): (u32, &[Vec3; 3]),
    [skin, other]: [&Skin; 2],
    of: &[Contact],
    at_vertices: &mut AtVertices,
) -> f64 {
    let corners = skin.surface.triangles[t as usize];
    let AtVertices { first, next, facing, gaps, .. } = at_vertices;
    facing.clear();
    let list = |v: u32| {
        let first = Some(first[v as usize]).filter(|k| *k != NONE);
        std::iter::successors(first, |k| Some(next[*k as usize]).filter(|k| *k != NONE))
    };
    let met = || {
        corners.into_iter().flat_map(list).filter(|&k| {
            point(of, k).is_some_and(|own| vertices(own).all(|v| corners.contains(&v)))
        })
    };
    let depth = met().map(|k| -gaps[k as usize / 2]).fold(0.0, f64::max);
    let around = Aabb::of_points(x).inflate(TOUCHING + depth);
    let itself = skin.surface.soft == other.surface.soft;
    let mut add = |o: u32| {
        let is_beside = |v: &u32| other.surface.triangles[o as usize].contains(v);
        if itself && corners.iter().any(is_beside) {
            return;
        }
        let corners = other.corners(o);
        let [p, q, r] = &corners;
        let is_near = Aabb { min: *p, max: *p }.with(q).with(r).overlaps(&around);
        if is_near && facing.iter().all(|f| f.triangle != o) {
            facing.push(FacingTriangle::new(o, corners));
        }
    };
    for there in met().filter_map(|k| point(of, k ^ 1)) {
        other.triangles_of(there, |o| {
            add(o);
            (0..3).filter_map(|k| other.surface.across(o, k)).for_each(&mut add);
        });
    }
    depth
}

/// Distance from the nearest of these triangles, negative behind it: not deeper than contacts say,
/// by `deepest` \[m\]. What seems to be lies beyond the rim of these triangles, apart from those
/// that follow.
fn distance(p: &Vec3, facing: &[FacingTriangle], other: &Skin, deepest: f64) -> Distance {
    let near = signed(p, facing, other);
    if near.value >= -deepest {
        return near;
    }
    Distance { value: -near.value, gradient: -near.gradient }
}

/// Distance from the nearest of these triangles, negative behind it.
fn signed(p: &Vec3, facing: &[FacingTriangle], other: &Skin) -> Distance {
    let mut nearest: Option<(&FacingTriangle, Closest)> = None;
    for f in facing {
        let least = nearest.map_or(f64::INFINITY, |(_, near)| near.distance_squared);
        let beyond = (p - f.middle).norm() - f.radius;
        if beyond > 0.0 && beyond * beyond > least * ROUNDED_UP {
            continue;
        }
        let near = closest_on_triangle(p, &f.x);
        if near.distance_squared < least {
            nearest = Some((f, near));
        }
    }
    let Some((f, near)) = nearest else {
        return Distance { value: f64::INFINITY, gradient: Vec3::y() };
    };
    let away = p - near.point;
    if near.feature == Feature::Face {
        return Distance { value: f.normal.dot(&away), gradient: f.normal };
    }
    let out = other.surface.pseudonormal(f.triangle, near.feature, other.x);
    let side = if out.dot(&away) < 0.0 { -1.0 } else { 1.0 };
    // Too near to say which way: places are rounded.
    let rounding = 16.0 * f64::EPSILON * (p.norm() + f.radius);
    let gradient = away.try_normalize(rounding).map(|away| side * away);
    Distance {
        value: side * near.distance_squared.sqrt(),
        gradient: gradient.or_else(|| out.try_normalize(0.0)).unwrap_or(f.normal),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Planes set no two triangles farther apart than any two of their points are.
    #[test]
    fn planes_bound_the_distance_of_triangles() {
        let (mut random, mut told) = (Random::new(16), 0);
        let n = 12;
        for i in 0..500 {
            let x = [0; 3].map(|_| random.vector(0.005));
            let y = [0; 3].map(|_| random.vector(0.005) + Vec3::x() * 0.006);
            let facing = FacingTriangle::new(0, x);
            let places = (0..=n).flat_map(|i| (0..=n - i).map(move |j| [i, j]));
            let to_x = places.map(|place| {
                let [u, v] = place.map(|k| f64::from(k) / f64::from(n));
                closest_on_triangle(&(y[0] + (y[1] - y[0]) * u + (y[2] - y[0]) * v), &x)
                    .distance_squared
            });
            let nearest = to_x.fold(f64::INFINITY, f64::min).sqrt();
            assert!(!facing.is_beyond(&y, nearest), "{i}: {nearest} m");
            told += usize::from(facing.is_beyond(&y, 0.5 * nearest));
        }
        assert!(told > 250, "{told} of 500");
    }
}
