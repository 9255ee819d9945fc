//! Sharp or small parts of a rigid shape against the triangles of a deformable surface: what
//! comes between the vertices. Corners, mesh points and sphere centres are tested as points;
//! edges of a cuboid and the axis of a capsule where they pass nearest to each triangle.

use crate::contact::aabb::Aabb;
use crate::contact::collector::{Collector, feature_key};
use crate::contact::soft_rigid::{KEY_POINT, KEY_SEGMENT, SoftRigid, VertexScratch};
use crate::contact::triangle::{
    Closest, Feature, area_vector, closest_on_triangle, segment_parameter,
};
use crate::contact::{Contact, Site, SurfacePoint};
use crate::math::Vec3;

const NONE: u32 = u32::MAX;
const UNMET: (f64, u32) = (f64::INFINITY, NONE);

/// Nearest triangle of each feature point, and deepest feature of each triangle.
#[derive(Clone, Debug, Default)]
pub(crate) struct FeatureScratch {
    nearest: Vec<(f64, u32)>,
    /// Points with an entry in `nearest`, in the order they were met.
    met: Vec<u32>,
    deepest: Vec<Option<Touch>>,
    touched: Vec<u32>,
    /// Per triangle, the round in which it was last visited.
    visited: Vec<u32>,
    round: u32,
}

impl FeatureScratch {
    pub fn with_size(points: usize, triangles: usize) -> Self {
        Self {
            nearest: vec![UNMET; points],
            met: Vec::with_capacity(points),
            deepest: vec![None; triangles],
            touched: Vec::with_capacity(triangles),
            visited: vec![0; triangles],
            round: 0,
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

/// A triangle within reach of the shape, in the shape frame.
struct Near {
    index: u32,
    x: [Vec3; 3],
    /// Motions of its corners in this step.
    u: [Vec3; 3],
    /// The largest of them \[m\].
    travel: f64,
    /// Distance of the nearest corner to the shape.
    vertex_gap: f64,
}

impl Near {
    fn new(pair: &SoftRigid, vertices: &VertexScratch, index: u32) -> Self {
        let v = pair.surface.triangles[index as usize].map(|v| v as usize);
        let [(x0, u0), (x1, u1), (x2, u2)] = v.map(|v| pair.in_shape(v));
        let squared = u0.norm_squared().max(u1.norm_squared()).max(u2.norm_squared());
        let vertex_gap = v.iter().map(|&v| vertices.gaps[v]).fold(f64::INFINITY, f64::min);
        Self { index, x: [x0, x1, x2], u: [u0, u1, u2], travel: squared.sqrt(), vertex_gap }
    }

    fn edge_max(&self) -> f64 {
        let [a, b, c] = &self.x;
        let squared = (b - a).norm_squared().max((c - b).norm_squared());
        squared.max((a - c).norm_squared()).sqrt()
    }
}

/// Adds at most one contact per triangle, where a feature comes closer than the triangle's own
/// vertices.
pub(crate) fn find(
    pair: &SoftRigid,
    vertices: &VertexScratch,
    scratch: &mut FeatureScratch,
    out: &mut Collector,
) {
    scratch.round = scratch.round.wrapping_add(1);
    for &v in &vertices.near {
        for &t in pair.surface.around(v) {
            if std::mem::replace(&mut scratch.visited[t as usize], scratch.round) == scratch.round {
                continue;
            }
            let near = Near::new(pair, vertices, t);
            // Any point of a triangle is within 1/√3 of its longest edge of some corner.
            let edge = 0.578 * near.edge_max();
            if near.vertex_gap > edge + depth_max(pair) + near.travel {
                continue;
            }
            meet_points(pair, &near, scratch);
            meet_segments(pair, &near, edge, scratch);
        }
    }
    settle_points(pair, vertices, scratch);
    deliver(pair, scratch, out);
}

/// How deep a feature may lie and still be taken as having come through the triangle.
pub(crate) fn depth_max(pair: &SoftRigid) -> f64 {
    pair.margin + 0.25 * pair.surface.edge_mean
}

/// Offers a triangle to every feature point around it.
fn meet_points(pair: &SoftRigid, near: &Near, scratch: &mut FeatureScratch) {
    let features = &pair.body.features;
    let reach = depth_max(pair) + near.travel + features.radius;
    let around = Aabb::of_points(&near.x).inflate(reach);
    let normal = area_vector(&near.x).try_normalize(1e-300).unwrap_or_else(Vec3::zeros);
    features.tree.overlapping(&around, |i| {
        let p = &features.points[i as usize];
        if !around.contains(p) {
            return;
        }
        let best = &mut scratch.nearest[i as usize];
        // The plane of the triangle is not farther than the triangle.
        let height = normal.dot(&(p - near.x[0]));
        if height.abs() > reach || height * height > best.0 {
            return;
        }
        let closest = closest_on_triangle(p, &near.x);
        // Of equally near triangles the lowest index.
        if (closest.distance_squared, near.index) < *best {
            if best.1 == NONE {
                scratch.met.push(i);
            }
            *best = (closest.distance_squared, near.index);
        }
    });
}

/// Turns the nearest triangle of each point into a touch, and forgets it.
fn settle_points(pair: &SoftRigid, vertices: &VertexScratch, scratch: &mut FeatureScratch) {
    for m in 0..scratch.met.len() {
        let i = scratch.met[m];
        let (_, t) = std::mem::replace(&mut scratch.nearest[i as usize], UNMET);
        let near = Near::new(pair, vertices, t);
        let p = pair.body.features.points[i as usize];
        let closest = closest_on_triangle(&p, &near.x);
        consider(pair, &near, &p, closest, [KEY_POINT, i], scratch);
    }
    scratch.met.clear();
}

/// Tests each segment where it passes nearest to the middle of a triangle, whose points lie
/// within `size` of a corner.
fn meet_segments(pair: &SoftRigid, near: &Near, size: f64, scratch: &mut FeatureScratch) {
    let features = &pair.body.features;
    let middle = (near.x[0] + near.x[1] + near.x[2]) / 3.0;
    let reach = 2.0 * size + depth_max(pair) + features.radius + near.travel;
    for (s, [a, b]) in features.segments.iter().enumerate() {
        let at = |q: &Vec3| segment_parameter(q, a, b);
        let t = at(&middle);
        let p = a + t * (b - a);
        // The corners of a cuboid are tested as points.
        let is_corner = features.radius == 0.0 && (t == 0.0 || t == 1.0);
        if is_corner || (p - middle).norm_squared() > reach * reach {
            continue;
        }
        let (mut p, mut closest) = (p, closest_on_triangle(&p, &near.x));
        if features.radius > 0.0 {
            // The axis of a capsule stays outside, so the nearest pair of points is meant.
            p = a + at(&closest.point) * (b - a);
            closest = closest_on_triangle(&p, &near.x);
        }
        if pair.surface.owns(near.index, closest.feature) {
            consider(pair, near, &p, closest, [KEY_SEGMENT | s as u32, near.index], scratch);
        }
    }
}

/// Keeps feature point `p` if it touches and is the deepest of its triangle.
fn consider(
    pair: &SoftRigid,
    near: &Near,
    p: &Vec3,
    closest: Closest,
    key: [u32; 2],
    scratch: &mut FeatureScratch,
) {
    // At a vertex the vertex itself is the contact; what is far needs no normal.
    let radius = pair.body.features.radius;
    let distance = closest.distance_squared.sqrt();
    let at_vertex = matches!(closest.feature, Feature::Vertex(_));
    if at_vertex || distance - radius > depth_max(pair) + near.travel {
        return;
    }
    // The pseudonormal is taken in the world, then turned into the shape frame.
    let outward_W = pair.surface.pseudonormal(near.index, closest.feature, pair.state.positions);
    let outward = pair.placed.rotation.tr_mul(&outward_W);
    let to_p = p - closest.point;
    let signed = distance.copysign(to_p.dot(&outward));
    let on_face = closest.feature == Feature::Face || distance < 1e-9;
    let normal = if on_face { outward } else { to_p / signed };
    let gap = signed - radius;

    let u: Vec3 = (0..3).map(|k| near.u[k] * closest.weights[k]).sum();
    let closing = u.dot(&normal).max(0.0);
    let missed = gap < near.vertex_gap - 0.1 * pair.margin;
    let too_deep = gap < -depth_max(pair) - radius;
    if gap > pair.margin + closing || !missed || too_deep || normal == Vec3::zeros() {
        return;
    }
    // What has come in through this triangle has taken the place of its nearest point. Near the
    // far side of a thin or folded part it lies inside as well, but that place is free.
    if signed < 0.0 && radius == 0.0 && pair.body.shape.distance(&closest.point).value > 0.0 {
        return;
    }
    let deepest = &mut scratch.deepest[near.index as usize];
    match deepest {
        Some(old) if old.gap <= gap => {}
        _ => {
            if deepest.is_none() {
                scratch.touched.push(near.index);
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
