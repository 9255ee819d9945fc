//! Neighbouring parts of one surface, which never touch each other.

use crate::contact::aabb::Aabb;
use crate::contact::bit_table::BitTable;
use crate::contact::bvh::Bvh;
use crate::contact::surface::Surface;
use crate::contact::triangle::closest_on_triangle;
use crate::math::Vec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Neighbours lie within this many mean edge lengths along the surface: the triangles around a
/// vertex and those next to them. A fold of a mesh is a row of edges, and lays just these on each
/// other, which no contact could part. What is farther away comes near by the bending of several
/// rows.
const ALONG: f64 = 2.0;
/// Or, through the body, they lie within this many. A part no thicker than its triangles are long
/// is pressed flat before its two sides meet; of a thicker one they are more than their own flesh
/// apart.
const THROUGH: f64 = 1.0;
/// Largest number of vertices along the surface that are neighbours, the nearest ones, and of
/// triangles around all of them: tables then grow with the surface and not with its square, however
/// uneven its edges. Even meshes have some twenty and forty.
const ALONG_MAX: usize = 128;
const TRIANGLES_MAX: usize = 1024;
/// Through the body, neighbours lie within this many edges of the vertex itself: where these are
/// much shorter than the mean, the mean would reach over ever more triangles. In even meshes the
/// mean is less. What is left out may touch.
const EDGES_THROUGH: f64 = 16.0;
/// Larger trees have no table of settled pairs, which only spares a search: at most 2 MB.
const NODES_MAX: usize = 4096;
/// Surfaces with more triangles or vertices have no table of pairs of triangles, nor of vertices
/// and triangles, which likewise only spare a search: at most 2 MB each.
const TABLED_MAX: usize = 4096;
/// Parts nearer than this part of an edge at rest overlap already, as in a seam: they would push
/// each other apart from the first step on. Contacts rest to a hundredth of an edge, and surfaces
/// that were scanned or drawn to lie on each other do so to a few.
const OVERLAP: f64 = 0.05;

/// Pairs of a vertex and a triangle that are neighbours: near along the surface at rest, on two
/// sides of a thin part, overlapping, or carried by one bone or two joined ones.
#[derive(Clone, Debug, Default)]
pub(crate) struct SeparateTriangles {
    /// Neighbours of vertex v: `triangles[start[v]..start[v + 1]]`, sorted.
    start: Vec<u32>,
    triangles: Vec<u32>,
    /// Pairs of tree nodes no two parts of which may touch.
    settled: BitTable,
    /// Vertices and triangles that are neighbours.
    neighbors: BitTable,
    /// Pairs of triangles that never touch.
    never: BitTable,
    regions: Regions,
    /// Table of regions that are one or joined: true for such pairs, row by row of `count`.
    near: Vec<bool>,
    count: usize,
}

/// The bone that carries each vertex, and which bones are neighbours.
#[derive(Clone, Debug, Default)]
pub(crate) struct Regions {
    /// Empty for a body without bones.
    pub of_vertex: Vec<u32>,
    /// Pairs of bones joined directly, lower first, sorted.
    pub joined: Vec<[u32; 2]>,
}

impl Regions {
    fn are_joined(&self, i: u32, j: u32) -> bool {
        i == j || self.joined.binary_search(&[i.min(j), i.max(j)]).is_ok()
    }
}

impl SeparateTriangles {
    /// For a surface with its vertices at rest at `x`.
    pub fn new(surface: &Surface, x: &[Vec3], regions: Regions) -> Self {
        let edges = surface_edges(surface, x);
        let corners = |t: &[u32; 3]| t.map(|v| x[v as usize]);
        let boxes: Vec<Aabb> =
            surface.triangles.iter().map(|t| Aabb::of_points(&corners(t))).collect();
        let tree = Bvh::build(&boxes);
        let mut apart = Self { start: vec![0], ..Self::default() };
        let mut near = EdgeSearch::new(x.len());
        for v in 0..x.len() {
            let mut triangles: Vec<u32> = near
                .along(&edges, v, ALONG * surface.edge_mean)
                .flat_map(|w| surface.around(w).iter().copied())
                .take(TRIANGLES_MAX)
                .collect();
            let around = edges[v].iter().map(|(_, length)| length).sum::<f64>();
            let around = around / edges[v].len().max(1) as f64;
            let reach = THROUGH * surface.edge_mean.min(EDGES_THROUGH * around);
            through(surface, &tree, x, (v as u32, reach), &mut triangles);
            triangles.sort_unstable();
            triangles.dedup();
            apart.triangles.extend(triangles);
            apart.start.push(apart.triangles.len() as u32);
        }
        apart.count = regions.of_vertex.iter().max().map_or(0, |most| *most as usize + 1);
        let pairs = (0..apart.count).flat_map(|i| (0..apart.count).map(move |j| (i, j)));
        apart.near = pairs.map(|(i, j)| regions.are_joined(i as u32, j as u32)).collect();
        apart.regions = regions;
        apart.tabulate(surface, x.len());
        apart.settle(surface);
        apart
    }

    /// True when vertex `v` and triangle `t` with these corners are neighbours.
    pub fn are_neighbors(&self, v: u32, t: u32, corners: &[u32; 3]) -> bool {
        if self.neighbors.is_empty() {
            return self.are_of_joined_bones(v, corners) || self.are_near(v, t);
        }
        self.neighbors.is_set(v, t)
    }

    /// True when vertex `v` and a corner of a triangle are carried by one bone, or by two joined
    /// ones.
    pub fn are_of_joined_bones(&self, v: u32, corners: &[u32; 3]) -> bool {
        let of = &self.regions.of_vertex;
        of.get(v as usize)
            .is_some_and(|&i| corners.iter().any(|&w| self.are_joined(i, of[w as usize])))
    }

    /// True when vertex `v` and triangle `t` are neighbours without regard to bones.
    pub fn are_near(&self, v: u32, t: u32) -> bool {
        let range = self.start[v as usize] as usize..self.start[v as usize + 1] as usize;
        self.triangles[range].binary_search(&t).is_ok()
    }

    /// True when the flesh of two bones never touches: around one bone, or across one joint, it is
    /// pressed together by bending.
    fn are_joined(&self, i: u32, j: u32) -> bool {
        self.near.get(i as usize * self.count + j as usize).is_some_and(|near| *near)
    }

    /// True when no vertex and no edge of two triangles is to touch the other one; false where no
    /// table says so.
    pub fn touch_never(&self, s: u32, t: u32) -> bool {
        !self.never.is_empty() && self.never.is_set(s, t)
    }

    /// True when the triangles of two groups, named by the bones of their first corners, need not
    /// be compared. False where there is a table of settled pairs, which decides better: a
    /// triangle's other corners may be of other bones.
    pub fn are_groups_apart(&self, i: u32, j: u32) -> bool {
        self.settled.is_empty() && self.are_joined(i, j)
    }

    /// True when all items below two tree nodes are neighbours.
    pub fn are_settled(&self, n: usize, m: usize) -> bool {
        if self.settled.is_empty() {
            return false;
        }
        self.settled.is_set(n as u32, m as u32)
    }

    /// Fills the tables of vertices and triangles, and of triangles.
    fn tabulate(&mut self, surface: &Surface, vertices: usize) {
        let count = surface.triangles.len();
        if count.max(vertices) > TABLED_MAX {
            return;
        }
        // Triangles in the order of the tree; vertices in that of the first triangle around them.
        let mut of_triangle = vec![0; count];
        let mut ordered = 0;
        surface.tree.in_order(|t| {
            of_triangle[t as usize] = ordered;
            ordered += 1;
        });
        let first = |v: &u32| surface.around(*v).iter().map(|&t| of_triangle[t as usize]).min();
        let mut by_place: Vec<u32> = (0..vertices as u32).collect();
        by_place.sort_by_key(first);
        let mut of_vertex = vec![0; vertices];
        for (place, v) in by_place.into_iter().enumerate() {
            of_vertex[v as usize] = place as u16;
        }
        self.neighbors = BitTable::new(of_vertex, of_triangle.clone(), |v, t| {
            self.are_neighbors(v as u32, t as u32, &surface.triangles[t])
        });
        self.never =
            BitTable::symmetric(of_triangle, |s, t| self.are_apart(surface, s as u32, t as u32));
    }

    /// Fills the bits from the leaves up; children come after their parents.
    fn settle(&mut self, surface: &Surface) {
        let tree = &surface.tree;
        if tree.node_count() > NODES_MAX {
            return;
        }
        let nodes = tree.node_count();
        let mut known = vec![false; nodes * nodes];
        for n in (0..nodes).rev() {
            for m in (n..nodes).rev() {
                let is_known = |i: usize, j: usize| known[i * nodes + j];
                let settled = match (tree.children(n), tree.children(m)) {
                    (Err(items), Err(others)) => {
                        let never = |s, t| match self.never.is_empty() {
                            true => self.are_apart(surface, s, t),
                            false => self.touch_never(s, t),
                        };
                        items.iter().all(|&s| others.iter().all(|&t| never(s, t)))
                    }
                    (Ok([l, r]), _) if n == m => {
                        [(l, l), (l, r), (r, r)].iter().all(|&(i, j)| is_known(i, j))
                    }
                    (Ok(halves), _) => halves.iter().all(|&i| is_known(i, m)),
                    (_, Ok(halves)) => halves.iter().all(|&j| is_known(n, j)),
                };
                (known[n * nodes + m], known[m * nodes + n]) = (settled, settled);
            }
        }
        let places: Vec<u16> = (0..nodes as u16).collect();
        self.settled = BitTable::new(places.clone(), places, |n, m| known[n * nodes + m]);
    }

    fn are_apart(&self, surface: &Surface, s: u32, t: u32) -> bool {
        let corners = |t: u32| surface.triangles[t as usize];
        let (of_s, of_t) = (corners(s), corners(t));
        of_s.iter().all(|&v| self.are_neighbors(v, t, &of_t))
            && of_t.iter().all(|&v| self.are_neighbors(v, s, &of_s))
    }
}

/// Adds the triangles that `v` looks at from behind nearby, and those it already touches.
fn through(
    surface: &Surface,
    tree: &Bvh,
    x: &[Vec3],
    (v, reach): (u32, f64),
    found: &mut Vec<u32>,
) {
    let p = &x[v as usize];
    let around = Aabb { min: *p, max: *p }.inflate(reach);
    tree.overlapping(&around, |t| {
        let closest = closest_on_triangle(p, &surface.corners(t, x));
        let distance = closest.distance_squared.sqrt();
        let overlaps = distance < OVERLAP * surface.edge_mean;
        let behind = || {
            let outward = surface.pseudonormal(t, closest.feature, x);
            outward.dot(&(p - closest.point)) <= 0.0
        };
        if overlaps || (distance < reach && behind()) {
            found.push(t);
        }
    });
}

/// Ends and lengths of the edges at each vertex, the shortest first.
fn surface_edges(surface: &Surface, x: &[Vec3]) -> Vec<Vec<(u32, f64)>> {
    let mut edges = vec![Vec::new(); x.len()];
    for t in &surface.triangles {
        for k in 0..3 {
            let (i, j) = (t[k] as usize, t[(k + 1) % 3] as usize);
            let length = (x[i] - x[j]).norm();
            edges[i].push((j as u32, length));
            edges[j].push((i as u32, length));
        }
    }
    edges.iter_mut().for_each(|ends| ends.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0))));
    edges
}

/// Work space of a search along edges (Dijkstra 1959).
struct EdgeSearch {
    distance: Vec<f64>,
    reached: Vec<u32>,
}

impl EdgeSearch {
    fn new(vertices: usize) -> Self {
        Self { distance: vec![f64::INFINITY; vertices], reached: Vec::new() }
    }

    /// The vertices within `reach` of `from` along edges, itself included.
    fn along(
        &mut self,
        edges: &[Vec<(u32, f64)>],
        from: usize,
        reach: f64,
    ) -> impl Iterator<Item = u32> {
        for v in self.reached.drain(..) {
            self.distance[v as usize] = f64::INFINITY;
        }
        // Distances are not negative, so their bits are in their order.
        let mut open = BinaryHeap::from([Reverse((0, from as u32))]);
        self.distance[from] = 0.0;
        self.reached.push(from as u32);
        let mut visited = 0;
        while let Some(Reverse((bits, v))) = open.pop() {
            let so_far = f64::from_bits(bits);
            if so_far > self.distance[v as usize] {
                continue;
            }
            visited += 1;
            if visited > ALONG_MAX {
                break;
            }
            // Shortest first: what comes after the first that leads too far does too.
            let near = edges[v as usize].iter().take(ALONG_MAX);
            for &(w, length) in near.take_while(|(_, length)| so_far + length <= reach) {
                let (next, known) = (so_far + length, &mut self.distance[w as usize]);
                if next >= *known {
                    continue;
                }
                if *known == f64::INFINITY {
                    self.reached.push(w);
                }
                *known = next;
                open.push(Reverse((next.to_bits(), w)));
            }
        }
        self.reached.clone().into_iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{EmbeddedSurface, Flesh, SurfaceVertex};

    /// Neighbours on a surface with these vertices, which no bone carries.
    fn apart(points: &[Vec3], triangles: Vec<[u32; 3]>) -> (Surface, SeparateTriangles) {
        apart_on_bones(points, triangles, Regions::default())
    }

    fn apart_on_bones(
        points: &[Vec3],
        triangles: Vec<[u32; 3]>,
        regions: Regions,
    ) -> (Surface, SeparateTriangles) {
        // In a tetrahedron of unit legs, coordinates are weights.
        let weights = |p: &Vec3| [1.0 - p.sum(), p.x, p.y, p.z];
        let vertices = points.iter().map(|p| SurfaceVertex { tet: 0, weights: weights(p) });
        let flesh = Flesh {
            nodes: vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()],
            tets: vec![[0, 1, 2, 3]],
            materials: Vec::new(),
            relaxation: Vec::new(),
            mass_damping: 0.0,
            stiffness_damping: 0.0,
            fixed: Vec::new(),
            collision: EmbeddedSurface { vertices: vertices.collect(), triangles },
            friction: 0.0,
        };
        let surface = Surface::new(0, &flesh, 0, &[]);
        let apart = SeparateTriangles::new(&surface, points, regions);
        (surface, apart)
    }

    /// The tables say what is said without them, on a sheet that four bones carry, of which two
    /// pairs are joined.
    #[test]
    fn tables_tell_what_is_told_without_them() {
        let (points, triangles) = sheet(12);
        let bone = |p: &Vec3| (4.0 * p.x).min(3.0) as u32;
        let of_vertex = points.iter().map(bone).collect();
        let regions = Regions { of_vertex, joined: vec![[0, 1], [2, 3]] };
        let (surface, tabled) = apart_on_bones(&points, triangles, regions);
        let mut told = [0; 4];
        for v in 0..points.len() as u32 {
            for (t, corners) in surface.triangles.iter().enumerate() {
                let of_bones = tabled.are_of_joined_bones(v, corners);
                let near = tabled.are_near(v, t as u32);
                assert_eq!(tabled.are_neighbors(v, t as u32, corners), of_bones || near);
                told[2 * usize::from(of_bones) + usize::from(near)] += 1;
            }
        }
        assert!(told.iter().all(|count| *count > 100), "{told:?}");

        let triangles = 0..surface.triangles.len() as u32;
        let never = |s: u32, t: u32| tabled.are_apart(&surface, s, t);
        for (s, t) in triangles.clone().flat_map(|s| triangles.clone().map(move |t| (s, t))) {
            assert_eq!(tabled.touch_never(s, t), never(s, t), "{s} {t}");
        }
        let tree = &surface.tree;
        let below: Vec<Vec<u32>> = (0..tree.node_count()).map(|n| below(tree, n)).collect();
        let mut settled = 0;
        for (n, m) in (0..below.len()).flat_map(|n| (0..below.len()).map(move |m| (n, m))) {
            let all = below[n].iter().all(|&s| below[m].iter().all(|&t| never(s, t)));
            assert_eq!(tabled.are_settled(n, m), all, "{n} {m}");
            settled += u32::from(all);
        }
        assert!(settled > 100, "{settled}");
    }

    /// The triangles below a node.
    fn below(tree: &Bvh, node: usize) -> Vec<u32> {
        match tree.children(node) {
            Err(items) => items.to_vec(),
            Ok(halves) => halves.into_iter().flat_map(|half| below(tree, half)).collect(),
        }
    }

    /// A sheet of `n` by `n` squares.
    fn sheet(n: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let at = |i: u32| f64::from(i % (n + 1)) / f64::from(n);
        let points = (0..(n + 1) * (n + 1)).map(|i| Vec3::new(at(i), at(i / (n + 1)), 0.0));
        let squares = (0..n * n).map(|i| i % n + i / n * (n + 1));
        let cut = |a: u32| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]];
        (points.collect(), squares.flat_map(cut).collect())
    }

    #[test]
    fn tables_of_a_large_sheet_grow_with_its_triangles() {
        let (points, triangles) = sheet(20);
        let (surface, small) = apart(&points, triangles);
        assert!(surface.tree.node_count() <= NODES_MAX && !small.settled.is_empty());
        let (points, triangles) = sheet(100);
        let (surface, large) = apart(&points, triangles);
        assert!(surface.tree.node_count() > NODES_MAX && large.settled.is_empty());
        assert!(!large.are_settled(0, 0));
        let per_vertex = |apart: &SeparateTriangles| {
            apart.triangles.len() as f64 / (apart.start.len() - 1) as f64
        };
        assert!(per_vertex(&large) < 1.2 * per_vertex(&small), "{}", per_vertex(&large));
        // What is near stays so, what is far too.
        let near = surface.triangles.iter().position(|t| t.contains(&0)).unwrap();
        assert!(large.are_neighbors(0, near as u32, &surface.triangles[near]));
        let far = surface.triangles.len() - 1;
        assert!(!large.are_neighbors(0, far as u32, &surface.triangles[far]));
    }

    /// All triangles meet at one vertex: each would be a neighbour of every vertex.
    #[test]
    fn tables_of_a_fan_grow_with_its_triangles() {
        for n in [200, 1500] {
            let angle = |i: u32| 2.0 * std::f64::consts::PI * f64::from(i) / f64::from(n);
            let rim = (0..n).map(|i| Vec3::new(angle(i).cos(), angle(i).sin(), 0.0) * 0.3);
            let mut points: Vec<Vec3> = rim.collect();
            points.push(Vec3::zeros());
            let triangles = (0..n).map(|i| [i, (i + 1) % n, n]).collect();
            let (surface, apart) = apart(&points, triangles);
            let most = (0..n as usize).map(|v| apart.start[v + 1] - apart.start[v]).max();
            assert!(most <= Some(2 * TRIANGLES_MAX as u32), "{most:?} of {n}");
            for v in 0..n {
                for t in [v, (v + n - 1) % n] {
                    assert!(apart.are_neighbors(v, t, &surface.triangles[t as usize]));
                }
            }
        }
    }
}
