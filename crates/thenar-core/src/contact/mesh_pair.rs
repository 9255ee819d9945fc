//! The contact points of a mesh with other shapes.
//!
//! A contact is a point of one surface and the exact distance of the other there. Points are
//! offered generously: corners, rims and moving lowest points of a convex shape; on each near
//! triangle the point nearest to the shape; ends of the part of each edge that runs along a face of
//! the shape; vertices of meshes; edges that cross. Whatever is offered has its true gap, so that
//! none of them can hold what the surfaces do not.

use crate::contact::aabb::Aabb;
use crate::contact::along::Along;
use crate::contact::approach::approach_from;
use crate::contact::features::{corners, rim};
use crate::contact::manifold::{Manifold, ManifoldPoint, OFFERED_MAX};
use crate::contact::mesh_clear;
use crate::contact::mesh_crossing;
use crate::contact::mesh_deep::{self, DeepFace};
use crate::contact::mesh_index::{Edges, MeshEdge};
use crate::contact::mesh_normals::{SAME, STANDING};
use crate::contact::nearest::{longest_edge, place_unknown, point as weighted, sharpened};
use crate::contact::rigid_pair::{Reach, reversed};
use crate::contact::support::{Solid, inradius, support};
use crate::contact::sweep::MovingPiece;
use crate::contact::{Distance, MeshShape, Shape};
use crate::math::Vec3;

/// Points on each rim of a cylinder or cone, beside its lowest: on these it stands, and as soon as
/// it tilts, the lowest goes round. Between two of them it tips 8 % of the radius too early.
const RIM_POINTS: usize = 8;
/// Iterations that find the lowest point of a rim over a mesh; on a flat one the first does.
const SETTLE: usize = 4;

/// Deeper than this part of a sharp shape's inradius its nearest face need not be the one that was
/// entered: there only corners and vertices tell the way out. Up to it, that is so only within as
/// much of the border of a face. Found by trial: with a tenth as much, or ten times, depths of
/// overlaps are wrong.
pub(super) const SHALLOW: f64 = 0.01;

/// A contact that points the other way by more than this (cosine, 120°) does not hold a body where
/// another would.
const OPPOSITE: f64 = -0.5;
/// Points in one place whose normals are nearer than this (cosine of 2.6°, [`STANDING`]) hold the
/// same.
const ALONG: f64 = 0.999;

const POINT: u32 = 0;
const FACE: u32 = 1 << 28;
const EDGE: u32 = 2 << 28;
const VERTEX: u32 = 3 << 28;
pub(super) const CROSSING: u32 = 4 << 28;
/// Points of what lies deep in a mesh.
pub(super) const DEEP: u32 = 5 << 28;
const BEND: u32 = 6 << 28;
/// Mask of the bits that hold a feature's kind.
pub(super) const KIND: u32 = 7 << 28;
/// Set in the feature of a point that came from side B.
pub(super) const FROM_B: u32 = 1 << 31;

/// A mesh piece.
pub(crate) fn mesh_of(shape: &Shape) -> Option<&MeshShape> {
    match shape {
        Shape::Mesh(mesh) => Some(mesh),
        _ => None,
    }
}

/// Adds the contact points of any convex shape or half-space A against mesh B.
pub(crate) fn convex_on_mesh(
    a: &MovingPiece,
    b: &MovingPiece,
    reach: Reach,
    manifold: &mut Manifold,
) {
    let Some(mesh) = mesh_of(&b.piece.shape) else { return };
    let pair = Pair::new(a, b, reach);
    if matches!(pair.a.shape, Shape::HalfSpace) {
        reversed(manifold, |m| vertices(&Pair::new(b, a, reach), mesh, FROM_B, m));
        return;
    }
    if mesh_clear::is_clear(&pair, mesh) {
        return;
    }
    let first = manifold.points().len();
    points_of(&pair, mesh, manifold);
    let shallow = match pair.a.shape {
        Shape::Cuboid { .. } | Shape::Cylinder { .. } | Shape::Cone { .. } => {
            SHALLOW * inradius(pair.a.shape)
        }
        Shape::Sphere { .. }
        | Shape::Capsule { .. }
        | Shape::Ellipsoid { .. }
        | Shape::HalfSpace
        | Shape::Mesh(_)
        | Shape::Compound(_) => f64::INFINITY,
    };
    let deepest = faces(&pair, mesh, shallow, first, manifold);
    edges(&pair, mesh, shallow, manifold);
    if shallow < f64::INFINITY {
        reversed(manifold, |m| vertices(&Pair::new(b, a, reach), mesh, FROM_B, m));
        drop_beside(&[(&pair, FROM_B)], first, shallow, manifold);
        if manifold.points().len() == first {
            faces(&pair, mesh, f64::INFINITY, first, manifold);
        }
        drop_strays(first, shallow, manifold);
    }
    // What rests, to round-off, is no overlap.
    let deepest = deepest.filter(|face| face.gap < -pair.same);
    let told = &manifold.points()[first..];
    if told.is_empty() || deepest.is_some() && told.iter().all(|p| p.gap > -1e-3 * pair.same) {
        mesh_deep::find(&pair, deepest, manifold);
    }
    if pair.travel > reach.margin && shallow == f64::INFINITY {
        // What lies beyond the margin now.
        reversed(manifold, |m| vertices(&Pair::new(b, a, reach), mesh, FROM_B, m));
    }
}

/// Leaves out vertices of meshes from `first` on that are met along no normal of their mesh: beside
/// a box that stands on level triangles, or has its edge on a ridge of them, its distance points
/// sideways, and would hold it as if a step were in its way. What the mesh's surface does there
/// other points tell; what has got in and is held by no other stays. `pairs` are those of which B
/// has the vertices, and the flag of these.
fn drop_beside(pairs: &[(&Pair, u32)], first: usize, shallow: f64, manifold: &mut Manifold) {
    let is_upright = |p: &ManifoldPoint| {
        pairs.iter().all(|(pair, flag)| {
            // Normals are those of the pair whose B has the flag.
            let n_W = if *flag == FROM_B { p.normal_W } else { -p.normal_W };
            let q_W = p.position_W - 0.5 * p.gap * n_W;
            let is_vertex = p.feature & (KIND | FROM_B) == flag | VERTEX;
            !is_vertex || p.gap <= -shallow || pair.is_normal(&q_W, p.gap, &n_W, STANDING)
        })
    };
    let mut upright = [true; OFFERED_MAX];
    let points = &manifold.points()[first..];
    for (upright, p) in upright.iter_mut().zip(points) {
        *upright = is_upright(p);
    }
    let same = pairs[0].0.same;
    let is_slow = pairs[0].0.travel <= pairs[0].0.reach.margin;
    let holds = |p: &ManifoldPoint| {
        let others = points.iter().zip(&upright);
        let is_held = |(o, upright): (&ManifoldPoint, &bool)| {
            *upright && o.gap <= same && o.normal_W.dot(&p.normal_W) > OPPOSITE
        };
        if p.gap > 0.0 { !is_slow && p.gap > same } else { !others.into_iter().any(is_held) }
    };
    let mut stays = upright;
    for (stays, p) in stays.iter_mut().zip(points).filter(|(stays, _)| !**stays) {
        *stays = holds(p);
    }
    let mut stays = stays.into_iter();
    manifold.retain_from(first, |_| stays.next().unwrap_or(true));
}

/// Leaves out points from `first` on that are deep and would be let out by another face than the
/// deepest one: they have sunk in near the border of the face that was entered.
fn drop_strays(first: usize, shallow: f64, manifold: &mut Manifold) {
    let points = manifold.points()[first..].iter();
    let Some(deepest) = points.min_by(|a, b| a.gap.total_cmp(&b.gap)).copied() else { return };
    manifold.retain_from(first, |p| {
        p.gap >= -shallow || p.normal_W.dot(&deepest.normal_W) > std::f64::consts::FRAC_1_SQRT_2
    });
}

/// Adds the contact points of two meshes.
pub(crate) fn mesh_on_mesh(
    a: &MovingPiece,
    b: &MovingPiece,
    reach: Reach,
    manifold: &mut Manifold,
) {
    let (Some(mesh_a), Some(mesh_b)) = (mesh_of(&a.piece.shape), mesh_of(&b.piece.shape)) else {
        return;
    };
    let first = manifold.points().len();
    let (on_b, on_a) = (Pair::new(a, b, reach), Pair::new(b, a, reach));
    vertices(&on_b, mesh_a, 0, manifold);
    reversed(manifold, |m| vertices(&on_a, mesh_b, FROM_B, m));
    mesh_crossing::crossings([&on_b, &on_a], [mesh_a, mesh_b], manifold);
    let shallow = SHALLOW * a.piece.bounds.half().min().min(b.piece.bounds.half().min());
    drop_beside(&[(&on_b, FROM_B), (&on_a, 0)], first, shallow, manifold);
}

/// Two pieces, and how they move.
pub(super) struct Pair<'a> {
    pub a: Solid<'a>,
    pub b: Solid<'a>,
    pub movers: [&'a MovingPiece<'a>; 2],
    pub reach: Reach,
    /// Upper bound of the motion of points against each other in the step \[m\].
    pub travel: f64,
    /// A length of A below which places do not differ \[m\].
    pub same: f64,
}

impl<'a> Pair<'a> {
    pub fn new(a: &'a MovingPiece<'a>, b: &'a MovingPiece<'a>, reach: Reach) -> Self {
        let (pa, pb) = (a.side.placed, b.side.placed);
        let travel = reach.h * (pa.velocity - pb.velocity).norm() + pa.turn + pb.turn;
        let size = |m: &MovingPiece| match mesh_of(&m.piece.shape) {
            Some(_) => m.side.body.radius,
            None => inradius(&m.piece.shape),
        };
        let same = SAME * size(a).min(size(b));
        Self { a: a.at(0.0, 0.0), b: b.at(0.0, 0.0), movers: [a, b], reach, travel, same }
    }

    /// The constraint of a ball of A (centre `p_W`) against the distance of B, and its motion in
    /// the step.
    pub fn approach(&self, p_W: &Vec3, radius: f64) -> Option<Distance> {
        let p = self.b.shape_point(p_W);
        let limit = radius + self.reach.margin + self.travel;
        let now = self.b.shape.distance_within(&p, limit)?;
        let way = self.way(p_W);
        let found = approach_from(self.b.shape, &p, now, &way, radius, self.reach.margin)?;
        Some(Distance { gradient: self.b.rotation * found.gradient, ..found })
    }

    /// The way of a point of A in the step if it goes straight on, seen from B, in B's frame \[m\].
    pub fn way(&self, p_W: &Vec3) -> Vec3 {
        let [a, b] = self.movers.map(|m| m.side.placed.velocity_at(p_W));
        self.b.rotation.tr_mul(&(a - b)) * self.reach.h
    }

    /// A ball whose surface is A's.
    fn offer(&self, feature: u32, p_W: &Vec3, radius: f64, manifold: &mut Manifold) {
        let Some(found) = self.approach(p_W, radius) else { return };
        // The end of a capsule is a ball of which one half lies inside.
        let touching = p_W - radius * found.gradient;
        let round = matches!(self.a.shape, Shape::Capsule { .. });
        if !(round && self.a.distance(&touching).value < -1e-3 * self.same) {
            self.push_ball(feature, p_W, radius, &found, manifold);
        }
    }

    pub fn push_ball(
        &self,
        feature: u32,
        p_W: &Vec3,
        radius: f64,
        &Distance { value, gradient }: &Distance,
        manifold: &mut Manifold,
    ) {
        let position_W = p_W - (radius + 0.5 * value) * gradient;
        self.push(feature, position_W, gradient, value, manifold);
    }

    pub fn push(
        &self,
        feature: u32,
        position_W: Vec3,
        normal_W: Vec3,
        gap: f64,
        manifold: &mut Manifold,
    ) {
        let same = |p: &ManifoldPoint| {
            (p.position_W - position_W).norm() < self.same && p.normal_W.dot(&normal_W) > ALONG
        };
        if !manifold.points().iter().any(same) {
            manifold.offer(ManifoldPoint { feature, position_W, normal_W, gap });
        }
    }

    /// The box around the piece of A in the frame of B, with all that could touch it.
    pub fn around_a(&self) -> Aabb {
        let rotation = self.b.rotation.transpose() * self.a.rotation;
        let bounds =
            self.movers[0].piece.bounds.moved(&rotation, &self.b.shape_point(&self.a.origin));
        bounds.inflate(self.reach.margin + self.travel)
    }
}

/// Corners, rims, centres and lowest points of convex A.
fn points_of(pair: &Pair, mesh: &MeshShape, manifold: &mut Manifold) {
    let mut next = POINT;
    let mut offer = |p: Vec3, radius: f64| {
        pair.offer(next, &pair.a.world_point(&p), radius, manifold);
        next += 1;
    };
    let up = |y: f64| Vec3::y() * y;
    match pair.a.shape {
        Shape::Sphere { radius } => offer(Vec3::zeros(), *radius),
        Shape::Capsule { radius, half_length } => {
            offer(up(-half_length), *radius);
            offer(up(*half_length), *radius);
        }
        Shape::Cuboid { half } => corners(half).into_iter().for_each(|p| offer(p, 0.0)),
        Shape::Cylinder { radius, half_length } => {
            for y in [-half_length, *half_length] {
                rim(*radius, y, RIM_POINTS).for_each(|p| offer(p, 0.0));
                offer(lowest_on_rim(pair, mesh, *radius, y), 0.0);
            }
        }
        Shape::Cone { radius, height } => {
            offer(up(0.75 * height), 0.0);
            rim(*radius, -0.25 * height, RIM_POINTS).for_each(|p| offer(p, 0.0));
            offer(lowest_on_rim(pair, mesh, *radius, -0.25 * height), 0.0);
        }
        Shape::Ellipsoid { .. } => {
            let mut p = Vec3::zeros();
            for _ in 0..SETTLE {
                p = support(pair.a.shape, &-gradient_at(pair, mesh, &p), 0.0);
            }
            offer(p, 0.0);
        }
        Shape::HalfSpace | Shape::Mesh(_) | Shape::Compound(_) => {}
    }
}

/// Gradient of the mesh's distance at a point of A; all in the frame of A.
fn gradient_at(pair: &Pair, mesh: &MeshShape, p_A: &Vec3) -> Vec3 {
    let d = mesh.distance(&pair.b.shape_point(&pair.a.world_point(p_A)));
    pair.a.rotation.tr_mul(&(pair.b.rotation * d.gradient))
}

/// The point of a rim that looks most against the mesh's normal there.
fn lowest_on_rim(pair: &Pair, mesh: &MeshShape, radius: f64, y: f64) -> Vec3 {
    let mut p = Vec3::y() * y;
    for _ in 0..SETTLE {
        let g = gradient_at(pair, mesh, &p);
        let aside = Vec3::new(g.x, 0.0, g.z).try_normalize(1e-9).unwrap_or_else(Vec3::x);
        p = Vec3::y() * y - radius * aside;
    }
    p
}

/// The point of each near triangle that is nearest to A, where A's nearest point agrees. Returns
/// the deepest in A, whether or not it does. Points of this pair begin at `first`.
fn faces(
    pair: &Pair,
    mesh: &MeshShape,
    shallow: f64,
    first: usize,
    manifold: &mut Manifold,
) -> Option<DeepFace> {
    let mut deepest: Option<DeepFace> = None;
    let mut nearest: Option<DeepFace> = None;
    let around = pair.around_a().inflate(mesh.index.rounding);
    let (margin, rounding) = (pair.reach.margin, mesh.index.rounding);
    mesh.index.tree.overlapping(&around, |item| {
        let t = mesh.index.items[item as usize];
        let tri = mesh.triangles[t as usize].map(|v| mesh.points[v as usize]);
        if !Aabb::of_points(&tri).overlaps(&around) {
            return;
        }
        let tri = tri.map(|p| pair.a.shape_point(&pair.b.world_point(&p)));
        if pair.a.shape.least_over(&tri) > margin + rounding {
            return;
        }
        let weights = pair.a.shape.nearest_on_triangle(&tri);
        let q = weighted(&tri, &sharpened(pair.a.shape, &tri, weights));
        let d = pair.a.shape.distance(&q);
        let gap = d.value - rounding;
        let n_W = -(pair.a.rotation * d.gradient);
        let q_W = pair.a.world_point(&q) + rounding * n_W;
        // Of equally deep triangles the lowest index.
        if gap < deepest.map_or(0.0, |d| d.gap)
            || deepest.is_some_and(|d| (gap, t) < (d.gap, d.triangle))
        {
            deepest = Some(DeepFace { triangle: t, q_W, n_W, gap });
        }
        if gap > margin || gap <= -shallow {
            return;
        }
        let unknown = place_unknown(longest_edge(&tri));
        let (n_W, seen) = pair.seen_upright(&q_W, gap, n_W, unknown);
        // Of triangles that are equally near but for round-off the lowest index.
        let rank = |n: &DeepFace| ((n.gap / (1e-3 * pair.same)).round() as i64, n.triangle);
        let face = DeepFace { triangle: t, q_W, n_W, gap };
        if pair.is_normal_beside(&seen, &n_W) {
            pair.push(FACE | t, q_W + 0.5 * gap * n_W, n_W, gap, manifold);
        } else if seen.is_within(STANDING) && nearest.is_none_or(|n| rank(&face) < rank(&n)) {
            nearest = Some(face);
        }
    });
    // The nearest of all is one of both surfaces, however aslant it was found.
    let least = manifold.points()[first..].iter().map(|p| p.gap).fold(f64::INFINITY, f64::min);
    if let Some(DeepFace { triangle, q_W, n_W, gap }) = nearest.filter(|n| n.gap < least) {
        pair.push(FACE | triangle, q_W + 0.5 * gap * n_W, n_W, gap, manifold);
    }
    deepest
}

/// The ends of the part of each sharp edge that runs along a face of A.
fn edges(pair: &Pair, mesh: &MeshShape, shallow: f64, manifold: &mut Manifold) {
    if !matches!(pair.a.shape, Shape::Cuboid { .. } | Shape::Cylinder { .. } | Shape::Cone { .. }) {
        return;
    }
    if let Shape::Cuboid { half } = pair.a.shape {
        mesh_crossing::of_cuboid(pair, half, mesh, manifold);
    }
    along_edges(pair, mesh, &mesh.index.edges, EDGE, shallow, manifold);
    if matches!(pair.a.shape, Shape::Cylinder { .. } | Shape::Cone { .. }) {
        along_edges(pair, mesh, &mesh.index.bends, BEND, shallow, manifold);
    }
}

/// The ends of the part of each edge that runs along a face of A; of bends, along which faces and
/// vertices stand, the place where they cross a rim.
fn along_edges(
    pair: &Pair,
    mesh: &MeshShape,
    edges: &Edges,
    kind: u32,
    shallow: f64,
    manifold: &mut Manifold,
) {
    let around = pair.around_a().inflate(mesh.index.rounding);
    let (margin, rounding) = (pair.reach.margin, mesh.index.rounding);
    let flat = 1e-3 * pair.same;
    edges.tree.overlapping(&around, |e| {
        let MeshEdge { vertices, normals } = edges.list[e as usize];
        let ends = vertices.map(|v| mesh.points[v as usize]);
        if !Aabb::of_points(&ends).overlaps(&around) {
            return;
        }
        let ends = ends.map(|p| pair.a.shape_point(&pair.b.world_point(&p)));
        let (middle, length) = (0.5 * (ends[0] + ends[1]), (ends[1] - ends[0]).norm());
        if pair.a.shape.distance(&middle).value > margin + rounding + 0.5 * length {
            return;
        }
        let along = Along::of(pair.a.shape, ends, flat);
        if along.value - rounding > margin || along.value - rounding < -shallow {
            return;
        }
        // The way off the mesh, and whether it is one of its normals.
        let look = |along: &Along| {
            let n_W = -(pair.a.rotation * along.gradient);
            let q_W = pair.a.world_point(&along.lowest) + rounding * n_W;
            let unknown = place_unknown(length);
            let (n_W, seen) = pair.seen_upright(&q_W, along.value - rounding, n_W, unknown);
            (n_W, seen.is_within(STANDING))
        };
        let mut along = along;
        let (mut n_W, mut is_normal) = look(&along);
        if along.value < rounding && !is_normal {
            let out =
                pair.a.rotation.tr_mul(&(pair.b.rotation * (normals[0] + normals[1]).normalize()));
            // Clear of the shape, whose nearest face may lie aslant to the way.
            let way = 0.5 * shallow.min(inradius(pair.a.shape)) - 2.0 * along.value;
            along.draw_apart(pair.a.shape, ends, out, way);
            (n_W, is_normal) = look(&along);
        }
        if !is_normal {
            return;
        }
        along.gradient = -pair.a.rotation.tr_mul(&n_W);
        let ends = if kind == BEND { &[along.lowest][..] } else { &along.ends };
        for (k, q) in ends.iter().enumerate() {
            let gap = along.value + along.gradient.dot(&(q - along.lowest)) - rounding;
            let q_W = pair.a.world_point(q) + rounding * n_W;
            if gap <= margin {
                pair.push(kind | (2 * e) | k as u32, q_W + 0.5 * gap * n_W, n_W, gap, manifold);
            }
        }
    });
}

/// The vertices of mesh A near B against B's distance.
fn vertices(pair: &Pair, mesh: &MeshShape, flag: u32, manifold: &mut Manifold) {
    let index = &mesh.index;
    let mut offer = |i: u32| {
        let v = index.vertices[i as usize];
        let p_W = pair.a.world_point(&mesh.points[v as usize]);
        pair.offer(flag | VERTEX | v, &p_W, index.rounding, manifold);
    };
    if matches!(pair.b.shape, Shape::HalfSpace) {
        let up = pair.a.rotation.tr_mul(&pair.b.rotation.column(1).into_owned());
        let level = pair.a.shape_point(&pair.b.origin);
        // How far the plane itself may come.
        let placed = pair.movers[1].side.placed;
        let arm = (pair.a.origin - placed.center_of_mass).norm() + pair.movers[0].side.body.radius;
        let comes = pair.reach.h * placed.angular_velocity.norm() * arm;
        let height = up.dot(&level) + pair.reach.margin + pair.travel + comes + index.rounding;
        index.vertex_tree.below(&up, height, offer);
        return;
    }
    let rotation = pair.a.rotation.transpose() * pair.b.rotation;
    let around = pair.movers[1].piece.bounds.moved(&rotation, &pair.a.shape_point(&pair.b.origin));
    let around = around.inflate(pair.reach.margin + pair.travel + index.rounding);
    index.vertex_tree.overlapping(&around, |i| {
        if around.contains(&mesh.points[index.vertices[i as usize] as usize]) {
            offer(i);
        }
    });
}
