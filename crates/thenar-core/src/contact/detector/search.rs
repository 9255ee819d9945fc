//! Pairs of each kind, tested one after another.

use super::two_rigid::TwoRigid;
use super::{Detector, Scratch};
use crate::contact::aabb::Aabb;
use crate::contact::collector::Collector;
use crate::contact::crowd::Allowance;
use crate::contact::deepening::Since;
use crate::contact::rigid_pair::{Reach, RigidSide};
use crate::contact::sides::Sight;
use crate::contact::soft_pairs::SoftPair;
use crate::contact::soft_rigid::SoftRigid;
use crate::contact::soft_soft::{SoftSide, SoftSoft};
use crate::contact::{Site, SurfaceState};
use crate::math::Vec3;
use crate::model::BodyId;

impl Detector {
    /// Sweeps along x over all rigid bodies, as far as the [`Allowance`] goes; contacts are then
    /// put in the order of the bodies.
    pub(super) fn rigid_rigid(&mut self, reach: Reach, since: Option<Since>, out: &mut Collector) {
        let Self { pairs, bodies, scratch, .. } = self;
        let Scratch { placed, order, manifold, .. } = scratch;
        let low = |i: u32| placed[i as usize].swept_W.min.x;
        order.sort_unstable_by(|&i, &j| low(i).total_cmp(&low(j)).then(i.cmp(&j)));
        let (mut allowance, mut skipped) = (Allowance::new(order.len()), 0);
        // Those that were near each other only on their way.
        let mut on_way = Allowance::new(order.len());
        for (k, &i) in order.iter().enumerate() {
            let end = placed[i as usize].swept_W.max.x + reach.margin;
            allowance.next_body();
            on_way.next_body();
            for &j in order[k + 1..].iter().take_while(|&&j| low(j) <= end) {
                let (i, j) = (i.min(j), i.max(j));
                let (Some(a), Some(b)) = (&bodies[i as usize], &bodies[j as usize]) else {
                    continue;
                };
                if !a.dynamic && !b.dynamic {
                    continue;
                }
                // Floors and walls meet any number.
                let of_crowd = a.dynamic && b.dynamic;
                let margin =
                    if of_crowd { allowance.margin(reach.margin) } else { Some(reach.margin) };
                let Some(margin) = margin else {
                    skipped += 1;
                    continue;
                };
                let sides = [(a, i), (b, j)]
                    .map(|(body, i)| RigidSide { body, placed: &placed[i as usize] });
                let near = |of: RigidSide, other: RigidSide| {
                    let swept = &other.placed.swept_W;
                    let bounded = *swept != Aabb::EVERYTHING;
                    !bounded || of.placed.may_touch(&of.body.shape, swept, margin, reach.h)
                };
                if !near(sides[0], sides[1]) || !near(sides[1], sides[0]) {
                    continue;
                }
                let two = TwoRigid::new([(a, i), (b, j)]);
                let past = since.map(|since| (since, two.past(&since)));
                if matches!(past, Some((_, None))) {
                    continue;
                }
                let ids = [i, j].map(BodyId::Rigid);
                let Some(friction) = pairs.friction(ids[0], ids[1], a.friction, b.friction) else {
                    continue;
                };
                let ends = sides.map(|side| side.placed.end_W);
                let at_end = since.is_none() || ends[0].inflate(margin).overlaps(&ends[1]);
                if of_crowd && !at_end && on_way.margin(0.0).is_none() {
                    continue;
                }
                out.count_pair();
                if of_crowd {
                    if at_end { allowance.spend() } else { on_way.spend() }
                }
                if at_end {
                    two.find(sides.map(|side| side.placed), reach, friction, manifold, out);
                }
                if let Some((since, Some(past))) = past {
                    two.measure_way(&since, past, manifold, out);
                }
            }
        }
        out.count_dropped(skipped);
        out.sort_by_key(|c| (rigid_index(&c.a), rigid_index(&c.b), c.key));
    }

    pub(super) fn soft_rigid(
        &mut self,
        pair: SoftPair,
        reach: Reach,
        states: SurfaceState,
        since: Option<Since>,
        sight: &mut Sight,
        out: &mut Collector,
    ) {
        let (soft, rigid) = (pair.soft as usize, pair.other as usize);
        let Some(body) = &self.bodies[rigid] else { return };
        let Scratch { placed, bounds, vertices, features, .. } = &mut self.scratch;
        let placed = &placed[rigid];
        let surface = &mut self.surfaces[soft];
        // A feature may have come through a triangle by so much and still touch.
        let inflated = reach.margin + surface.depth_max();
        if !placed.may_touch(&body.shape, &bounds[soft].swept, inflated, reach.h) {
            return;
        }
        let of = (body, placed, rigid);
        if since.is_some_and(|since| !since.may_deepen_in(surface, states.positions, of)) {
            return;
        }
        out.count_pair();
        let within = |p: &Vec3| bounds[soft].swept.contains(&placed.world_point(p));
        let may_be_inside = body.sharp.inner.iter().any(|inner| within(&inner.center));
        if may_be_inside && !std::mem::replace(&mut bounds[soft].refitted, true) {
            surface.refit(&surface.own(states), reach.h, &bounds[soft].drift);
        }
        let search = SoftRigid {
            h: reach.h,
            margin: reach.margin,
            soft: pair.soft,
            surface,
            state: surface.own(states),
            may_be_inside,
            travel: reach.h * (bounds[soft].drift.norm() + bounds[soft].spread),
            rigid: pair.other,
            body,
            placed,
            friction: pair.friction,
        };
        search.find(sight, vertices, features, out);
    }

    pub(super) fn soft_soft(
        &mut self,
        pair: SoftPair,
        reach: Reach,
        states: SurfaceState,
        since: Option<Since>,
        sight: &mut Sight,
        out: &mut Collector,
    ) {
        let both = [pair.soft as usize, pair.other as usize];
        let swept = both.map(|i| self.scratch.bounds[i].swept);
        if swept[0].is_empty() || !swept[0].inflate(reach.margin).overlaps(&swept[1]) {
            return;
        }
        let apart = self.apart[both[0]].as_ref().filter(|_| both[0] == both[1]);
        if let Some(since) = since {
            let sides = both.map(|i| (&self.surfaces[i], &self.clusters[i]));
            if !since.may_deepen(sides, apart) {
                return;
            }
        }
        out.count_pair();
        for i in both {
            let bounds = &mut self.scratch.bounds[i];
            if !std::mem::replace(&mut bounds.refitted, true) {
                let own = self.surfaces[i].own(states);
                self.surfaces[i].refit(&own, reach.h, &bounds.drift);
            }
        }
        let [a, b] = both.map(|i| SoftSide {
            soft: i as u32,
            id: self.pairs.id(BodyId::Soft(i as u32)),
            surface: &self.surfaces[i],
            state: self.surfaces[i].own(states),
            drift: self.scratch.bounds[i].drift,
        });
        let Reach { h, margin } = reach;
        SoftSoft { h, margin, a, b, apart, friction: pair.friction }.find(
            sight,
            &mut self.scratch.pair,
            out,
        );
    }
}

fn rigid_index(site: &Site) -> u32 {
    match site {
        Site::Rigid { body, .. } => *body,
        Site::Soft(point) => point.soft,
    }
}
