//! Deformable surfaces that have got into each other: the way back.
//!
//! In contact surfaces overlap by the solver's tolerance. A start that overlaps, or a step that could
//! not be held, leaves vertices deeper inside than the search near the surface looks. They are found
//! from where the surfaces cut each other: an edge that pierces a triangle has an end inside, and from
//! there the inside spreads along the edges of its own surface. Each such vertex is led out to the
//! nearest place of the other surface that faces it, however deep it is.

use crate::contact::collector::Collector;
use crate::contact::sides::Sight;
use crate::contact::soft_soft::{PairScratch, SoftSide, SoftSoft};
use crate::contact::surface::Surface;
use crate::contact::triangle::{Closest, area_vector, closest_on_triangle};
use crate::math::Vec3;

/// Contacts rest within this part of an edge; what is deeper has got in.
const ENTERED: f64 = 0.01;
/// A vertex leaves through a face that its own normal opposes by at least this (cosine of 120°).
const OPPOSED: f64 = -0.5;

/// Vertices of one side that are, or may be, deep inside the other.
#[derive(Clone, Debug, Default)]
pub(super) struct DeepScratch {
    queue: Vec<u32>,
    /// Per vertex, whether it was in the queue.
    queued: Vec<bool>,
}

impl DeepScratch {
    pub fn with_size(vertices: usize) -> Self {
        Self { queue: Vec::with_capacity(vertices), queued: vec![false; vertices] }
    }

    /// Each vertex is looked at once.
    pub fn add(&mut self, v: u32) {
        if !std::mem::replace(&mut self.queued[v as usize], true) {
            self.queue.push(v);
        }
    }

    fn clear(&mut self) {
        for v in self.queue.drain(..) {
            self.queued[v as usize] = false;
        }
    }
}

impl SoftSoft<'_> {
    /// Notes the inner ends of the edges by which two triangles pierce each other.
    pub(super) fn pierce(&self, [s, t]: [u32; 2], deep: &mut [DeepScratch; 2]) {
        let [a, b] = [&self.a, &self.b];
        self.pierce_from(a, s, b, t, &mut deep[0]);
        self.pierce_from(b, t, a, s, &mut deep[1]);
    }

    fn pierce_from(
        &self,
        own: &SoftSide,
        s: u32,
        other: &SoftSide,
        t: u32,
        deep: &mut DeepScratch,
    ) {
        let x = other.surface.corners(t, other.state.positions);
        let area = area_vector(&x);
        let corners = own.surface.triangles[s as usize];
        let p = corners.map(|v| own.state.positions[v as usize]);
        let height = p.map(|p| area.dot(&(p - x[0])));
        let entered = -ENTERED * other.surface.edge_mean * area.norm();
        for k in 0..3 {
            let (i, j) = (k, (k + 1) % 3);
            let (inner, outer) = if height[i] < height[j] { (i, j) } else { (j, i) };
            if height[inner] > entered || height[outer] <= 0.0 {
                continue;
            }
            let part = height[outer] / (height[outer] - height[inner]);
            let cut = p[outer] + part * (p[inner] - p[outer]);
            let is_inside = |k: usize| {
                let edge = x[(k + 1) % 3] - x[k];
                area.dot(&edge.cross(&(cut - x[k]))) >= 0.0
            };
            if (0..3).all(is_inside) {
                deep.add(corners[inner]);
            }
        }
    }

    /// Contacts of the vertices of side `i` that are deep inside the other, and touch nothing yet.
    pub(super) fn settle_deep(
        &self,
        i: usize,
        sight: &mut Sight,
        scratch: &mut PairScratch,
        out: &mut Collector,
    ) {
        let [own, other] = self.facing(i);
        let mut deep = std::mem::take(&mut scratch.deep[i]);
        let mut next = 0;
        while next < deep.queue.len() {
            let v = deep.queue[next];
            next += 1;
            let touches = scratch.vertices[i].touches(v);
            if !touches {
                let Some((t, closest)) = self.way_out(own, other, v) else { continue };
                self.push_vertex(i, v, t, &closest, sight, out);
            }
            own.surface.neighbors_of(v, |w| deep.add(w));
        }
        deep.clear();
        scratch.deep[i] = deep;
    }

    /// Where vertex `v` leaves the other surface; `None` when it has not got in.
    fn way_out(&self, own: &SoftSide, other: &SoftSide, v: u32) -> Option<(u32, Closest)> {
        let p = own.state.positions[v as usize];
        let (t, nearest) = nearest_on(other, &p, |_| true)?;
        if depth(other.surface, &p, t, &nearest, other.state.positions)
            < ENTERED * other.surface.edge_mean
        {
            return None;
        }
        let normal = own.surface.vertex_normal(v, own.state.positions);
        let bound = OPPOSED * normal.norm();
        let opposed = nearest_on(other, &p, |t| {
            let area = area_vector(&other.surface.corners(t, other.state.positions));
            normal.dot(&area) <= bound * area.norm()
        });
        Some(opposed.unwrap_or((t, nearest)))
    }
}

/// The nearest of those triangles that `wanted` admits.
fn nearest_on(side: &SoftSide, p: &Vec3, wanted: impl Fn(u32) -> bool) -> Option<(u32, Closest)> {
    let mut best: Option<(u32, Closest)> = None;
    side.surface.tree.nearest(0, p, f64::INFINITY, |t| {
        if !wanted(t) {
            return f64::INFINITY;
        }
        let found = closest_on_triangle(p, &side.surface.corners(t, side.state.positions));
        let squared = found.distance_squared;
        // Of equally near triangles the lowest index.
        if best.is_none_or(|(u, b)| (squared, t) < (b.distance_squared, u)) {
            best = Some((t, found));
        }
        squared
    });
    best
}

/// How far `p` lies inside \[m\].
fn depth(surface: &Surface, p: &Vec3, t: u32, closest: &Closest, x: &[Vec3]) -> f64 {
    let outward = surface.pseudonormal(t, closest.feature, x);
    let distance = closest.distance_squared.sqrt();
    if outward.dot(&(p - closest.point)) < 0.0 { distance } else { -distance }
}
