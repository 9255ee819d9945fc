//! The contact points of one pair of rigid bodies.

use crate::math::{Vec3, tangents};
use crate::room::Room;

/// Points held at once. When there are more, those that would be delivered last are let go.
const OFFERED_MAX: usize = 64;
/// How many remain then.
const KEPT: usize = 32;
/// Points delivered are at most this many: the deepest, and those farthest apart.
pub(crate) const DELIVERED_MAX: usize = 12;
/// Of points higher than the deepest by more than this part of how far apart they lie, the lower go
/// first: a body can only stand on the lower ones. So far a body tilts (0.6°) before it stands on a higher one.
const LEVEL: f64 = 1e-2;

/// Ways in which a body may tilt: with so many each corner of a rectangle comes first in one.
const TILTS: usize = 6;
/// How far it tilts \[rad\]: a small angle, which weighs a gap of 1 mm like 2 cm to the side, the usual margin like the
/// size of what a hand holds. Of points that are level it chooses the same at any angle.
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

/// A bounded set of points. Those of the pair of pieces in hand lie last, and make room among themselves.
#[derive(Clone, Debug, Default)]
pub(crate) struct Manifold {
    points: Room<ManifoldPoint>,
    /// The first of them.
    own: usize,
}

impl Manifold {
    pub fn new() -> Self {
        Self { points: Room::with_capacity(OFFERED_MAX), own: 0 }
    }

    pub fn clear(&mut self) {
        self.points.clear();
        self.own = 0;
    }

    /// Begins another pair of pieces, for which half the room is kept. Returns the index of its first point, which
    /// stays its first whatever is offered.
    pub fn begin(&mut self) -> usize {
        self.leave(0, KEPT);
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
    pub fn retain_from(&mut self, first: usize, keep: impl Fn(&ManifoldPoint) -> bool) {
        let mut kept = first;
        for i in first..self.points.len() {
            if keep(&self.points[i]) {
                self.points.swap(kept, i);
                kept += 1;
            }
        }
        self.points.truncate(kept);
    }

    /// Leaves at most `DELIVERED_MAX` points: first the deepest, then those that would touch first if the
    /// body tilted, then again and again the one farthest from those chosen, at first of those about as deep.
    pub fn reduce(&mut self) {
        self.leave(0, DELIVERED_MAX);
    }

    /// Leaves so many of the points from `first` on.
    fn leave(&mut self, first: usize, count: usize) {
        if self.points.len() - first > count {
            choose(&mut self.points[first..], count);
            self.points.truncate(first + count);
        }
    }
}

/// Puts next to those chosen the point that touches first if the body tilts a little in way `k`.
fn choose_for_tilt(points: &mut [ManifoldPoint], k: usize, (t1, t2): &(Vec3, Vec3)) {
    let (sin, cos) = (std::f64::consts::TAU * k as f64 / TILTS as f64).sin_cos();
    let way = (t1 * cos + t2 * sin) * TILT;
    let early = |p: &ManifoldPoint| way.dot(&p.position_W) - p.gap;
    let mut best = k + 1;
    for i in k + 2..points.len() {
        if early(&points[i]) > early(&points[best]) {
            best = i;
        }
    }
    points.swap(k + 1, best);
}

/// Puts the `count` points to keep, of more, before the others.
fn choose(points: &mut [ManifoldPoint], count: usize) {
    let n = points.len();
    let deepest = (0..n).min_by(|&i, &j| points[i].gap.total_cmp(&points[j].gap));
    points.swap(0, deepest.unwrap_or(0));
    let first = points[0];
    let spread = |p: &ManifoldPoint| (p.position_W - first.position_W).norm_squared();
    let reach = points.iter().map(spread).fold(0.0, f64::max).sqrt();
    let level = first.gap.max(0.0) + LEVEL * reach;
    let tilts = TILTS.min(count - 1);
    for k in 0..tilts {
        choose_for_tilt(points, k, &tangents(&first.normal_W));
    }
    for chosen in tilts + 1..count {
        let worth = |i: usize| {
            let p = &points[i];
            let to = |c: &ManifoldPoint| (c.position_W - p.position_W).norm_squared();
            let apart = points[..chosen].iter().map(to).fold(f64::INFINITY, f64::min);
            (p.gap <= level, apart)
        };
        let mut best = (chosen, worth(chosen));
        for i in chosen + 1..n {
            let other = worth(i);
            if other > best.1 {
                best = (i, other);
            }
        }
        points.swap(chosen, best.0);
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
