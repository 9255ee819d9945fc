//! Pairs of bodies that may have got deeper into each other than they were.
//!
//! No distance to a whole surface changes by more than its two sides have moved past each other;
//! depths along a way out that is kept may change by more, and are then seen a step later. Of
//! surfaces that is asked cluster by cluster: what has moved far past some part of a body lies
//! mostly far from it.

use crate::contact::aabb::Aabb;
use crate::contact::apart::SeparateTriangles;
use crate::contact::collector::KnownDepths;
use crate::contact::rigid_body::{Placed, RigidBody};
use crate::contact::surface::Surface;
use crate::contact::{RigidPlace, Shape};
use crate::math::{Mat3, Pose, Quat, Vec3};
use std::ops::Range;

/// Most clusters of a surface, or up to twice as many: all pairs of two surfaces' are gone through,
/// 16 000 boxes at most. Larger clusters are passed over less often, and each time cost a search.
const CLUSTERS_MAX: usize = 64;
/// Clusters of fewer triangles tell little more than these: four leaves of the tree.
const TRIANGLES_MIN: usize = 16;

/// Displacements of bodies since their contacts were found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Displacements<'a> {
    /// Poses of rigid bodies then.
    pub poses_WB: &'a [Pose],
    /// Displacements of the vertices of all surfaces \[m\].
    pub vertices: &'a [Vec3],
}

/// Motion of a rigid body.
#[derive(Clone, Copy, Debug)]
pub(super) struct RigidMove {
    /// Turns and moves what is at p now back to where it was: `turn p + offset`.
    turn: Mat3,
    offset: Vec3,
    /// Way of the centre of mass \[m\].
    way: Vec3,
    /// Most that turning adds to the way of the centre of mass \[m\].
    sweep: f64,
}

impl RigidMove {
    pub const NONE: Self = Self {
        turn: Mat3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        offset: Vec3::new(0.0, 0.0, 0.0),
        way: Vec3::new(0.0, 0.0, 0.0),
        sweep: 0.0,
    };

    pub fn new(body: &RigidBody, from: &Pose, to: &Pose) -> Self {
        let turn = (from.rotation * to.rotation.inverse()).to_rotation_matrix().into_inner();
        Self {
            turn,
            offset: from.position - turn * to.position,
            way: to.position - from.position,
            sweep: to.rotation.angle_to(&from.rotation) * body.radius,
        }
    }

    /// Returns an upper bound of the distance that two bodies have moved past each other \[m\].
    pub fn past(&self, other: &Self) -> f64 {
        (self.way - other.way).norm() + self.sweep + other.sweep
    }

    /// Returns the distance by which a point, now at `p` after the way `way`, has moved past the
    /// body \[m\].
    fn past_point(&self, p: &Vec3, way: &Vec3) -> f64 {
        let carried = p - (self.turn * p + self.offset);
        (way - carried).norm()
    }
}

/// Triangles that lie together.
#[derive(Clone, Debug)]
struct Cluster {
    /// Node of the surface's tree.
    node: usize,
    /// Part of the list of vertices.
    vertices: Range<usize>,
    /// Box around the vertices.
    bounds: Aabb,
    /// Box around the ways that the vertices went.
    ways: Aabb,
}

/// All triangles of a surface.
#[derive(Clone, Debug)]
pub(super) struct Clusters {
    list: Vec<Cluster>,
    vertices: Vec<u32>,
}

impl Clusters {
    pub fn new(surface: &Surface) -> Self {
        let most = surface.triangles.len().div_ceil(CLUSTERS_MAX).max(TRIANGLES_MIN);
        let mut clusters = Self { list: Vec::new(), vertices: Vec::new() };
        let mut open = if surface.triangles.is_empty() { vec![] } else { vec![0] };
        while let Some(node) = open.pop() {
            let mut triangles = Vec::new();
            gather(surface, node, &mut triangles);
            match surface.tree.children(node) {
                Ok(halves) if triangles.len() > most => open.extend(halves),
                _ => clusters.push(surface, node, &triangles),
            }
        }
        clusters
    }

    fn push(&mut self, surface: &Surface, node: usize, triangles: &[u32]) {
        let corners = triangles.iter().flat_map(|&t| surface.triangles[t as usize]);
        let mut vertices: Vec<u32> = corners.collect();
        vertices.sort_unstable();
        vertices.dedup();
        let first = self.vertices.len();
        self.vertices.extend(vertices);
        let vertices = first..self.vertices.len();
        self.list.push(Cluster { node, vertices, bounds: Aabb::EMPTY, ways: Aabb::EMPTY });
    }

    /// Takes vertices as they are, and the ways that they went.
    pub fn fit(&mut self, positions: &[Vec3], ways: &[Vec3]) {
        let Self { list, vertices } = self;
        for cluster in list {
            (cluster.bounds, cluster.ways) = (Aabb::EMPTY, Aabb::EMPTY);
            for &v in &vertices[cluster.vertices.clone()] {
                cluster.bounds = cluster.bounds.with(&positions[v as usize]);
                cluster.ways = cluster.ways.with(&ways[v as usize]);
            }
        }
    }
}

/// The triangles below a node of the tree.
fn gather(surface: &Surface, node: usize, into: &mut Vec<u32>) {
    match surface.tree.children(node) {
        Err(items) => into.extend(items),
        Ok(halves) => halves.into_iter().for_each(|half| gather(surface, half, into)),
    }
}

impl Aabb {
    /// The largest difference of two points along each axis, one in each of the boxes.
    fn span(&self, other: &Self) -> Vec3 {
        let (ahead, behind) = (self.max - other.min, other.max - self.min);
        Vec3::new(ahead.x.max(behind.x), ahead.y.max(behind.y), ahead.z.max(behind.z))
    }
}

/// Displacements of bodies, and what is known of their depths.
#[derive(Clone, Copy)]
pub(super) struct Since<'a> {
    pub rigids: &'a [RigidMove],
    /// Poses of rigid bodies before and now.
    pub ends: (&'a [Pose], &'a [RigidPlace]),
    /// Ways of the vertices of all surfaces \[m\].
    pub vertices: &'a [Vec3],
    pub known: KnownDepths<'a>,
}

impl Since<'_> {
    /// Returns an upper bound of the distance that two rigid bodies have moved past each other
    /// \[m\].
    pub fn past(&self, i: u32, j: u32) -> f64 {
        self.rigids[i as usize].past(&self.rigids[j as usize])
    }

    /// Returns the pose of a rigid body after this part of its way.
    pub fn place(&self, i: u32, s: f64) -> RigidPlace {
        let (from, to) = (&self.ends.0[i as usize], &self.ends.1[i as usize].pose_WB);
        let turn = (to.rotation * from.rotation.inverse()).scaled_axis();
        let rotation = Quat::from_scaled_axis(s * turn) * from.rotation;
        let pose_WB = Pose::new(from.position + s * (to.position - from.position), rotation);
        RigidPlace { pose_WB, velocity_W: Vec3::zeros(), angular_velocity_W: Vec3::zeros() }
    }

    /// True when some point of a rigid body may have moved by more than this \[m\].
    pub fn goes_farther(&self, i: u32, way: f64) -> bool {
        let of = &self.rigids[i as usize];
        of.way.norm() + of.sweep > way
    }

    /// Box around a rigid body on its way.
    pub fn swept(&self, i: u32, body: &RigidBody, at: &Placed) -> Aabb {
        let (of, way) = (&self.rigids[i as usize], &self.rigids[i as usize].way);
        match body.shape {
            Shape::HalfSpace => at.swept_W,
            _ => at.swept_W.union(&at.swept_W.translate(&-way)).inflate(of.sweep),
        }
    }

    /// True when a vertex of a surface that is near to a rigid body, and that body, have moved past
    /// each other by more than the slack. `positions` are those of all vertices.
    pub fn may_deepen_in(
        &self,
        surface: &Surface,
        positions: &[Vec3],
        (body, placed, rigid): (&RigidBody, &Placed, usize),
    ) -> bool {
        let known = &self.known;
        let depth = known.of_soft(surface.soft).min(known.of_rigid(rigid as u32)) + known.slack;
        let reach = surface.depth_max() + depth;
        let is_plane = matches!(body.shape, Shape::HalfSpace);
        let vertices = surface.part(positions).iter().zip(surface.part(self.vertices));
        vertices.enumerate().any(|(v, (p, way))| {
            let near = match is_plane {
                true => placed.shape_point(p).y <= 0.0,
                // Of a triangle that reaches the shape some corner is no farther than its edge.
                false => placed.swept_W.inflate(reach + surface.edge_around[v]).contains(p),
            };
            near && self.rigids[rigid].past_point(p, way) > known.slack
        })
    }

    /// True when two surfaces, or two parts of one, have moved past each other by more than the
    /// slack where they are near to each other.
    pub fn may_deepen(
        &self,
        sides: [(&Surface, &Clusters); 2],
        apart: Option<&SeparateTriangles>,
    ) -> bool {
        let known = &self.known;
        let [a, b] = sides.map(|(surface, _)| known.of_soft(surface.soft));
        let [depth, other] = sides.map(|(surface, _)| surface.depth_max());
        let reach = depth.max(other) + a.min(b) + known.slack;
        let [(_, a), (_, b)] = sides;
        a.list.iter().any(|of_a| {
            let around = of_a.bounds.inflate(reach);
            b.list.iter().any(|of_b| {
                around.overlaps(&of_b.bounds)
                    && of_a.ways.span(&of_b.ways).norm() > known.slack
                    && !apart.is_some_and(|apart| apart.are_settled(of_a.node, of_b.node))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::tests::{Scene, boxed, cube, moved};
    use crate::contact::{Detector, SearchReport, SeenSides, SurfaceState};
    use crate::model::Motion;
    use crate::random::Random;

    const SLACK: f64 = 5e-4;

    /// A plane, a box and two soft cubes beside and upon each other.
    fn scene() -> Scene {
        let mut scene = Scene::new();
        scene.rigid(Motion::Prescribed, Shape::HalfSpace, Pose::identity());
        scene.rigid(Motion::Dynamic, boxed(0.02), Pose::translation(0.041, 0.021, 0.0));
        for y in [0.0205, 0.061] {
            let soft = scene.soft(cube(0.04, 4));
            moved(&mut scene.surfaces[soft as usize].0, Vec3::new(0.0, y, 0.0));
        }
        scene
    }

    fn search(after: &Scene, since: Option<&Scene>) -> SearchReport {
        let all = |scene: &Scene| -> Vec<Vec3> {
            scene.surfaces.iter().flat_map(|surface| surface.0.clone()).collect()
        };
        let positions = all(after);
        let velocities = vec![Vec3::zeros(); positions.len()];
        let states = SurfaceState { positions: &positions, velocities: &velocities };
        let poses: Vec<Pose> = since.iter().flat_map(|s| &s.places).map(|p| p.pose_WB).collect();
        let from = since.map_or_else(Vec::new, all);
        let ways: Vec<Vec3> = positions.iter().zip(&from).map(|(x, x0)| x - x0).collect();
        let moved = since.map(|_| Displacements { poses_WB: &poses, vertices: &ways });
        let known = KnownDepths { slack: SLACK, ..KnownDepths::default() };
        let mut detector = Detector::new(&after.desc);
        detector.measure(&after.places, states, &SeenSides::default(), known, moved)
    }

    /// Bodies that part, meet, turn and bend from where none overlaps: what a whole search finds is
    /// found, of pairs that are often fewer.
    #[test]
    fn what_has_got_deeper_is_looked_at() {
        let (mut random, mut deeper, mut fewer) = (Random::new(3), 0, 0);
        let before = scene();
        assert_eq!(search(&before, None).penetration, 0.0);
        for i in 0..300 {
            let mut after = scene();
            let far = if i % 3 == 0 { 4e-4 } else { 3e-3 };
            let place = &mut after.places[1].pose_WB;
            place.position += random.vector(far);
            place.rotation = Quat::from_scaled_axis(random.vector(20.0 * far));
            for (points, _) in &mut after.surfaces {
                let (way, bend) = (random.vector(far), random.vector(10.0 * far));
                points.iter_mut().for_each(|p| *p += way + bend * p.x);
            }
            let (all, some) = (search(&after, None), search(&after, Some(&before)));
            assert_eq!(some.penetration, all.penetration, "{i}");
            deeper += u32::from(all.penetration > 0.0);
            fewer += u32::from(some.pairs < all.pairs);
        }
        assert!(deeper > 100 && fewer > 100, "{deeper} {fewer}");
    }

    /// Overlaps of which nothing is known, in bodies that turn and move as one.
    #[test]
    fn what_moves_as_one_is_not_looked_at() {
        let mut before = scene();
        before.places[1].pose_WB.position.x -= 2e-3;
        moved(&mut before.surfaces[1].0, -2e-3 * Vec3::y());
        let mut after = scene();
        let by = Pose::new(Vec3::new(1e-3, 3e-3, -2e-3), Quat::from_scaled_axis(Vec3::y() * 2e-3));
        let still = after.places[0];
        after.places.iter_mut().zip(&before.places).for_each(|(place, from)| {
            place.pose_WB = by * from.pose_WB;
        });
        after.places[0] = still;
        for ((points, _), (from, _)) in after.surfaces.iter_mut().zip(&before.surfaces) {
            points.iter_mut().zip(from).for_each(|(p, p0)| *p = by.point(p0));
        }
        assert!(search(&after, None).penetration > 1e-3);
        assert_eq!(search(&after, Some(&before)).pairs, 0);
    }
    /// A plate that falls across another and is through it at the end of the step, where nothing
    /// overlaps: some look on the way finds it at least half as deep as it is thick, and no deeper
    /// than that and its tilt over the other's half width make it. One that passes by 1 mm is not
    /// found.
    #[test]
    fn thin_plates_that_came_through_each_other_are_seen() {
        for thickness in [4e-4, 3e-3] {
            let half = 0.5 * thickness;
            let scene = |x: f64, height: f64, tilt: f64| {
                let mut scene = Scene::new();
                let [below, above] = [Vec3::new(0.03, half, 0.045), Vec3::new(0.045, half, 0.03)];
                scene.rigid(Motion::Prescribed, Shape::Cuboid { half: below }, Pose::identity());
                let turn = Quat::from_scaled_axis(Vec3::z() * tilt);
                let pose = Pose::new(Vec3::new(x, height, 0.0), turn);
                scene.rigid(Motion::Dynamic, Shape::Cuboid { half: above }, pose);
                scene
            };
            for far in [3.0, 10.0] {
                let [before, after] = [(far, 0.01), (-far, 0.02)]
                    .map(|(up, tilt)| (up * thickness + up.signum() * 0.045 * tilt, tilt));
                let at = |x: f64, (height, tilt): (f64, f64)| scene(x, height, tilt);
                let (before_here, here) = (at(0.0, before), at(0.0, after));
                assert_eq!(search(&here, None).penetration, 0.0);
                let depth = search(&here, Some(&before_here)).penetration;
                let most = 1.01 * (thickness + 0.03 * 0.02);
                assert!(depth > half && depth <= most, "{thickness} {far}: {depth}");
                let (before_beside, beside) = (at(0.076, before), at(0.076, after));
                assert_eq!(search(&beside, Some(&before_beside)).penetration, 0.0);
            }
        }
    }
}
