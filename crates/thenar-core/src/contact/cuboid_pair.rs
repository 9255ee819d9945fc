//! Two cuboids that touch or overlap: the axis of least overlap, then the faces clipped against
//! each other, or the two nearest edges.
//!
//! ```text
//!        incident face (clipped to the sides of the reference face)
//!          .-------------.
//!      ....|.............|....  gap along n at each remaining corner
//!      |   reference face    |
//! ```

use crate::contact::Shape;
use crate::contact::manifold::{Manifold, ManifoldPoint};
use crate::contact::polygon::{Corner, Polygon};
use crate::contact::support::Solid;
use crate::math::{Mat3, Vec3};

/// A later face is taken only if the boxes are farther apart along it by this part of the least
/// half-length: of faces that are level to round-off the first stays, and the gap told is too small
/// by no more.
const FACE_HANDICAP: f64 = 1e-6;
/// An axis across two edges is taken only if the boxes are farther apart along it by this part of
/// the least half-length: edges make one point where faces make up to eight. Boxes that are level
/// but for a small tilt so stand on faces; the overlap found is too great by no more than this
/// part. Tests hold with 1e-6, too; with 0.1 boxes no longer part the shortest way.
const EDGE_HANDICAP: f64 = 1e-2;
/// Edges at less than this (sine) to each other have no axis of their own: across parallel edges
/// boxes are rectangles, which their faces separate, and the gap is missed by less than this part
/// of an edge.
const SINE_MIN: f64 = 1e-3;
/// Part of the boxes' sizes within which a point beside a face lies on the face's side, so that
/// round-off cuts no corner that two boxes in line share: a cut corner has another name, and what
/// was kept of the contact is lost.
const ON_SIDE: f64 = 1e-9;

/// A cuboid in the world; columns of `axes` are its own axes.
#[derive(Clone, Copy)]
struct Box3 {
    center: Vec3,
    axes: Mat3,
    half: Vec3,
}

impl Box3 {
    fn axis(&self, k: usize) -> Vec3 {
        self.axes.column(k).into_owned()
    }

    /// Half the extent along unit vector `n`.
    fn extent(&self, n: &Vec3) -> f64 {
        (0..3).map(|k| self.half[k] * self.axis(k).dot(n).abs()).sum()
    }

    /// Sign and number of the axis nearest to direction `n`.
    fn face_towards(&self, n: &Vec3) -> (usize, f64) {
        let along = self.axes.tr_mul(n);
        let k = along.iamax();
        (k, 1.0_f64.copysign(along[k]))
    }
}

/// The three kinds of separating axis.
#[derive(Clone, Copy, PartialEq)]
enum Axis {
    FaceA(usize),
    FaceB(usize),
    Edges(usize, usize),
}

/// A candidate: unit direction from B to A, and the separation along it.
#[derive(Clone, Copy)]
struct Candidate {
    axis: Axis,
    normal: Vec3,
    separation: f64,
}

/// Adds the contact points of cuboids A and B whose gap is at most `margin`.
pub(crate) fn find(a: &Solid, b: &Solid, margin: f64, manifold: &mut Manifold) {
    let (Shape::Cuboid { half: half_a }, Shape::Cuboid { half: half_b }) = (a.shape, b.shape)
    else {
        return;
    };
    let in_world =
        |s: &Solid, half: &Vec3| Box3 { center: s.origin, axes: s.rotation, half: *half };
    let (box_a, box_b) = (in_world(a, half_a), in_world(b, half_b));
    let Some(best) = choose_axis(&box_a, &box_b, margin) else { return };
    let first = manifold.points().len();
    match best.axis {
        Axis::FaceA(k) => clip_faces(&box_a, &box_b, k, &-best.normal, false, manifold),
        Axis::FaceB(k) => clip_faces(&box_b, &box_a, k, &best.normal, true, manifold),
        Axis::Edges(i, j) => join_edges(&box_a, &box_b, i, j, &best.normal, manifold),
    }
    manifold.retain_from(first, |p| p.gap <= margin);
}

/// The axis on which the boxes touch, or `None` when they are apart by more than `margin`.
fn choose_axis(a: &Box3, b: &Box3, margin: f64) -> Option<Candidate> {
    let between = a.center - b.center;
    let test = |axis: Axis, direction: Vec3| {
        let normal = direction * 1.0_f64.copysign(direction.dot(&between));
        let separation = normal.dot(&between) - a.extent(&normal) - b.extent(&normal);
        Candidate { axis, normal, separation }
    };
    let stays_apart = |c: &Candidate| c.separation > margin;
    let later =
        |c: &Candidate, best: &Candidate, handicap: f64| c.separation > best.separation + handicap;

    let size = a.half.min().min(b.half.min());
    let mut best: Option<Candidate> = None;
    for k in 0..6 {
        let c = if k < 3 {
            test(Axis::FaceA(k), a.axis(k))
        } else {
            test(Axis::FaceB(k - 3), b.axis(k - 3))
        };
        if stays_apart(&c) {
            return None;
        }
        if best.is_none_or(|best| later(&c, &best, FACE_HANDICAP * size)) {
            best = Some(c);
        }
    }
    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
        let cross = a.axis(i).cross(&b.axis(j));
        let length = cross.norm();
        if length < SINE_MIN {
            continue;
        }
        let c = test(Axis::Edges(i, j), cross / length);
        if stays_apart(&c) {
            return None;
        }
        if best.is_none_or(|best| later(&c, &best, EDGE_HANDICAP * size)) {
            best = Some(c);
        }
    }
    best
}

/// A quadrilateral clipped by four sides has at most eight corners.
type Clipped = Polygon<12, 4>;

/// Face `k` of `reference`, whose outward normal is `n`, against the facing side of `incident`.
fn clip_faces(
    reference: &Box3,
    incident: &Box3,
    k: usize,
    n: &Vec3,
    reference_is_b: bool,
    manifold: &mut Manifold,
) {
    let (face, sign) = incident.face_towards(&-n);
    let mut polygon = incident_face(incident, face, sign);
    let tolerance = ON_SIDE * (reference.half.max() + incident.half.max());
    for side in 0..4 {
        let along = (k + 1 + side / 2) % 3;
        let outward = reference.axis(along) * if side % 2 == 0 { 1.0 } else { -1.0 };
        let offset = outward.dot(&reference.center) + reference.half[along];
        polygon = polygon.clip(&outward, offset, side as u32, tolerance);
    }

    let face_offset = n.dot(&reference.center) + reference.half[k];
    let towards_a = if reference_is_b { *n } else { -n };
    let faces = (face_code(k, reference.axis(k).dot(n)) * 6 + face_code(face, sign)) * 2
        + u32::from(reference_is_b);
    for corner in polygon.corners() {
        let gap = n.dot(&corner.p) - face_offset;
        manifold.offer(ManifoldPoint {
            feature: 1 << 16 | faces << 7 | corner.id,
            position_W: corner.p - 0.5 * gap * n,
            normal_W: towards_a,
            gap,
        });
    }
}

fn face_code(axis: usize, sign: f64) -> u32 {
    2 * axis as u32 + u32::from(sign > 0.0)
}

/// The four corners of a face in circular order.
fn incident_face(b: &Box3, face: usize, sign: f64) -> Clipped {
    let (j, k) = ((face + 1) % 3, (face + 2) % 3);
    let mut polygon = Clipped::empty(None);
    for (edge, (sj, sk)) in
        [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].into_iter().enumerate()
    {
        let mut local = Vec3::zeros();
        local[face] = sign * b.half[face];
        local[j] = sj * b.half[j];
        local[k] = sk * b.half[k];
        polygon.push(Corner { p: b.center + b.axes * local, id: edge as u32, edge: edge as u32 });
    }
    polygon
}

/// The nearest points of edge `i` of A and edge `j` of B that face each other along `n`.
fn join_edges(a: &Box3, b: &Box3, i: usize, j: usize, n: &Vec3, manifold: &mut Manifold) {
    let (on_a, code_a) = edge_towards(a, i, &-n);
    let (on_b, code_b) = edge_towards(b, j, n);
    let (da, db) = (a.axis(i), b.axis(j));
    let (cosine, between) = (da.dot(&db), on_b - on_a);
    let across = 1.0 - cosine * cosine;
    let t = (between.dot(&da) - cosine * between.dot(&db)) / across;
    let t = t.clamp(-a.half[i], a.half[i]);
    let p = on_a + t * da;
    let s = (p - on_b).dot(&db).clamp(-b.half[j], b.half[j]);
    let q = on_b + s * db;
    manifold.offer(ManifoldPoint {
        feature: 2 << 16 | code_a << 8 | code_b,
        position_W: 0.5 * (p + q),
        normal_W: *n,
        gap: (p - q).dot(n),
    });
}

/// Middle of the edge along `axis` farthest in direction `n`, and its number.
fn edge_towards(b: &Box3, axis: usize, n: &Vec3) -> (Vec3, u32) {
    let along = b.axes.tr_mul(n);
    let mut local = Vec3::zeros();
    let mut code = axis as u32;
    for k in (0..3).filter(|&k| k != axis) {
        local[k] = b.half[k].copysign(along[k]);
        code = code << 1 | u32::from(along[k] > 0.0);
    }
    (b.center + b.axes * local, code)
}
