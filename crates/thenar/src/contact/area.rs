//! The area over which surfaces touch.
//!
//! The area of a contact patch is that of the part of the soft surface nearer than [`TOUCHING`] to the
//! other body, at the end of the step. It is found triangle by triangle: the distance is sampled over a
//! triangle, taken as linear in between, and the part below the bound is cut out. What is found on a
//! triangle is shared evenly by the contacts that touch it, so that their sum does not depend on how
//! many there are.

use crate::contact::area_faces::Faces;
use crate::contact::area_samples::{PARTS_MAX, area_below, part_below, parts_for};
use crate::contact::rigid_body::{Placed, RigidBody};
use crate::contact::surface::Surface;
use crate::contact::triangle::area_vector;
use crate::contact::{Contact, Site, SurfacePoint};
use crate::math::Vec3;
use crate::room::Room;
use std::cell::Cell;
use std::ops::Range;

/// Surfaces nearer than this touch \[m\]: a definition, as no area is without one. Of a ball of radius R that only just
/// touches a plane it gives 2π R times this, 1.3 mm² for a fingertip of 1 cm.
pub(crate) const TOUCHING: f64 = 20e-6;

/// A corner of less weight has no part in a point.
const LIGHT: f64 = 1e-9;

/// The area of a contact that touches, until it is known.
const TO_COME: f64 = -1.0;

/// Work space: per triangle of the largest surface.
#[derive(Clone, Debug)]
pub(crate) struct AreaScratch {
    /// Contacts that touch a triangle, and then its area for each of them \[m²\].
    count: Vec<u32>,
    share: Vec<f64>,
    /// Triangles with a count.
    touched: Room<u32>,
    /// Per vertex, the distance to another soft surface \[m\], and those that have one.
    gaps: Vec<f64>,
    known: Room<u32>,
    /// The same within triangles and their edges.
    within: Vec<Within>,
    noted: Room<u32>,
}

/// Between surfaces farther apart than this no contact tells a distance \[m\]: the usual margin. Where none tells one
/// they count as so far apart, fifty times [`TOUCHING`]: beside a place that touches the area ends within 2 % of an
/// edge.
const FAR: f64 = 1e-3;

/// Distances that contacts tell at places of a triangle between its corners, of each kind the least.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Within {
    /// Distance \[m\], and part of edge k from corner k.
    edges: [(f64, f64); 3],
    /// Distance \[m\], and weights.
    face: (f64, [f64; 3]),
}

impl Within {
    const NOTHING: Self = Self { edges: [(FAR, 0.5); 3], face: (FAR, [0.0; 3]) };

    /// The part of the triangle's area that is nearer than [`TOUCHING`], given the distances of its corners: linear
    /// between these places, in a fan about the one inside or the nearest.
    fn part_below(&self, corners: [f64; 3]) -> f64 {
        // Places as weights of the corners 1 and 2.
        let mut rim = [([0.0; 2], FAR); 6];
        let mut count = 0;
        for (k, start) in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
            rim[count] = (start, corners[k]);
            count += 1;
            let (gap, s) = self.edges[k];
            if gap < FAR {
                let end = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]][k];
                rim[count] = ([0, 1].map(|i| start[i] + s * (end[i] - start[i])), gap);
                count += 1;
            }
        }
        let rim = &rim[..count];
        let (face, weights) = self.face;
        let nearest = rim.iter().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(rim[0], |p| *p);
        let (middle, least) = if face < FAR { ([weights[1], weights[2]], face) } else { nearest };
        let mut part = 0.0;
        for (i, (p, gap)) in rim.iter().enumerate() {
            let (q, next) = rim[(i + 1) % count];
            let [u, v] = [*p, q].map(|x| [x[0] - middle[0], x[1] - middle[1]]);
            part += (u[0] * v[1] - u[1] * v[0]).abs() * part_below([least, *gap, next]);
        }
        part
    }
}

impl AreaScratch {
    pub fn with_size(triangles: usize, vertices: usize) -> Self {
        Self {
            count: vec![0; triangles],
            share: vec![0.0; triangles],
            touched: Room::with_capacity(triangles),
            gaps: vec![FAR; vertices],
            known: Room::with_capacity(vertices),
            within: vec![Within::NOTHING; triangles],
            noted: Room::with_capacity(triangles),
        }
    }

    fn clear(&mut self) {
        for t in self.touched.drain(..) {
            (self.count[t as usize], self.share[t as usize]) = (0, 0.0);
        }
        for v in self.known.drain(..) {
            self.gaps[v as usize] = FAR;
        }
        for t in self.noted.drain(..) {
            self.within[t as usize] = Within::NOTHING;
        }
    }

    /// Notes the distance at a point of a surface.
    fn note(&mut self, skin: &Skin, point: &SurfacePoint, gap: f64) {
        if gap >= FAR {
            return;
        }
        skin.triangles_of(point, |t| {
            let corners = skin.surface.triangles[t as usize];
            let weights = corners.map(|v| {
                let of = (0..3).filter(|&k| point.vertices[k] == v).map(|k| point.weights[k]);
                of.sum::<f64>()
            });
            let light = (0..3).filter(|&k| weights[k] <= LIGHT);
            match light.clone().count() {
                2 => {
                    let k = (0..3).find(|&k| weights[k] > LIGHT).unwrap_or(0);
                    let known = &mut self.gaps[corners[k] as usize];
                    if *known == FAR {
                        self.known.push(corners[k]);
                    }
                    *known = known.min(gap);
                }
                light_count => {
                    let within = &mut self.within[t as usize];
                    if *within == Within::NOTHING {
                        self.noted.push(t);
                    }
                    if light_count == 0 && gap < within.face.0 {
                        within.face = (gap, weights);
                    }
                    // Edge k lies across from corner k + 2.
                    for k in light.map(|k| (k + 1) % 3) {
                        if gap < within.edges[k].0 {
                            within.edges[k] = (gap, weights[(k + 1) % 3]);
                        }
                    }
                }
            }
        });
    }

    fn touch(&mut self, t: u32) {
        if self.count[t as usize] == 0 {
            self.touched.push(t);
        }
        self.count[t as usize] += 1;
    }
}

/// A soft surface as it is at the end of the step.
#[derive(Clone, Copy)]
pub(crate) struct Skin<'a> {
    pub surface: &'a Surface,
    pub x: &'a [Vec3],
}

impl Skin<'_> {
    /// The triangles a contact lies on: those around a vertex, both of an edge, or one.
    fn triangles_of(&self, point: &SurfacePoint, mut each: impl FnMut(u32)) {
        let heavy = |k: usize| point.weights[k] > LIGHT;
        let around = self.surface.around(point.vertices[(0..3).find(|k| heavy(*k)).unwrap_or(0)]);
        for &t in around {
            let corners = self.surface.triangles[t as usize];
            if (0..3).all(|k| !heavy(k) || corners.contains(&point.vertices[k])) {
                each(t);
            }
        }
    }

    fn corners(&self, t: u32) -> [Vec3; 3] {
        self.surface.corners(t, self.x)
    }

    fn triangle_area(&self, t: u32) -> f64 {
        area_vector(&self.corners(t)).norm()
    }
}

/// Areas of the contacts `of` of one surface with one rigid body, all of which are of this pair.
pub(crate) fn with_rigid(
    skin: Skin,
    (body, placed): (&RigidBody, &Placed),
    of: &[Contact],
    areas: &mut [f64],
    scratch: &mut AreaScratch,
) {
    let touches = |point: &SurfacePoint| {
        let p = placed.shape_point(&point.interpolate(skin.x));
        let found = body.shape.distance_within(&p, 2.0 * TOUCHING);
        found.is_some_and(|d| d.value <= TOUCHING)
    };
    for (contact, area) in of.iter().zip(areas.iter_mut()) {
        *area = 0.0;
        if let Some(point) = soft_point(&contact.a).filter(|point| touches(point)) {
            *area = TO_COME;
            skin.triangles_of(point, |t| scratch.touch(t));
        }
    }
    let guess = Cell::new(0);
    let distance = |x_W: &Vec3, known: f64| {
        body.shape.distance_near(&placed.shape_point(x_W), known, &guess).value
    };
    for i in 0..scratch.touched.len() {
        let t = scratch.touched[i];
        let x = skin.corners(t);
        let parts = parts_for(&body.shape, &x);
        // A point that touches where samples find nothing stands for the finest part.
        let least = skin.triangle_area(t) / (PARTS_MAX * PARTS_MAX) as f64;
        let faces = Faces::near(&body.shape, x.map(|p| placed.shape_point(&p)), &guess);
        let beyond = |u: f64, v: f64| faces.as_ref().is_some_and(|faces| faces.are_beyond(u, v));
        let area = area_below(&x, parts, distance, beyond);
        let area = if area > 0.0 { area } else { least };
        scratch.share[t as usize] = area / f64::from(scratch.count[t as usize]);
    }
    for (contact, area) in of.iter().zip(areas).filter(|(_, area)| **area == TO_COME) {
        *area = 0.0;
        if let Some(point) = soft_point(&contact.a) {
            skin.triangles_of(point, |t| *area += scratch.share[t as usize]);
        }
    }
    scratch.clear();
}

/// Areas of contacts between two soft surfaces (or one and itself): half of what touches on either
/// side. `gap` gives each contact's distance at the end of the step.
pub(crate) fn between_soft(
    skins: [Skin; 2],
    of: &[Contact],
    gap: impl Fn(&Contact) -> f64,
    areas: &mut [f64],
    scratch: &mut AreaScratch,
) {
    areas.fill(0.0);
    let itself = skins[0].surface.soft == skins[1].surface.soft;
    for skin in &skins[..if itself { 1 } else { 2 }] {
        // What does not touch tells how far the rim of what does is.
        for contact in of {
            for point in points_on(contact, skin.surface.soft) {
                scratch.note(skin, point, gap(contact));
                if gap(contact) <= TOUCHING {
                    skin.triangles_of(point, |t| scratch.touch(t));
                }
            }
        }
        for i in 0..scratch.touched.len() {
            let t = scratch.touched[i];
            let corners = skin.surface.triangles[t as usize];
            let gaps = corners.map(|v| scratch.gaps[v as usize]);
            let least = 1.0 / (PARTS_MAX * PARTS_MAX) as f64;
            let part = scratch.within[t as usize].part_below(gaps).max(least);
            let area = skin.triangle_area(t) * part;
            scratch.share[t as usize] = 0.5 * area / f64::from(scratch.count[t as usize]);
        }
        for (contact, area) in of.iter().zip(areas.iter_mut()).filter(|(c, _)| gap(c) <= TOUCHING) {
            for point in points_on(contact, skin.surface.soft) {
                skin.triangles_of(point, |t| *area += scratch.share[t as usize]);
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

fn soft_point(site: &Site) -> Option<&SurfacePoint> {
    match site {
        Site::Soft(point) => Some(point),
        Site::Rigid { .. } => None,
    }
}

/// Runs of contacts of the same two bodies.
pub(crate) fn runs(contacts: &[Contact]) -> impl Iterator<Item = Range<usize>> {
    let body = |site: &Site| match site {
        Site::Rigid { body, .. } => (0, *body),
        Site::Soft(point) => (1, point.soft),
    };
    let pair = move |c: &Contact| {
        let (a, b) = (body(&c.a), body(&c.b));
        if a <= b { (a, b) } else { (b, a) }
    };
    let mut start = 0;
    contacts.chunk_by(move |c, d| pair(c) == pair(d)).map(move |run| {
        start += run.len();
        start - run.len()..start
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With distances that are linear, places between the corners change nothing; a place of an edge alone that
    /// touches is a triangle about it.
    #[test]
    fn places_within_a_triangle_are_taken_up() {
        let corners = [0.0, 2.0 * TOUCHING, 4.0 * TOUCHING];
        let at = |w: [f64; 3]| (0..3).map(|k| w[k] * corners[k]).sum::<f64>();
        let mut within = Within::NOTHING;
        let whole = within.part_below(corners);
        assert!((whole - 0.125).abs() < 1e-12, "{whole}");
        within.face = (at([0.3, 0.4, 0.3]), [0.3, 0.4, 0.3]);
        assert!((within.part_below(corners) - whole).abs() < 1e-12);
        within.edges[2] = (at([0.9, 0.0, 0.1]), 0.9);
        assert!((within.part_below(corners) - whole).abs() < 1e-12);

        let mut ridge = Within::NOTHING;
        ridge.edges[0] = (0.0, 0.5);
        // As far as `TOUCHING / FAR` of the way to each corner: of both halves that part squared.
        let part = (TOUCHING / FAR).powi(2);
        assert!((ridge.part_below([FAR; 3]) - part).abs() < 1e-12);
    }
}
