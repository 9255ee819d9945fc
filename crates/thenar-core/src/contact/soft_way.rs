//! Direction in which an entangled region leaves.
//!
//! Vertices that each took the nearest place outside would pull their body apart: those of a side
//! wall are nearest to the wall beside them. A region leaves along one direction n, A by +n and B
//! by -n, and its *depth along n* is how far the farthest of its places has to go, the least common
//! translation that frees it. Of all directions the shallowest is the penetration depth of the
//! region (Cameron 1997, for rigid bodies). Tried are: the way it came in by, as its vertices have
//! seen the other surface; the gradient of the common volume, which is minus the sum of the area
//! vectors inside (Allard et al. 2010); and those ways from some of its places to the nearest place
//! outside that make the common volume smaller: others lead a region on through the other body,
//! whose far side it does not see. Edges that go through with no vertex inside tell little of the
//! volume: the faces that they went through are tried, too.

use crate::contact::sides::Sight;
use crate::contact::soft_deep::{NONE, Place};
use crate::contact::soft_soft::SoftSoft;
use crate::contact::triangle::{area_vector, cut_by_ray};
use crate::math::Vec3;

/// Another way is taken than it came in by only if that is shorter by this factor: ways of about
/// one length do not alternate. Out of a flat face the way is longer by as much where it stands at
/// 60° to its normal.
pub(super) const HYSTERESIS: f64 = 2.0;
/// Number of places, taken evenly by depth from all, that offer their nearest way out. Each offer
/// asks all places for their depth along it: the work grows with the region, and not with its
/// square.
const OFFERED: usize = 32;

/// Normals are of one way out if they are parallel so far (cosine, less rounding).
const PARALLEL: f64 = 1.0 - 1e-9;
/// Round-off of a sum of area vectors, in parts of their lengths.
const ROUNDING: f64 = 1e-12;

/// Way by which a region leaves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    /// Unit direction for side A; B goes against it.
    pub along: Vec3,
    /// Farthest way of a place, in parts of how deep the search near its other surface looks.
    pub relative: f64,
}

impl Way {
    /// The direction of a side.
    pub fn of(&self, side: usize) -> Vec3 {
        self.along * sign(side)
    }
}

fn sign(side: usize) -> f64 {
    if side == 0 { 1.0 } else { -1.0 }
}

/// Point at which a place comes out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exit {
    /// Length of its way \[m\].
    pub depth: f64,
    /// Through this place of the other surface.
    pub triangle: u32,
    pub weights: [f64; 3],
}

impl SoftSoft<'_> {
    /// The way of some places, the deepest first.
    pub(super) fn way(&self, places: &[Place], sight: &Sight) -> Option<Way> {
        let mut best: Option<(Vec3, f64)> = None;
        let mut bound = f64::INFINITY;
        let mut offer = |direction: Vec3, kept: f64| {
            let Some(along) = direction.try_normalize(0.0) else { return };
            if let Some(depth) = self.depth_along(places, &along, bound) {
                best = Some((along, depth));
                bound = depth / kept;
            }
        };
        let gradient: Vec3 = places.iter().map(|p| p.inward * sign(p.side)).sum();
        let rounding = ROUNDING * places.iter().map(|p| p.inward.norm()).sum::<f64>();
        offer(self.came_in_by(places, sight), HYSTERESIS);
        offer(gradient, 1.0);
        let stride = places.len().div_ceil(OFFERED);
        if places.iter().all(|p| p.vertex == NONE) {
            for place in places.iter().step_by(stride) {
                let [_, other] = self.facing(place.side);
                let face = other.surface.corners(place.through, other.state.positions);
                offer(area_vector(&face) * sign(place.side), 1.0);
            }
        }
        for place in places.iter().step_by(stride) {
            let out = if place.vertex == NONE { place.inward } else { place.out };
            let out = out * sign(place.side);
            if gradient.dot(&out) >= -rounding * out.norm() {
                offer(out, 1.0);
            }
        }
        best.map(|(along, relative)| Way { along, relative })
    }

    /// The sum of the normals that its vertices saw in the step before.
    fn came_in_by(&self, places: &[Place], sight: &Sight) -> Vec3 {
        self.seen(places, sight).sum()
    }

    /// True when a region was put where it is: its vertices have seen nothing of the other surface,
    /// or most of them were on one way out. What came in by itself saw the other surface bend
    /// around it.
    pub(super) fn was_put(&self, places: &[Place], sight: &Sight) -> bool {
        let Some(first) = self.seen(places, sight).next() else { return true };
        let parallel = self.seen(places, sight).filter(|n| n.dot(&first) >= PARALLEL).count();
        2 * parallel >= self.seen(places, sight).count()
    }

    /// Directions for A that its vertices saw in the step before.
    fn seen(&self, places: &[Place], sight: &Sight) -> impl Iterator<Item = Vec3> {
        places.iter().filter(|p| p.vertex != NONE).filter_map(|place| {
            let [own, other] = self.facing(place.side);
            let vertex = own.surface.first_vertex + place.vertex as usize;
            Some(sight.recall(vertex, other.id)?.normal * sign(place.side))
        })
    }

    /// Depth of places along a direction, in parts of how deep the search near a surface looks;
    /// `None` if it is not below `bound`, or some find no way out.
    fn depth_along(&self, places: &[Place], along: &Vec3, bound: f64) -> Option<f64> {
        let mut deepest = 0.0_f64;
        for place in places {
            let [_, other] = self.facing(place.side);
            let depth = match self.exit(place, along) {
                Some(exit) => exit.depth / self.depth(other),
                None if place.vertex == NONE => 0.0,
                None => return None,
            };
            deepest = deepest.max(depth);
            if deepest >= bound {
                return None;
            }
        }
        Some(deepest)
    }

    /// Returns the point at which a place leaves the other surface if A goes along a direction.
    pub(super) fn exit(&self, place: &Place, along: &Vec3) -> Option<Exit> {
        let [_, other] = self.facing(place.side);
        let along = along * sign(place.side);
        let area = |t: u32| area_vector(&other.surface.corners(t, other.state.positions));
        let mut best: Option<Exit> = None;
        other.surface.tree.along_ray(&place.p, &along, |t| {
            let least = best.map_or(f64::INFINITY, |best| best.depth);
            if area(t).dot(&along) <= 0.0 {
                return least;
            }
            let x = other.surface.corners(t, other.state.positions);
            let Some((depth, weights)) = cut_by_ray(&place.p, &along, &x) else { return least };
            // Of equally far triangles the lowest index.
            if best.is_none_or(|best| (depth, t) < (best.depth, best.triangle)) {
                best = Some(Exit { depth, triangle: t, weights });
            }
            least.min(depth)
        });
        // It has gone through there, and goes back there.
        best.filter(|best| best.triangle != place.through)
    }

    /// True when a vertex of a surface that touches itself is inside another part of it: beyond its
    /// own triangles, a ray out of it leaves once more than it enters (winding number).
    pub(super) fn is_wound(&self, v: u32) -> bool {
        let side = &self.a;
        let normal = &side.surface.vertex_normal(v, side.state.positions);
        let p = side.state.positions[v as usize];
        let mut winding = 0;
        side.surface.tree.along_ray(&p, normal, |t| {
            let x = side.surface.corners(t, side.state.positions);
            if !side.surface.triangles[t as usize].contains(&v)
                && cut_by_ray(&p, normal, &x).is_some()
            {
                winding += if area_vector(&x).dot(normal) > 0.0 { 1 } else { -1 };
            }
            f64::INFINITY
        });
        winding > 0
    }
}
