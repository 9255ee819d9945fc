//! Exact signed distance to a triangle mesh: the nearest triangle by a tree of boxes, the side by
//! angle-weighted pseudo-normals (Bærentzen and Aanæs, Signed distance computation using the
//! angle weighted pseudonormal, 2005).
//!
//! Pieces that share no edge are asked one by one, and the piece in which a point lies deepest, or
//! which is nearest, answers: so pieces that overlap are one body. A cavity belongs to the piece
//! around it. Where a piece is open, pseudo-normals tell the side near it and the grid far from it.

use crate::contact::DistanceGrid;
use crate::contact::aabb::Aabb;
use crate::contact::bvh::Bvh;
use crate::contact::triangle::{Closest, Feature, area_vector, closest_on_triangle};
use crate::math::Vec3;

/// An edge of the mesh that is not flat.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshEdge {
    pub vertices: [u32; 2],
    /// Outward normals of the faces beside it (twice the same at a border).
    pub normals: [Vec3; 2],
}

/// Index for queries of a mesh.
#[derive(Clone, Default)]
pub(crate) struct MeshIndex {
    pub tree: Bvh,
    /// Triangle of each item of the tree, in the order of its leaves; those without area are left
    /// out.
    pub items: Vec<u32>,
    /// Corners of each item.
    pub(super) corners: Vec<[Vec3; 3]>,
    /// Unit normal per triangle.
    pub face_normals: Vec<Vec3>,
    /// Pseudo-normals of the edges of each triangle, edge k from corner k to corner k + 1.
    edge_normals: Vec<[Vec3; 3]>,
    /// Pseudo-normals per vertex, weighted by angle.
    vertex_normals: Vec<Vec3>,
    /// The pieces: number, box and node of each.
    pub(super) pieces: Vec<(u32, Aabb, u32)>,
    /// True for each piece that is closed.
    pub(super) closed: Vec<bool>,
    /// Edges whose faces differ in direction by more than `SHARP`.
    pub edges: Edges,
    /// Edges that stick out by less, numbered after those.
    pub bends: Edges,
    /// Vertices of triangles, and a tree over them.
    pub vertices: Vec<u32>,
    pub vertex_tree: Bvh,
    /// Half the thickness of a shell, zero for a solid \[m\].
    pub rounding: f64,
    /// True when all pieces are closed, or all are shells: where one is open, sides may change in
    /// free air.
    pub(super) is_solid: bool,
    /// Longest side of the box around the mesh \[m\].
    pub(super) size: f64,
}

/// Edges, and a tree over them.
#[derive(Clone, Default)]
pub(crate) struct Edges {
    pub list: Vec<MeshEdge>,
    /// Number of the first.
    pub first: u32,
    pub tree: Bvh,
    /// Length of the longest \[m\].
    pub longest: f64,
}

impl Edges {
    fn plant(&mut self, points: &[Vec3]) {
        let length = |e: &MeshEdge| {
            let [from, to] = e.vertices.map(|v| points[v as usize]);
            (to - from).norm()
        };
        self.longest = self.list.iter().map(length).fold(0.0, f64::max);
        let ends = |e: &MeshEdge| Aabb::of_points(&e.vertices.map(|v| points[v as usize]));
        self.tree = Bvh::build(&self.list.iter().map(ends).collect::<Vec<_>>());
    }
}

impl std::fmt::Debug for MeshIndex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MeshIndex").field("triangles", &self.items.len()).finish_non_exhaustive()
    }
}

/// Cosine of the bend from which an edge is an edge, 5°. Below it the surface is taken as smooth:
/// faces of bodies touch it within its own, and only their edges and rims touch it at bends.
const SHARP: f64 = 0.996_194_698_091_745_5;
/// Cosine of the bend from which a sharp edge that lies across can sink in beside the vertices,
/// 8e-4 rad: by a ten-thousandth of the edge, an eighth of its bend.
const LEVEL: f64 = 1.0 - 3.2e-7;

impl MeshIndex {
    /// Prepares triangles; those that are degenerate or name missing points are left out.
    pub fn new(points: &[Vec3], triangles: &[[u32; 3]], grid: &DistanceGrid) -> Self {
        let corners = |t: u32| triangles[t as usize].map(|v| points[v as usize]);
        let sound = |t: &u32| {
            let inside = triangles[*t as usize].iter().all(|&v| (v as usize) < points.len());
            inside && area_vector(&corners(*t)).norm() > 0.0
        };
        let items: Vec<u32> = (0..triangles.len() as u32).filter(sound).collect();
        let mut index = Self {
            face_normals: vec![Vec3::zeros(); triangles.len()],
            edge_normals: vec![[Vec3::zeros(); 3]; triangles.len()],
            vertex_normals: vec![Vec3::zeros(); points.len()],
            ..Self::default()
        };
        for &t in &items {
            let x = corners(t);
            let normal = area_vector(&x).normalize();
            index.face_normals[t as usize] = normal;
            for k in 0..3 {
                let (to, from) = (x[(k + 1) % 3] - x[k], x[(k + 2) % 3] - x[k]);
                let angle = to.cross(&from).norm().atan2(to.dot(&from));
                index.vertex_normals[triangles[t as usize][k] as usize] += angle * normal;
            }
        }
        let mut pieces = PieceSets::new(triangles.len());
        let open = index.join_edges(triangles, &items, points, &mut pieces);
        let boxes: Vec<Aabb> = items.iter().map(|&t| Aabb::of_points(&corners(t))).collect();
        pieces.hold_cavities(&items, &boxes, &corners);
        let group: Vec<u32> = items.iter().map(|&t| pieces.of(t)).collect();
        let last = group.iter().max().map_or(0, |&g| g as usize + 1);
        index.closed = vec![true; last];
        open.iter().for_each(|&t| index.closed[pieces.of(t) as usize] = false);
        index.tree = Bvh::build_grouped(&boxes, |i| group[i as usize]);
        index.pieces = index.tree.groups().map(|(g, around, node)| (g, *around, node)).collect();
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b));
        index.size = if boxes.is_empty() { 0.0 } else { 2.0 * bounds.half().max() };
        let of_items = items.iter().flat_map(|&t| triangles[t as usize]);
        index.vertices = of_items.collect();
        index.vertices.sort_unstable();
        index.vertices.dedup();
        let place = |&v: &u32| Aabb { min: points[v as usize], max: points[v as usize] };
        index.vertex_tree = Bvh::build(&index.vertices.iter().map(place).collect::<Vec<_>>());
        index.items = index.tree.renumber().into_iter().map(|i| items[i as usize]).collect();
        index.corners = index.items.iter().map(|&t| corners(t)).collect();
        index.rounding = index.shell(grid);
        index.is_solid = index.rounding > 0.0 || open.is_empty();
        index.edges.plant(points);
        index.bends.plant(points);
        index.bends.first = index.edges.list.len() as u32;
        index
    }

    /// Joins triangles across their edges into pieces and makes the normals of edges. Returns
    /// triangles at borders, where sides do not agree, and where more than two meet.
    fn join_edges(
        &mut self,
        triangles: &[[u32; 3]],
        items: &[u32],
        points: &[Vec3],
        pieces: &mut PieceSets,
    ) -> Vec<u32> {
        let mut sides: Vec<([u32; 2], u32, usize)> = Vec::with_capacity(3 * items.len());
        for &t in items {
            for k in 0..3 {
                let (a, b) = (triangles[t as usize][k], triangles[t as usize][(k + 1) % 3]);
                sides.push(([a.min(b), a.max(b)], t, k));
            }
        }
        sides.sort_unstable();
        let mut open = Vec::new();
        for same in sides.chunk_by(|a, b| a.0 == b.0) {
            let normals = same.iter().map(|&(_, t, _)| self.face_normals[t as usize]);
            let sum: Vec3 = normals.clone().sum();
            for &(_, t, k) in same {
                self.edge_normals[t as usize][k] = sum;
                pieces.join(t, same[0].1);
            }
            let starts = |s: &([u32; 2], u32, usize)| triangles[s.1 as usize][s.2] == s.0[0];
            let ways = same.iter().filter(|s| starts(s)).count();
            if same.len() != 2 || ways != 1 {
                open.extend(same.iter().map(|s| s.1));
            }
            let first = self.face_normals[same[0].1 as usize];
            let other = self.face_normals[same[same.len() - 1].1 as usize];
            // Only edges that stick out can touch before their faces do.
            let [a, b] = same[0].0.map(|v| points[v as usize]);
            let outward = {
                let t = &triangles[same[0].1 as usize];
                let apex = t.iter().find(|v| !same[0].0.contains(v)).map(|&v| points[v as usize]);
                apex.is_none_or(|apex| other.dot(&(apex - 0.5 * (a + b))) <= 0.0)
            };
            let edge = MeshEdge { vertices: same[0].0, normals: [first, other] };
            if same.len() != 2 || (first.dot(&other) < SHARP && outward) {
                self.edges.list.push(edge);
            } else if first.dot(&other) < LEVEL && outward {
                self.bends.list.push(edge);
            }
        }
        open
    }

    /// Half the thickness of the shell that the grid describes; zero of a solid. The grid of a
    /// shell holds the distance to its triangles less that half, exactly, at each of its points.
    fn shell(&self, grid: &DistanceGrid) -> f64 {
        if self.closed.iter().all(|&closed| closed) || !grid.is_sound() {
            return 0.0;
        }
        let Some(near) = self.closest(&grid.origin) else { return 0.0 };
        let half = near.distance_squared.sqrt() - f64::from(grid.values[0]);
        if half > 0.5 * grid.cell { half } else { 0.0 }
    }

    /// The nearest point of all triangles.
    fn closest(&self, p: &Vec3) -> Option<Closest> {
        let mut best: Option<Closest> = None;
        for &(_, _, node) in &self.pieces {
            let reach = best.map_or(f64::INFINITY, |b| b.distance_squared);
            if let Some((_, near)) = self.closest_below(node, p, reach) {
                best = Some(near);
            }
        }
        best
    }

    /// The nearest item below a node of the tree, and its nearest point.
    pub(super) fn closest_below(
        &self,
        node: u32,
        p: &Vec3,
        reach_squared: f64,
    ) -> Option<(u32, Closest)> {
        let mut best: Option<(u32, Closest)> = None;
        let mut least = reach_squared;
        self.tree.nearest(node, p, reach_squared, |i| {
            let near = closest_on_triangle(p, &self.corners[i as usize]);
            if near.distance_squared < least {
                least = near.distance_squared;
                best = Some((i, near));
            }
            least
        });
        best
    }

    /// Pseudo-normal of the part of triangle `t` that a point is nearest to; not of unit length.
    pub(super) fn normal(&self, triangles: &[[u32; 3]], t: u32, feature: Feature) -> Vec3 {
        let t = t as usize;
        match feature {
            Feature::Face => self.face_normals[t],
            Feature::Edge(k) => self.edge_normals[t][k],
            Feature::Vertex(k) => self.vertex_normals[triangles[t][k] as usize],
        }
    }
}

/// Sets of triangles, joined one by one.
struct PieceSets(Vec<u32>);

impl PieceSets {
    fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// The least triangle of the piece of `t`.
    fn of(&self, mut t: u32) -> u32 {
        while self.0[t as usize] != t {
            t = self.0[t as usize];
        }
        t
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.of(a), self.of(b));
        let (low, high) = (a.min(b), a.max(b));
        self.0[high as usize] = low;
        // Shorter ways for later.
        self.0[a.max(b) as usize] = low;
    }

    /// Gives each piece that faces inward to the smallest piece around it.
    fn hold_cavities(
        &mut self,
        items: &[u32],
        boxes: &[Aabb],
        corners: &impl Fn(u32) -> [Vec3; 3],
    ) {
        for t in 0..self.0.len() as u32 {
            self.0[t as usize] = self.of(t);
        }
        let mut pieces: Vec<(u32, f64, Aabb)> = Vec::new();
        let mut place = vec![usize::MAX; self.0.len()];
        let origin = boxes.first().map_or(Vec3::zeros(), Aabb::center);
        for (&t, around) in items.iter().zip(boxes) {
            let piece = self.0[t as usize];
            if place[piece as usize] == usize::MAX {
                place[piece as usize] = pieces.len();
                pieces.push((piece, 0.0, Aabb::EMPTY));
            }
            let entry = &mut pieces[place[piece as usize]];
            let [a, b, c] = corners(t).map(|x| x - origin);
            entry.1 += a.dot(&b.cross(&c));
            entry.2 = entry.2.union(around);
        }
        let holder = |(_, volume, around): &(u32, f64, Aabb)| {
            let holds = |b: &&(u32, f64, Aabb)| {
                b.1 > volume.abs() && b.2.contains(&around.min) && b.2.contains(&around.max)
            };
            let holders = pieces.iter().filter(holds);
            holders.min_by(|a, b| a.1.total_cmp(&b.1)).map(|h| h.0)
        };
        let cavities = pieces.iter().filter(|p| p.1 < 0.0);
        let found: Vec<_> = cavities.filter_map(|c| Some((c.0, holder(c)?))).collect();
        found.iter().for_each(|&(cavity, holder)| self.join(cavity, holder));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::grid::tests::grid_of;
    use crate::contact::tests::{boxed, cube};
    use crate::contact::triangle::ROUNDED_UP;
    use crate::contact::{MeshShape, PlacedShape, Shape};
    use crate::math::Pose;
    use crate::random::Random;
    use std::cell::Cell;
    use std::f64::consts::{PI, TAU};
    use std::sync::Arc;

    type Surface = (Vec<Vec3>, Vec<[u32; 3]>);

    /// A closed surface of two parameters, each over n or m steps of a circle.
    fn torus(major: f64, minor: f64, n: u32, m: u32) -> Surface {
        let mut surface: Surface = Default::default();
        for i in 0..n {
            for j in 0..m {
                let (u, v) = (TAU * f64::from(i) / f64::from(n), TAU * f64::from(j) / f64::from(m));
                let r = major + minor * v.cos();
                surface.0.push(Vec3::new(r * u.cos(), minor * v.sin(), -r * u.sin()));
                let at = |i: u32, j: u32| i % n * m + j % m;
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                surface.1.extend([[a, b, c], [a, c, d]]);
            }
        }
        surface
    }

    fn join(a: Surface, b: Surface) -> Surface {
        let first = a.0.len() as u32;
        let triangles = b.1.iter().map(|t| t.map(|v| v + first));
        (a.0.into_iter().chain(b.0).collect(), a.1.into_iter().chain(triangles).collect())
    }

    /// Distance to all triangles one by one; inside where they turn about `p` by more than half a
    /// solid angle (van Oosterom and Strackee, 1983).
    fn brute(p: &Vec3, (points, triangles): &Surface) -> f64 {
        let mut least = f64::INFINITY;
        let mut angle = 0.0;
        for t in triangles {
            let x = t.map(|v| points[v as usize]);
            least = least.min(closest_on_triangle(p, &x).distance_squared);
            let [a, b, c] = x.map(|x| x - p);
            let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
            let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
            angle += 2.0 * a.dot(&b.cross(&c)).atan2(below);
        }
        least.sqrt() * if angle > TAU { -1.0 } else { 1.0 }
    }

    fn any_grid() -> DistanceGrid {
        DistanceGrid { origin: Vec3::repeat(1e3), cell: 1.0, dims: [2; 3], values: vec![1.0; 8] }
    }

    #[test]
    fn distances_are_exact_near_and_far() {
        let mut random = Random::new(31);
        let inner: Surface = {
            let (points, triangles) = cube(0.02, 2);
            (points, triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect())
        };
        let hollow = join(cube(0.05, 3), inner);
        for surface in [cube(0.05, 1), cube(0.05, 5), torus(0.04, 0.015, 24, 12), hollow] {
            let mesh = MeshShape::new(surface.0.clone(), surface.1.clone(), any_grid());
            for reach in [0.03, 0.06, 0.5, 10.0] {
                for _ in 0..400 {
                    let p = random.vector(reach);
                    let (d, exact) = (mesh.distance(&p), brute(&p, &surface));
                    assert!((d.value - exact).abs() < 1e-13 * (1.0 + reach), "{p}: {d:?} {exact}");
                    assert!((d.gradient.norm() - 1.0).abs() < 1e-9);
                    let foot = p - d.value * d.gradient;
                    assert!(mesh.distance(&foot).value.abs() < 1e-12 * (1.0 + reach));
                    let near = mesh.distance_within(&p, 0.01);
                    assert_eq!(near, Some(d).filter(|d| d.value < 0.01));
                }
            }
        }
    }

    /// Whatever is guessed and known, near or far, and of pieces within each other.
    #[test]
    fn a_guess_changes_nothing() {
        let mut random = Random::new(4);
        let mut other = cube(0.02, 3);
        other.0.iter_mut().for_each(|p| p.x += 0.03);
        for surface in [torus(0.04, 0.015, 24, 12), join(cube(0.05, 4), other)] {
            let mesh = MeshShape::new(surface.0, surface.1, any_grid());
            let guess = Cell::new(0);
            let mut p = Vec3::zeros();
            for i in 0..4000 {
                p = if i % 20 == 0 { random.vector(0.06) } else { p + random.vector(0.002) };
                let exact = mesh.distance(&p);
                for known in [exact.value.abs() * ROUNDED_UP, 0.1, f64::INFINITY] {
                    assert_eq!(mesh.distance_near(&p, known, &guess), exact, "{p}");
                }
            }
        }
    }

    /// On the surface itself the gradient is the normal there.
    #[test]
    fn on_the_surface_the_gradient_is_the_normal() {
        let (points, triangles) = cube(0.05, 4);
        let mesh = MeshShape::new(points, triangles, any_grid());
        for off in [-1e-9, -1e-15, 0.0, 1e-15, 1e-9] {
            for (x, z) in [(0.0, 0.0), (0.0125, 0.001), (0.003, 0.004)] {
                let d = mesh.distance(&Vec3::new(x, 0.025 + off, z));
                assert!((d.gradient - Vec3::y()).norm() < 1e-6 && (d.value - off).abs() < 1e-16);
            }
        }
    }

    /// Pieces that overlap are the union, as a compound of them.
    #[test]
    fn overlapping_pieces_are_one_body() {
        let mut other = cube(0.05, 2);
        other.0.iter_mut().for_each(|p| p.x += 0.03);
        let both = join(cube(0.05, 2), other);
        let mesh = MeshShape::new(both.0, both.1, any_grid());
        let part =
            |x: f64| PlacedShape { shape: boxed(0.025), pose_SP: Pose::translation(x, 0.0, 0.0) };
        let union = Shape::Compound(Arc::new(vec![part(0.0), part(0.03)]));
        let mut random = Random::new(8);
        for _ in 0..2000 {
            let p = random.vector(0.08);
            assert!((mesh.distance(&p).value - union.distance(&p).value).abs() < 1e-15);
        }
    }

    /// A square sheet whose grid holds the distance less 2 mm is a shell of 4 mm.
    #[test]
    fn a_sheet_is_as_thick_as_its_grid_says() {
        let points: Vec<Vec3> = [(0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1)]
            .iter()
            .map(|&(x, z)| Vec3::new(x, 0.0, z))
            .collect();
        let sheet: Surface = (points, vec![[0, 1, 2], [0, 2, 3]]);
        let origin = Vec3::new(-0.01, -0.01, -0.01);
        let mut grid = DistanceGrid { origin, cell: 0.002, dims: [61, 11, 61], values: vec![] };
        for i in 0..61 * 11 * 61u32 {
            let index = Vec3::new(f64::from(i % 61), f64::from(i / 61 % 11), f64::from(i / 671));
            let p = grid.origin + grid.cell * index;
            grid.values.push((brute(&p, &sheet).abs() - 0.002) as f32);
        }
        let mesh = MeshShape::new(sheet.0.clone(), sheet.1.clone(), grid);
        let mut random = Random::new(2);
        for _ in 0..500 {
            let p = random.vector(0.15);
            let exact = brute(&p, &sheet).abs() - 0.002;
            assert!((mesh.distance(&p).value - exact).abs() < 1e-8);
        }
    }

    /// The grid says what is inside a box without its lid.
    #[test]
    fn an_open_mesh_has_the_inside_of_its_grid() {
        let (points, mut triangles) = cube(0.05, 4);
        triangles.retain(|t| t.iter().any(|&v| points[v as usize].y < 0.0249));
        let open = MeshShape::new(points, triangles, grid_of(&boxed(0.025), 0.04, 33));
        assert!(open.distance(&Vec3::new(0.0, -0.01, 0.0)).value < -0.014);
        assert!(open.distance(&Vec3::new(0.0, -0.03, 0.0)).value > 0.0);
        assert!(open.distance(&Vec3::new(0.0, 0.05, 0.0)).value > 0.02);
        assert!((open.distance(&Vec3::new(0.03, PI * 1e-3, 0.0)).value - 0.005).abs() < 1e-12);
    }
}
