//! The area over which soft surfaces touch, each other or themselves: half of what touches on either side.
//!
//! A triangle of one surface is held against those of the other that contacts say it meets: whatever is near makes one.

use crate::contact::aabb::Aabb;
use crate::contact::area::{AreaScratch, LIGHT, Skin, TOUCHING, soft_point};
use crate::contact::area_samples::{PARTS_MAX, area_below};
use crate::contact::triangle::{Feature, area_vector, closest_on_triangle};
use crate::contact::{Contact, Distance, SurfacePoint};
use crate::math::Vec3;
use crate::room::Room;

/// Triangles of the other surface that one is held against, at most: six or seven lie around a vertex, and as many beside
/// those, with four or five such vertices.
const FACING_MAX: usize = 64;
/// Each triangle is divided into parts half as long as an edge of the other surface: each then meets an edge or two.
const PARTS_OF_EDGE: f64 = 2.0;

const NONE: u32 = u32::MAX;

/// Points of contacts by the first vertex they lie at, as lists.
#[derive(Clone, Debug)]
pub(super) struct AtVertices {
    first: Vec<u32>,
    /// Of each point: twice the number of its contact, and one more on side B.
    next: Room<u32>,
    /// Vertices with a list.
    listed: Room<u32>,
}

impl AtVertices {
    pub fn with_size(vertices: usize) -> Self {
        Self {
            first: vec![NONE; vertices],
            // A contact at each vertex, of either surface, and as many between them.
            next: Room::with_capacity(8 * vertices),
            listed: Room::with_capacity(vertices),
        }
    }

    pub fn clear(&mut self) {
        for v in self.listed.drain(..) {
            self.first[v as usize] = NONE;
        }
        self.next.clear();
    }

    fn list(&mut self, skin: &Skin, of: &[Contact]) {
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

    fn at(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let known = |k: u32| (k != NONE).then_some(k);
        std::iter::successors(known(self.first[v as usize]), move |k| known(self.next[*k as usize]))
    }
}

/// A point of a contact.
fn point(of: &[Contact], k: u32) -> Option<&SurfacePoint> {
    let contact = &of[k as usize / 2];
    soft_point(if k % 2 == 0 { &contact.a } else { &contact.b })
}

/// The vertices a point lies between.
fn vertices(point: &SurfacePoint) -> impl Iterator<Item = u32> + '_ {
    (0..3).filter(|k| point.weights[*k] > LIGHT).map(|k| point.vertices[k])
}

/// Areas of contacts between two soft surfaces (or one and itself). `gap` gives each contact's distance at the end of
/// the step.
pub(crate) fn between_soft(
    skins: [Skin; 2],
    of: &[Contact],
    gap: impl Fn(&Contact) -> f64,
    areas: &mut [f64],
    scratch: &mut AreaScratch,
) {
    areas.fill(0.0);
    let itself = skins[0].surface.soft == skins[1].surface.soft;
    for (skin, other) in
        [(skins[0], skins[1]), (skins[1], skins[0])].iter().take(2 - usize::from(itself))
    {
        scratch.at_vertices.list(skin, of);
        // Whether a contact touches at a point, or else is near there.
        let touches = |contact: &Contact, point: &SurfacePoint| {
            let gap = gap(contact);
            let is_near = || gap <= skin.edge_longest(point) + TOUCHING;
            if gap <= TOUCHING { Some(true) } else { is_near().then_some(false) }
        };
        for contact in of {
            for point in points_on(contact, skin.surface.soft) {
                match touches(contact, point) {
                    Some(true) => skin.triangles_of(point, |t| scratch.touch(t)),
                    Some(false) => skin.triangles_of(point, |t| scratch.come_near(t)),
                    None => {}
                }
            }
        }
        for i in 0..scratch.touched.len() {
            let t = scratch.touched[i];
            let x = skin.corners(t);
            let facing = Facing::of((t, &x), [skin, other], of, &scratch.at_vertices);
            let edge = (0..3).map(|k| (x[(k + 1) % 3] - x[k]).norm()).fold(0.0, f64::max);
            let parts = (PARTS_OF_EDGE * edge / other.surface.edge_mean).ceil() as usize;
            let distance = |p: &Vec3, _| facing.distance(p);
            let parts = parts.clamp(1, PARTS_MAX);
            let area = match facing.count {
                0 => 0.0,
                _ => area_below(&x, parts, distance, |_| false),
            };
            scratch.share_out(*skin, t, 0.5 * area);
        }
        for (contact, area) in of.iter().zip(areas.iter_mut()) {
            for point in points_on(contact, skin.surface.soft) {
                if let Some(touches) = touches(contact, point) {
                    skin.triangles_of(point, |t| *area += scratch.share_of(t, touches));
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

/// What a triangle meets: corners of triangles of another surface, and their normals.
struct Facing {
    triangles: [([Vec3; 3], Vec3); FACING_MAX],
    count: usize,
}

impl Facing {
    /// The triangles that contacts say triangle `t` with corners `x` meets, and those beside them, as far as they may be
    /// nearer than [`TOUCHING`].
    fn of(
        (t, x): (u32, &[Vec3; 3]),
        [skin, other]: [&Skin; 2],
        of: &[Contact],
        at_vertices: &AtVertices,
    ) -> Self {
        let corners = skin.surface.triangles[t as usize];
        let mut met = Met { triangles: [0; FACING_MAX], count: 0 };
        for k in corners.into_iter().flat_map(|v| at_vertices.at(v)) {
            let (Some(own), Some(there)) = (point(of, k), point(of, k ^ 1)) else { continue };
            if vertices(own).all(|v| corners.contains(&v)) {
                other.triangles_of(there, |o| met.add(o));
            }
        }
        for i in 0..met.count {
            let o = met.triangles[i];
            (0..3).filter_map(|k| other.surface.across(o, k)).for_each(|o| met.add(o));
        }
        let around = Aabb::of_points(x).inflate(TOUCHING);
        let mut facing =
            Self { triangles: [([Vec3::zeros(); 3], Vec3::zeros()); FACING_MAX], count: 0 };
        for o in &met.triangles[..met.count] {
            let x = other.corners(*o);
            if Aabb::of_points(&x).overlaps(&around) {
                let normal = area_vector(&x).try_normalize(0.0).unwrap_or_default();
                facing.triangles[facing.count] = (x, normal);
                facing.count += 1;
            }
        }
        facing
    }

    /// From the nearest triangle, negative behind its inside.
    fn distance(&self, p: &Vec3) -> Distance {
        let mut nearest = Distance { value: f64::INFINITY, gradient: Vec3::y() };
        let mut least = f64::INFINITY;
        for (x, normal) in &self.triangles[..self.count] {
            let near = closest_on_triangle(p, x);
            if near.distance_squared < least {
                least = near.distance_squared;
                let (away, value) = (p - near.point, least.sqrt());
                let is_inside = near.feature == Feature::Face && normal.dot(&away) < 0.0;
                // On the surface, or too near to say which way.
                let out = away.try_normalize(f64::EPSILON * p.norm()).unwrap_or(*normal);
                let side = if is_inside { -1.0 } else { 1.0 };
                nearest = Distance { value: side * value, gradient: side * out };
            }
        }
        nearest
    }
}

/// Different triangles, as many as there is room for.
struct Met {
    triangles: [u32; FACING_MAX],
    count: usize,
}

impl Met {
    fn add(&mut self, t: u32) {
        if self.count < FACING_MAX && !self.triangles[..self.count].contains(&t) {
            self.triangles[self.count] = t;
            self.count += 1;
        }
    }
}
