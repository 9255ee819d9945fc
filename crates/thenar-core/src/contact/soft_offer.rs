//! The triangle that a vertex of a deformable surface is nearest to, and the one that comes to it
//! in a step.

use crate::contact::approach::LastSide;
use crate::contact::near::{Arrival, Near, may_arrive};
use crate::contact::sides::Sight;
use crate::contact::soft_soft::{NEVER, SoftSoft, VertexScratch};
#[cfg(doc)]
use crate::contact::surface::Facet;
use crate::contact::triangle::{Closest, ROUNDED_UP, closest_on_triangle};

impl SoftSoft<'_> {
    /// Keeps triangle `t`, over whose plane vertex `v` of side `i` has this height
    /// ([`Facet::heights`]), if it is the nearest so far within reach, or the first to come to the
    /// vertex in the step; for a vertex that was in contact, among those that face it.
    pub(super) fn offer(
        &self,
        (i, v): (usize, u32),
        (t, height): (u32, f64),
        reach: f64,
        sight: &Sight,
        scratch: &mut VertexScratch,
    ) {
        let [own, other] = self.facing(i);
        let p = &own.state.positions[v as usize];
        let facet = &other.surface.facets[t as usize];
        let VertexScratch { nearest, arriving, met, .. } = scratch;
        let (best, first) = (&mut nearest[v as usize], &mut arriving[v as usize]);
        // The nearest counts within reach, what comes to touch in this step beyond.
        let away = facet.bounds.distance_squared(p).max(facet.distance_squared_by(height));
        let least = best.map_or(reach * reach, |(_, c)| c.distance_squared.min(reach * reach));
        let comes = self.margin + facet.travel_past(&own.surface.motions[v as usize]);
        let may_come = |squared: f64| squared <= comes * comes * ROUNDED_UP;
        if away > least * ROUNDED_UP && !may_come(away) || self.are_neighbors(v, t) {
            return;
        }
        let x = other.surface.corners(t, other.state.positions);
        let seen = sight.recall(own.surface.first_vertex + v as usize, other.id);
        if seen.is_some_and(|s: LastSide| s.normal.dot(&facet.area) <= 0.0) {
            return;
        }
        let closest = closest_on_triangle(p, &x);
        let known = best.is_some() || *first != NEVER;
        // Of equally near triangles (a shared edge) the lowest index, whatever the order.
        let nearer = match best {
            None => closest.distance_squared <= reach * reach,
            Some((u, c)) => (closest.distance_squared, t) < (c.distance_squared, *u),
        };
        if nearer {
            *best = Some((t, closest));
        }
        let squared = closest.distance_squared;
        if squared > self.margin * self.margin && may_come(squared) {
            let latest = first.0.min(1.0);
            let arrival = self.arrival(i, v, t, closest, latest);
            let then = arrival.map_or(NEVER, |a| (a.at, t));
            if then < *first {
                *first = then;
            }
        }
        if !known && (nearer || *first != NEVER) {
            met.push(v);
        }
    }

    /// Returns the arrival of triangle `t` of the other side at vertex `v` of side `i`, if no later
    /// than after the part `latest` of the step.
    fn arrival(&self, i: usize, v: u32, t: u32, now: Closest, latest: f64) -> Option<Arrival> {
        let [own, other] = self.facing(i);
        let p = &own.state.positions[v as usize];
        let corners = other.surface.triangles[t as usize];
        let (motion, motions) = (own.surface.motions[v as usize], &other.surface.motions);
        let past = |k: usize| (motions[corners[k] as usize] - motion) * latest;
        if !may_arrive(p, &now, self.margin, past) {
            return None;
        }
        self.relative(i, v, t).arrival_from(p, 0.0, self.margin, now, latest)
    }

    /// Triangle `t` of the other side as it moves past vertex `v` of side `i`.
    pub(super) fn relative(&self, i: usize, v: u32, t: u32) -> Near {
        let [own, other] = self.facing(i);
        let own_velocity = own.state.velocities[v as usize];
        let corners = other.surface.triangles[t as usize].map(|w| w as usize);
        let motion = |w: usize| (other.state.velocities[w] - own_velocity) * self.h;
        Near::moving(t, corners.map(|w| other.state.positions[w]), corners.map(motion))
    }
}
