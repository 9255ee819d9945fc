//! The part of a triangle that is nearer to something than [`TOUCHING`], by samples of the
//! distance.

use crate::contact::area::TOUCHING;
use crate::contact::triangle::{ROUNDED_UP, area_vector};
use crate::contact::{Distance, Shape};
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

/// A distance within bounds. Where all beside it lies on the same side of [`TOUCHING`] by these,
/// nobody looks into it: the value is one of them.
#[derive(Clone, Copy)]
struct Sample {
    value: f64,
    low: f64,
    high: f64,
    /// Gradient of the distance, where that was looked into.
    gradient: Option<Vec3>,
}

impl Sample {
    const UNKNOWN: Self =
        Self { value: 0.0, low: f64::NEG_INFINITY, high: f64::INFINITY, gradient: None };
    /// Farther than [`TOUCHING`], and not looked into as long as the parts beside it are.
    const BEYOND: Self = Self { value: f64::INFINITY, low: TOUCHING, ..Self::UNKNOWN };

    fn exact(Distance { value, gradient }: Distance) -> Self {
        Self { value, low: value, high: value, gradient: Some(gradient) }
    }

    /// The knowledge of a place so far away, as a distance changes by no more than the way.
    fn after(&self, way: f64) -> Self {
        Self { low: self.low - way, high: self.high + way, ..*self }
    }

    /// Bounds that both know.
    fn and(&self, other: &Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.min(other.high), ..*self }
    }

    /// The sample, looked into where need be: `distance` gets what it is at most on either side.
    fn settled(
        self,
        widest: f64,
        is_beyond: impl Fn() -> bool,
        distance: impl Fn(f64) -> Distance,
    ) -> Self {
        let Self { low, high, .. } = self;
        if low > TOUCHING + widest {
            return Self { value: low, gradient: None, ..self };
        }
        if high < TOUCHING - widest {
            return Self { value: high, gradient: None, ..self };
        }
        if is_beyond() {
            return Self::BEYOND;
        }
        Self::exact(distance(high.max(-low)))
    }

    /// True when a bound says that all within a part's width lies on one side of [`TOUCHING`].
    fn is_clear(&self) -> bool {
        self.gradient.is_none() && self.value < f64::INFINITY
    }
}

/// Area of the part of triangle `x` where `distance` is below [`TOUCHING`] \[m²\], with edges
/// divided into `parts`. `distance` is asked with a bound that it does not exceed on either side.
/// Of places, by their weights of corners 1 and 2, `beyond` says whether the triangle between them
/// is farther all over; it may not know.
pub(super) fn area_below(
    x: &[Vec3; 3],
    parts: usize,
    distance: impl Fn(&Vec3, f64) -> Distance,
    beyond: impl Fn([[f64; 2]; 3]) -> bool,
) -> f64 {
    let n = parts.min(PARTS_MAX);
    // Between samples.
    let ways = [0, 1, 2].map(|k| (x[(k + 1) % 3] - x[k]).norm() / n as f64 * ROUNDED_UP);
    let widest = ways.iter().copied().fold(0.0, f64::max);
    let weights = |i: usize, j: usize| [i as f64 / n as f64, j as f64 / n as f64];
    let place = |i: usize, j: usize| {
        let [u, v] = weights(i, j);
        x[0] + (x[1] - x[0]) * u + (x[2] - x[0]) * v
    };
    let at = |i: usize, j: usize, known: Sample| {
        let is_beyond = || beyond([weights(i, j); 3]);
        known.settled(widest, is_beyond, |most| distance(&place(i, j), most))
    };
    let part = |corners: [(&mut Sample, usize, usize); 3]| {
        if let Some((clear, ..)) = corners.iter().find(|(sample, ..)| sample.is_clear()) {
            return if clear.value > TOUCHING { 0.0 } else { 1.0 };
        }
        let is_unknown = |(sample, ..): &(&mut Sample, usize, usize)| sample.gradient.is_none();
        if corners.iter().any(is_unknown) {
            let [a, b, c] = &corners;
            if beyond([a, b, c].map(|(_, i, j)| weights(*i, *j))) {
                return 0.0;
            }
        }
        let planes = corners.map(|(sample, i, j)| {
            let x = place(i, j);
            if sample.gradient.is_none() {
                *sample = Sample::exact(distance(&x, f64::INFINITY));
            }
            (x, sample.value, sample.gradient.unwrap_or_default())
        });
        let rises = planes.map(|(x, gap, slope)| planes.map(|(y, ..)| gap + slope.dot(&(y - x))));
        part_below_planes(rises)
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

/// The part of a triangle's area where a distance is below [`TOUCHING`], given its tangent planes
/// at the corners by their values at all corners. A distance that bends up lies between these
/// planes and the plane through its values; in a hollow, where it bends down, it lies between that
/// plane and the lowest of them.
fn part_below_planes(rises: [[f64; 3]; 3]) -> f64 {
    let gaps = [0, 1, 2].map(|i| rises[i][i]);
    let pairs = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
    let (mut hollow, mut bent) = (0.0_f64, 0.0_f64);
    for (i, j) in pairs {
        let over = gaps[j] - rises[i][j];
        (hollow, bent) = (hollow.max(-over), bent.max(over));
    }
    let flat = part_below(gaps);
    if hollow.max(bent) <= FLAT {
        return flat;
    }
    let up = || between(flat, part_below_all(rises), bent);
    let down = || {
        // One is below where not all are above. A plane means nothing beyond an edge, where the
        // distance bends up from it.
        let above = rises.map(|rise| rise.map(|g| 2.0 * TOUCHING - g));
        let any = between(flat, 1.0 - part_below_all(above), hollow);
        flat + (1.0 - bent / hollow).max(0.0) * (any - flat)
    };
    let part = |bends: f64, of: &dyn Fn() -> f64| if bends > 0.0 { bends * of() } else { 0.0 };
    (part(bent, &up) + part(hollow, &down)) / (bent + hollow)
}

/// From what the plane through the values cuts out and what the tangent planes do, which leave it
/// by `bends` \[m\] at most. Along a line of length h on which a distance bends by κ the tangent
/// planes err by `κ h²/24` in the mean, and the plane by `κ h²/12` to the other side: two thirds of
/// the ones and a third of the other leave no error of second order. What is smooth bends by a
/// quarter of [`TOUCHING`] as [`parts_for`] divides it, and a tangent leaves it by four times that:
/// beyond, and wholly from twice as much on, it is an edge or a tip, and made of the tangent
/// planes.
fn between(flat: f64, tangents: f64, bends: f64) -> f64 {
    let smooth = (flat + 2.0 * tangents) / 3.0;
    let edge = (bends / TOUCHING - 1.0).clamp(0.0, 1.0);
    smooth + edge * (tangents - smooth)
}

/// Tangent planes that differ by no more \[m\] are one: rounding of places in a metre is a tenth of
/// it.
const FLAT: f64 = 1e-15;

/// The part of a triangle's area where three linear functions with these corner values are all
/// below [`TOUCHING`].
fn part_below_all(functions: [[f64; 3]; 3]) -> f64 {
    // By weights of the corners. A cut of what is convex adds one corner; where rounding has bent
    // that, no more than there were.
    let [mut one, mut other] = [[[0.0_f64; 3]; 3 << 3]; 2];
    let (mut whole, mut cut) = (&mut one, &mut other);
    (whole[0], whole[1], whole[2]) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let (mut count, mut heights) = (3, [0.0; 3 << 3]);
    for f in functions {
        for (height, w) in heights.iter_mut().zip(&whole[..count]) {
            *height = w.iter().zip(&f).map(|(w, f)| w * (f - TOUCHING)).sum();
        }
        if heights[..count].iter().all(|height| *height <= 0.0) {
            continue;
        }
        let mut corners = 0;
        for (k, from) in whole[..count].iter().enumerate() {
            let next = (k + 1) % count;
            let (a, b, to) = (heights[k], heights[next], &whole[next]);
            if a <= 0.0 {
                cut[corners] = *from;
                corners += 1;
            }
            if (a <= 0.0) != (b <= 0.0) {
                cut[corners] = [0, 1, 2].map(|i| from[i] + (to[i] - from[i]) * (a / (a - b)));
                corners += 1;
            }
        }
        count = corners;
        std::mem::swap(&mut whole, &mut cut);
    }
    let polygon = &whole[..count];
    let cross = |p: &[f64; 3], q: &[f64; 3]| p[1] * q[2] - p[2] * q[1];
    (0..count).map(|k| cross(&polygon[k], &polygon[(k + 1) % count])).sum()
}

/// The part of a triangle's area where a linear function with these corner values is below
/// [`TOUCHING`].
fn part_below(gaps: [f64; 3]) -> f64 {
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
    use crate::random::Random;
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

    /// The parts below, by all samples.
    fn parts_below(x: &[Vec3; 3], n: usize, distance: impl Fn(&Vec3) -> Distance) -> f64 {
        let place = |[i, j]: [usize; 2]| {
            let (u, v) = (i as f64 / n as f64, j as f64 / n as f64);
            x[0] + (x[1] - x[0]) * u + (x[2] - x[0]) * v
        };
        let part = |corners: [[usize; 2]; 3]| {
            let at = corners.map(|c| (place(c), distance(&place(c))));
            let rise = |(p, d): (Vec3, Distance), q: Vec3| d.value + d.gradient.dot(&(q - p));
            part_below_planes(at.map(|a| at.map(|(q, _)| rise(a, q))))
        };
        let mut parts = 0.0;
        for (i, j) in (0..n).flat_map(|j| (0..n - j).map(move |i| (i, j))) {
            parts += part([[i, j], [i + 1, j], [i, j + 1]]);
            if i + j + 1 < n {
                parts += part([[i + 1, j], [i + 1, j + 1], [i, j + 1]]);
            }
        }
        parts
    }

    fn to_ball(p: &Vec3, middle: &Vec3, radius: f64) -> Distance {
        Distance { value: (p - middle).norm() - radius, gradient: (p - middle).normalize() }
    }

    /// The bounds find as many parts below as all samples do, and spare a third of the samples.
    #[test]
    fn bounds_tell_what_samples_would() {
        let (mut random, mut all_asked) = (Random::new(6), 0);
        for i in 0..300 {
            let x = [0; 3].map(|_| random.vector(0.01));
            let radius = 0.002 + 0.05 * random.unit();
            let middle = (x[0] + x[1] + x[2]) / 3.0 + random.vector(1.0).normalize() * radius;
            let distance = |p: &Vec3| to_ball(p, &middle, radius);
            let n = PARTS_MAX;
            let asked = Cell::new(0);
            let found = area_below(
                &x,
                n,
                |p, most| {
                    asked.set(asked.get() + 1);
                    assert!(distance(p).value.abs() <= most);
                    distance(p)
                },
                |_| false,
            );
            let all = area_vector(&x).norm() * parts_below(&x, n, distance) / (n * n) as f64;
            assert!((found - all).abs() <= 1e-12 * area_vector(&x).norm(), "{i}: {found} {all}");
            all_asked += asked.get();
        }
        assert!(all_asked < 300 * (PARTS_MAX + 1) * (PARTS_MAX + 2) / 3, "{all_asked}");
    }

    /// Area of the part of a triangle below a height, given those of its corners: quadratic in it
    /// on either side of the middle corner.
    fn under(area: f64, mut corners: [f64; 3], height: f64) -> f64 {
        corners.sort_by(f64::total_cmp);
        let [a, b, c] = corners;
        let part = |from: f64, to: f64| (from - to).powi(2) / ((a - c).abs() * (b - to).abs());
        match height {
            h if h <= a => 0.0,
            h if h <= b => area * part(h, a),
            h if h <= c => area * (1.0 - part(h, c)),
            _ => area,
        }
    }

    /// An edge that a triangle lies on, wherever and however turned, touches a strip, into however
    /// few parts the triangle is divided: on skin that lies on it flat, as wide as the bound
    /// reaches beside it; on skin that leans on both sides, as they open.
    #[test]
    fn edges_touch_strips() {
        let mut random = Random::new(11);
        let x =
            [Vec3::new(-2e-3, 0.0, -1e-3), Vec3::new(0.0, 0.0, 2e-3), Vec3::new(2e-3, 0.0, -1e-3)];
        let area = area_vector(&x).norm();
        for i in 0..300 {
            let angles = [0; 2].map(|_| 0.05 + 1.4 * random.unit());
            let (gap, at) = (0.5 * TOUCHING * random.unit(), 1e-3 * (random.unit() - 0.5));
            let turn = 3.0 * random.unit();
            let across = Vec3::new(turn.cos(), 0.0, turn.sin());
            let along = |p: &Vec3| across.dot(p) - at;
            let flat = |p: &Vec3| {
                let value = along(p).hypot(gap);
                Distance { value, gradient: (across * along(p) + Vec3::y() * gap) / value }
            };
            let draped = |p: &Vec3| {
                let side = if along(p) < 0.0 { -angles[0] } else { angles[1] };
                let gradient = across * side.sin() + Vec3::y() * side.cos();
                Distance { value: gap + along(p) * side.sin(), gradient }
            };
            let strip = |[left, right]: [f64; 2]| {
                under(area, x.map(|p| along(&p)), right) - under(area, x.map(|p| along(&p)), -left)
            };
            let beside = (TOUCHING * TOUCHING - gap * gap).sqrt();
            let open = angles.map(|angle| (TOUCHING - gap) / angle.sin());
            for parts in [1, 2, 5, 16] {
                let on_flat = area_below(&x, parts, |p, _| flat(p), |_| false) / strip([beside; 2]);
                assert!((on_flat - 1.0).abs() < 0.2, "{i}: {on_flat} by {parts}");
                let on_draped = area_below(&x, parts, |p, _| draped(p), |_| false) / strip(open);
                assert!((on_draped - 1.0).abs() < 0.1, "{i}: {on_draped} by {parts}");
            }
        }
    }

    /// Tangent planes of a distance that does not bend are one but for rounding, whichever way it
    /// leans.
    #[test]
    fn planes_that_are_one_cut_like_it() {
        let mut random = Random::new(5);
        for i in 0..300_000 {
            let x = [0; 3].map(|_| random.vector(2e-3) + Vec3::new(0.3, -0.2, 0.5));
            let gradient = random.vector(1.0).normalize();
            let middle = (x[0] + x[1] + x[2]) / 3.0 + random.vector(1e-3);
            let at = x.map(|p| {
                let seen = gradient + random.vector(1e-12);
                (p, TOUCHING + gradient.dot(&(p - middle)), seen)
            });
            let rises = at.map(|(p, d, g)| at.map(|(q, ..)| d + g.dot(&(q - p))));
            let expected = part_below(at.map(|(_, d, _)| d));
            for found in [part_below_planes(rises), part_below_all(rises)] {
                assert!((found - expected).abs() < 1e-6, "{i}: {found} of {expected}");
            }
        }
    }

    /// The nearer of two flat pieces that meet in a hollow counts.
    #[test]
    fn hollows_touch_where_either_side_does() {
        let mut random = Random::new(12);
        let (mut tested, mut beyond) = (0, 0);
        let x = [Vec3::zeros(), Vec3::new(4e-4, 0.0, 0.0), Vec3::new(1e-4, 3e-4, 0.0)];
        for i in 0..2000 {
            let steep = (0.1 + 0.4 * random.unit()) * Vec3::x();
            let turned = steep + random.vector(0.2);
            let at = [0; 2].map(|_| x[0] + (x[1] - x[0]) * random.unit() + (x[2] - x[0]) * 0.3);
            let sides = [(steep, at[0]), (-turned, at[1])];
            let distance = |p: &Vec3| {
                let of = sides.map(|(g, q)| (TOUCHING + g.dot(&(p - q)), g));
                let (value, gradient) = if of[0].0 < of[1].0 { of[0] } else { of[1] };
                Distance { value, gradient }
            };
            let found = part_below_planes(x.map(|p| {
                let d = distance(&p);
                x.map(|q| d.value + d.gradient.dot(&(q - p)))
            }));
            let n = 200;
            let places = (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j)));
            let is_below = |(i, j): &(i32, i32)| {
                let [u, v] = [i, j].map(|k| (f64::from(*k) + 1.0 / 3.0) / f64::from(n));
                distance(&(x[0] + (x[1] - x[0]) * u + (x[2] - x[0]) * v)).value <= TOUCHING
            };
            let expected = places.filter(is_below).count() as f64 / f64::from(n * (n + 1) / 2);
            let hollow = x.iter().map(|p| distance(p).gradient.x > 0.0).collect::<Vec<_>>();
            // The crease lies between the corners, and bends enough to be one.
            if hollow.iter().all(|h| *h == hollow[0]) {
                continue;
            }
            let off = (found - expected).abs();
            assert!(off < 0.2, "{i}: {found} of {expected}");
            tested += 1;
            beyond += u32::from(off > 0.1);
        }
        assert!(tested > 100 && 100 * beyond < tested, "{beyond} of {tested} beyond a tenth");
    }

    /// Across a cylinder that presses into a triangle, however turned and shifted, a strip is
    /// below: divided as coarsely as [`parts_for`] does it is right to a part in a hundred, and as
    /// it moves its area does not jump.
    #[test]
    fn strips_of_round_things_are_right_to_second_order() {
        let (radius, depth) = (8e-3, 10e-6);
        let x =
            [Vec3::new(-2e-3, 0.0, -1e-3), Vec3::new(0.0, 0.0, 2e-3), Vec3::new(2e-3, 0.0, -1e-3)];
        let area = area_vector(&x).norm();
        let least = parts_for(&Shape::Cylinder { radius, half_length: 0.1 }, &x);
        let half = ((radius + TOUCHING).powi(2) - (radius - depth).powi(2)).sqrt();
        // Three quarters as many parts bend so much that some count as edges.
        for (parts, within) in [(least, 0.01), (3 * least / 4, 0.1)] {
            for turn in [0.0_f64, 0.3, 0.6, 0.9, 1.2, 1.5] {
                let across = Vec3::new(turn.cos(), 0.0, turn.sin());
                let mut before = None;
                for i in 0..500 {
                    let at = 4e-7 * f64::from(i) - 1e-4;
                    let distance = |p: &Vec3| {
                        let (along, up) = (across.dot(p) - at, radius - depth);
                        let value = along.hypot(up);
                        let gradient = (across * along - Vec3::y() * up) / value;
                        Distance { value: value - radius, gradient }
                    };
                    let along = x.map(|p| across.dot(&p) - at);
                    let expected = under(area, along, half) - under(area, along, -half);
                    let found = area_below(&x, parts, |p, _| distance(p), |_| false);
                    let off = (found / expected - 1.0).abs();
                    assert!(off < within, "{i}, {turn}, {parts}: {found} of {expected}");
                    // The strip is 4 mm long at most, and moves by 0.4 µm.
                    let change = (found - before.unwrap_or(found)).abs();
                    assert!(change < 8.0 * 4e-3 * 4e-7, "{i}, {turn}: a jump by {change} m²");
                    before = Some(found);
                }
            }
        }
    }

    /// A flat triangle under a ball that just touches it is nearer than the bound within a disc of
    /// radius `√(2 R t + t²)`.
    #[test]
    fn a_ball_on_a_plane_touches_a_disc() {
        let (radius, t): (f64, f64) = (0.06, TOUCHING);
        let x =
            [Vec3::new(-6e-3, 0.0, -4e-3), Vec3::new(0.0, 0.0, 6e-3), Vec3::new(6e-3, 0.0, -4e-3)];
        let middle = Vec3::y() * radius;
        let disc = std::f64::consts::PI * (2.0 * radius * t + t * t);
        let area = area_below(&x, PARTS_MAX, |p, _| to_ball(p, &middle, radius), |_| false);
        assert!((area / disc - 1.0).abs() < 0.02, "{area} of {disc} m²");
    }
}
