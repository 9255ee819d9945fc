//! The contact points of two convex shapes: the nearest points, and where the faces that look at
//! each other overlap.
//!
//! ```text
//!        incident face (clipped to the sides of the reference face)
//!          .-------------.
//!      ....|.............|....  gap along n at each remaining corner
//!      |   reference face    |
//! ```

use crate::contact::manifold::{Manifold, ManifoldPoint};
use crate::contact::polygon::{Corner, Polygon};
use crate::contact::round_side::{Over, RoundSide};
use crate::contact::separation::{Separation, TOUCHING, separation};
use crate::contact::support::{DISC_CORNERS, Face, Solid, inradius};
use crate::contact::{Shape, cuboid_pair};
use crate::math::Vec3;

/// A flat face is the reference when the normal differs from its own by less than this (cosine of
/// 2.6°): heights over it are then distances to a thousandth. What is tilted more rises by the
/// usual margin within 22 mm. Tests of rigid pairs hold from 0.99 to 0.99999.
const ALIGNED: f64 = 0.999;
/// The face of A is preferred to that of B only if so much better aligned (in cosines): of faces
/// that are level to round-off B's stays.
const HANDICAP: f64 = 1e-4;
/// A line and a round side that cross at more than this angle (sine of 45°) are left to their
/// nearest points.
const ALONG: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Cosine of the angle (45°) from the normal of the pair beyond which the way to the other shape
/// leads to another side of it.
const ALIKE: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Edges that cross at more than this angle touch at their nearest points alone \[rad\]; up to it,
/// how far they lie [beside](BESIDE) each other decides. Tests of rigid pairs hold from 0.005 to
/// 0.5.
const PARALLEL: f64 = 0.05;
/// Ends of a common length lie above each other but for this part of their gap (a line to which the
/// normal stands askew by as much), and this part of the shorter line (lines that cross at twice
/// this angle).
const BESIDE: [f64; 2] = [1e-2, 1e-4];
/// A corner no higher than this part of the size above the nearest point stands for it: directions
/// are good for as much, the root of the tolerance to which distances are searched.
const SAME: f64 = 1e-7;
/// Places nearer to each other than this part of the size are one: ten times as much.
const SAME_PLACE: f64 = 1e-6;
/// A normal this near to that of a flat face (cosine, 1.4e-6 rad) is the face's: ten times as far
/// as directions are good for.
const ON_FACE: f64 = 1.0 - 1e-12;
/// Part of a polygon's side within which a point beside the side lies on it; corners nearer to each
/// other than this part of the polygon are one. Round-off leaves less.
const ON_SIDE: f64 = 1e-9;

/// Features: the nearest points, corners of a clipped face, ends of a common length.
const NEAREST: u32 = 3 << 16;
const CLIPPED: u32 = 4 << 16;
const ENDS: u32 = 5 << 16;

/// Returns the separation of A from B, one of which may be a half-space.
pub(crate) fn apart(a: &Solid, b: &Solid) -> Separation {
    match (a.shape, b.shape) {
        (Shape::HalfSpace, _) => turned(apart(b, a)),
        (_, Shape::HalfSpace) => {
            let normal = b.rotation.column(1).into_owned();
            let point_a = a.support(&-normal, 0.0);
            let gap = normal.dot(&(point_a - b.origin));
            Separation { gap, normal, point_a, point_b: point_a - gap * normal }
        }
        (Shape::Sphere { radius }, _) => {
            let d = b.distance(&a.origin);
            let point_a = a.origin - *radius * d.gradient;
            let gap = d.value - radius;
            Separation { gap, normal: d.gradient, point_a, point_b: point_a - gap * d.gradient }
        }
        (_, Shape::Sphere { .. }) => turned(apart(b, a)),
        _ => separation(a, b),
    }
}

fn turned(s: Separation) -> Separation {
    Separation { gap: s.gap, normal: -s.normal, point_a: s.point_b, point_b: s.point_a }
}

/// Round-off taken out of a separation whose normal is that of a flat face.
fn on_face(a: &Solid, b: &Solid, near: Separation) -> Separation {
    let bounded = |s: &Solid| !matches!(s.shape, Shape::HalfSpace);
    if !bounded(a) || !bounded(b) {
        return near;
    }
    let faces = [a.face(&-near.normal).normal.map(|m| -m), b.face(&near.normal).normal];
    let flat = faces.into_iter().flatten().find(|m| m.dot(&near.normal) > ON_FACE);
    let Some(normal) = flat else { return near };
    let gap = normal.dot(&(a.support(&-normal, 0.0) - b.support(&normal, 0.0)));
    Separation { gap, normal, ..near }
}

/// Adds the contact points of A and B if they are no farther than `near_enough`, normals from B to
/// A; of the faces those whose gap is at most `margin`, which is more for bodies that move fast:
/// stopped at one point, they turn others in.
pub(crate) fn find(a: &Solid, b: &Solid, near_enough: f64, margin: f64, manifold: &mut Manifold) {
    let near = apart(a, b);
    if near.gap > near_enough {
        return;
    }
    let near = on_face(a, b, near);
    let boxes = matches!((a.shape, b.shape), (Shape::Cuboid { .. }, Shape::Cuboid { .. }));
    if boxes && near.gap < TOUCHING * inradius(a.shape).min(inradius(b.shape)) {
        cuboid_pair::find(a, b, margin, manifold);
        return;
    }
    let n = near.normal;
    let first = manifold.points().len();
    let face_a = a.face(&-n);
    let face_b = match b.shape {
        Shape::HalfSpace => None,
        _ => Some(b.face(&n)),
    };
    let on_plane = matches!(a.shape, Shape::HalfSpace);
    let aligned = |face: &Face, towards: &Vec3| face.normal.map_or(-1.0, |m| m.dot(towards));
    let by_a = if on_plane { -1.0 } else { aligned(&face_a, &-n) };
    let by_b = face_b.as_ref().map_or(2.0, |face| aligned(face, &n));
    match &face_b {
        _ if on_plane => {
            if let Some(face) = &face_b {
                flatten(face, &near.point_a, &-n, &[], true, margin, manifold);
            }
        }
        None => flatten(&face_a, &near.point_b, &n, &[], false, margin, manifold),
        Some(face_b) if by_b >= ALIGNED && by_b + HANDICAP >= by_a => {
            let m = face_b.normal.unwrap_or(n);
            flatten(&face_a, &face_b.corners()[0], &m, face_b.corners(), false, margin, manifold);
        }
        Some(face_b) if by_a >= ALIGNED => {
            let m = face_a.normal.unwrap_or(-n);
            flatten(face_b, &face_a.corners()[0], &m, face_a.corners(), true, margin, manifold);
        }
        Some(face_b) => lines([a, b], [&face_a, face_b], &n, margin, manifold),
    }
    // The nearest points themselves, unless corners are as near on all sides.
    let size = inradius(a.shape).min(inradius(b.shape));
    let found = &manifold.points()[first..];
    let least = found.iter().map(|p| p.gap).fold(f64::INFINITY, f64::min);
    if found.len() < 2 || least > near.gap + SAME * size {
        let position_W = 0.5 * (near.point_a + near.point_b);
        let beside = |p: &ManifoldPoint| (p.position_W - position_W).norm() > SAME_PLACE * size;
        manifold.retain_from(first, beside);
        manifold.offer(ManifoldPoint { feature: NEAREST, position_W, normal_W: n, gap: near.gap });
    }
}

/// Offers the part of the face `incident` over the polygon `sides` (everything if that is empty) in
/// the plane through `p` with normal `n`. `by_a` tells that this plane belongs to A.
fn flatten(
    incident: &Face,
    p: &Vec3,
    n: &Vec3,
    sides: &[Vec3],
    by_a: bool,
    margin: f64,
    manifold: &mut Manifold,
) {
    let corners = incident.corners();
    if corners.len() < 2 {
        return;
    }
    let mut polygon = polygon(corners);
    let middle = sides.iter().sum::<Vec3>() / sides.len().max(1) as f64;
    for (k, from) in sides.iter().enumerate() {
        let to = sides[(k + 1) % sides.len()];
        let across = (to - from).cross(n);
        let outward = across * 1.0_f64.copysign(across.dot(&(from - middle)));
        let length = outward.norm();
        if length > 0.0 {
            let outward = outward / length;
            polygon = polygon.clip(&outward, outward.dot(from), k as u32, ON_SIDE * length);
        }
    }
    let (normal_W, flag) = if by_a { (-n, 1 << 15) } else { (*n, 0) };
    if let Some((end, tip)) = incident.tip {
        let is_end = |c: &&mut Corner| c.id == end as u32;
        polygon.corners_mut().iter_mut().filter(is_end).for_each(|c| c.p = tip);
    }
    for corner in polygon.corners() {
        let gap = n.dot(&(corner.p - p));
        if gap <= margin {
            manifold.offer(ManifoldPoint {
                feature: CLIPPED | flag | corner.id,
                position_W: corner.p - 0.5 * gap * n,
                normal_W,
                gap,
            });
        }
    }
}

/// The line of a face that lies farthest along `n`: an edge of a rectangle, or a face that is one,
/// as it runs.
fn straight(face: &Face, n: &Vec3) -> Option<[Vec3; 2]> {
    let corners = face.corners();
    if let [from, to] = *corners {
        return (from != to).then_some([from, to]);
    }
    if corners.len() < 2 || corners.len() > 4 {
        return None;
    }
    let edge = |k: usize| [corners[k], corners[(k + 1) % corners.len()]];
    let height = |k: &usize| n.dot(&(edge(*k)[0] + edge(*k)[1]));
    (0..corners.len()).max_by(|i, j| height(i).total_cmp(&height(j))).map(edge)
}

/// Two lines that run along each other touch along their common length: its ends.
fn lines(
    [a, b]: [&Solid; 2],
    [face_a, face_b]: [&Face; 2],
    n: &Vec3,
    margin: f64,
    manifold: &mut Manifold,
) {
    let (Some(of_a), Some(of_b)) = (straight(face_a, &-n), straight(face_b, n)) else { return };
    let (of_a, of_b) = (Line::between(of_a), Line::between(of_b));
    let round = [a, b].map(RoundSide::of);
    // Of two round sides the thinner one is looked at: from its axis the other is seen as from its
    // surface.
    let by_a = match &round {
        [Some(of_a), Some(of_b)] => of_a.thickness() <= of_b.thickness(),
        [_, of_b] => of_b.is_none(),
    };
    let [round_a, round_b] = round;
    let (round, line, other, other_line, way) =
        if by_a { (round_a, of_a, b, of_b, *n) } else { (round_b, of_b, a, of_a, -n) };
    let is_along = line.sine(&other_line) <= if round.is_some() { ALONG } else { PARALLEL };
    let (s, t) = (line.part(&other_line.at(0.0)), line.part(&other_line.at(1.0)));
    let (low, high) = (s.min(t).max(0.0), s.max(t).min(1.0));
    if !is_along || low >= high {
        return;
    }
    for (k, s) in [low, high].into_iter().enumerate() {
        let p = line.at(s);
        let foot = other_line.at(other_line.part(&p));
        let over = round.as_ref().and_then(|round| round.over(other, s));
        let Some(end) = over.or_else(|| above(&p, &foot, &way, line.shorter(&other_line))) else {
            continue;
        };
        let Over { normal_W, on_side_W, gap } = end;
        if gap <= margin && normal_W.dot(&way) > ALIKE {
            manifold.offer(ManifoldPoint {
                feature: ENDS | k as u32,
                position_W: on_side_W - 0.5 * gap * normal_W,
                normal_W: if by_a { normal_W } else { -normal_W },
                gap,
            });
        }
    }
}

/// An edge's point `p` above the point `q` of another, as far as they are not beside each other:
/// lines of this length that are not the nearest ones are.
fn above(p: &Vec3, q: &Vec3, n: &Vec3, length: f64) -> Option<Over> {
    let gap = (p - q).dot(n);
    let beside = ((p - q) - gap * n).norm();
    let is_above = beside <= BESIDE[0] * gap.abs() + BESIDE[1] * length;
    is_above.then_some(Over { normal_W: *n, on_side_W: *p, gap })
}

/// From one point to another.
#[derive(Clone, Copy)]
struct Line {
    from: Vec3,
    along: Vec3,
    square: f64,
}

impl Line {
    fn between([from, to]: [Vec3; 2]) -> Self {
        let along = to - from;
        Self { from, along, square: along.norm_squared() }
    }

    /// The point after the part `s`.
    fn at(&self, s: f64) -> Vec3 {
        self.from + s * self.along
    }

    /// The part after which the line is nearest to `p`.
    fn part(&self, p: &Vec3) -> f64 {
        (p - self.from).dot(&self.along) / self.square
    }

    fn sine(&self, other: &Self) -> f64 {
        self.along.cross(&other.along).norm() / (self.square * other.square).sqrt()
    }

    /// Length of the shorter of two \[m\].
    fn shorter(&self, other: &Self) -> f64 {
        self.square.min(other.square).sqrt()
    }
}

/// A face clipped by the sides of another: each side adds at most one corner to a convex polygon.
type Clipped = Polygon<{ 2 * DISC_CORNERS }, 64>;

/// A polygon, or a segment taken there and back.
fn polygon(points: &[Vec3]) -> Clipped {
    let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    let mut polygon = Clipped::empty(Some(ON_SIDE * size));
    for (k, p) in points.iter().enumerate() {
        polygon.push(Corner { p: *p, id: k as u32, edge: k as u32 });
    }
    polygon
}
