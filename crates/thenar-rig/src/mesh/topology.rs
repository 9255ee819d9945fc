//! Topology of a mesh: pieces, holes, handles.

use super::edges::Edges;
use crate::TriMesh;

/// The shape of a mesh's connections.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Topology {
    /// Vertices that triangles use.
    pub vertices: usize,
    /// Number of edges.
    pub edges: usize,
    /// Number of triangles.
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
