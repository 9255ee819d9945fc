//! The contact points of one pair of rigid bodies.

use crate::capacity_vec::CapacityVec;
use crate::math::{Vec3, tangents};

/// Points held at once. When there are more, those that would be delivered last are let go.
pub(super) const OFFERED_MAX: usize = 64;
/// Number of points that remain then.
const POINTS_KEPT: usize = 32;
/// Points delivered are at most this many: the deepest, and those farthest apart.
pub(crate) const DELIVERED_MAX: usize = 12;
/// Height over the deepest point, in parts of how far apart points lie, past which the lower points
/// go first: a body can only stand on those. A body tilts by this much (0.6°) before it stands on a
/// higher one.
const LEVEL: f64 = 1e-2;
/// Points that differ by no more than this part of their reach are as good as each other, and the
/// one offered first is taken: a body that comes to rest trembles by less, and its points must not
/// change for that. What is left out for it lies deeper by no more than 4 µm under a cup that is 40
/// mm wide.
const EQUAL: f64 = 1e-4;

/// Ways in which a body may tilt: with six, each corner of a rectangle comes first in one.
const TILTS: usize = 6;
/// Tilt of the body \[rad\]: a small angle, which weighs a gap of 1 mm like 2 cm to the side, the
/// usual margin like the size of what a hand holds. Among level points any angle makes the same
/// choice.
const TILT: f64 = 0.05;

/// One point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ManifoldPoint {
    /// Names the features that meet.
    pub feature: u32,
    pub position_W: Vec3,
    /// From B to A.
    pub normal_W: Vec3,
    pub gap: f64,
}

/// A bounded set of points. Those of the pair of pieces in hand lie last, and make room among
/// themselves.
#[derive(Clone, Debug, Default)]
pub(crate) struct Manifold {
    points: CapacityVec<ManifoldPoint>,
    /// The first of them.
    own: usize,
}

impl Manifold {
    pub fn new() -> Self {
        Self { points: CapacityVec::with_capacity(OFFERED_MAX), own: 0 }
    }

    pub fn clear(&mut self) {
        self.points.clear();
        self.own = 0;
    }

    /// Begins another pair of pieces, for which half the room is kept. Returns the index of its
    /// first point, which stays its first whatever is offered.
    pub fn begin(&mut self) -> usize {
        self.leave(0, POINTS_KEPT);
        self.own = self.points.len();
        self.own
    }

    /// Ends the last pair: what is offered now is of the whole.
    pub fn end(&mut self) {
        self.own = 0;
    }

    pub fn points(&self) -> &[ManifoldPoint] {
        &self.points
    }

    pub fn points_mut(&mut self) -> &mut [ManifoldPoint] {
        &mut self.points
    }

    /// Offers a point.
    pub fn offer(&mut self, point: ManifoldPoint) {
        if self.points.len() == OFFERED_MAX {
            self.leave(self.own, (OFFERED_MAX - self.own) / 2);
        }
        self.points.push(point);
    }

    /// Removes points from `first` on that `keep` does not hold for.
    pub fn retain_from(&mut self, first: usize, mut keep: impl FnMut(&ManifoldPoint) -> bool) {
        let mut kept = first;
        for i in first..self.points.len() {
            if keep(&self.points[i]) {
                self.points.swap(kept, i);
                kept += 1;
            }
        }
        self.points.truncate(kept);
    }

    /// Leaves at most `DELIVERED_MAX` points: first the deepest (but for [`EQUAL`]), then those
    /// that would touch first if the body tilted, then again and again the one farthest from those
    /// chosen, at first of those about as deep.
    pub fn reduce(&mut self) {
        self.leave(0, DELIVERED_MAX);
    }

    /// Leaves `count` of the points from `first` on.
    fn leave(&mut self, first: usize, count: usize) {
        if self.points.len() - first > count {
            choose(&mut self.points[first..], count);
            self.points.truncate(first + count);
        }
    }
}

/// Finds the least index from `from` on whose worth comes within `equal` of the most.
fn best(from: usize, count: usize, equal: f64, worth: impl Fn(usize) -> f64) -> usize {
    let mut all = [f64::NEG_INFINITY; OFFERED_MAX];
    (from..count).for_each(|i| all[i] = worth(i));
    let most = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (from..count).find(|&i| all[i] >= most - equal).unwrap_or(from)
}

/// Puts a point next to the `chosen` first ones; the others keep their order.
fn take(points: &mut [ManifoldPoint], chosen: usize, i: usize) {
    points[chosen..=i].rotate_right(1);
}

/// Puts the `count` points to keep, of more, before the others, both in the order in which they
/// were offered.
fn choose(points: &mut [ManifoldPoint], count: usize) {
    let n = points.len();
    let lowest = points.iter().map(|p| p.gap).fold(f64::INFINITY, f64::min);
    let from = points[0].position_W;
    // No farther than twice what it would be from any other point.
    let reach = points.iter().map(|p| (p.position_W - from).norm()).fold(0.0, f64::max);
    let equal = EQUAL * reach;
    let level = lowest.max(0.0) + LEVEL * reach;
    let deepest = best(0, n, equal, |i| -points[i].gap);
    take(points, 0, deepest);
    let (t1, t2) = tangents(&points[0].normal_W);
    let tilts = TILTS.min(count - 1);
    for k in 0..tilts {
        // The point that touches first if the body tilts a little in way `k`.
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / TILTS as f64).sin_cos();
        let way = (t1 * cos + t2 * sin) * TILT;
        let early = |i: usize| way.dot(&points[i].position_W) - points[i].gap;
        let i = best(k + 1, n, TILT * equal, early);
        take(points, k + 1, i);
    }
    for chosen in tilts + 1..count {
        let apart = |i: usize| {
            let p = &points[i];
            let to = |c: &ManifoldPoint| (c.position_W - p.position_W).norm();
            let apart = points[..chosen].iter().map(to).fold(f64::INFINITY, f64::min);
            // Whatever is level comes before whatever is not.
            if p.gap <= level { apart } else { apart - 4.0 * reach }
        };
        let i = best(chosen, n, equal, apart);
        take(points, chosen, i);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reduction_keeps_the_deepest_and_the_outline() {
        let mut manifold = Manifold::new();
        for i in 0..8u32 {
            for j in 0..8u32 {
                let gap = if (i, j) == (3, 4) { -1.0 } else { 0.0 };
                manifold.offer(ManifoldPoint {
                    feature: 8 * i + j,
                    position_W: Vec3::new(f64::from(i), 0.0, f64::from(j)),
                    normal_W: Vec3::y(),
                    gap,
                });
            }
        }
        manifold.reduce();
        let has = |f: u32| manifold.points().iter().any(|p| p.feature == f);
        assert_eq!(manifold.points().len(), DELIVERED_MAX);
        assert!(has(28), "the deepest");
        assert!(has(0) && has(7) && has(56) && has(63), "the four corners");
    }

    /// A cup comes to rest on 16 points of its rim, and trembles by nanometres: it keeps the twelve
    /// that it stands on.
    #[test]
    fn a_rim_keeps_its_points_as_it_settles() {
        let mut random = crate::random::Random::new(5);
        let radius = 0.04;
        let mut chosen = |tremble: f64| {
            let mut manifold = Manifold::new();
            let tilt = random.vector(tremble / radius);
            for i in 0..16 {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 16.0).sin_cos();
                let at = Vec3::new(cos, 0.0, sin) * radius;
                let shaken = at + random.vector(tremble);
                let gap = 1e-6 + tilt.dot(&at) + random.vector(tremble).x;
                let point = ManifoldPoint {
                    feature: i as u32,
                    position_W: shaken,
                    normal_W: Vec3::y(),
                    gap,
                };
                manifold.offer(point);
            }
            manifold.reduce();
            manifold.points().iter().map(|p| p.feature).collect::<Vec<_>>()
        };
        let kept = chosen(0.0);
        assert_eq!(kept.len(), DELIVERED_MAX);
        for tremble in [1e-9, 1e-8, 1e-7] {
            (0..100).for_each(|_| assert_eq!(chosen(tremble), kept, "{tremble:e}"));
        }
    }

    /// Pieces of a body have their own points, however many each offers.
    #[test]
    fn points_of_other_pairs_stay_before_those_of_the_pair_in_hand() {
        let mut manifold = Manifold::new();
        for pair in 0..20u32 {
            let first = manifold.begin();
            for i in 0..100u32 {
                let position_W =
                    Vec3::new(f64::from(i % 7), 0.0, f64::from(i) + 200.0 * f64::from(pair));
                let feature = 1000 * pair + i;
                manifold.offer(ManifoldPoint {
                    feature,
                    position_W,
                    normal_W: Vec3::y(),
                    gap: 0.0,
                });
            }
            let own = &manifold.points()[first..];
            assert!(own.len() >= 16 && own.iter().all(|p| p.feature / 1000 == pair));
            assert!(manifold.points()[..first].iter().all(|p| p.feature / 1000 < pair));
        }
    }
}
