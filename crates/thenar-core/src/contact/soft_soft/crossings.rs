//! Edges of two surfaces, or of one with itself, that cross.

use super::{PairScratch, SoftSide, SoftSoft};
use crate::contact::aabb::Aabb;
use crate::contact::collector::{Collector, feature_key};
use crate::contact::ridge::{Crossing, Passing, Ridge, crossing, passing};
use crate::contact::soft_rigid::KEY_CROSSING;
use crate::contact::surface::Facet;
use crate::contact::triangle::Feature;
use crate::contact::{Contact, Site, SurfacePoint};
use crate::math::Vec3;

/// Edges (triangle and number) of A and B that cross.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cross {
    edges: [(u32, usize); 2],
    found: Crossing,
}

impl SoftSoft<'_> {
    /// Notes the edges of `s` and `t` that cross. Between two bodies each edge belongs to one
    /// triangle; within one surface the lowest pair of the edges' faces that may touch answers for
    /// them.
    pub(super) fn cross(
        &self,
        pair: [u32; 2],
        heights: &[[f64; 3]; 2],
        reach: f64,
        scratch: &mut PairScratch,
        out: &mut Collector,
    ) {
        let of_a = |k: usize| (&self.a, pair[0], k, &heights[0]);
        let of_b = |k: usize| (&self.b, pair[1], k, &heights[1]);
        let mut edges_b = None;
        for k in 0..3 {
            let Some(ends_a) = self.edge(of_a(k), self.b.facet(pair[1]), reach) else { continue };
            let edges_b = edges_b.get_or_insert_with(|| {
                [0, 1, 2].map(|l| self.edge(of_b(l), self.a.facet(pair[0]), reach))
            });
            for (l, ends_b) in edges_b.iter().enumerate() {
                let Some(ends_b) = ends_b else { continue };
                let Some(passing) = passing(&ends_a, ends_b, reach) else { continue };
                let edges = [(pair[0], k), (pair[1], l)];
                let Some(rims) = self.rims(edges) else { continue };
                let Some(found) = self.crossing(&passing, edges, rims) else { continue };
                if scratch.crossings.len() < scratch.crossings_max {
                    scratch.crossings.push(Cross { edges, found });
                } else {
                    out.count_dropped(1);
                }
            }
        }
    }

    /// Tells which of two edges (triangle and number) of A and B are *rims*: the face across is
    /// flesh of a bone joined to that of the other edge, and the two never touch. `None` where
    /// these two triangles do not answer for the edges.
    fn rims(&self, edges: [(u32, usize); 2]) -> Option<[bool; 2]> {
        let [(s, k), (t, l)] = edges;
        let Some(apart) = self.apart else { return Some([false; 2]) };
        let may_touch_a = |face: u32| !self.is_neighbor(&self.b, t, l, face);
        let may_touch_b = |face: u32| !self.is_neighbor(&self.a, s, k, face);
        if !may_touch_a(s) || !may_touch_b(t) {
            return None;
        }
        let (across_a, across_b) = (self.a.surface.across(s, k), self.b.surface.across(t, l));
        let (a, b) = (
            across_a.filter(|&face| may_touch_a(face)),
            across_b.filter(|&face| may_touch_b(face)),
        );
        let order = |a: u32, b: u32| (a.min(b), a.max(b));
        let others =
            [a.map(|a| order(a, t)), b.map(|b| order(s, b)), a.zip(b).map(|(a, b)| order(a, b))];
        if others.into_iter().flatten().any(|pair| pair < order(s, t)) {
            return None;
        }
        let triangles = &self.a.surface.triangles;
        let is_joined = |(t, k): (u32, usize), face: u32| {
            let ends = [k, (k + 1) % 3].map(|k| triangles[t as usize][k]);
            ends.iter().any(|&v| apart.are_of_joined_bones(v, &triangles[face as usize]))
        };
        let of_a = across_a.is_some_and(|face| is_joined(edges[1], face));
        let of_b = across_b.is_some_and(|face| is_joined(edges[0], face));
        Some([of_a, of_b])
    }

    /// The ends of edge `k` of a triangle whose corners have these heights over another one
    /// ([`Facet::heights`]), unless it is farther than `reach` from that, or belongs to another
    /// triangle of its body.
    #[inline(always)]
    fn edge(
        &self,
        (side, t, k, heights): (&SoftSide, u32, usize, &[f64; 3]),
        other: &Facet,
        reach: f64,
    ) -> Option<[Vec3; 2]> {
        if self.apart.is_none() && !side.surface.owns(t, Feature::Edge(k)) {
            return None;
        }
        let (i, j) = (k, (k + 1) % 3);
        if other.is_beyond(&[heights[i], heights[j]], reach) {
            return None;
        }
        let corners = side.surface.triangles[t as usize];
        let ends = [i, j].map(|k| side.state.positions[corners[k] as usize]);
        let around = Aabb { min: ends[0], max: ends[0] }.with(&ends[1]);
        around.inflate(reach).overlaps(&other.bounds).then_some(ends)
    }

    /// The contact of two edges that pass; of a rim only the triangle's own face counts.
    fn crossing(
        &self,
        passing: &Passing,
        edges: [(u32, usize); 2],
        rims: [bool; 2],
    ) -> Option<Crossing> {
        let ridge = |i: usize| {
            let (side, (t, k)) = (self.side(i), edges[i]);
            let ridge = if rims[i] { Ridge::rim } else { Ridge::of };
            ridge(side.surface, t, k, side.state.positions)
        };
        let found = crossing(passing, &ridge(0)?, &ridge(1)?)?;
        let [a, b] = self.points(&Cross { edges, found });
        let slip = a.interpolate(self.a.state.velocities) - b.interpolate(self.b.state.velocities);
        let closing = (-slip.dot(&found.normal)).max(0.0) * self.h;
        let depth = self.depth(&self.a).min(self.depth(&self.b));
        (found.gap <= self.margin + closing && found.gap >= -depth).then_some(found)
    }

    fn points(&self, cross: &Cross) -> [SurfacePoint; 2] {
        [0, 1].map(|i| {
            let (side, (t, k), s) = (self.side(i), cross.edges[i], cross.found.at[i]);
            let mut weights = [0.0; 3];
            (weights[k], weights[(k + 1) % 3]) = (1.0 - s, s);
            let vertices = side.surface.triangles[t as usize];
            SurfacePoint { soft: side.soft, vertices, weights }
        })
    }

    pub(super) fn settle_crossings(&self, scratch: &mut PairScratch, out: &mut Collector) {
        scratch.crossings.sort_unstable_by_key(|c| c.edges);
        let PairScratch { crossings, deep, .. } = scratch;
        for cross in crossings.drain(..) {
            let [(s, _), (t, _)] = cross.edges;
            if deep.is_deep(0, s) || deep.is_deep(usize::from(self.apart.is_none()), t) {
                continue;
            }
            let [a, b] = self.points(&cross);
            let [i, j] = cross.edges.map(|(t, k)| 3 * t + k as u32);
            let Crossing { normal, gap, .. } = cross.found;
            out.push(Contact {
                key: feature_key([KEY_CROSSING | self.a.soft, self.b.soft, i, j]),
                a: Site::Soft(a),
                b: Site::Soft(b),
                position_W: b.interpolate(self.b.state.positions) + 0.5 * gap * normal,
                normal_W: normal,
                gap,
                friction: self.friction,
            });
        }
    }
}
