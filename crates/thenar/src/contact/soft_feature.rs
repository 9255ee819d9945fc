//! Sharp or small parts of a rigid shape against the triangles of a deformable surface: what
//! comes between the vertices. Corners, mesh points and sphere centres are tested as points;
//! edges of a cuboid and the axis of a capsule where they pass nearest to each triangle.

use crate::contact::aabb::Aabb;
use crate::contact::collector::{Collector, feature_key};
use crate::contact::point_tree::Segment;
use crate::contact::soft_rigid::{KEY_POINT, KEY_SEGMENT, SoftRigid, VertexScratch};
use crate::contact::triangle::{Closest, Feature, closest_on_triangle, segment_parameter};
use crate::contact::{Contact, Site, SurfacePoint};
use crate::math::Vec3;

const NONE: u32 = u32::MAX;

/// Nearest triangle of each feature point, and deepest feature of each triangle.
#[derive(Clone, Debug, Default)]
pub(crate) struct FeatureScratch {
    nearest: Vec<(f64, u32)>,
    /// Points with an entry in `nearest`, in the order they were met.
    met: Vec<u32>,
    deepest: Vec<Option<Touch>>,
    touched: Vec<u32>,
}

impl FeatureScratch {
    pub fn with_size(points: usize, triangles: usize) -> Self {
        Self {
            nearest: vec![(f64::INFINITY, NONE); points],
            met: Vec::with_capacity(points),
            deepest: vec![None; triangles],
            touched: Vec::with_capacity(triangles),
        }
    }
}

/// A rigid feature at a triangle.
#[derive(Clone, Copy, Debug)]
struct Touch {
    key: [u32; 2],
    closest: Closest,
    /// Outward normal of the soft surface, in the shape frame.
    normal: Vec3,
    gap: f64,
}

/// Adds at most one contact per triangle, where a feature comes closer than the triangle's own
/// vertices.
pub(crate) fn find(
    pair: &SoftRigid,
    vertices: &VertexScratch,
    scratch: &mut FeatureScratch,
    out: &mut Collector,
) {
    for t in 0..pair.surface.triangles.len() as u32 {
        let v = pair.surface.triangles[t as usize].map(|v| v as usize);
        if v.iter().all(|&v| vertices.gaps[v] == f64::INFINITY) {
            continue;
        }
        let x = v.map(|v| vertices.places[v]);
        let travel = v.iter().map(|&v| vertices.motions[v].norm()).fold(0.0, f64::max);
        if !within_reach(pair, vertices, &v, &x, travel) {
            continue;
        }
        meet_points(pair, t, &x, travel, scratch);
        for (s, segment) in pair.body.features.segments.iter().enumerate() {
            meet_segment(pair, vertices, t, &x, s as u32, segment, scratch);
        }
    }
    settle_points(pair, vertices, scratch);
    deliver(pair, scratch, out);
}

/// How deep a feature may lie and still be taken as having come through the triangle.
pub(crate) fn depth_max(pair: &SoftRigid) -> f64 {
    pair.margin + 0.5 * pair.surface.edge_mean
}

/// Any point of a triangle is within 1/√3 of its longest edge of some vertex.
fn within_reach(
    pair: &SoftRigid,
    vertices: &VertexScratch,
    v: &[usize; 3],
    x: &[Vec3; 3],
    travel: f64,
) -> bool {
    let gap = v.iter().map(|&v| vertices.gaps[v]).fold(f64::INFINITY, f64::min);
    let edge = (0..3).map(|k| (x[k] - x[(k + 1) % 3]).norm()).fold(0.0, f64::max);
    gap <= 0.578 * edge + depth_max(pair) + travel
}

/// Offers triangle `t` to every feature point around it.
fn meet_points(pair: &SoftRigid, t: u32, x: &[Vec3; 3], travel: f64, scratch: &mut FeatureScratch) {
    let features = &pair.body.features;
    let reach = depth_max(pair) + travel + features.radius;
    let around = Aabb::of_points(x).inflate(reach);
    features.tree.overlapping(&around, |i| {
        let p = &features.points[i as usize];
        if !around.contains(p) {
            return;
        }
        let closest = closest_on_triangle(p, x);
        let best = &mut scratch.nearest[i as usize];
        if closest.distance_squared < best.0 {
            if best.1 == NONE {
                scratch.met.push(i);
            }
            *best = (closest.distance_squared, t);
        }
    });
}

/// Turns the nearest triangle of each point into a touch, and forgets it.
fn settle_points(pair: &SoftRigid, vertices: &VertexScratch, scratch: &mut FeatureScratch) {
    for m in 0..scratch.met.len() {
        let i = scratch.met[m];
        let (_, t) = std::mem::replace(&mut scratch.nearest[i as usize], (f64::INFINITY, NONE));
        let x = pair.surface.triangles[t as usize].map(|v| vertices.places[v as usize]);
        let p = pair.body.features.points[i as usize];
        let closest = closest_on_triangle(&p, &x);
        consider(pair, vertices, t, &p, closest, [KEY_POINT, i], scratch);
    }
    scratch.met.clear();
}

/// Tests a segment where it passes nearest to the middle of a triangle.
fn meet_segment(
    pair: &SoftRigid,
    vertices: &VertexScratch,
    t: u32,
    x: &[Vec3; 3],
    index: u32,
    [a, b]: &Segment,
    scratch: &mut FeatureScratch,
) {
    let middle = (x[0] + x[1] + x[2]) / 3.0;
    let at = |q: &Vec3| a + segment_parameter(q, a, b) * (b - a);
    let radius = pair.body.features.radius;
    let mut p = at(&middle);
    if radius == 0.0 && (p == *a || p == at(b)) {
        // The corners are tested as points.
        return;
    }
    let half = Aabb::of_points(x).half().norm();
    let reach = 1.5 * half + depth_max(pair) + radius + vertices.motion_of(pair, t);
    if (p - middle).norm_squared() > reach * reach {
        return;
    }
    let mut closest = closest_on_triangle(&p, x);
    if radius > 0.0 {
        // The axis of a capsule stays outside, so the nearest pair of points is meant.
        p = at(&closest.point);
        closest = closest_on_triangle(&p, x);
    }
    if pair.surface.owns(t, closest.feature) {
        consider(pair, vertices, t, &p, closest, [KEY_SEGMENT | index, t], scratch);
    }
}

impl VertexScratch {
    /// Largest motion of a triangle's vertices.
    fn motion_of(&self, pair: &SoftRigid, t: u32) -> f64 {
        let v = pair.surface.triangles[t as usize];
        v.iter().map(|&v| self.motions[v as usize].norm()).fold(0.0, f64::max)
    }
}

/// Keeps feature point `p` if it touches and is the deepest of its triangle.
fn consider(
    pair: &SoftRigid,
    vertices: &VertexScratch,
    t: u32,
    p: &Vec3,
    closest: Closest,
    key: [u32; 2],
    scratch: &mut FeatureScratch,
) {
    // At a vertex the vertex itself is the contact.
    if matches!(closest.feature, Feature::Vertex(_)) {
        return;
    }
    // The pseudonormal is taken in the world, then turned into the shape frame.
    let outward_W = pair.surface.pseudonormal(t, closest.feature, pair.state.positions);
    let outward = pair.placed.rotation.tr_mul(&outward_W);
    let to_p = p - closest.point;
    let distance = closest.distance_squared.sqrt();
    let side = to_p.dot(&outward);
    let signed = distance.copysign(side);
    let on_face = closest.feature == Feature::Face || distance < 1e-9;
    let normal = if on_face { outward } else { to_p / signed };
    let gap = signed - pair.body.features.radius;

    let v = pair.surface.triangles[t as usize].map(|v| v as usize);
    let u: Vec3 = (0..3).map(|k| vertices.motions[v[k]] * closest.weights[k]).sum();
    let closing = u.dot(&normal).max(0.0);
    let vertex_gap = v.iter().map(|&v| vertices.gaps[v]).fold(f64::INFINITY, f64::min);
    let missed = gap < vertex_gap - 0.1 * pair.margin;
    let too_deep = gap < -depth_max(pair) - pair.body.features.radius;
    if gap > pair.margin + closing || !missed || too_deep || normal == Vec3::zeros() {
        return;
    }
    let deepest = &mut scratch.deepest[t as usize];
    match deepest {
        Some(old) if old.gap <= gap => {}
        _ => {
            if deepest.is_none() {
                scratch.touched.push(t);
            }
            *deepest = Some(Touch { key, closest, normal, gap });
        }
    }
}

/// Hands over one contact per touched triangle.
fn deliver(pair: &SoftRigid, scratch: &mut FeatureScratch, out: &mut Collector) {
    scratch.touched.sort_unstable();
    for i in 0..scratch.touched.len() {
        let t = scratch.touched[i];
        let Some(touch) = scratch.deepest[t as usize].take() else { continue };
        let position_W = pair.placed.world_point(&touch.closest.point);
        let vertices = pair.surface.triangles[t as usize];
        let point = SurfacePoint { soft: pair.soft, vertices, weights: touch.closest.weights };
        let [kind, feature] = touch.key;
        out.push(Contact {
            key: feature_key([kind, pair.soft, pair.rigid, feature]),
            a: Site::Soft(point),
            b: Site::Rigid { body: pair.rigid, offset_W: position_W - pair.placed.center_of_mass },
            position_W,
            // The rigid feature lies outside the soft surface: from B to A is inward.
            normal_W: -(pair.placed.rotation * touch.normal),
            gap: touch.gap,
            friction: pair.friction,
            area: 0.0,
        });
    }
    scratch.touched.clear();
}
