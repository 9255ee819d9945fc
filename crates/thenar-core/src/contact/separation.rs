//! Distance or overlap depth of two convex shapes, and its direction.
//!
//! The nearest points of the two cores are found by Gilbert, Johnson and Keerthi's method (1988).
//! Cores that are apart have a direction that does not depend on round-off, even where the shapes
//! themselves touch or overlap; along that direction the shapes' own extents tell the distance.

use crate::contact::Shape;
use crate::contact::support::{Solid, inradius, rounding};
use crate::contact::triangle::closest_on_triangle;
use crate::math::Vec3;

/// Most passes of one search, each with one new corner. Where they end early, what is found are
/// points of the two shapes, whose distance is greater than the least. Tests of rigid pairs hold
/// with 30, too.
const ITERATIONS_MAX: usize = 100;
/// The squared distance found is at most this part above the true one: some fifty roundings. The
/// direction is then good to the root of it, 1e-7.
const TOLERANCE: f64 = 1e-14;
/// Sharp shapes nearer than this part of their inradius are asked by their cores: the direction
/// between two points loses digits as these come nearer, and with a thousandth of the size between
/// them has lost three of sixteen. Tests of rigid pairs hold with 1e-5, too; with 0.05 gaps are
/// wrong.
pub(crate) const TOUCHING: f64 = 1e-3;
/// Distances that cores are moved inward, as parts of the inradius: little, so that the direction
/// is that of the shapes; more, when shapes overlap by as much. Each holds for overlaps up to twice
/// as deep (of shapes of one size), and even the last leaves a core; what lies deeper is let out
/// the shortest way for its middle.
const INWARD: [f64; 4] = [0.02, 0.1, 0.4, 0.9];
/// A face's direction counts only if the gap along it is larger by this part of the size: ten times
/// what a direction is good for, so that round-off does not choose.
const FACE_BETTER: f64 = 1e-6;
/// Times that shapes are drawn apart along the way found before, at most. Overlaps of 0.5 mm of
/// shapes of 2 cm then lie on both surfaces to 10 µm, but for a corner on a cone; with two, to 0.1
/// mm.
const DRAWN: usize = 4;
/// Round-off of a gap, as a part of the size: positions that are a million sizes away still keep as
/// many digits.
const ROUND_OFF: f64 = 1e-9;

/// Two shapes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Separation {
    /// Distance along `normal`, negative when they overlap \[m\].
    pub gap: f64,
    /// Unit vector from B to A, world.
    pub normal: Vec3,
    /// On the surfaces, world.
    pub point_a: Vec3,
    pub point_b: Vec3,
}

/// The separation of A from B, both convex and bounded.
pub(crate) fn separation(a: &Solid, b: &Solid) -> Separation {
    let (round_a, round_b) = (rounding(a.shape), rounding(b.shape));
    let (size_a, size_b) = (inradius(a.shape), inradius(b.shape));
    let size = size_a.min(size_b);
    if let Some(near) = nearest(a, b, [round_a, round_b])
        && (near.gap > TOUCHING * size)
    {
        let exact = Separation {
            gap: near.gap - round_a - round_b,
            point_a: near.point_a - round_a * near.normal,
            point_b: near.point_b + round_b * near.normal,
            ..near
        };
        return exact;
    }
    for part in INWARD {
        let inward = |round: f64, size: f64| round.max(part * size);
        let cores = [inward(round_a, size_a), inward(round_b, size_b)];
        if let Some(near) = nearest(a, b, cores)
            && near.gap > TOUCHING * part * size
        {
            let rough = along(a, b, near);
            let rough = past_faces(a, b, rough, size);
            let drawn = |found: &Separation| drawn_apart(a, b, found, size);
            let found = std::iter::successors(Some(rough), drawn).take(1 + DRAWN);
            return found.last().unwrap_or(rough);
        }
    }
    // One lies deep in the other: out the shortest way for the middle of A.
    let out = b.distance(&a.origin);
    let near = Separation { gap: 0.0, normal: out.gradient, point_a: a.origin, point_b: a.origin };
    past_faces(a, b, along(a, b, near), size)
}

/// Returns `found`, or the separation along the normal of a box's face if that is larger: along any
/// direction it is a lower bound. The way out for the middle of a wide plate is no way out for what
/// has sunk in far from there.
fn past_faces(a: &Solid, b: &Solid, found: Separation, size: f64) -> Separation {
    let mut best = found;
    for (of, sign) in [(a, -1.0), (b, 1.0)] {
        if !matches!(of.shape, Shape::Cuboid { .. }) {
            continue;
        }
        for k in 0..6 {
            let side = if k < 3 { sign } else { -sign };
            let normal: Vec3 = side * of.rotation.column(k % 3);
            let (low, high) = (a.support(&-normal, 0.0), b.support(&normal, 0.0));
            let gap = normal.dot(&(low - high));
            if gap > best.gap + FACE_BETTER * size {
                // A face is met by what of the other body is farthest towards it.
                let point = if sign < 0.0 { high + gap * normal } else { low };
                best = Separation { gap, normal, point_a: point, point_b: point - gap * normal };
            }
        }
    }
    best
}

/// Separation of a pair, found where A is moved out along the rough normal until the two are just
/// apart, as nearest points are exact there, and moved back again.
fn drawn_apart(a: &Solid, b: &Solid, rough: &Separation, size: f64) -> Option<Separation> {
    let rounds = [rounding(a.shape), rounding(b.shape)];
    let way = (2.0 * TOUCHING * size - rough.gap) * rough.normal;
    let near = nearest(&Solid { origin: a.origin + way, ..*a }, b, rounds)?;
    let n = near.normal;
    let gap = near.gap - rounds[0] - rounds[1];
    let (point_a, point_b) = (near.point_a - rounds[0] * n, near.point_b + rounds[1] * n);
    let back = gap - way.dot(&n);
    // The shapes are as far apart as they are along the best direction.
    let better = gap > 0.0 && back >= rough.gap - ROUND_OFF * size;
    better.then(|| {
        // The part of the way across the normal is shared by both.
        let across = 0.5 * (way - way.dot(&n) * n);
        let point_a = point_a - way + across;
        Separation { gap: back, normal: n, point_a, point_b: point_b - across }
    })
}

/// The separation along the direction of the cores: from the farthest points of both.
fn along(a: &Solid, b: &Solid, cores: Separation) -> Separation {
    let n = cores.normal;
    let (low_a, high_b) = (n.dot(&a.support(&-n, 0.0)), n.dot(&b.support(&n, 0.0)));
    let point_a = a.nearest(&(cores.point_a + (low_a - n.dot(&cores.point_a)) * n));
    let point_b = b.nearest(&(cores.point_b + (high_b - n.dot(&cores.point_b)) * n));
    Separation { gap: low_a - high_b, normal: n, point_a, point_b }
}

/// A point of the difference A - B, from a point of each.
#[derive(Clone, Copy)]
struct Corner {
    w: Vec3,
    a: Vec3,
    b: Vec3,
}

/// The nearest points of two cores; `None` when these overlap.
fn nearest(a: &Solid, b: &Solid, inward: [f64; 2]) -> Option<Separation> {
    let corner = |d: &Vec3| {
        let (p, q) = (a.support(&-d, inward[0]), b.support(d, inward[1]));
        Corner { w: p - q, a: p, b: q }
    };
    let start = a.origin - b.origin;
    let mut simplex = Simplex::new(corner(&start.try_normalize(1e-12).unwrap_or_else(Vec3::y)));
    let mut v = simplex.corners[0].w;
    let scale = inradius(a.shape).min(inradius(b.shape));
    // A plane between them has been found.
    let mut disjoint = false;
    for _ in 0..ITERATIONS_MAX {
        let square = v.norm_squared();
        if square < (1e-12 * scale).powi(2) {
            return None;
        }
        let next = corner(&v);
        if square - v.dot(&next.w) <= TOLERANCE * square || simplex.holds(&next.w) {
            break;
        }
        disjoint |= v.dot(&next.w) > 0.0;
        let mut larger = simplex;
        larger.push(next);
        if !disjoint && larger.count == 4 && larger.surrounds_origin() {
            return None;
        }
        let nearer = larger.reduce()?;
        if nearer.norm_squared() >= square {
            break;
        }
        (v, simplex) = (nearer, larger);
    }
    let gap = v.norm();
    let (point_a, point_b) = simplex.points();
    Some(Separation { gap, normal: v / gap, point_a, point_b })
}

/// Up to four corners, and the weights of the point of their hull nearest to the origin.
#[derive(Clone, Copy)]
struct Simplex {
    corners: [Corner; 4],
    weights: [f64; 4],
    count: usize,
}

impl Simplex {
    fn new(corner: Corner) -> Self {
        Self { corners: [corner; 4], weights: [1.0, 0.0, 0.0, 0.0], count: 1 }
    }

    fn push(&mut self, corner: Corner) {
        self.corners[self.count] = corner;
        self.count += 1;
    }

    fn holds(&self, w: &Vec3) -> bool {
        self.corners[..self.count].iter().any(|c| c.w == *w)
    }

    fn points(&self) -> (Vec3, Vec3) {
        let weighted = || self.corners[..self.count].iter().zip(self.weights);
        (weighted().map(|(c, w)| c.a * w).sum(), weighted().map(|(c, w)| c.b * w).sum())
    }

    /// Keeps the corners that the nearest point on the hull's faces needs, and returns it.
    fn reduce(&mut self) -> Option<Vec3> {
        let w = |i: usize| self.corners[i].w;
        let faces: &[[usize; 3]] = match self.count {
            2 => &[[0, 1, 1]],
            3 => &[[0, 1, 2]],
            _ => &[[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
        };
        let mut best: Option<([usize; 3], [f64; 3], Vec3, f64)> = None;
        for face in faces {
            let near = closest_on_triangle(&Vec3::zeros(), &face.map(w));
            if best.is_none_or(|b| near.distance_squared < b.3) {
                best = Some((*face, near.weights, near.point, near.distance_squared));
            }
        }
        let (face, weights, _, _) = best?;
        let mut kept = *self;
        kept.count = 0;
        kept.weights = [0.0; 4];
        for (i, weight) in face.into_iter().zip(weights).filter(|(_, weight)| *weight > 0.0) {
            // The second of two corners may stand in a triangle twice.
            if let Some(k) = (0..kept.count).find(|&k| kept.corners[k].w == w(i)) {
                kept.weights[k] += weight;
                continue;
            }
            kept.corners[kept.count] = self.corners[i];
            kept.weights[kept.count] = weight;
            kept.count += 1;
        }
        *self = kept;
        Some(self.corners[..self.count].iter().zip(self.weights).map(|(c, w)| c.w * w).sum())
    }

    fn surrounds_origin(&self) -> bool {
        let w = |i: usize| self.corners[i].w;
        [[0, 1, 2, 3], [0, 3, 1, 2], [0, 2, 3, 1], [1, 3, 2, 0]].iter().all(|&[i, j, k, top]| {
            let normal = (w(j) - w(i)).cross(&(w(k) - w(i)));
            let (origin, above) = (-normal.dot(&w(i)), normal.dot(&(w(top) - w(i))));
            origin * above > 0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Mat3, Quat};
    use crate::random::Random;

    /// Capsules and boxes in a plate of 4 m by 2 mm: the way out is through its face, as deep as
    /// the lowest of their own points tells.
    #[test]
    fn what_sinks_into_a_wide_thin_plate_is_let_out_by_its_face() {
        let mut random = Random::new(12);
        let plate = Shape::Cuboid { half: Vec3::new(2.0, 0.001, 2.0) };
        let shapes = [
            Shape::Capsule { radius: 0.006, half_length: 0.008 },
            Shape::Cuboid { half: Vec3::new(0.012, 0.006, 0.006) },
        ];
        for i in 0..20_000 {
            let shape = &shapes[i % 2];
            // Every other pair lies nearly along the plate.
            let lying = Quat::from_axis_angle(&Vec3::z_axis(), std::f64::consts::FRAC_PI_2);
            let tilt = Quat::from_scaled_axis(random.vector(0.1)) * lying;
            let turn = if i % 4 < 2 { tilt } else { Quat::from_scaled_axis(random.vector(3.0)) };
            let rotation = turn.to_rotation_matrix().into_inner();
            // Up to through the plate, but not so far that down is the shorter way.
            let depth = 6.9e-3 * 10.0_f64.powf(-7.0 * random.unit());
            let at = |origin: Vec3| Solid { shape, rotation, origin };
            let low = at(Vec3::zeros()).support(&-Vec3::y(), 0.0).y;
            let origin = Vec3::new(random.vector(1.0).x, 0.001 - depth - low, random.vector(1.0).x);
            let b = Solid { shape: &plate, rotation: Mat3::identity(), origin: Vec3::zeros() };
            let a = at(origin);
            for (found, up) in [(separation(&a, &b), 1.0), (separation(&b, &a), -1.0)] {
                assert!((found.gap + depth).abs() < 1e-9, "{i}: {} at {depth}", found.gap);
                assert!((up * found.normal - Vec3::y()).norm() < 1e-6, "{:?}", found.normal);
            }
        }
    }
}
