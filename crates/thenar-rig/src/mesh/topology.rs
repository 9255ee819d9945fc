//! What a mesh is made of: pieces, holes, handles, orientation.

use super::edges::Edges;
use crate::{RigError, TriMesh, mesh::Bvh};

/// The shape of a mesh's connections.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Topology {
    /// Vertices that triangles use.
    pub vertices: usize,
    /// Edges.
    pub edges: usize,
    /// Triangles.
    pub triangles: usize,
    /// Pieces connected through shared vertices.
    pub components: usize,
    /// Edges of one triangle only.
    pub boundary_edges: usize,
    /// Edges of more than two triangles.
    pub non_manifold_edges: usize,
    /// Edges whose two triangles run along them in the same direction.
    pub misoriented_edges: usize,
    /// Vertices whose triangles form more than one fan.
    pub non_manifold_vertices: usize,
    /// Triangles of no area.
    pub degenerate_triangles: usize,
}

impl Topology {
    /// Counts everything; the mesh must pass [`TriMesh::check`] and should be welded.
    pub fn of(mesh: &TriMesh) -> Self {
        let edges = Edges::new(&mesh.triangles);
        let mut used = vec![false; mesh.positions.len()];
        mesh.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);

        let mut topology = Self {
            vertices: used.iter().filter(|&&u| u).count(),
            edges: edges.list.len(),
            triangles: mesh.triangles.len(),
            components: components(mesh).1,
            boundary_edges: 0,
            non_manifold_edges: 0,
            misoriented_edges: 0,
            non_manifold_vertices: non_manifold_vertices(mesh, &edges),
            degenerate_triangles: (0..mesh.triangles.len())
                .filter(|&t| mesh.area_vector(t).norm() == 0.0)
                .count(),
        };
        for e in 0..edges.list.len() {
            match edges.sides(e) {
                [_] => topology.boundary_edges += 1,
                [a, b] => topology.misoriented_edges += usize::from(a.forward == b.forward),
                _ => topology.non_manifold_edges += 1,
            }
        }
        topology
    }

    /// Every edge has exactly two triangles.
    pub fn closed(&self) -> bool {
        self.boundary_edges == 0 && self.non_manifold_edges == 0
    }

    /// No edge has more than two triangles, no vertex more than one fan.
    pub fn manifold(&self) -> bool {
        self.non_manifold_edges == 0 && self.non_manifold_vertices == 0
    }

    /// Neighbouring triangles agree on which side is out.
    pub fn oriented(&self) -> bool {
        self.misoriented_edges == 0
    }

    /// Total number of handles of a closed manifold mesh: `V - E + F = 2 (components - genus)`.
    pub fn genus(&self) -> Option<i64> {
        let euler = self.vertices as i64 - self.edges as i64 + self.triangles as i64;
        (self.closed() && self.manifold()).then_some(self.components as i64 - euler / 2)
    }
}

/// The component of each vertex (numbered in order of first vertex; unused vertices have
/// `u32::MAX`) and their number.
pub(crate) fn components(mesh: &TriMesh) -> (Vec<u32>, usize) {
    let mut parent: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    for &[a, b, c] in &mesh.triangles {
        join(&mut parent, a, b);
        join(&mut parent, b, c);
    }
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);

    let mut label = vec![u32::MAX; parent.len()];
    let mut count = 0;
    for v in 0..parent.len() {
        if used[v] {
            let root = find(&mut parent, v as u32) as usize;
            if label[root] == u32::MAX {
                label[root] = count;
                count += 1;
            }
            label[v] = label[root];
        }
    }
    (label, count as usize)
}

/// Root of `v`, halving the path on the way.
pub(crate) fn find(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        parent[v as usize] = parent[parent[v as usize] as usize];
        v = parent[v as usize];
    }
    v
}

/// Unites two sets; the smaller root stays root.
pub(crate) fn join(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(parent, a), find(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}

/// Number of vertices whose triangle corners do not hang together through edges.
fn non_manifold_vertices(mesh: &TriMesh, edges: &Edges) -> usize {
    // Unites corners (3 t + k) that meet at a vertex across an edge, then counts fans per vertex.
    let mut parent: Vec<u32> = (0..3 * mesh.triangles.len() as u32).collect();
    let corner_at = |t: u32, v: u32| {
        mesh.triangles[t as usize].iter().position(|&x| x == v).map(|k| 3 * t + k as u32)
    };
    for (e, edge) in edges.list.iter().enumerate() {
        let sides = edges.sides(e);
        for v in edge.vertices {
            for other in &sides[1..] {
                if let (Some(a), Some(b)) =
                    (corner_at(sides[0].triangle, v), corner_at(other.triangle, v))
                {
                    join(&mut parent, a, b);
                }
            }
        }
    }
    let mut fans = vec![0; mesh.positions.len()];
    for corner in 0..parent.len() {
        if find(&mut parent, corner as u32) == corner as u32 {
            fans[mesh.triangles[corner / 3][corner % 3] as usize] += 1;
        }
    }
    fans.iter().filter(|&&f| f > 1).count()
}

/// What [`TriMesh::orient`] changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Orientation {
    /// Triangles turned to agree with their neighbours or to face outward.
    pub flipped_triangles: usize,
    /// Edge-connected pieces that cannot be oriented (Möbius strips).
    pub unorientable_pieces: usize,
    /// Closed pieces that lie within others and faced inward: kept as walls of cavities.
    pub cavities: usize,
}

impl TriMesh {
    /// Makes neighbouring triangles agree on their orientation and closed pieces face outward.
    /// A closed piece that faces inward stays so when it lies inside an odd number of others.
    pub fn orient(&mut self) -> Result<Orientation, RigError> {
        self.check()?;
        let before = self.triangles.clone();
        let mut result = Orientation::default();
        let pieces = self.agree(&mut result);

        let mut closed = Vec::new();
        for piece in pieces.iter().filter(|p| p.closed) {
            let triangles = piece.triangles.iter().map(|&t| self.triangles[t as usize]).collect();
            let mut part = TriMesh { positions: self.positions.clone(), triangles }.compacted();
            let inward = part.volume() < 0.0;
            if inward {
                part.triangles.iter_mut().for_each(|t| t.swap(1, 2));
                piece.triangles.iter().for_each(|&t| self.triangles[t as usize].swap(1, 2));
            }
            closed.push((piece, inward, part));
        }
        if closed.len() > 1 {
            result.cavities = self.restore_cavities(&closed);
        }
        result.flipped_triangles =
            before.iter().zip(&self.triangles).filter(|(a, b)| a != b).count();
        Ok(result)
    }

    /// Turns inward again what is a cavity wall; returns how many are.
    fn restore_cavities(&mut self, closed: &[(&Piece, bool, TriMesh)]) -> usize {
        let hierarchies: Vec<Bvh> = closed.iter().map(|(_, _, part)| Bvh::new(part)).collect();
        let mut cavities = 0;
        for (i, (piece, inward, part)) in closed.iter().enumerate() {
            if !inward {
                continue;
            }
            let p = part.positions[0];
            let depth =
                (0..closed.len()).filter(|&j| j != i && hierarchies[j].contains(&p)).count();
            if depth % 2 == 1 {
                piece.triangles.iter().for_each(|&t| self.triangles[t as usize].swap(1, 2));
                cavities += 1;
            }
        }
        cavities
    }

    /// Walks over two-sided edges from the first triangle of each piece, turning triangles to agree.
    fn agree(&mut self, result: &mut Orientation) -> Vec<Piece> {
        let edges = Edges::new(&self.triangles);
        // For each triangle: turned or not, once seen.
        let mut turned: Vec<Option<bool>> = vec![None; self.triangles.len()];
        let mut pieces = Vec::new();
        for seed in 0..self.triangles.len() {
            if turned[seed].is_some() {
                continue;
            }
            turned[seed] = Some(false);
            let mut piece = Piece { triangles: vec![seed as u32], closed: true };
            let (mut next, mut consistent) = (0, true);
            while next < piece.triangles.len() {
                let t = piece.triangles[next];
                next += 1;
                for e in edges.of_triangle[t as usize] {
                    let &[a, b] = edges.sides(e as usize) else {
                        piece.closed = false;
                        continue;
                    };
                    let other = if a.triangle == t { b.triangle } else { a.triangle };
                    let here = turned[t as usize].unwrap_or(false);
                    let wanted = here ^ (a.forward == b.forward);
                    match turned[other as usize] {
                        None => {
                            turned[other as usize] = Some(wanted);
                            piece.triangles.push(other);
                        }
                        Some(is) => consistent &= is == wanted,
                    }
                }
            }
            piece.closed &= consistent;
            result.unorientable_pieces += usize::from(!consistent);
            pieces.push(piece);
        }
        for (triangle, turned) in self.triangles.iter_mut().zip(turned) {
            if turned == Some(true) {
                triangle.swap(1, 2);
            }
        }
        pieces
    }
}

/// Triangles connected through two-sided edges.
struct Piece {
    triangles: Vec<u32>,
    /// Orientable and without boundary.
    closed: bool,
}
