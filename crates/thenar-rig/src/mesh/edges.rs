//! The edges of a triangle mesh, by sorting.

/// An undirected edge and the triangles around it.
#[derive(Clone, Debug)]
pub struct Edge {
    /// Vertices of the edge, the smaller index first.
    pub vertices: [u32; 2],
    /// Range into `Edges::sides`.
    first: u32,
    count: u32,
}

/// One triangle's side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct EdgeSide {
    /// Triangle that has the edge.
    pub triangle: u32,
    /// The side runs from corner `corner` to the next.
    pub corner: u32,
    /// True if the triangle runs from the edge's smaller vertex to the larger.
    pub forward: bool,
}

/// All edges, sorted by their vertices.
#[derive(Clone, Debug, Default)]
pub struct Edges {
    /// The edges.
    pub list: Vec<Edge>,
    sides: Vec<EdgeSide>,
    /// Per triangle and side (from corner k to k+1), its edge.
    pub of_triangle: Vec<[u32; 3]>,
}

impl Edges {
    pub fn new(triangles: &[[u32; 3]]) -> Self {
        let mut all: Vec<([u32; 2], EdgeSide)> = Vec::with_capacity(3 * triangles.len());
        for (t, triangle) in triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
                let side = EdgeSide { triangle: t as u32, corner: k as u32, forward: a < b };
                all.push(([a.min(b), a.max(b)], side));
            }
        }
        all.sort_unstable();

        let mut edges = Self { of_triangle: vec![[0; 3]; triangles.len()], ..Self::default() };
        for (vertices, side) in all {
            if edges.list.last().is_none_or(|e| e.vertices != vertices) {
                let first = edges.sides.len() as u32;
                edges.list.push(Edge { vertices, first, count: 0 });
            }
            let index = edges.list.len() - 1;
            edges.list[index].count += 1;
            edges.of_triangle[side.triangle as usize][side.corner as usize] = index as u32;
            edges.sides.push(side);
        }
        edges
    }

    /// The triangle sides along edge `e`.
    pub fn sides(&self, e: usize) -> &[EdgeSide] {
        let Edge { first, count, .. } = self.list[e];
        &self.sides[first as usize..(first + count) as usize]
    }
}
