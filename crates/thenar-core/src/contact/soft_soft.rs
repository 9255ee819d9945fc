//! Two deformable surfaces, or one with itself: vertices against triangles both ways, and edges
//! that cross.

mod crossings;

use crate::capacity_vec::CapacityVec;
use crate::contact::apart::SeparateTriangles;
use crate::contact::approach::LastSide;
use crate::contact::bvh::Bvh;
use crate::contact::collector::{Collector, feature_key};
use crate::contact::sides::Sight;
use crate::contact::soft_deep::{DeepScratch, nearest_on};
use crate::contact::soft_rigid::KEY_SOFT_SOFT;
use crate::contact::surface::{Facet, Surface};
use crate::contact::triangle::{Closest, Feature, ROUNDED_UP, closest_on_triangle};
use crate::contact::{Contact, Site, SurfacePoint, SurfaceState};
use crate::math::Vec3;
use crossings::Cross;

const NONE: u32 = u32::MAX;
/// Distances to one place are equal but for rounding \[m\]. Places a metre from the origin are
/// rounded by 1e-16 m: between points so near to each other a direction is good to 1e-7, between
/// nearer ones soon to nothing.
const BY_ROUNDING: f64 = 1e-9;
/// A vertex whose mean normal goes along the contact's by more than this (cosine) has come through
/// to the far side, or meets a surface turned inside out, and would be held where it does not
/// belong. Up to this, 17° beyond square, the mean normal at a rim may lean. Unit tests hold from
/// -0.3 to 0.9: none tells the value.
const FACING: f64 = 0.3;

/// One of two surfaces. Its boxes are fitted to the step.
#[derive(Clone, Copy)]
pub(crate) struct SoftSide<'a> {
    pub soft: u32,
    /// Number of the body among all bodies.
    pub id: u32,
    pub surface: &'a Surface,
    pub state: SurfaceState<'a>,
    /// Mean velocity.
    pub drift: Vec3,
}

impl SoftSide<'_> {
    #[inline]
    fn facet(&self, t: u32) -> &Facet {
        &self.surface.facets[t as usize]
    }

    #[inline]
    pub(super) fn corners(&self, t: u32) -> [Vec3; 3] {
        self.surface.corners(t, self.state.positions)
    }

    /// True when the surface that goes on beyond the nearest place of a triangle comes nearer to
    /// `p`: where some triangles are left out (neighbours), the nearest of all others may be at the
    /// rim of these, whose inside says nothing.
    fn goes_on_nearer(&self, p: &Vec3, t: u32, nearest: &Closest) -> bool {
        let least = (nearest.distance_squared.sqrt() - BY_ROUNDING).max(0.0).powi(2);
        let is_nearer = |u: u32| {
            let corners = self.surface.corners(u, self.state.positions);
            closest_on_triangle(p, &corners).distance_squared < least
        };
        match nearest.feature {
            Feature::Face => false,
            Feature::Edge(k) => self.surface.across(t, k).is_some_and(is_nearer),
            Feature::Vertex(k) => {
                let vertex = self.surface.triangles[t as usize][k];
                self.surface.around(vertex).iter().copied().any(is_nearer)
            }
        }
    }
}

/// Two surfaces in one step.
pub(crate) struct SoftSoft<'a> {
    pub h: f64,
    pub margin: f64,
    pub a: SoftSide<'a>,
    pub b: SoftSide<'a>,
    /// Given when both sides are the same surface: which parts of it are neighbours.
    pub apart: Option<&'a SeparateTriangles>,
    pub friction: f64,
}

/// Findings on the vertices of each side, and on edges.
#[derive(Clone, Debug)]
pub(crate) struct PairScratch {
    pub(super) vertices: [VertexScratch; 2],
    pub(super) deep: DeepScratch,
    crossings: CapacityVec<Cross>,
    /// No more are kept; not the room that the list happens to have, which a clone lacks.
    crossings_max: usize,
}

#[derive(Clone, Debug)]
pub(super) struct VertexScratch {
    /// Nearest triangle of the other side, for each vertex.
    pub nearest: Vec<Option<(u32, Closest)>>,
    /// Part of the step until a triangle arrives first, and that triangle, for each vertex.
    pub arriving: Vec<(f64, u32)>,
    /// Vertices that have a nearest or an arriving triangle.
    pub met: CapacityVec<u32>,
    /// Per vertex the triangle it touches, or `NONE`.
    touched: Vec<u32>,
}

impl PairScratch {
    /// Room for surfaces of up to this many vertices and triangles.
    pub fn with_size(vertices: usize, triangles: usize) -> Self {
        let one = || VertexScratch {
            nearest: vec![None; vertices],
            arriving: vec![NEVER; vertices],
            met: CapacityVec::with_capacity(vertices),
            touched: vec![NONE; vertices],
        };
        Self {
            vertices: [one(), one()],
            deep: DeepScratch::with_size(vertices, triangles),
            crossings: CapacityVec::with_capacity(vertices),
            crossings_max: vertices,
        }
    }
}

/// A vertex that no triangle reaches in the step.
pub(super) const NEVER: (f64, u32) = (f64::INFINITY, NONE);

impl VertexScratch {
    /// True when vertex `v` is in contact.
    pub fn touches(&self, v: u32) -> bool {
        self.touched[v as usize] != NONE
    }
}

impl SoftSoft<'_> {
    /// Adds at most one contact per vertex, and one per two edges that cross.
    pub fn find(&self, sight: &mut Sight, scratch: &mut PairScratch, out: &mut Collector) {
        let depth = self.depth(&self.a).max(self.depth(&self.b));
        let reach = (self.margin + self.flown()).max(depth);
        match self.apart {
            None => {
                let (a, b) = (&self.a.surface.tree, &self.b.surface.tree);
                Bvh::pairs(a, b, reach, |s, t| self.meet([s, t], reach, sight, scratch, out));
                self.entangle(sight, &mut scratch.deep);
                self.settle(0, sight, scratch, out);
                self.settle(1, sight, scratch, out);
            }
            Some(apart) => {
                let settled = |n, m| apart.are_settled(n, m);
                let joined = |i, j| apart.are_groups_apart(i, j);
                self.a.surface.tree.pairs_within(reach, joined, settled, |s, t| {
                    if !apart.touch_never(s, t) {
                        self.meet([s, t], reach, sight, scratch, out);
                    }
                });
                self.slide_on(apart, reach, sight, &mut scratch.vertices[0]);
                self.entangle(sight, &mut scratch.deep);
                self.settle(0, sight, scratch, out);
            }
        }
        self.settle_crossings(scratch, out);
        let PairScratch { deep, vertices, .. } = scratch;
        self.lead_out(deep, vertices, sight, out);
    }

    /// Returns the distance that the surfaces move past each other on the whole \[m\].
    fn flown(&self) -> f64 {
        self.h * (self.a.drift - self.b.drift).norm()
    }

    /// Returns the depth below a surface down to which a point is led out.
    pub(super) fn depth(&self, side: &SoftSide) -> f64 {
        side.surface.depth_max()
    }

    fn side(&self, i: usize) -> &SoftSide<'_> {
        if i == 0 { &self.a } else { &self.b }
    }

    /// The two sides as seen by a vertex of side `i`: its own and the other one.
    pub(super) fn facing(&self, i: usize) -> [&SoftSide<'_>; 2] {
        [self.side(i), self.side(1 - i)]
    }

    pub(super) fn are_neighbors(&self, v: u32, t: u32) -> bool {
        let corners = |apart: &SeparateTriangles| {
            apart.are_neighbors(v, t, &self.a.surface.triangles[t as usize])
        };
        self.apart.is_some_and(corners)
    }

    /// Offers to each other the vertices and edges of triangle `s` of A and `t` of B. Those that
    /// are farther apart than `reach` only touch if they come nearer in this step.
    fn meet(
        &self,
        [s, t]: [u32; 2],
        reach: f64,
        sight: &Sight,
        scratch: &mut PairScratch,
        out: &mut Collector,
    ) {
        let [of_s, of_t] = [(&self.a, s), (&self.b, t)].map(|(side, t)| side.facet(t));
        let [x, y] = [(&self.a, s), (&self.b, t)].map(|(side, t)| side.corners(t));
        let heights = [of_t.heights(&y[0], &x), of_s.heights(&x[0], &y)];
        let is_within = |reach: f64| {
            of_s.bounds.inflate(reach).overlaps(&of_t.bounds)
                && !of_t.is_beyond(&heights[0], reach)
                && !of_s.is_beyond(&heights[1], reach)
        };
        let is_near = is_within(reach);
        if !is_near && !is_within((self.margin + of_s.travel_past_all(of_t)) * ROUNDED_UP) {
            return;
        }
        let second = usize::from(self.apart.is_none());
        for (k, v) in self.a.surface.owned_corners(s) {
            self.offer((0, v), (t, heights[0][k]), reach, sight, &mut scratch.vertices[0]);
        }
        for (k, v) in self.b.surface.owned_corners(t) {
            self.offer((1, v), (s, heights[1][k]), reach, sight, &mut scratch.vertices[second]);
        }
        if is_near {
            self.cross([s, t], &heights, reach, scratch, out);
            if of_s.bounds.overlaps(&of_t.bounds) {
                self.pierce([s, t], &heights, &mut scratch.deep);
            }
        }
    }

    /// Offers to each vertex that was in contact, of one surface, the flesh of its own bone and of
    /// those joined to that, too, where no contact begins: one that slides there, over the rim of
    /// what it may touch, goes on until the two part.
    fn slide_on(
        &self,
        apart: &SeparateTriangles,
        reach: f64,
        sight: &Sight,
        scratch: &mut VertexScratch,
    ) {
        let side = &self.a;
        let (first, count) = (side.surface.first_vertex, side.surface.vertex_count());
        for seen in sight.before.of(first..first + count, side.id) {
            let v = seen.vertex - first as u32;
            let p = &side.state.positions[v as usize];
            let wanted = |t: u32| {
                let faces = seen.normal.dot(&side.surface.facets[t as usize].area) > 0.0;
                faces && !apart.are_near(v, t)
            };
            let known = scratch.nearest[v as usize];
            // What lies before another face touches that.
            if known.is_some_and(|(t, nearest)| !side.goes_on_nearer(p, t, &nearest)) {
                continue;
            }
            let bound = known.map_or(reach, |(_, c)| c.distance_squared.sqrt().min(reach));
            let Some(nearest) = nearest_on(side, p, bound, wanted) else { continue };
            if known.is_none() && scratch.arriving[v as usize] == NEVER {
                scratch.met.push(v);
            }
            scratch.nearest[v as usize] = Some(nearest);
        }
    }

    /// Turns the nearest triangles of side `i` into contacts, in the order of its vertices.
    fn settle(&self, i: usize, sight: &mut Sight, scratch: &mut PairScratch, out: &mut Collector) {
        let surface = self.side(i).surface;
        let PairScratch { vertices, deep, .. } = scratch;
        let own = &mut vertices[i];
        own.met.sort_unstable();
        own.touched.fill(NONE);
        for m in 0..own.met.len() {
            let v = own.met[m];
            let arriving = std::mem::replace(&mut own.arriving[v as usize], NEVER);
            let nearest = own.nearest[v as usize].take();
            if deep.leads(i, v, surface) {
                continue;
            }
            let touched = nearest.filter(|(t, c)| self.vertex(i, v, *t, c, sight, out));
            if let Some((t, _)) = touched {
                own.touched[v as usize] = t;
            } else if arriving != NEVER && self.arrive(i, v, arriving.1, sight, out) {
                own.touched[v as usize] = arriving.1;
            }
        }
        own.met.clear();
    }

    /// A vertex of side `i` at its nearest triangle; true if it becomes a contact.
    #[allow(clippy::too_many_arguments)]
    fn vertex(
        &self,
        i: usize,
        v: u32,
        t: u32,
        closest: &Closest,
        sight: &mut Sight,
        out: &mut Collector,
    ) -> bool {
        let [own, other] = self.facing(i);
        let p = own.state.positions[v as usize];
        let Some((normal, gap)) = signed(other, &p, t, closest) else { return false };
        if gap > self.margin || gap < -self.depth(other) {
            return false;
        }
        let own_normal = own.surface.vertex_normal(v, own.state.positions);
        if own_normal.dot(&normal) > FACING * own_normal.norm() {
            return false;
        }
        // Last, as it costs most.
        if gap < 0.0 && !self.has_got_in(other, v, &p, (t, closest), -gap) {
            return false;
        }
        self.push([own, other], v, (t, closest.weights), (normal, gap), sight, out);
        true
    }

    /// True when a vertex at `p`, `depth` \[m\] behind its nearest place of the other side, is in
    /// it. A shallow one is; a deep one is by winding number, as the outer side of a surface that
    /// is folded inside out looks inward. Within one surface, it must not be nearest to the rim of
    /// its neighbours.
    pub(super) fn has_got_in(
        &self,
        other: &SoftSide,
        v: u32,
        p: &Vec3,
        (t, nearest): (u32, &Closest),
        depth: f64,
    ) -> bool {
        if self.apart.is_none() {
            return other.surface.holds_behind(p, depth, other.state.positions);
        }
        !other.goes_on_nearer(p, t, nearest) && (!other.surface.is_deep(depth) || self.is_wound(v))
    }

    /// A vertex of side `i` at the triangle that it comes to in this step.
    fn arrive(&self, i: usize, v: u32, t: u32, sight: &mut Sight, out: &mut Collector) -> bool {
        let [own, other] = self.facing(i);
        let p = own.state.positions[v as usize];
        let Some(arrival) = self.relative(i, v, t).arrival(&p, 0.0, self.margin) else {
            return false;
        };
        let normal = -arrival.normal;
        let own_normal = own.surface.vertex_normal(v, own.state.positions);
        if own_normal.dot(&normal) > FACING * own_normal.norm() {
            return false;
        }
        self.push([own, other], v, (t, arrival.weights), (normal, arrival.gap), sight, out);
        true
    }

    /// A vertex of `own` at a place of `other`, told by triangle and weights.
    pub(super) fn push(
        &self,
        [own, other]: [&SoftSide; 2],
        v: u32,
        (t, weights): (u32, [f64; 3]),
        (normal, gap): (Vec3, f64),
        sight: &mut Sight,
        out: &mut Collector,
    ) {
        let p = own.state.positions[v as usize];
        let vertices = other.surface.triangles[t as usize];
        sight.note(own.surface.first_vertex + v as usize, other.id, LastSide { normal, place: p });
        out.push(Contact {
            key: feature_key([KEY_SOFT_SOFT, own.soft, other.soft, v]),
            a: Site::Soft(SurfacePoint::vertex(own.soft, v)),
            b: Site::Soft(SurfacePoint { soft: other.soft, vertices, weights }),
            position_W: p,
            normal_W: normal,
            gap,
            friction: self.friction,
        });
    }

    /// True when an edge is a neighbour of triangle `other`.
    pub(super) fn is_neighbor(&self, side: &SoftSide, t: u32, k: usize, other: u32) -> bool {
        let corners = side.surface.triangles[t as usize];
        [corners[k], corners[(k + 1) % 3]].iter().any(|&v| self.are_neighbors(v, other))
    }
}

/// Normal of a side at its point nearest to `p`, and the signed distance along it.
fn signed(side: &SoftSide, p: &Vec3, t: u32, closest: &Closest) -> Option<(Vec3, f64)> {
    let outward = side.surface.pseudonormal(t, closest.feature, side.state.positions);
    if outward == Vec3::zeros() {
        return None;
    }
    let to_p = p - closest.point;
    let gap = closest.distance_squared.sqrt().copysign(to_p.dot(&outward));
    let on_face = closest.feature == Feature::Face || gap.abs() < BY_ROUNDING;
    Some((if on_face { outward } else { to_p / gap }, gap))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::tests::{Scene, cube};

    /// A face that is pressed together sideways to a tenth brings parts of it near each other that
    /// are no neighbours. None of it lies in the other, whether a vertex is a little above or below
    /// their plane.
    #[test]
    fn what_lies_beside_the_rim_of_its_neighbours_is_not_in_it() {
        for n in [6, 9, 12] {
            for height in [-1e-4, -1e-5, 1e-5] {
                let mut scene = Scene::new();
                let soft = scene.soft(cube(0.04, n));
                scene.desc.self_contact.push(soft);
                let points = &mut scene.surfaces[0].0;
                for p in points.iter_mut().filter(|p| p.y > 0.0199) {
                    p.x *= 0.1;
                    p.z *= 0.1;
                }
                let nearest = |p: &&mut Vec3| p.x.abs() + p.z.abs() < 0.5e-3 && p.y > 0.0199;
                let raised: Vec<_> = points.iter_mut().filter(nearest).collect();
                assert!(!raised.is_empty());
                raised.into_iter().for_each(|p| p.y += height);
                let deep: Vec<f64> =
                    scene.find(1e-3).iter().map(|c| c.gap).filter(|gap| *gap < -1e-5).collect();
                assert!(deep.is_empty(), "{n} cells, {height} m: {deep:?}");
            }
        }
    }
}
