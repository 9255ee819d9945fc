//! Contact points between two rigid shapes.
//!
//! Two cuboids have their own method. Otherwise one side gives points (balls of a radius) and
//! the other its signed distance; meshes do so in both directions. The order is: half-space,
//! cuboid, mesh, capsule, sphere; the later one gives the points.

use crate::contact::Shape;
use crate::contact::approach::approach;
use crate::contact::cuboid_pair;
use crate::contact::features::capsule_axis;
use crate::contact::manifold::{Manifold, ManifoldPoint};
use crate::contact::rigid_body::{Placed, RigidBody};
use crate::contact::triangle::segment_parameter;
use crate::math::Vec3;

/// One of two rigid bodies.
#[derive(Clone, Copy)]
pub(crate) struct RigidSide<'a> {
    pub body: &'a RigidBody,
    pub placed: &'a Placed,
}

/// How far to look.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// Length of the step \[s\].
    pub h: f64,
    /// Surfaces nearer than this are in contact \[m\].
    pub margin: f64,
}

/// Most samples along the axis of a capsule, or the edge of a cuboid, against a mesh.
const SAMPLES_MAX: usize = 8;
/// Set in the feature of a point that came from side B.
const FROM_B: u32 = 1 << 31;

/// Fills `manifold` with the points of A against B, normals from B to A.
pub(crate) fn find(a: RigidSide, b: RigidSide, reach: Reach, manifold: &mut Manifold) {
    manifold.clear();
    if rank(&a.body.shape) >= rank(&b.body.shape) {
        find_ranked(a, b, reach, manifold);
    } else {
        find_ranked(b, a, reach, manifold);
        manifold.points_mut().iter_mut().for_each(|p| p.normal_W = -p.normal_W);
    }
    manifold.reduce();
}

fn rank(shape: &Shape) -> u32 {
    match shape {
        Shape::HalfSpace => 0,
        Shape::Cuboid { .. } => 1,
        Shape::Mesh(_) => 2,
        Shape::Capsule { .. } => 3,
        Shape::Sphere { .. } => 4,
    }
}

fn find_ranked(a: RigidSide, b: RigidSide, reach: Reach, manifold: &mut Manifold) {
    match (&a.body.shape, &b.body.shape) {
        (Shape::Sphere { radius }, _) => {
            point(a, b, reach, 0, &Vec3::zeros(), *radius, manifold);
        }
        (Shape::Capsule { radius, half_length }, _) => {
            capsule(a, b, reach, *radius, *half_length, manifold);
        }
        (Shape::Cuboid { half: half_a }, Shape::Cuboid { half: half_b }) => {
            cuboid_pair::find((a.placed, half_a), (b.placed, half_b), reach, manifold);
        }
        (Shape::Mesh(_) | Shape::Cuboid { .. }, _) => {
            fixed_points(a, b, reach, 0, manifold);
            if matches!(b.body.shape, Shape::Cuboid { .. } | Shape::Mesh(_)) {
                reversed(manifold, |m| {
                    fixed_points(b, a, reach, FROM_B, m);
                    edge_samples(b, a, reach, m);
                });
            }
        }
        // Half-spaces are fixed and do not meet.
        (Shape::HalfSpace, _) => {}
    }
}

/// Runs `find` for the opposite direction and turns the normals of what it adds.
fn reversed(manifold: &mut Manifold, find: impl FnOnce(&mut Manifold)) {
    let flip = |m: &mut Manifold| m.points_mut().iter_mut().for_each(|p| p.normal_W = -p.normal_W);
    flip(manifold);
    find(manifold);
    flip(manifold);
}

/// A ball of A (centre `p_A` in its shape frame) against the distance of B.
fn point(
    a: RigidSide,
    b: RigidSide,
    reach: Reach,
    feature: u32,
    p_A: &Vec3,
    radius: f64,
    manifold: &mut Manifold,
) {
    let p_W = a.placed.world_point(p_A);
    let p = b.placed.shape_point(&p_W);
    let u_W = (a.placed.velocity_at(&p_W) - b.placed.velocity_at(&p_W)) * reach.h;
    let u = b.placed.rotation.tr_mul(&u_W);
    let Some(found) = approach(&b.body.shape, &p, &u, radius, reach.margin) else { return };
    let normal_W = b.placed.rotation * found.gradient;
    manifold.offer(ManifoldPoint {
        feature,
        position_W: p_W - (radius + 0.5 * found.value) * normal_W,
        normal_W,
        gap: found.value,
    });
}

/// The fixed points of A (corners, mesh points) near B against its distance.
fn fixed_points(a: RigidSide, b: RigidSide, reach: Reach, flag: u32, manifold: &mut Manifold) {
    let features = &a.body.features;
    let mut offer = |i: u32| {
        point(a, b, reach, flag | i, &features.points[i as usize], features.radius, manifold);
    };
    if matches!(b.body.shape, Shape::HalfSpace) {
        (0..features.points.len() as u32).for_each(offer);
        return;
    }
    // B during the step, seen from A, which turns and travels too.
    let travel = reach.h * a.placed.velocity.norm() + a.placed.turn;
    let to_a = a.placed.rotation.transpose();
    let around = b.placed.swept_W.moved(&to_a, &-(to_a * a.placed.origin));
    let around = around.inflate(reach.margin + travel);
    features.tree.overlapping(&around, |i| {
        if around.contains(&features.points[i as usize]) {
            offer(i);
        }
    });
}

/// Points along the edges of cuboid A against the distance of B.
fn edge_samples(a: RigidSide, b: RigidSide, reach: Reach, manifold: &mut Manifold) {
    let n = SAMPLES_MAX - 1;
    for (e, [from, to]) in a.body.features.segments.iter().enumerate() {
        for k in 1..=n {
            let p = from + (to - from) * (k as f64 / (n + 1) as f64);
            point(a, b, reach, FROM_B | 0x1000_0000 | (16 * e + k) as u32, &p, 0.0, manifold);
        }
    }
}

/// A capsule touches at its ends, where it comes nearest, and where it enters and leaves the
/// part of its axis that lies over the other shape.
fn capsule(
    a: RigidSide,
    b: RigidSide,
    reach: Reach,
    radius: f64,
    half_length: f64,
    manifold: &mut Manifold,
) {
    let axis = capsule_axis(half_length);
    let ends = axis.map(|p| b.placed.shape_point(&a.placed.world_point(&p)));
    let mut places = Places { at: [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], count: 2 };
    match &b.body.shape {
        Shape::HalfSpace | Shape::Sphere { .. } => {}
        Shape::Capsule { half_length, .. } => {
            for other in capsule_axis(*half_length) {
                places.add(segment_parameter(&other, &ends[0], &ends[1]));
            }
            places.add(nearest_to(&b.body.shape, &ends));
        }
        Shape::Cuboid { half } => {
            let t = nearest_to(&b.body.shape, &ends);
            let at_t = ends[0] + t * (ends[1] - ends[0]);
            let face = b.body.shape.distance(&at_t).gradient.iamax();
            if let Some([start, end]) = over_face(&ends, half, face) {
                places.add(start);
                places.add(end);
            }
            places.add(t);
        }
        Shape::Mesh(_) => {
            let inner = ((2.0 * half_length / radius).ceil() as usize).clamp(1, SAMPLES_MAX - 2);
            (1..=inner).for_each(|k| places.add(k as f64 / (inner + 1) as f64));
            reversed(manifold, |m| fixed_points(b, a, reach, FROM_B, m));
        }
    }
    for (feature, &t) in places.at[..places.count].iter().enumerate() {
        let p = axis[0] + t * (axis[1] - axis[0]);
        let earlier = &places.at[..feature];
        if !earlier.iter().any(|s| (s - t).abs() * half_length < 1e-3 * radius) {
            point(a, b, reach, feature as u32, &p, radius, manifold);
        }
    }
}

/// Parameters along the axis of a capsule, each with its own feature number.
struct Places {
    at: [f64; SAMPLES_MAX],
    count: usize,
}

impl Places {
    fn add(&mut self, t: f64) {
        self.at[self.count] = t;
        self.count += 1;
    }
}

/// Where on the segment the distance to a convex shape is least: golden-section search, since
/// that distance is convex along a line.
fn nearest_to(shape: &Shape, [p, q]: &[Vec3; 2]) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let value = |t: f64| shape.distance(&(p + t * (q - p))).value;
    let (mut low, mut high) = (0.0, 1.0);
    let (mut t0, mut t1) = (1.0 - GOLDEN, GOLDEN);
    let (mut v0, mut v1) = (value(t0), value(t1));
    for _ in 0..48 {
        if v0 <= v1 {
            high = t1;
            (t1, v1) = (t0, v0);
            t0 = high - GOLDEN * (high - low);
            v0 = value(t0);
        } else {
            low = t0;
            (t0, v0) = (t1, v1);
            t1 = low + GOLDEN * (high - low);
            v1 = value(t1);
        }
    }
    0.5 * (low + high)
}

/// The part of a segment over the face of a cuboid with this axis, as parameters.
fn over_face([p, q]: &[Vec3; 2], half: &Vec3, face: usize) -> Option<[f64; 2]> {
    let (mut start, mut end) = (0.0_f64, 1.0_f64);
    for k in (0..3).filter(|&k| k != face) {
        let way = q[k] - p[k];
        if way.abs() < 1e-12 {
            if p[k].abs() > half[k] {
                return None;
            }
            continue;
        }
        let (t0, t1) = ((-half[k] - p[k]) / way, (half[k] - p[k]) / way);
        start = start.max(t0.min(t1));
        end = end.min(t0.max(t1));
    }
    (start < end).then_some([start, end])
}
