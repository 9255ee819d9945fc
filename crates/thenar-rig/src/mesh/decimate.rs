//! Simplification by edge collapse.
//!
//! Edges go in order of quadric error (Garland & Heckbert 1997). The new vertex minimises the
//! quadric among the points that keep the enclosed volume unchanged (Lindstrom & Turk 1998), so a
//! closed mesh keeps its volume to rounding. A collapse is refused when it would change the
//! topology (link condition), turn a triangle by more than about 80°, or make a sliver.

use super::edges::Edges;
use super::quadric::Quadric;
use crate::work::{STAGE_MAX, Stage};
use crate::{RigError, TriMesh};
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;
use thenar_core::Vec3;

/// Weight of the walls that hold open boundaries, against the area of the triangles there.
const BOUNDARY_WEIGHT: f64 = 10.0;
/// A triangle may turn until the cosine falls to this.
const TURN_COSINE_MIN: f64 = 0.17;
/// Smallest quality (1 for equilateral) of a triangle, unless it was worse before.
const QUALITY_MIN: f64 = 0.1;

/// Looks at triangles that one collapse takes in an even mesh: six edges offered again, and about
/// three tried, with twelve triangles around each.
const LOOKS: f64 = 110.0;
/// Looks that a mesh may take in all. Each costs about as much as four comparisons of a point with
/// a triangle.
const LOOKS_MAX: usize = (STAGE_MAX / 4.0) as usize;

/// Looks between two tellings: some 60 ms.
const EVERY: usize = 1_000_000;
/// Triangles that may meet at a vertex that moves. To offer all of its edges takes as many looks as
/// the square, of which a mesh has [`LOOKS_MAX`] in all: enough for 500 such vertices. What has
/// more stays where it is.
const VALENCE_MAX: usize = 1000;

/// Collapses edges until at most `triangles_target` remain, or nothing more can be collapsed
/// without harm. A closed manifold stays one and keeps its volume.
pub fn decimate(mesh: &TriMesh, triangles_target: usize) -> Result<TriMesh, RigError> {
    decimate_within(mesh, triangles_target, vec![f64::INFINITY; mesh.positions.len()])
}

/// [`decimate`] that lengthens no edge beyond the limits of its ends \[m\], one limit per vertex;
/// more triangles than wanted may remain. A vertex that takes another's place takes the smaller
/// limit of both.
pub fn decimate_within(
    mesh: &TriMesh,
    triangles_target: usize,
    limits: Vec<f64>,
) -> Result<TriMesh, RigError> {
    mesh.check()?;
    if limits.len() != mesh.positions.len() {
        return Err(RigError::invalid(format!(
            "{} limits of edges for {} vertices",
            limits.len(),
            mesh.positions.len()
        )));
    }
    let wanted = mesh.triangles.len().saturating_sub(triangles_target);
    let stage = Stage::new("simplifying the mesh", wanted, 4.0 * LOOKS * wanted as f64, "")?;
    let mut work = Work::new(mesh, limits, stage)?;
    loop {
        let before = work.alive;
        work.collapse_until(triangles_target)?;
        // What was refused may have become possible meanwhile.
        if work.alive <= triangles_target || work.alive == before {
            return Ok(work.finish());
        }
        work.offer_all()?;
    }
}

/// A candidate collapse; stale when either vertex has changed since.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    cost: f64,
    vertices: [u32; 2],
    stamps: [u32; 2],
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then(self.vertices.cmp(&other.vertices))
    }
}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Candidate {}

struct Work {
    positions: Vec<Vec3>,
    /// Removed triangles have equal corners.
    triangles: Vec<[u32; 3]>,
    /// Triangles around each vertex that may move.
    around: Vec<Vec<u32>>,
    quadrics: Vec<Quadric>,
    /// Longest edge that a collapse may make at each vertex.
    limits: Vec<f64>,
    stamps: Vec<u32>,
    /// On an edge that has one triangle.
    boundary: Vec<bool>,
    /// On an edge of more than two triangles, or with too many around: never moved.
    locked: Vec<bool>,
    heap: BinaryHeap<Reverse<Candidate>>,
    /// Triangles looked at so far.
    looked: usize,
    /// Triangles looked at when progress was last reported.
    told: usize,
    stage: Stage,
    /// Triangles at first, and now.
    first: usize,
    alive: usize,
    origin: Vec3,
}

fn area_vector([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (b - a).cross(&(c - a)) * 0.5
}

/// Area over that of the equilateral triangle with the same mean squared edge.
fn quality([a, b, c]: &[Vec3; 3]) -> f64 {
    let edges2 = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
    if edges2 > 0.0 { 4.0 * 3f64.sqrt() * area_vector(&[*a, *b, *c]).norm() / edges2 } else { 0.0 }
}

impl Work {
    fn new(mesh: &TriMesh, limits: Vec<f64>, stage: Stage) -> Result<Self, RigError> {
        // Quadrics hold squared coordinates: stay near the origin.
        let [min, max] = mesh.bounds();
        let origin = (min + max) * 0.5;
        let n = mesh.positions.len();
        let mut triangles = mesh.triangles.clone();
        triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
        let mut work = Self {
            positions: mesh.positions.iter().map(|p| p - origin).collect(),
            first: triangles.len(),
            alive: triangles.len(),
            triangles,
            around: vec![Vec::new(); n],
            quadrics: vec![Quadric::zero(); n],
            limits,
            stamps: vec![0; n],
            boundary: vec![false; n],
            locked: vec![false; n],
            heap: BinaryHeap::new(),
            looked: 0,
            told: 0,
            stage,
            origin,
        };
        work.gather()?;
        Ok(work)
    }

    fn gather(&mut self) -> Result<(), RigError> {
        for (t, triangle) in self.triangles.iter().enumerate() {
            let corners = triangle.map(|v| self.positions[v as usize]);
            let n = area_vector(&corners);
            let area = n.norm();
            for &v in triangle {
                self.around[v as usize].push(t as u32);
                if area > 0.0 {
                    let plane = Quadric::plane(&corners[0], &(n / area), area);
                    let quadric = &mut self.quadrics[v as usize];
                    *quadric = quadric.sum(&plane);
                }
            }
        }
        let edges = Edges::new(&self.triangles);
        for (e, edge) in edges.list.iter().enumerate() {
            match edges.sides(e) {
                [side] => self.wall(edge.vertices, side.triangle),
                [_, _] => {}
                _ => edge.vertices.iter().for_each(|&v| self.locked[v as usize] = true),
            }
        }
        for (around, locked) in self.around.iter_mut().zip(&mut self.locked) {
            if around.len() > VALENCE_MAX {
                (*around, *locked) = (Vec::new(), true);
            }
        }
        self.offer_all()
    }

    fn offer_all(&mut self) -> Result<(), RigError> {
        self.heap.clear();
        let alive: Vec<_> = self
            .triangles
            .iter()
            .copied()
            .filter(|&[a, b, c]| a != b && b != c && c != a)
            .collect();
        for edge in Edges::new(&alive).list {
            self.offer(edge.vertices)?;
        }
        Ok(())
    }

    fn offer(&mut self, edge: [u32; 2]) -> Result<(), RigError> {
        self.look(edge)?;
        self.heap.extend(self.candidate(edge).map(|(candidate, _)| Reverse(candidate)));
        Ok(())
    }

    /// Counts a look at the triangles around an edge, and reports at intervals.
    fn look(&mut self, edge: [u32; 2]) -> Result<(), RigError> {
        self.looked += 1 + self.valence(edge);
        if self.looked > LOOKS_MAX {
            return Err(RigError::invalid(
                "the mesh cannot be simplified: too many triangles meet at one vertex",
            ));
        }
        if self.looked - self.told > EVERY {
            self.told = self.looked;
            self.stage.tell(self.first - self.alive)?;
        }
        Ok(())
    }

    fn valence(&self, edge: [u32; 2]) -> usize {
        edge.iter().map(|&v| self.around[v as usize].len()).sum()
    }

    /// Adds a plane through a boundary edge, square to its triangle.
    fn wall(&mut self, vertices: [u32; 2], triangle: u32) {
        let [a, b] = vertices.map(|v| self.positions[v as usize]);
        let n = area_vector(&self.corners(triangle));
        let across = (b - a).cross(&n);
        let weight = BOUNDARY_WEIGHT * (b - a).norm_squared();
        for v in vertices {
            self.boundary[v as usize] = true;
            if across.norm() > 0.0 {
                let plane = Quadric::plane(&a, &across.normalize(), weight);
                self.quadrics[v as usize] = self.quadrics[v as usize].sum(&plane);
            }
        }
    }

    fn corners(&self, t: u32) -> [Vec3; 3] {
        self.triangles[t as usize].map(|v| self.positions[v as usize])
    }

    /// The collapse of an edge, and the best place for the new vertex; none if it is locked. Places
    /// are not kept in the heap, whose entries are moved often.
    fn candidate(&self, [u, v]: [u32; 2]) -> Option<(Candidate, Vec3)> {
        let (u, v) = (u.min(v), u.max(v));
        if self.locked[u as usize] || self.locked[v as usize] {
            return None;
        }
        let quadric = self.quadrics[u as usize].sum(&self.quadrics[v as usize]);
        let [a, b] = [u, v].map(|x| self.positions[x as usize]);
        let point = match (self.boundary[u as usize], self.boundary[v as usize]) {
            (true, false) => a,
            (false, true) => b,
            (true, true) => quadric.minimum(&((a + b) * 0.5), &Vec3::zeros(), 0.0).unwrap_or(a),
            (false, false) => self.best_point(u, v, &quadric),
        };
        // A short edge costs a little even on flat ground, so that flat parts thin out evenly.
        let cost = quadric.at(&point) + 1e-6 * quadric.A.trace() * (a - b).norm_squared();
        let stamps = [u, v].map(|x| self.stamps[x as usize]);
        Some((Candidate { cost, vertices: [u, v], stamps }, point))
    }

    /// The least-error point that keeps the volume, unless it runs away.
    fn best_point(&self, u: u32, v: u32, quadric: &Quadric) -> Vec3 {
        let (a, b) = (self.positions[u as usize], self.positions[v as usize]);
        let middle = (a + b) * 0.5;
        // The tetrahedra between the new point x and the old triangles must sum to zero:
        // Σ n_t · (x - p_t) = 0.
        let (mut g, mut d, mut size) = (Vec3::zeros(), 0.0, 0.0);
        let shared = |t: &&u32| !self.triangles[**t as usize].contains(&u);
        for &t in
            self.around[u as usize].iter().chain(self.around[v as usize].iter().filter(shared))
        {
            let corners = self.corners(t);
            let n = area_vector(&corners);
            g += n;
            d += n.dot(&corners[0]);
            size += n.norm();
        }
        if g.norm() < 1e-3 * size {
            (g, d) = (Vec3::zeros(), 0.0);
        }
        match quadric.minimum(&middle, &g, d) {
            Some(x) if (x - middle).norm() <= 2.0 * (a - b).norm() => x,
            _ if g != Vec3::zeros() => middle + g * ((d - g.dot(&middle)) / g.norm_squared()),
            _ => middle,
        }
    }

    fn collapse_until(&mut self, triangles_target: usize) -> Result<(), RigError> {
        while self.alive > triangles_target {
            let Some(Reverse(next)) = self.heap.pop() else { return Ok(()) };
            let [u, v] = next.vertices;
            self.look(next.vertices)?;
            if [u, v].map(|x| self.stamps[x as usize]) != next.stamps {
                continue;
            }
            // Neighbours may have moved since it was offered.
            let Some((fresh, point)) = self.candidate([u, v]) else { continue };
            if fresh.cost > next.cost * (1.0 + 1e-9) {
                self.heap.push(Reverse(fresh));
            } else if self.valence([u, v]) <= VALENCE_MAX
                && self.link_condition(u, v)
                && self.keeps_shape(u, v, &point)
                && self.keeps_short(u, v, &point)
            {
                self.collapse(u, v, point)?;
            }
        }
        Ok(())
    }

    /// The vertices around `v`, ascending.
    fn neighbours(&self, v: u32) -> Vec<u32> {
        let mut ring: Vec<u32> = self.around[v as usize]
            .iter()
            .flat_map(|&t| self.triangles[t as usize])
            .filter(|&x| x != v)
            .collect();
        ring.sort_unstable();
        ring.dedup();
        ring
    }

    /// The two vertex rings share exactly the corners opposite the edge (Dey et al. 1999), and
    /// what remains is not folded flat onto itself.
    fn link_condition(&self, u: u32, v: u32) -> bool {
        let of_edge: Vec<u32> = self.around[u as usize]
            .iter()
            .copied()
            .filter(|&t| self.triangles[t as usize].contains(&v))
            .collect();
        let boundary_edge = of_edge.len() == 1;
        let both_on_boundary = self.boundary[u as usize] && self.boundary[v as usize];
        if of_edge.is_empty() || of_edge.len() > 2 || (both_on_boundary && !boundary_edge) {
            return false;
        }
        let (ring_u, ring_v) = (self.neighbours(u), self.neighbours(v));
        let common = ring_u.iter().filter(|x| ring_v.binary_search(x).is_ok()).count();
        // A tetrahedron, or a lone triangle, is left alone.
        common == of_edge.len() && ring_u.len() + ring_v.len() - common > 2 + common
    }

    /// No triangle that stays turns over, turns far or becomes a sliver.
    fn keeps_shape(&self, u: u32, v: u32, point: &Vec3) -> bool {
        let stays = |(from, other): (u32, u32)| {
            self.around[from as usize].iter().all(|&t| {
                let triangle = self.triangles[t as usize];
                if triangle.contains(&other) {
                    return true;
                }
                let before = self.corners(t);
                let after: [Vec3; 3] =
                    std::array::from_fn(|k| if triangle[k] == from { *point } else { before[k] });
                let (n, m) = (area_vector(&before), area_vector(&after));
                m.norm() > 0.0
                    && n.dot(&m) >= TURN_COSINE_MIN * n.norm() * m.norm()
                    && quality(&after) >= QUALITY_MIN.min(quality(&before))
            })
        };
        stays((u, v)) && stays((v, u))
    }

    /// No edge at the new vertex becomes longer than it may be.
    fn keeps_short(&self, u: u32, v: u32, point: &Vec3) -> bool {
        let own = self.limits[u as usize].min(self.limits[v as usize]);
        let short = |x: &u32| {
            let limit = own.min(self.limits[*x as usize]);
            (self.positions[*x as usize] - point).norm_squared() <= limit * limit
        };
        own == f64::INFINITY
            || self
                .neighbours(u)
                .iter()
                .chain(&self.neighbours(v))
                .all(|x| short(x) || *x == u || *x == v)
    }

    fn collapse(&mut self, u: u32, v: u32, point: Vec3) -> Result<(), RigError> {
        self.positions[u as usize] = point;
        self.quadrics[u as usize] = self.quadrics[u as usize].sum(&self.quadrics[v as usize]);
        self.boundary[u as usize] |= self.boundary[v as usize];
        self.limits[u as usize] = self.limits[u as usize].min(self.limits[v as usize]);

        let moved = std::mem::take(&mut self.around[v as usize]);
        for t in moved {
            if self.triangles[t as usize].contains(&u) {
                for x in std::mem::replace(&mut self.triangles[t as usize], [u; 3]) {
                    self.around[x as usize].retain(|&s| s != t);
                }
                self.alive -= 1;
            } else {
                for x in &mut self.triangles[t as usize] {
                    if *x == v {
                        *x = u;
                    }
                }
                self.around[u as usize].push(t);
            }
        }
        self.stamps[v as usize] += 1;
        // Costs depend on the triangles around, so every edge of the ring is offered afresh.
        self.stamps[u as usize] += 1;
        for x in self.neighbours(u) {
            self.offer([u, x])?;
        }
        Ok(())
    }

    fn finish(self) -> TriMesh {
        let origin = self.origin;
        let mut triangles = self.triangles;
        triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
        let positions = self.positions.iter().map(|p| p + origin).collect();
        TriMesh { positions, triangles }.compacted()
    }
}
