//! The area over which surfaces touch.
//!
//! The area of a contact patch is that of the part of the soft surface nearer than [`TOUCHING`] to
//! the other body, at the end of the step. It is found triangle by triangle: the distance and its
//! gradient are sampled over a triangle, and the part below the bound is cut out. What is found on
//! a triangle is shared evenly by the contacts that touch it, so that their sum does not depend on
//! how many there are; what bears load touches. During the step an edge or a tip slides away from
//! the points that meet it: where none touches any more, but the triangle does, those near on it
//! share. Between two soft surfaces a patch has at least the area that its load asks for
//! (`area_least`).

use crate::capacity_vec::CapacityVec;
use crate::contact::area_between::AtVertices;
use crate::contact::area_faces::Faces;
use crate::contact::area_least::Patches;
use crate::contact::area_samples::{PARTS_MAX, area_below, parts_for};
use crate::contact::nearest::longest_edge;
use crate::contact::rigid_body::{Placed, RigidBody};
use crate::contact::surface::Surface;
use crate::contact::triangle::area_vector;
use crate::contact::{Contact, Distance, Site, SurfacePoint};
use crate::math::Vec3;
use std::cell::Cell;
use std::ops::Range;

/// Surfaces nearer than this touch \[m\]: a definition, as no area is without one. Of a ball of
/// radius R that only just touches a plane it gives 2π R times this, 1.3 mm² for a fingertip of 1
/// cm.
pub(crate) const TOUCHING: f64 = 20e-6;

/// A corner of less weight has no part in a point.
pub(super) const WEIGHT_MIN: f64 = 1e-9;

/// The area of a contact that touches, until it is known.
const TO_COME: f64 = -1.0;
/// The area of a contact near on a triangle that may touch, until it is known.
const MAY_COME: f64 = -2.0;

/// Work space: per triangle of the largest surface.
#[derive(Clone, Debug)]
pub(crate) struct AreaScratch {
    /// Contacts that touch a triangle, those that only are near on it, and then its area for each
    /// of them \[m²\].
    count: Vec<u32>,
    near: Vec<u32>,
    share: Vec<f64>,
    /// Triangles with a count.
    pub touched: CapacityVec<u32>,
    /// Between soft surfaces, what lies at each vertex.
    pub at_vertices: AtVertices,
    /// Loads and areas of patches.
    pub(super) patches: Patches,
}

impl AreaScratch {
    /// Room for the largest surface, with these counts of triangles and vertices, and for at most
    /// this many contacts.
    pub fn with_size(triangles: usize, vertices: usize, contacts: usize) -> Self {
        Self {
            count: vec![0; triangles],
            near: vec![0; triangles],
            share: vec![0.0; triangles],
            touched: CapacityVec::with_capacity(triangles),
            at_vertices: AtVertices::with_size(vertices, contacts, triangles),
            patches: Patches::with_size(triangles, vertices, contacts),
        }
    }

    pub fn clear(&mut self) {
        for t in self.touched.drain(..) {
            let t = t as usize;
            (self.count[t], self.near[t], self.share[t]) = (0, 0, 0.0);
        }
        self.at_vertices.clear();
    }

    pub fn touch(&mut self, t: u32) {
        self.list(t);
        self.count[t as usize] += 1;
    }

    pub fn come_near(&mut self, t: u32) {
        self.list(t);
        self.near[t as usize] += 1;
    }

    fn list(&mut self, t: u32) {
        if self.count[t as usize] + self.near[t as usize] == 0 {
            self.touched.push(t);
        }
    }

    /// Shares a triangle's area, which touches, by the contacts that do or, where none does, by
    /// those near on it.
    pub fn share_out(&mut self, t: u32, area: f64) {
        let (touching, near) = (self.count[t as usize], self.near[t as usize]);
        self.share[t as usize] = area / f64::from(if touching > 0 { touching } else { near });
    }

    /// Area of a triangle that touches, by samples. Where they find nothing, a point that touches
    /// or bore load stands for the finest part: so small a patch is not resolved.
    pub fn at_least(&self, skin: &Skin, t: u32, area: f64) -> f64 {
        if area > 0.0 || self.count[t as usize] == 0 {
            return area;
        }
        skin.triangle_area(t) / (PARTS_MAX * PARTS_MAX) as f64
    }

    /// The part of a triangle's area that is one contact's, which touches or only is near.
    pub fn share_of(&self, t: u32, touches: bool) -> f64 {
        if touches == (self.count[t as usize] > 0) { self.share[t as usize] } else { 0.0 }
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
    pub fn triangles_of(&self, point: &SurfacePoint, mut each: impl FnMut(u32)) {
        let heavy = |k: usize| point.weights[k] > WEIGHT_MIN;
        let around = self.surface.around(point.vertices[(0..3).find(|k| heavy(*k)).unwrap_or(0)]);
        for &t in around {
            let corners = self.surface.triangles[t as usize];
            if (0..3).all(|k| !heavy(k) || corners.contains(&point.vertices[k])) {
                each(t);
            }
        }
    }

    pub fn corners(&self, t: u32) -> [Vec3; 3] {
        self.surface.corners(t, self.x)
    }

    /// The longest edge of the triangles a contact lies on \[m\].
    pub fn edge_longest(&self, point: &SurfacePoint) -> f64 {
        let mut longest = 0.0_f64;
        self.triangles_of(point, |t| {
            longest = longest.max(longest_edge(&self.corners(t)));
        });
        longest
    }

    fn triangle_area(&self, t: u32) -> f64 {
        area_vector(&self.corners(t)).norm()
    }
}

/// Areas of the contacts `of` of one surface with one rigid body, all of which are of this pair;
/// `bears` says which bore load in the step.
pub(crate) fn with_rigid(
    skin: Skin,
    (body, placed): (&RigidBody, &Placed),
    of: &[Contact],
    areas: &mut [f64],
    bears: impl Fn(usize) -> bool,
    scratch: &mut AreaScratch,
) {
    let guess = Cell::new(0);
    for (i, (contact, area)) in of.iter().zip(areas.iter_mut()).enumerate() {
        *area = 0.0;
        let Some(point) = soft_point(&contact.a) else { continue };
        let p = placed.shape_point(&point.interpolate(skin.x));
        // No point of a triangle that touches is farther than this.
        let widest = skin.edge_longest(point) + TOUCHING;
        let found = body.shape.distance_within_near(&p, widest, &guess);
        if bears(i) || found.is_some_and(|distance| distance.value <= TOUCHING) {
            *area = TO_COME;
            skin.triangles_of(point, |t| scratch.touch(t));
        } else if found.is_some() {
            *area = MAY_COME;
            skin.triangles_of(point, |t| scratch.come_near(t));
        }
    }
    let distance = |x_W: &Vec3, known: f64| {
        let near = body.shape.distance_near(&placed.shape_point(x_W), known, &guess);
        Distance { gradient: placed.rotation * near.gradient, ..near }
    };
    for i in 0..scratch.touched.len() {
        let t = scratch.touched[i];
        let x = skin.corners(t);
        let parts = parts_for(&body.shape, &x);
        let faces = Faces::near(&body.shape, x.map(|p| placed.shape_point(&p)), &guess);
        let beyond = |places| faces.as_ref().is_some_and(|faces| faces.are_beyond(places));
        let area = area_below(&x, parts, distance, beyond);
        scratch.share_out(t, scratch.at_least(&skin, t, area));
    }
    for (contact, area) in of.iter().zip(areas).filter(|(_, area)| **area < 0.0) {
        let mut all = 0.0;
        if let Some(point) = soft_point(&contact.a) {
            skin.triangles_of(point, |t| all += scratch.share_of(t, *area == TO_COME));
        }
        *area = all;
    }
    scratch.clear();
}

pub(super) fn soft_point(site: &Site) -> Option<&SurfacePoint> {
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
