//! Orientation of a mesh: which side is out.

use super::edges::Edges;
use super::nesting::depths;
use crate::work::phase;
use crate::{RigError, TriMesh};

/// Changes that [`TriMesh::orient`] made.
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
        phase("orienting the pieces of the mesh")?;
        let before = self.triangles.clone();
        let mut result = Orientation::default();
        let pieces = self.agree(&mut result);

        let mut closed = Vec::new();
        for piece in pieces.iter().filter(|p| p.closed) {
            let mut part = self.part(&piece.triangles);
            let inward = part.volume() < 0.0;
            if inward {
                part.triangles.iter_mut().for_each(|t| t.swap(1, 2));
                self.turn(&piece.triangles);
            }
            closed.push((piece, inward, part));
        }
        if closed.iter().any(|(_, inward, _)| *inward) && closed.len() > 1 {
            let (turned, parts): (Vec<_>, Vec<_>) =
                closed.into_iter().map(|(piece, inward, part)| ((piece, inward), part)).unzip();
            let inward: Vec<usize> = (0..turned.len()).filter(|&k| turned[k].1).collect();
            let depths = depths(&parts, &inward)?;
            for (&k, _) in inward.iter().zip(depths).filter(|(_, depth)| depth % 2 == 1) {
                self.turn(&turned[k].0.triangles);
                result.cavities += 1;
            }
        }
        result.flipped_triangles =
            before.iter().zip(&self.triangles).filter(|(a, b)| a != b).count();
        Ok(result)
    }

    /// Makes triangles face the other way.
    fn turn(&mut self, triangles: &[u32]) {
        triangles.iter().for_each(|&t| self.triangles[t as usize].swap(1, 2));
    }

    /// Some of the triangles with only their own vertices, in the order these have here. Costs what
    /// they are, not what the mesh is.
    fn part(&self, triangles: &[u32]) -> TriMesh {
        let corners = || triangles.iter().map(|&t| self.triangles[t as usize]);
        let mut used: Vec<u32> = corners().flatten().collect();
        used.sort_unstable();
        used.dedup();
        TriMesh {
            positions: used.iter().map(|&v| self.positions[v as usize]).collect(),
            triangles: corners()
                .map(|t| t.map(|v| used.partition_point(|&u| u < v) as u32))
                .collect(),
        }
    }

    /// Walks over two-sided edges from the first triangle of each piece, turning triangles to
    /// agree.
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
