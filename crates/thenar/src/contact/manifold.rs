//! The contact points of one pair of rigid bodies.

use crate::math::{Vec3, tangents};

/// Points held at once. When there are more, those that would be delivered last are let go.
const OFFERED_MAX: usize = 64;
/// How many remain then.
const KEPT: usize = 32;
/// Points delivered are at most this many: the deepest, and those farthest apart.
pub(crate) const DELIVERED_MAX: usize = 12;
/// Of points higher than the deepest by more than this part of how far apart they lie, the lower go
/// first: a body can only stand on the lower ones.
const LEVEL: f64 = 1e-2;

/// Ways in which a body may tilt: with so many each corner of a rectangle comes first in one.
const TILTS: usize = 6;
/// How far it tilts \[rad\]: a small angle, which weighs a gap of 1 mm like 2 cm to the side.
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

/// A bounded set of points.
#[derive(Clone, Debug, Default)]
pub(crate) struct Manifold {
    points: Vec<ManifoldPoint>,
}

impl Manifold {
    pub fn new() -> Self {
        Self { points: Vec::with_capacity(OFFERED_MAX) }
    }

    pub fn clear(&mut self) {
        self.points.clear();
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
            self.leave(KEPT);
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
        self.leave(DELIVERED_MAX);
    }

    /// Puts next to those chosen the point that touches first if the body tilts a little in way `k`.
    fn choose_for_tilt(&mut self, k: usize, (t1, t2): &(Vec3, Vec3)) {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / TILTS as f64).sin_cos();
        let way = (t1 * cos + t2 * sin) * TILT;
        let early = |p: &ManifoldPoint| way.dot(&p.position_W) - p.gap;
        let mut best = k + 1;
        for i in k + 2..self.points.len() {
            if early(&self.points[i]) > early(&self.points[best]) {
                best = i;
            }
        }
        self.points.swap(k + 1, best);
    }

    fn leave(&mut self, count: usize) {
        let n = self.points.len();
        if n <= count {
            return;
        }
        let deepest = (0..n).min_by(|&i, &j| self.points[i].gap.total_cmp(&self.points[j].gap));
        self.points.swap(0, deepest.unwrap_or(0));
        let first = self.points[0];
        let spread = |p: &ManifoldPoint| (p.position_W - first.position_W).norm_squared();
        let reach = self.points.iter().map(spread).fold(0.0, f64::max).sqrt();
        let level = first.gap.max(0.0) + LEVEL * reach;
        let tilts = TILTS.min(count - 1);
        for k in 0..tilts {
            self.choose_for_tilt(k, &tangents(&first.normal_W));
        }
        for chosen in tilts + 1..count {
            let worth = |i: usize| {
                let p = &self.points[i];
                let to = |c: &ManifoldPoint| (c.position_W - p.position_W).norm_squared();
                let apart = self.points[..chosen].iter().map(to).fold(f64::INFINITY, f64::min);
                (p.gap <= level, apart)
            };
            let mut best = (chosen, worth(chosen));
            for i in chosen + 1..n {
                let other = worth(i);
                if other > best.1 {
                    best = (i, other);
                }
            }
            self.points.swap(chosen, best.0);
        }
        self.points.truncate(count);
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
}
