//! Which parts of one surface never touch each other: neighbours.

use crate::contact::aabb::Aabb;
use crate::contact::bvh::Bvh;
use crate::contact::surface::Surface;
use crate::contact::triangle::closest_on_triangle;
use crate::math::Vec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Neighbours lie within this many mean edge lengths along the surface,
const ALONG: f64 = 2.0;
/// or, through the body, within this many.
const THROUGH: f64 = 1.0;
/// Parts nearer than this part of an edge overlap already.
const OVERLAP: f64 = 0.05;

/// Pairs of a vertex and a triangle that are neighbours: near along the surface at rest, on two
/// sides of a thin part, overlapping, or carried by one bone or two joined ones.
#[derive(Clone, Debug, Default)]
pub(crate) struct Apart {
    /// Neighbours of vertex v: `triangles[start[v]..start[v + 1]]`, sorted.
    start: Vec<u32>,
    triangles: Vec<u32>,
    /// One bit per pair of tree nodes n ≤ m: no two of their parts may touch.
    nodes: usize,
    settled: Vec<u64>,
    regions: Regions,
    /// Whether two regions are one or joined, row by row, and how many there are.
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

impl Apart {
    /// For a surface with its vertices at rest at `x`.
    pub fn new(surface: &Surface, x: &[Vec3], regions: Regions) -> Self {
        let edges = surface_edges(surface, x);
        let corners = |t: &[u32; 3]| t.map(|v| x[v as usize]);
        let boxes: Vec<Aabb> =
            surface.triangles.iter().map(|t| Aabb::of_points(&corners(t))).collect();
        let tree = Bvh::build(&boxes);
        let mut apart = Self { start: vec![0], ..Self::default() };
        let mut near = Near::new(x.len());
        for v in 0..x.len() {
            let mut triangles: Vec<u32> = near
                .along(&edges, v, ALONG * surface.edge_mean)
                .flat_map(|w| surface.around(w).iter().copied())
                .collect();
            through(surface, &tree, x, v as u32, &mut triangles);
            triangles.sort_unstable();
            triangles.dedup();
            apart.triangles.extend(triangles);
            apart.start.push(apart.triangles.len() as u32);
        }
        apart.count = regions.of_vertex.iter().max().map_or(0, |most| *most as usize + 1);
        let pairs = (0..apart.count).flat_map(|i| (0..apart.count).map(move |j| (i, j)));
        apart.near = pairs.map(|(i, j)| regions.are_joined(i as u32, j as u32)).collect();
        apart.regions = regions;
        apart.settle(surface);
        apart
    }

    /// Whether vertex `v` and triangle `t` with these corners are neighbours.
    pub fn are_neighbors(&self, v: u32, t: u32, corners: &[u32; 3]) -> bool {
        if let Some(&i) = self.regions.of_vertex.get(v as usize)
            && corners.iter().any(|&w| self.are_joined(i, self.regions.of_vertex[w as usize]))
        {
            return true;
        }
        let range = self.start[v as usize] as usize..self.start[v as usize + 1] as usize;
        self.triangles[range].binary_search(&t).is_ok()
    }

    /// Whether the flesh of two bones never touches: around one bone, or across one joint, it is
    /// pressed together by bending.
    pub fn are_joined(&self, i: u32, j: u32) -> bool {
        self.near.get(i as usize * self.count + j as usize).is_some_and(|near| *near)
    }

    /// Whether all below two tree nodes are neighbours.
    pub fn are_settled(&self, n: usize, m: usize) -> bool {
        let bit = n.min(m) * self.nodes + n.max(m);
        self.settled[bit / 64] >> (bit % 64) & 1 == 1
    }

    /// Fills the bits from the leaves up; children come after their parents.
    fn settle(&mut self, surface: &Surface) {
        let tree = &surface.tree;
        self.nodes = tree.node_count();
        self.settled = vec![0; (self.nodes * self.nodes).div_ceil(64)];
        for n in (0..self.nodes).rev() {
            for m in (n..self.nodes).rev() {
                let settled = match (tree.children(n), tree.children(m)) {
                    (Err(items), Err(others)) => items
                        .iter()
                        .all(|&s| others.iter().all(|&t| self.touch_never(surface, s, t))),
                    (Ok([l, r]), _) if n == m => {
                        [(l, l), (l, r), (r, r)].iter().all(|&(i, j)| self.are_settled(i, j))
                    }
                    (Ok(halves), _) => halves.iter().all(|&i| self.are_settled(i, m)),
                    (_, Ok(halves)) => halves.iter().all(|&j| self.are_settled(n, j)),
                };
                let bit = n * self.nodes + m;
                self.settled[bit / 64] |= u64::from(settled) << (bit % 64);
            }
        }
    }

    fn touch_never(&self, surface: &Surface, s: u32, t: u32) -> bool {
        let corners = |t: u32| surface.triangles[t as usize];
        let (of_s, of_t) = (corners(s), corners(t));
        of_s.iter().all(|&v| self.are_neighbors(v, t, &of_t))
            && of_t.iter().all(|&v| self.are_neighbors(v, s, &of_s))
    }
}

/// Adds the triangles that `v` looks at from behind nearby, and those it already touches.
fn through(surface: &Surface, tree: &Bvh, x: &[Vec3], v: u32, found: &mut Vec<u32>) {
    let p = &x[v as usize];
    let reach = THROUGH * surface.edge_mean;
    let around = Aabb { min: *p, max: *p }.inflate(reach);
    tree.overlapping(&around, |t| {
        let closest = closest_on_triangle(p, &surface.corners(t, x));
        let distance = closest.distance_squared.sqrt();
        let outward = surface.pseudonormal(t, closest.feature, x);
        let behind = outward.dot(&(p - closest.point)) <= 0.0;
        if distance < OVERLAP * surface.edge_mean || (behind && distance < reach) {
            found.push(t);
        }
    });
}

/// Ends and lengths of the edges at each vertex.
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
    edges
}

/// Work space of a search along edges (Dijkstra 1959).
struct Near {
    distance: Vec<f64>,
    reached: Vec<u32>,
}

impl Near {
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
        while let Some(Reverse((bits, v))) = open.pop() {
            let so_far = f64::from_bits(bits);
            if so_far > self.distance[v as usize] {
                continue;
            }
            for &(w, length) in &edges[v as usize] {
                let (next, known) = (so_far + length, &mut self.distance[w as usize]);
                if next > reach || next >= *known {
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
