//! Sharp straight edges of a rigid shape across the edges of a deformable surface.
//!
//! ```text
//!        shape                 An edge that lies on a triangle is held where it comes in and where it goes out:
//!     ______________           at the edges of the triangle (x), or at its own ends (o). As it moves, these
//!    |              |          places move along with it, and one that leaves an edge of the surface at a
//!  __|______________|__        vertex goes on from there along the next.
//!    o--x----x---x--o
//! ```
//!
//! Flesh is smooth, its triangles are how it is stored: at such a place the normal is that of the
//! smooth surface. Where the surface has an edge of its own, as a block does, the two edges have
//! one normal, square to both.

use crate::contact::aabb::Aabb;
use crate::contact::blunt::way_to;
use crate::contact::bvh::Bvh;
use crate::contact::near::Near;
use crate::contact::ridge::{PARALLEL, Ridge, crossing, passing};
use crate::contact::soft_feature::{Touch, depth_max, is_free};
use crate::contact::soft_rigid::{KEY_EDGE, SoftRigid};
use crate::contact::soft_round::Touches;
use crate::contact::triangle::{Closest, Feature};
use crate::math::{Pose, Vec3};
use std::cell::OnceCell;

/// Sine of the angle between faces that count as one.
const FLAT: f64 = 1e-6;

/// A straight edge of a rigid shape that sticks out between two faces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    ends: [Vec3; 2],
    ridge: Ridge,
}

/// Edges, and a tree over them.
#[derive(Clone, Debug)]
pub(crate) struct Edges {
    list: Vec<Edge>,
    tree: Bvh,
}

impl Edge {
    /// `None` where the faces have one direction or opposite ones: the border of a sheet has no two
    /// sides.
    pub fn between(ends: [Vec3; 2], [n, m]: [Vec3; 2]) -> Option<Self> {
        let fall = |own: Vec3, other: Vec3| (own * own.dot(&other) - other).try_normalize(FLAT);
        let ridge = Ridge { falls: [fall(n, m)?, fall(m, n)?], outward: n + m };
        Some(Self { ends, ridge })
    }

    /// From the frame of a part to that of the shape.
    pub fn placed(&self, pose_SP: &Pose) -> Self {
        let Ridge { falls, outward } = self.ridge;
        let ridge = Ridge {
            falls: falls.map(|fall| pose_SP.vector(&fall)),
            outward: pose_SP.vector(&outward),
        };
        Self { ends: self.ends.map(|p| pose_SP.point(&p)), ridge }
    }

    /// The unit vector that is nearest to `n` among the normals of planes that rest on the edge;
    /// others cut a face.
    fn within_faces(&self, n: Vec3) -> Vec3 {
        let falls = self.ridge.falls.iter();
        falls.fold(n, |n, fall| n - fall * fall.dot(&n).max(0.0)).normalize()
    }
}

impl Edges {
    pub fn new(list: Vec<Edge>) -> Self {
        let boxes: Vec<Aabb> = list.iter().map(|e| Aabb::of_points(&e.ends)).collect();
        Self { tree: Bvh::build(&boxes), list }
    }
}

/// Lets the edges that a triangle answers for touch those of the shape.
pub(crate) fn meet_edges(pair: &SoftRigid, near: &Near, touches: &mut Touches) {
    let edges = &pair.body.sharp.edges;
    if edges.list.is_empty() {
        return;
    }
    let reach = depth_max(pair);
    for k in (0..3).filter(|&k| pair.surface.owns(near.index, Feature::Edge(k))) {
        let ends = [near.x[k], near.x[(k + 1) % 3]];
        let own = SkinEdge { near, k, ends, up: OnceCell::new() };
        let is_crease = pair.surface.is_crease(near.index, k);
        edges.tree.overlapping(&Aabb::of_points(&own.ends).inflate(reach), |e| {
            let found = match is_crease {
                true => on_crease(pair, &own, e, reach),
                false => on_skin(pair, &own, e, reach),
            };
            found.into_iter().for_each(|touch| touches.offer(touch));
        });
    }
}

/// Edge `k` of a triangle, in the shape frame.
struct SkinEdge<'a> {
    near: &'a Near,
    k: usize,
    ends: [Vec3; 2],
    /// The unit normal between its faces, once it is wanted.
    up: OnceCell<Vec3>,
}

impl SkinEdge<'_> {
    fn up(&self, pair: &SoftRigid) -> Vec3 {
        let feature = Feature::Edge(self.k);
        let up_W = || pair.surface.pseudonormal(self.near.index, feature, pair.state.positions);
        *self.up.get_or_init(|| pair.placed.rotation.tr_mul(&up_W()))
    }

    /// Weights of the point at part `at` of the edge.
    fn weights(&self, at: f64) -> [f64; 3] {
        let mut weights = [0.0; 3];
        (weights[self.k], weights[(self.k + 1) % 3]) = (1.0 - at, at);
        weights
    }

    fn point(&self, at: f64) -> Vec3 {
        point_of(&self.ends, at)
    }

    /// The place nearest to `q` on the triangles beside the edge, and its triangle.
    fn closest(&self, pair: &SoftRigid, q: &Vec3) -> (u32, Closest) {
        let own = (self.near.index, self.near.closest(q));
        let Some(t) = pair.surface.across(own.0, self.k) else { return own };
        let other = (t, Near::new(pair, t).closest(q));
        if other.1.distance_squared < own.1.distance_squared { other } else { own }
    }

    /// True when a point `depth` \[m\] below the edge is nearer to no other triangle around its
    /// ends: so is every point that is not deep.
    fn is_way_out(&self, pair: &SoftRigid, q: &Vec3, depth: f64) -> bool {
        let surface = pair.surface;
        let corners = surface.triangles[self.near.index as usize];
        let around = [self.k, (self.k + 1) % 3].map(|k| surface.around(corners[k]));
        let least = depth - surface.entered();
        let is_nearer = |&t: &u32| Near::new(pair, t).closest(q).distance_squared < least * least;
        !surface.is_deep(depth) || !around.into_iter().flatten().any(is_nearer)
    }
}

fn point_of(ends: &[Vec3; 2], at: f64) -> Vec3 {
    ends[0] + (ends[1] - ends[0]) * at
}

/// Contact of an edge with one within a smooth surface, where they cross as seen along the
/// surface's normal there. Unlike the places at which two lines are nearest, such a place lies over
/// the surface however nearly parallel they are.
fn on_skin(pair: &SoftRigid, own: &SkinEdge, e: u32, reach: f64) -> Option<Touch> {
    let edge = &pair.body.sharp.edges.list[e as usize];
    let ([at, along], height) = seen_along(&own.up(pair), &own.ends, &edge.ends)?;
    if height.abs() > reach {
        return None;
    }
    let (p, q) = (own.point(at), point_of(&edge.ends, along));
    let weights = own.weights(at);
    let x = pair.state.positions;
    let smooth_W = pair.surface.smooth_normal(own.near.index, &weights, x);
    let outward = pair.placed.rotation.tr_mul(&smooth_W);
    if outward.dot(&edge.ridge.outward) >= 0.0 {
        return None;
    }
    let outward = -edge.within_faces(-outward);
    let length = pair.surface.edge_within(own.near.index, &weights);
    touch(pair, own, e, (&p, &q), height, |way, gap| way_to(way, gap, &outward, length))
}

/// Parts of `a` and `b` at which the edges cross, and how far b lies above a there, seen along the
/// unit vector `up`.
fn seen_along(up: &Vec3, a: &[Vec3; 2], b: &[Vec3; 2]) -> Option<([f64; 2], f64)> {
    let (u, v, w) = (a[1] - a[0], b[1] - b[0], b[0] - a[0]);
    let across = u.cross(&v);
    let area = across.dot(up);
    if area * area <= PARALLEL * u.norm_squared() * v.norm_squared() {
        return None;
    }
    let at = [w.cross(&v).dot(up) / area, w.cross(&u).dot(up) / area];
    let height = w.dot(&across) / area;
    at.iter().all(|s| (0.0..=1.0).contains(s)).then_some((at, height))
}

/// Contact of an edge with one that the surface had at rest.
fn on_crease(pair: &SoftRigid, own: &SkinEdge, e: u32, reach: f64) -> Option<Touch> {
    let edge = &pair.body.sharp.edges.list[e as usize];
    let passing = passing(&own.ends, &edge.ends, reach)?;
    let ridge_W = Ridge::of(pair.surface, own.near.index, own.k, pair.state.positions)?;
    let to_shape = |v_W: Vec3| pair.placed.rotation.tr_mul(&v_W);
    let ridge = Ridge { falls: ridge_W.falls.map(to_shape), outward: to_shape(ridge_W.outward) };
    let found = crossing(&passing, &ridge, &edge.ridge)?;
    let (p, q) = (own.point(found.at[0]), point_of(&edge.ends, found.at[1]));
    touch(pair, own, e, (&p, &q), found.gap, |_, _| found.normal)
}

/// Place `p` of the surface's edge touches place `q` on edge `e` of the shape, unless that has not
/// come in there: `height` tells by its sign on which side of the surface q lies, `normal` gives
/// the direction for a way to the surface and a gap.
fn touch(
    pair: &SoftRigid,
    own: &SkinEdge,
    e: u32,
    (p, q): (&Vec3, &Vec3),
    height: f64,
    normal: impl FnOnce(&Vec3, f64) -> Vec3,
) -> Option<Touch> {
    let (triangle, closest) = own.closest(pair, q);
    let gap = closest.distance_squared.sqrt().copysign(height);
    if gap > pair.margin {
        return None;
    }
    let has_come_in = || {
        !is_free(pair, p, (p - q).norm(), gap)
            && own.is_way_out(pair, q, -gap)
            && pair.surface.holds_behind(&pair.placed.world_point(q), -gap, pair.state.positions)
    };
    (gap >= 0.0 || has_come_in()).then(|| Touch {
        key: [KEY_EDGE | e, 3 * own.near.index + own.k as u32],
        triangle,
        weights: closest.weights,
        sharp: Some(*q),
        normal: normal(&(closest.point - q), gap),
        gap,
    })
}

#[cfg(test)]
mod tests {
    use crate::contact::tests::{Scene, boxed, cube};
    use crate::contact::{Contact, Shape};
    use crate::math::{Pose, Quat, Vec3};
    use crate::model::Motion;

    /// A cushion of triangles with edges of some 7 mm, 60 mm across, its top at the origin.
    fn cushion() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let (mut points, triangles) = cube(0.04, 6);
        let round = |p: &Vec3| p.normalize() * 0.03 - Vec3::y() * 0.03;
        points.iter_mut().for_each(|p| *p = round(p));
        (points, triangles)
    }

    fn find(shape: &Shape, pose: Pose, surface: (Vec<Vec3>, Vec<[u32; 3]>)) -> Vec<Contact> {
        let mut scene = Scene::new();
        scene.rigid(Motion::Dynamic, shape.clone(), pose);
        scene.soft(surface);
        scene.find(1e-3)
    }

    /// The lower edge of a box that stands on it, over the cushion: gap and direction of what is
    /// nearest to touching go along with it, wherever the edge lies beside the vertices, and
    /// however it lies to the edges of the surface.
    #[test]
    fn an_edge_goes_over_a_cushion_without_jumps() {
        let bar = Shape::Cuboid { half: Vec3::new(0.05, 0.005, 0.005) };
        let low = 0.005 * std::f64::consts::SQRT_2;
        for turn in [0.0, 1e-6, 0.1, 0.785] {
            let upright = Quat::from_scaled_axis(Vec3::x() * std::f64::consts::FRAC_PI_4);
            let turned = Quat::from_scaled_axis(Vec3::y() * turn) * upright;
            let least = |k: i32| {
                let aside = turned * Vec3::new(0.0, 1.0, 1.0).normalize() * (2e-5 * f64::from(k));
                let at = Vec3::new(aside.x, low - 2e-5, aside.z);
                let found = find(&bar, Pose::new(at, turned), cushion());
                let least = found.into_iter().min_by(|a, b| a.gap.total_cmp(&b.gap));
                least.expect("it touches")
            };
            let mut before = least(-40);
            for k in -39..=40 {
                let now = least(k);
                // Facets of 7 mm slope by 7 in 60 about a cushion that slopes by 2 in 30.
                assert!(
                    (now.gap - before.gap).abs() < 5e-6,
                    "{turn} {k}: {} {}",
                    before.gap,
                    now.gap
                );
                // What bears changes places, and up is up.
                let turned = now.normal_W.angle(&before.normal_W);
                assert!(turned < 0.12 && now.normal_W.y < -0.98, "{turn} {k}: {turned}");
                before = now;
            }
        }
    }

    /// Only the ends and the crossings of an edge between the corners of a large triangle touch,
    /// and each crossing is as deep as the edge is there.
    #[test]
    fn crossings_are_as_deep_as_the_edge_lies() {
        let wedge = Shape::Cuboid { half: Vec3::new(0.03, 0.004, 0.004) };
        let upright = Quat::from_scaled_axis(Vec3::x() * std::f64::consts::FRAC_PI_4);
        let low = 0.004 * std::f64::consts::SQRT_2;
        let tilt = 0.02_f64;
        for depth in [-2e-4, 0.0, 1e-5, 5e-5] {
            let turned = Quat::from_scaled_axis(Vec3::z() * tilt) * upright;
            let at = Vec3::new(0.001, 0.02 - depth, 0.0007)
                + turned * Vec3::new(0.0, 1.0, -1.0).normalize() * low;
            let found = find(&wedge, Pose::new(at, turned), cube(0.04, 4));
            let edge = |x: f64| 0.02 - depth + tilt.tan() * (x - 0.001);
            let is_on = |c: &&Contact| {
                let p = c.position_W;
                p.x.abs() < 0.0195 && (p.y - edge(p.x)).abs() < 2e-6
            };
            let crossings: Vec<_> = found.iter().filter(is_on).collect();
            assert!(!crossings.is_empty(), "{depth}");
            for c in crossings {
                // The top of the cube is flat: its height above that.
                let height = c.position_W.y - 0.02;
                assert!((c.gap - height).abs() < 1e-12, "{depth}: {} {height}", c.gap);
                let straight = c.normal_W.angle(&-Vec3::y()) < 1e-9 || c.gap > 0.0;
                assert!(straight, "{depth}: {}", c.normal_W);
            }
        }
    }

    /// A block of flesh that lies across the edge of a table: its own edges are held straight up,
    /// too.
    #[test]
    fn creases_that_lie_on_an_edge_are_held_square_to_both() {
        for cells in [1, 2, 5] {
            let (points, triangles) = cube(0.04, cells);
            let table = boxed(0.05);
            let at = Vec3::new(0.05 - 0.0013, -0.05 - 0.02 + 1e-5, 0.003);
            let found = find(&table, Pose::new(at, Quat::identity()), (points, triangles));
            let on_creases: Vec<_> =
                found.iter().filter(|c| (c.position_W.z.abs() - 0.02).abs() < 1e-9).collect();
            let at_edge = on_creases.iter().filter(|c| (c.position_W.x + 0.0013).abs() < 1e-9);
            assert_eq!(at_edge.count(), 2, "{cells}");
            for c in found {
                assert!(c.normal_W.angle(&Vec3::y()) < 1e-9, "{cells}: {c:?}");
                // Where they cross, the edge of the table lies in the side of the block.
                assert!((-1e-5 - 1e-12..1e-12).contains(&c.gap), "{cells}: {c:?}");
            }
        }
    }
}
