//! Smooth refinement by Loop subdivision that passes through the given vertices.
//!
//! Plain Loop subdivision (Loop 1987) shrinks the mesh towards its inside. Here the control
//! vertices are first moved so that the limit surface passes through the given ones: a few rounds
//! of `control += given - limit(control)` (progressive interpolation, Cheng et al. 2009), and the
//! finest mesh is pushed to its limit positions. A closed convex-ish mesh then gains a little
//! volume, as the smooth body that its vertices were taken from has more than their polyhedron;
//! [`Refined::volume_ratio`] says how much.

use super::edges::Edges;
use crate::work::phase;
use crate::{RigError, TriMesh};
use thenar_core::Vec3;

/// Rounds of progressive interpolation.
const ROUNDS: usize = 20;

/// More triangles than this are refused.
const TRIANGLES_MAX: usize = 4_000_000;

/// A refined mesh.
#[derive(Clone, Debug)]
pub struct Refined {
    /// The mesh; its first vertices are those of the given mesh, at (nearly) the same place.
    pub mesh: TriMesh,
    /// Volume over that of the given mesh (meaningful for closed meshes).
    pub volume_ratio: f64,
    /// Largest distance between a given vertex and where it is now \[m\].
    pub moved_max: f64,
}

/// Refines until there are at least `triangles_min` triangles.
pub fn subdivide_to(mesh: &TriMesh, triangles_min: usize) -> Result<Refined, RigError> {
    mesh.check()?;
    let mut levels = 0;
    while mesh.triangles.len() << (2 * levels) < triangles_min && levels < 12 {
        levels += 1;
    }
    subdivide(mesh, levels)
}

/// Splits every triangle into four, `levels` times. Edges of one triangle, or of more than two,
/// are refined as smooth curves of their own.
pub fn subdivide(mesh: &TriMesh, levels: usize) -> Result<Refined, RigError> {
    mesh.check()?;
    if levels > 12 || mesh.triangles.len() << (2 * levels) > TRIANGLES_MAX {
        return Err(RigError::invalid(format!(
            "{levels} levels of subdivision of {} triangles would give more than {TRIANGLES_MAX}",
            mesh.triangles.len()
        )));
    }
    if levels == 0 {
        return Ok(Refined { mesh: mesh.clone(), volume_ratio: 1.0, moved_max: 0.0 });
    }
    phase("refining the mesh")?;
    let mut fine = interpolating_control(mesh);
    for _ in 0..levels {
        fine = split(&fine);
    }
    let stencil = Stencil::new(&fine);
    fine.positions = stencil.limit(&fine.positions);

    let moved = |(a, b): (&Vec3, &Vec3)| (a - b).norm();
    let moved_max = mesh.positions.iter().zip(&fine.positions).map(moved).fold(0.0, f64::max);
    Ok(Refined { volume_ratio: fine.volume() / mesh.volume(), moved_max, mesh: fine })
}

/// The mesh whose Loop limit surface passes through the vertices of `mesh`.
fn interpolating_control(mesh: &TriMesh) -> TriMesh {
    let stencil = Stencil::new(mesh);
    let mut control = mesh.clone();
    for _ in 0..ROUNDS {
        let limit = stencil.limit(&control.positions);
        for ((c, given), limit) in control.positions.iter_mut().zip(&mesh.positions).zip(&limit) {
            *c += given - limit;
        }
    }
    control
}

/// The neighbours of each vertex. A vertex on a boundary or non-manifold edge counts only its
/// neighbours along such edges.
struct Stencil {
    first: Vec<u32>,
    neighbours: Vec<u32>,
    curve: Vec<bool>,
}

impl Stencil {
    fn new(mesh: &TriMesh) -> Self {
        let edges = Edges::new(&mesh.triangles);
        let n = mesh.positions.len();
        let mut curve = vec![false; n];
        let sharp = |e: usize| edges.sides(e).len() != 2;
        for (e, edge) in edges.list.iter().enumerate() {
            edge.vertices.iter().for_each(|&v| curve[v as usize] |= sharp(e));
        }
        let mut lists = vec![Vec::new(); n];
        for (e, edge) in edges.list.iter().enumerate() {
            let [a, b] = edge.vertices;
            for (v, other) in [(a, b), (b, a)] {
                if !curve[v as usize] || sharp(e) {
                    lists[v as usize].push(other);
                }
            }
        }
        let mut first = vec![0];
        let mut neighbours = Vec::new();
        for list in lists {
            neighbours.extend(list);
            first.push(neighbours.len() as u32);
        }
        Self { first, neighbours, curve }
    }

    fn around(&self, v: usize) -> &[u32] {
        &self.neighbours[self.first[v] as usize..self.first[v + 1] as usize]
    }

    /// Each vertex mixed with the mean of its neighbours, the latter by the weight from `share`
    /// (given the number of neighbours and whether it lies on a curve).
    fn mixed(&self, positions: &[Vec3], share: fn(usize, bool) -> f64) -> Vec<Vec3> {
        let mix = |(v, p): (usize, &Vec3)| {
            let around = self.around(v);
            let corner = self.curve[v] && around.len() != 2;
            if around.is_empty() || corner {
                return *p;
            }
            let mean =
                around.iter().map(|&x| positions[x as usize]).sum::<Vec3>() / around.len() as f64;
            let s = share(around.len(), self.curve[v]);
            p * (1.0 - s) + mean * s
        };
        positions.iter().enumerate().map(mix).collect()
    }

    /// Places of the vertices after one refinement.
    fn refined(&self, positions: &[Vec3]) -> Vec<Vec3> {
        self.mixed(positions, |n, curve| if curve { 0.25 } else { loop_share(n) })
    }

    /// Places of the vertices after infinitely many refinements.
    fn limit(&self, positions: &[Vec3]) -> Vec<Vec3> {
        self.mixed(positions, |n, curve| {
            let s = loop_share(n);
            if curve { 1.0 / 3.0 } else { s / (s + 3.0 / 8.0) }
        })
    }
}

/// `n β`: the neighbours' part in Loop's vertex rule.
fn loop_share(n: usize) -> f64 {
    let c = 3.0 / 8.0 + (2.0 * std::f64::consts::PI / n as f64).cos() / 4.0;
    5.0 / 8.0 - c * c
}

/// One step of Loop subdivision. Edge vertices follow the old ones, in the order of edges.
fn split(mesh: &TriMesh) -> TriMesh {
    let edges = Edges::new(&mesh.triangles);
    let n = mesh.positions.len() as u32;
    let mut positions = Stencil::new(mesh).refined(&mesh.positions);
    let at = |v: u32| mesh.positions[v as usize];

    for (e, edge) in edges.list.iter().enumerate() {
        let ends = at(edge.vertices[0]) + at(edge.vertices[1]);
        positions.push(match edges.sides(e) {
            [a, b] => {
                let opposite = [a, b]
                    .map(|s| at(mesh.triangles[s.triangle as usize][(s.corner as usize + 2) % 3]));
                ends * 0.375 + (opposite[0] + opposite[1]) * 0.125
            }
            _ => ends * 0.5,
        });
    }

    let mut triangles = Vec::with_capacity(4 * mesh.triangles.len());
    for (&[a, b, c], of) in mesh.triangles.iter().zip(&edges.of_triangle) {
        let [ab, bc, ca] = of.map(|e| n + e);
        triangles.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    TriMesh { positions, triangles }
}
