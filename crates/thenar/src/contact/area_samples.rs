//! The part of a triangle that is nearer to something than [`TOUCHING`], by samples of the distance.

use crate::contact::Shape;
use crate::contact::area::TOUCHING;
use crate::contact::triangle::{ROUNDED_UP, area_vector};
use crate::math::Vec3;

/// Most parts into which the edges of a triangle are divided.
pub(super) const PARTS_MAX: usize = 16;

/// Into how many parts to divide the edges of a triangle: over one part a surface of the shape's
/// curvature bends by a quarter of what counts as touching.
pub(super) fn parts_for(shape: &Shape, x: &[Vec3; 3]) -> usize {
    let edge = (0..3).map(|k| (x[(k + 1) % 3] - x[k]).norm_squared()).fold(0.0, f64::max).sqrt();
    let part = (8.0 * shape.least_radius() * TOUCHING / 4.0).sqrt();
    ((edge / part).ceil() as usize).clamp(1, PARTS_MAX)
}

/// A distance within bounds. Where they tell that no sample beside it lies on the other side of [`TOUCHING`], they
/// are not looked into, and the value is one of them.
#[derive(Clone, Copy)]
struct Sample {
    value: f64,
    low: f64,
    high: f64,
}

impl Sample {
    const UNKNOWN: Self = Self { value: 0.0, low: f64::NEG_INFINITY, high: f64::INFINITY };
    /// Farther than [`TOUCHING`], and not looked into as long as none beside it is nearer.
    const BEYOND: Self = Self { value: f64::INFINITY, low: TOUCHING, high: f64::INFINITY };

    fn exact(value: f64) -> Self {
        Self { value, low: value, high: value }
    }

    /// The knowledge of a place so far away, as a distance changes by no more than the way.
    fn after(&self, way: f64) -> Self {
        Self { low: self.low - way, high: self.high + way, ..*self }
    }

    /// Known by both.
    fn and(&self, other: &Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.min(other.high), ..*self }
    }

    /// Looked into where need be: `distance` is given what it is at most on either side.
    fn settled(
        self,
        widest: f64,
        is_beyond: impl Fn() -> bool,
        distance: impl Fn(f64) -> f64,
    ) -> Self {
        let Self { low, high, .. } = self;
        if low > TOUCHING + widest {
            return Self { value: low, ..self };
        }
        if high < TOUCHING - widest {
            return Self { value: high, ..self };
        }
        if is_beyond() {
            return Self::BEYOND;
        }
        Self::exact(distance(high.max(-low)))
    }
}

/// Area of the part of triangle `x` where `distance` is below [`TOUCHING`] \[m²\], with edges divided
/// into so many parts. `distance` is asked with a bound that it does not exceed on either side; of places, by their
/// weights of corners 1 and 2, of which `beyond` says that they are farther it is asked only beside what is below.
pub(super) fn area_below(
    x: &[Vec3; 3],
    parts: usize,
    distance: impl Fn(&Vec3, f64) -> f64,
    beyond: impl Fn(f64, f64) -> bool,
) -> f64 {
    let n = parts.min(PARTS_MAX);
    // Between samples.
    let ways = [0, 1, 2].map(|k| (x[(k + 1) % 3] - x[k]).norm() / n as f64 * ROUNDED_UP);
    let widest = ways.iter().copied().fold(0.0, f64::max);
    let weights = |i: usize, j: usize| (i as f64 / n as f64, j as f64 / n as f64);
    let there = |i: usize, j: usize, most: f64| {
        let (u, v) = weights(i, j);
        distance(&(x[0] + (x[1] - x[0]) * u + (x[2] - x[0]) * v), most)
    };
    let at = |i: usize, j: usize, known: Sample| {
        let (u, v) = weights(i, j);
        known.settled(widest, || beyond(u, v), |most| there(i, j, most))
    };
    // A corner that lies beyond is looked into only beside one that does not.
    let part = |corners: [(&mut Sample, usize, usize); 3]| {
        let [(a, ..), (b, ..), (c, ..)] = &corners;
        let least = a.value.min(b.value).min(c.value);
        if least > TOUCHING {
            return 0.0;
        }
        let mut gaps = [0.0; 3];
        for (gap, (sample, i, j)) in gaps.iter_mut().zip(corners) {
            if sample.value == f64::INFINITY {
                *sample = Sample::exact(there(i, j, f64::INFINITY));
            }
            *gap = sample.value;
        }
        part_below(gaps)
    };
    // Two rows of samples at a time.
    let mut below = [Sample::UNKNOWN; PARTS_MAX + 1];
    let mut above = [Sample::UNKNOWN; PARTS_MAX + 1];
    below[0] = at(0, 0, Sample::UNKNOWN);
    (1..=n).for_each(|i| below[i] = at(i, 0, below[i - 1].after(ways[0])));
    let mut parts_below = 0.0;
    for j in 0..n {
        for i in 0..n - j {
            let known = below[i].after(ways[2]).and(&below[i + 1].after(ways[1]));
            let beside = if i > 0 { above[i - 1].after(ways[0]) } else { Sample::UNKNOWN };
            above[i] = at(i, j + 1, known.and(&beside));
        }
        for i in 0..n - j {
            let (start, end) = below.split_at_mut(i + 1);
            let (left, right) = (&mut start[i], &mut end[0]);
            let (start, end) = above.split_at_mut(i + 1);
            let (upper, beside) = (&mut start[i], &mut end[0]);
            parts_below += part([(left, i, j), (&mut *right, i + 1, j), (&mut *upper, i, j + 1)]);
            if i + 1 < n - j {
                parts_below += part([(right, i + 1, j), (beside, i + 1, j + 1), (upper, i, j + 1)]);
            }
        }
        std::mem::swap(&mut below, &mut above);
    }
    area_vector(x).norm() * parts_below / (n * n) as f64
}

/// The part of a triangle's area where a linear function with these corner values is below
/// [`TOUCHING`].
pub(super) fn part_below(gaps: [f64; 3]) -> f64 {
    let g = gaps.map(|g| g - TOUCHING);
    let count = g.iter().filter(|g| **g <= 0.0).count();
    // The corner that lies alone on its side of the cut.
    let cut = |inside: bool| {
        let k = (0..3).find(|&k| (g[k] <= 0.0) == inside).unwrap_or(0);
        let (a, b, c) = (g[k], g[(k + 1) % 3], g[(k + 2) % 3]);
        (a / (a - b)) * (a / (a - c))
    };
    match count {
        0 => 0.0,
        1 => cut(true),
        2 => 1.0 - cut(false),
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::triangle::tests::Random;
    use std::cell::Cell;

    #[test]
    fn linear_cuts_are_exact() {
        let t = TOUCHING;
        assert_eq!(part_below([0.0, 0.0, 0.0]), 1.0);
        assert_eq!(part_below([2.0 * t; 3]), 0.0);
        // Below at one corner, as far above at the others: a quarter; and the other way round.
        assert!((part_below([0.0, 2.0 * t, 2.0 * t]) - 0.25).abs() < 1e-12);
        assert!((part_below([2.0 * t, 0.0, 0.0]) - 0.75).abs() < 1e-12);
    }

    /// As many parts are found below as by all samples, of which a third need not be looked into.
    #[test]
    fn bounds_tell_what_samples_would() {
        let (mut random, mut all_asked) = (Random::new(6), 0);
        for i in 0..300 {
            let x = [0; 3].map(|_| random.vector(0.01));
            let radius = 0.002 + 0.05 * random.unit();
            let middle = (x[0] + x[1] + x[2]) / 3.0 + random.vector(1.0).normalize() * radius;
            let distance = |p: &Vec3| (p - middle).norm() - radius;
            let n = PARTS_MAX;
            let at = |i: usize, j: usize| {
                let (u, v) = (i as f64 / n as f64, j as f64 / n as f64);
                distance(&(x[0] + (x[1] - x[0]) * u + (x[2] - x[0]) * v))
            };
            let mut parts = 0.0;
            for (i, j) in (0..n).flat_map(|j| (0..n - j).map(move |i| (i, j))) {
                parts += part_below([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < n {
                    parts += part_below([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
            let asked = Cell::new(0);
            let found = area_below(
                &x,
                n,
                |p, most| {
                    asked.set(asked.get() + 1);
                    assert!(distance(p).abs() <= most);
                    distance(p)
                },
                |_, _| false,
            );
            let all = area_vector(&x).norm() * parts / (n * n) as f64;
            assert!((found - all).abs() <= 1e-12 * area_vector(&x).norm(), "{i}: {found} {all}");
            all_asked += asked.get();
        }
        assert!(all_asked < 300 * (PARTS_MAX + 1) * (PARTS_MAX + 2) / 3, "{all_asked}");
    }

    /// A flat triangle under a ball that just touches it is nearer than the bound within a disc of
    /// radius `√(2 R t + t²)`.
    #[test]
    fn a_ball_on_a_plane_touches_a_disc() {
        let (radius, t): (f64, f64) = (0.06, TOUCHING);
        let x =
            [Vec3::new(-6e-3, 0.0, -4e-3), Vec3::new(0.0, 0.0, 6e-3), Vec3::new(6e-3, 0.0, -4e-3)];
        let distance = |p: &Vec3, _| (p - Vec3::y() * radius).norm() - radius;
        let disc = std::f64::consts::PI * (2.0 * radius * t + t * t);
        let area = area_below(&x, PARTS_MAX, distance, |_, _| false);
        assert!((area / disc - 1.0).abs() < 0.1, "{area} of {disc} m²");
    }
}
