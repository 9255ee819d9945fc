//! A deformable collision surface: fixed topology, moving vertices.

use crate::contact::SurfaceState;
use crate::contact::aabb::Aabb;
use crate::contact::bvh::Bvh;
use crate::contact::smooth::SmoothNormals;
use crate::contact::triangle::{
    Feature, ROUNDED_UP, are_beyond, area_or_flat, area_vector, solid_angle,
};
use crate::math::Vec3;
use crate::model::Flesh;

const NONE: u32 = u32::MAX;
/// A point that has come in by this part of the mean edge has come in through the triangle that is
/// nearest to it. The circle in an equilateral triangle has a radius of 0.29 edges: below its
/// middle, what is less deep is nearer to the triangle than to a wall that goes down from its rim.
const DEPTH: f64 = 0.25;
/// Contacts rest within this part of the mean edge; what is deeper has got in.
const ENTERED: f64 = 0.01;

/// A triangle at the start of a step, and its motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet {
    pub bounds: Aabb,
    /// Area vector \[m²\].
    pub area: Vec3,
    /// Length of the area vector \[m²\]; without end where rounding decides where that points, so
    /// that no plane tells anything.
    extent: f64,
    /// Mean motion of its corners in the step \[m\].
    motion: Vec3,
    /// The points move by this, but for so much \[m\].
    spread: f64,
}

impl Facet {
    fn new(x: &[Vec3; 3], motions: &[Vec3; 3]) -> Self {
        let motion = (motions[0] + motions[1] + motions[2]) / 3.0;
        let off = motions.iter().map(|u| (u - motion).norm_squared()).fold(0.0, f64::max);
        let (area, flat) = area_or_flat(x);
        Self {
            bounds: Aabb { min: x[0], max: x[0] }.with(&x[1]).with(&x[2]),
            area,
            extent: if flat { f64::INFINITY } else { area.norm() },
            motion,
            spread: off.sqrt(),
        }
    }

    /// Returns an upper bound of the motion of its points past one that moves by `motion` \[m\].
    pub fn travel_past(&self, motion: &Vec3) -> f64 {
        (self.motion - motion).norm() + self.spread
    }

    /// Heights of points over the triangle's plane, which goes through `origin`, times its area
    /// \[m³\].
    #[inline]
    pub fn heights<const N: usize>(&self, origin: &Vec3, points: &[Vec3; N]) -> [f64; N] {
        points.map(|p| self.area.dot(&(p - origin)))
    }

    /// Square of the least distance from the triangle of a point with this height, of
    /// [`Facet::heights`] \[m²\]; zero for a triangle without area.
    #[inline]
    pub fn distance_squared_by(&self, height: f64) -> f64 {
        let distance = height / self.extent;
        distance * distance
    }

    /// True where points with these heights, and all between them, lie farther over the plane, or
    /// farther under it, than `reach` \[m\]; false for a triangle without area.
    #[inline]
    pub fn is_beyond<const N: usize>(&self, heights: &[f64; N], reach: f64) -> bool {
        are_beyond(heights, reach * ROUNDED_UP * self.extent)
    }

    /// Returns an upper bound of the motion of its points past any point of another triangle \[m\].
    pub fn travel_past_all(&self, other: &Self) -> f64 {
        self.travel_past(&other.motion) + other.spread
    }
}

/// Topology of one surface and a tree over its triangles.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    /// Index of the deformable body.
    pub soft: u32,
    pub triangles: Vec<[u32; 3]>,
    /// Triangle across edge k (from corner k to k + 1), or `NONE`.
    neighbors: Vec<[u32; 3]>,
    /// Triangles around vertex v: `around[around_start[v]..around_start[v + 1]]`.
    around_start: Vec<u32>,
    around: Vec<u32>,
    pub tree: Bvh,
    /// Triangles as of the last [`Surface::refit`].
    pub facets: Vec<Facet>,
    /// Motions of the vertices in the step \[m\].
    pub motions: Vec<Vec3>,
    /// Places of the vertices at the end of the step, seen from the frame of the tree \[m\].
    ends: Vec<Vec3>,
    /// For each triangle, which of its corners it answers for.
    owned: Vec<[bool; 3]>,
    /// Mean edge length at rest \[m\].
    pub edge_mean: f64,
    /// Longest edge of each triangle, at rest \[m\].
    pub edge_of: Vec<f64>,
    /// Longest edge of the triangles around each vertex, at rest \[m\].
    pub edge_around: Vec<f64>,
    pub friction: f64,
    smooth: SmoothNormals,
    /// Index of its first vertex in lists over all surfaces.
    pub first_vertex: usize,
}

impl Surface {
    /// `region_of_vertex` may be empty; parts of one region lie together in the tree.
    pub fn new(soft: u32, flesh: &Flesh, first_vertex: usize, region_of_vertex: &[u32]) -> Self {
        let mut rest = vec![Vec3::zeros(); flesh.collision.vertices.len()];
        flesh.collision.positions(&flesh.tets, &flesh.nodes, &mut rest);
        let triangles = flesh.collision.triangles.clone();
        let (around_start, around) = triangles_around(&triangles, rest.len());
        let still = [Vec3::zeros(); 3];
        let facets: Vec<Facet> =
            triangles.iter().map(|t| Facet::new(&of_corners(t, &rest), &still)).collect();
        let boxes: Vec<Aabb> = facets.iter().map(|facet| facet.bounds).collect();
        let lengths: Vec<f64> = triangles.iter().flat_map(|t| edge_lengths(t, &rest)).collect();
        let longest = |edges: &[f64]| edges.iter().copied().fold(0.0, f64::max);
        let edge_of: Vec<f64> = lengths.chunks(3).map(longest).collect();
        let neighbors = neighbors(&triangles);
        let across = |t: u32, k: usize| Some(neighbors[t as usize][k]).filter(|&u| u != NONE);
        Self {
            soft,
            smooth: SmoothNormals::new(&triangles, &rest, across),
            around_start,
            around,
            tree: Bvh::build_grouped(&boxes, |t| {
                let corner = triangles[t as usize][0] as usize;
                region_of_vertex.get(corner).copied().unwrap_or(0)
            }),
            facets,
            motions: vec![Vec3::zeros(); rest.len()],
            ends: rest.clone(),
            owned: owners(&triangles, rest.len()),
            edge_mean: lengths.iter().sum::<f64>() / lengths.len().max(1) as f64,
            edge_around: longest_around(&triangles, &edge_of, rest.len()),
            edge_of,
            friction: flesh.friction,
            first_vertex,
            neighbors,
            triangles,
        }
    }

    /// Returns the largest depth below the surface at which a point is led out through its nearest
    /// triangle \[m\]: what is deeper is as near to others.
    pub fn depth_max(&self) -> f64 {
        DEPTH * self.edge_mean
    }

    pub fn vertex_count(&self) -> usize {
        self.around_start.len() - 1
    }

    /// This surface's part of the vertices of all surfaces.
    pub fn own<'a>(&self, all: SurfaceState<'a>) -> SurfaceState<'a> {
        let [positions, velocities] = [all.positions, all.velocities].map(|of| self.part(of));
        SurfaceState { positions, velocities }
    }

    /// Part of a list with one entry for each of these.
    pub fn part<'a>(&self, of_all: &'a [Vec3]) -> &'a [Vec3] {
        &of_all[self.first_vertex..self.first_vertex + self.vertex_count()]
    }

    /// Takes the triangles as they are, and puts the boxes of the tree around them and where they
    /// are after a step of length `h`, both seen from a frame that moves with velocity `drift`.
    pub fn refit(&mut self, state: &SurfaceState, h: f64, drift: &Vec3) {
        let Self { triangles, facets, motions, ends, tree, .. } = self;
        let vertices = motions.iter_mut().zip(ends.iter_mut());
        for ((motion, end), (p, v)) in vertices.zip(state.positions.iter().zip(state.velocities)) {
            (*motion, *end) = (h * v, p + h * (v - drift));
        }
        for (facet, t) in facets.iter_mut().zip(triangles.iter()) {
            *facet = Facet::new(&of_corners(t, state.positions), &of_corners(t, motions));
        }
        tree.refit(|t| {
            let [a, b, c] = of_corners(&triangles[t as usize], ends);
            facets[t as usize].bounds.with(&a).with(&b).with(&c)
        });
    }

    /// The corners (0 to 2) that this triangle answers for, with their vertices: each vertex has
    /// one such triangle.
    pub fn owned_corners(&self, triangle: u32) -> impl Iterator<Item = (usize, u32)> {
        let (corners, owned) = (self.triangles[triangle as usize], self.owned[triangle as usize]);
        (0..3).filter(move |&k| owned[k]).map(move |k| (k, corners[k]))
    }

    /// The triangle across edge `k`, if there is one.
    pub fn across(&self, triangle: u32, k: usize) -> Option<u32> {
        Some(self.neighbors[triangle as usize][k]).filter(|&t| t != NONE)
    }

    /// Calls `each` for the vertices that share an edge with `vertex`, some of them twice.
    pub fn neighbors_of(&self, vertex: u32, mut each: impl FnMut(u32)) {
        let corners = self.around(vertex).iter().flat_map(|&t| self.triangles[t as usize]);
        corners.filter(|&w| w != vertex).for_each(&mut each);
    }

    /// The outward normal at a vertex, weighted by area; of any length.
    pub fn vertex_normal(&self, vertex: u32, x: &[Vec3]) -> Vec3 {
        self.around(vertex).iter().map(|&t| area_vector(&self.corners(t, x))).sum()
    }

    pub fn corners(&self, triangle: u32, x: &[Vec3]) -> [Vec3; 3] {
        of_corners(&self.triangles[triangle as usize], x)
    }

    /// True when a point is inside by the surface's winding number, which no fold changes.
    pub fn winds_around(&self, p: &Vec3, x: &[Vec3]) -> bool {
        let angles = (0..self.triangles.len() as u32).map(|t| solid_angle(p, &self.corners(t, x)));
        angles.sum::<f64>() > std::f64::consts::TAU
    }

    /// True when a point that lies behind its nearest place by `depth` \[m\] is inside. A shallow
    /// one is; a deep one is by winding number, as the outer side of a surface that is folded
    /// inside out looks inward.
    pub fn holds_behind(&self, p: &Vec3, depth: f64, x: &[Vec3]) -> bool {
        !self.is_deep(depth) || self.winds_around(p, x)
    }

    /// True when what lies `depth` \[m\] behind the surface has got in.
    pub fn is_deep(&self, depth: f64) -> bool {
        depth > self.entered()
    }

    /// Contacts rest no deeper behind the surface than this \[m\]; what is deeper has got in.
    pub fn entered(&self) -> f64 {
        ENTERED * self.edge_mean
    }

    /// The triangles around a vertex.
    pub fn around(&self, vertex: u32) -> &[u32] {
        let v = vertex as usize;
        &self.around[self.around_start[v] as usize..self.around_start[v + 1] as usize]
    }

    /// The mean of the unit normals around a vertex, by areas: shorter than 1 where the surface is
    /// bent.
    pub fn mean_normal_at(&self, vertex: u32, x: &[Vec3]) -> Vec3 {
        let areas = self.around(vertex).iter().map(|&t| area_vector(&self.corners(t, x)));
        let (sum, whole) = areas.fold((Vec3::zeros(), 0.0), |(s, a), n| (s + n, a + n.norm()));
        if whole > 0.0 { sum / whole } else { Vec3::zeros() }
    }

    /// Mean of the unit normals at a point of a triangle, interpolated between its corners: no jump
    /// where a point goes on from a face to an edge or a vertex.
    pub fn mean_normal(&self, triangle: u32, weights: &[f64; 3], x: &[Vec3]) -> Vec3 {
        let corners = self.triangles[triangle as usize].into_iter().zip(weights);
        corners.filter(|(_, w)| **w != 0.0).map(|(v, w)| self.mean_normal_at(v, x) * *w).sum()
    }

    /// Length of the edges around a vertex, no more than the mean \[m\].
    pub fn edge_at(&self, vertex: u32) -> f64 {
        self.edge_mean.min(self.edge_around[vertex as usize])
    }

    /// Length of the edges at a point of a triangle \[m\], interpolated like
    /// [`Surface::mean_normal`].
    pub fn edge_within(&self, triangle: u32, weights: &[f64; 3]) -> f64 {
        let corners = self.triangles[triangle as usize].into_iter().zip(weights);
        corners.map(|(v, w)| self.edge_at(v) * w).sum()
    }

    /// The normal that decides inside from outside at a feature: of the face, the sum over an
    /// edge's two faces, or the angle-weighted sum around a vertex (Bærentzen & Aanæs 2005).
    /// Unit length; zero for a degenerate neighbourhood.
    pub fn pseudonormal(&self, triangle: u32, feature: Feature, x: &[Vec3]) -> Vec3 {
        let sum = match feature {
            Feature::Face => self.normal(triangle, x),
            Feature::Edge(k) => {
                let across = self.neighbors[triangle as usize][k];
                let other = if across == NONE { Vec3::zeros() } else { self.normal(across, x) };
                self.normal(triangle, x) + other
            }
            Feature::Vertex(k) => {
                let vertex = self.triangles[triangle as usize][k];
                let weighted = |&t: &u32| self.angle_at(t, vertex, x) * self.normal(t, x);
                self.around(vertex).iter().map(weighted).sum()
            }
        };
        sum.try_normalize(1e-12).unwrap_or_else(Vec3::zeros)
    }

    /// The outward normal at a point of a triangle, interpolated over the smooth piece of the
    /// surface around it. Unit length; zero for a degenerate neighbourhood.
    pub fn smooth_normal(&self, triangle: u32, weights: &[f64; 3], x: &[Vec3]) -> Vec3 {
        self.smooth.at(triangle, weights, &self.triangles, x)
    }

    /// True when edge `k` of a triangle is a sharp edge of the surface's own: where it was bent at
    /// rest.
    pub fn is_crease(&self, triangle: u32, k: usize) -> bool {
        self.smooth.creases[triangle as usize][k]
    }

    /// True when this triangle answers for the feature: of two triangles that share an edge,
    /// the one with the lower index.
    pub fn owns(&self, triangle: u32, feature: Feature) -> bool {
        match feature {
            Feature::Edge(k) => triangle < self.neighbors[triangle as usize][k],
            Feature::Face => true,
            Feature::Vertex(_) => false,
        }
    }

    fn normal(&self, triangle: u32, x: &[Vec3]) -> Vec3 {
        let area = area_vector(&self.corners(triangle, x));
        area.try_normalize(0.0).unwrap_or_else(Vec3::zeros)
    }

    fn angle_at(&self, triangle: u32, vertex: u32, x: &[Vec3]) -> f64 {
        let t = self.triangles[triangle as usize];
        let k = t.iter().position(|&v| v == vertex).unwrap_or(0);
        let at = |j: usize| x[t[(k + j) % 3] as usize] - x[vertex as usize];
        at(1).angle(&at(2))
    }
}

fn of_corners(&[u, v, w]: &[u32; 3], x: &[Vec3]) -> [Vec3; 3] {
    [x[u as usize], x[v as usize], x[w as usize]]
}

fn edge_lengths(t: &[u32; 3], x: &[Vec3]) -> [f64; 3] {
    std::array::from_fn(|k| (x[t[k] as usize] - x[t[(k + 1) % 3] as usize]).norm())
}

/// For each triangle the corners that no earlier triangle has.
fn owners(triangles: &[[u32; 3]], vertices: usize) -> Vec<[bool; 3]> {
    let mut taken = vec![false; vertices];
    let mut take = |v: u32| !std::mem::replace(&mut taken[v as usize], true);
    triangles.iter().map(|t| t.map(&mut take)).collect()
}

/// For each vertex the longest of its triangles' longest edges.
fn longest_around(triangles: &[[u32; 3]], edge_of: &[f64], vertices: usize) -> Vec<f64> {
    let mut longest = vec![0.0_f64; vertices];
    for (triangle, &edge) in triangles.iter().zip(edge_of) {
        triangle.iter().for_each(|&v| longest[v as usize] = longest[v as usize].max(edge));
    }
    longest
}

/// Triangles around each vertex, as offsets and a list.
fn triangles_around(triangles: &[[u32; 3]], vertices: usize) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0u32; vertices + 1];
    triangles.iter().flatten().for_each(|&v| start[v as usize + 1] += 1);
    for v in 0..vertices {
        start[v + 1] += start[v];
    }
    let mut next = start.clone();
    let mut around = vec![0; triangles.len() * 3];
    for (t, triangle) in triangles.iter().enumerate() {
        for &v in triangle {
            around[next[v as usize] as usize] = t as u32;
            next[v as usize] += 1;
        }
    }
    (start, around)
}

/// The triangle across each edge. Where more than two share an edge, pairs are taken in order.
fn neighbors(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut edges: Vec<([u32; 2], usize, usize)> = Vec::with_capacity(triangles.len() * 3);
    for (t, v) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (v[k], v[(k + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], t, k));
        }
    }
    edges.sort_unstable();
    let mut neighbors = vec![[NONE; 3]; triangles.len()];
    let mut i = 0;
    while i + 1 < edges.len() {
        let ((e, t, k), (other, u, j)) = (edges[i], edges[i + 1]);
        if e == other {
            neighbors[t][k] = u as u32;
            neighbors[u][j] = t as u32;
            i += 2;
        } else {
            i += 1;
        }
    }
    neighbors
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::tests::{Scene, cube};
    use crate::contact::triangle::closest_on_triangle;
    use crate::random::Random;

    /// Planes of triangles, of slivers and of such as rounding leaves on a line, set no point and
    /// no triangle farther apart than they are; of even triangles they tell most.
    #[test]
    fn planes_bound_distances_from_below() {
        let (mut random, mut told) = (Random::new(15), 0);
        for i in 0..3000 {
            let (a, b) = (random.vector(0.01), random.vector(0.01));
            let beside = random.vector([0.01, 1e-8, 1e-16][i % 3]);
            let x = [a, b, a + (b - a) * random.unit() + beside].map(|p| p + Vec3::repeat(0.7));
            let facet = Facet::new(&x, &[Vec3::zeros(); 3]);
            let y = [0; 3].map(|_| x[0] + random.vector(0.004) + Vec3::x() * 0.006);
            let heights = facet.heights(&x[0], &y);
            let distances = [0, 1, 2].map(|k| closest_on_triangle(&y[k], &x).distance_squared);
            for k in 0..3 {
                let most = distances[k] * ROUNDED_UP + 1e-18;
                assert!(facet.distance_squared_by(heights[k]) <= most, "{i}: {most}");
            }
            let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min).sqrt();
            assert!(!facet.is_beyond(&heights, nearest), "{i}");
            told += usize::from(i % 3 == 0 && facet.is_beyond(&heights, 0.5 * nearest));
        }
        assert!(told > 200, "{told} of 1000");
    }

    /// Over a cube blown up to a ball, bent everywhere: no jump over edges, nor at vertices.
    #[test]
    fn mean_normals_go_on_from_face_to_edge_to_vertex() {
        let (mut x, triangles) = cube(0.02, 3);
        x.iter_mut().for_each(|p| *p = p.normalize() * 0.01);
        let mut scene = Scene::new();
        scene.soft((x.clone(), triangles.clone()));
        let surface = Surface::new(0, &scene.desc.softs[0].flesh, 0, &[]);
        for t in 0..triangles.len() as u32 {
            for k in 0..3 {
                let corner = triangles[t as usize][k];
                let mut weights = [0.0; 3];
                weights[k] = 1.0;
                let at = (surface.mean_normal(t, &weights, &x), surface.edge_within(t, &weights));
                assert!((at.0 - surface.mean_normal_at(corner, &x)).norm() < 1e-15);
                assert!((at.1 - surface.edge_at(corner)).abs() < 1e-15);

                let next = triangles[t as usize][(k + 1) % 3];
                let across = surface.across(t, k).expect("a closed surface");
                let seen = |u: u32, off: f64| {
                    let place = |v: u32| match v {
                        v if v == corner => 0.3 - 0.5 * off,
                        v if v == next => 0.7 - 0.5 * off,
                        _ => off,
                    };
                    let weights = triangles[u as usize].map(place);
                    (surface.mean_normal(u, &weights, &x), surface.edge_within(u, &weights))
                };
                let [(own, edge), (other, edge_there)] = [seen(t, 1e-9), seen(across, 1e-9)];
                assert!((own - other).norm() < 1e-8 && (edge - edge_there).abs() < 1e-10);
                assert!((seen(t, 0.3).0 - own).norm() > 1e-3, "it is bent");
            }
        }
    }
}
