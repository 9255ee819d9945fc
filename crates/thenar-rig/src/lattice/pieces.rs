//! Lattice tetrahedra duplicated per connected piece of the body.
//!
//! Within one lattice tetrahedron the body may show in several pieces that do not touch there (two
//! fingers). Each piece gets a tetrahedron of its own with four nodes of its own; nodes are then
//! merged wherever the body runs through from one tetrahedron into the next. Two fingers thus
//! share nodes only where a chain of flesh connects them (after Molino et al. 2004, Nesme et al.
//! 2009).

use super::bcc::{Point, TetKey};
use super::cells::Cells;
use super::samples::Samples;
use super::union_find::UnionFind;
use thenar_core::Vec3;

/// The lattice cut into pieces.
pub(super) struct Pieces {
    /// Lattice tetrahedron of each piece.
    pub keys: Vec<TetKey>,
    /// Volume of that tetrahedron \[m³\].
    pub volumes: Vec<f64>,
    /// Nodes of each piece.
    pub nodes: Vec<[u32; 4]>,
    /// Place of each node.
    pub positions: Vec<Vec3>,
    /// Number of inside points in each piece.
    pub counts: Vec<u32>,
    /// Piece of each inside point.
    pub of_sample: Vec<u32>,
}

impl Pieces {
    /// Cuts the lattice along the sampled body.
    pub fn new(samples: &Samples, lattice: &impl Cells) -> Self {
        let count = samples.cells.len();
        let keys: Vec<TetKey> = (0..count).map(|i| lattice.locate(&samples.position(i))).collect();

        // Pieces: points linked within one tetrahedron.
        let mut sets = UnionFind::new(count);
        for_each_link(samples, |i, j| {
            if keys[i as usize] == keys[j as usize] {
                sets.union(i, j);
            }
        });
        let mut pieces = Self {
            keys: Vec::new(),
            volumes: Vec::new(),
            nodes: Vec::new(),
            positions: Vec::new(),
            counts: Vec::new(),
            of_sample: vec![u32::MAX; count],
        };
        for i in 0..count {
            let root = sets.find(i as u32) as usize;
            if root == i {
                pieces.of_sample[i] = pieces.keys.len() as u32;
                pieces.keys.push(keys[i]);
                pieces.volumes.push(lattice.volume(keys[i]));
                pieces.counts.push(0);
            }
            let piece = pieces.of_sample[root];
            pieces.of_sample[i] = piece;
            pieces.counts[piece as usize] += 1;
        }
        pieces.merge_nodes(samples, lattice);
        pieces
    }

    /// Gives each piece four nodes and merges them across the links between pieces.
    fn merge_nodes(&mut self, samples: &Samples, lattice: &impl Cells) {
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        for_each_link(samples, |i, j| {
            let (a, b) = (self.of_sample[i as usize], self.of_sample[j as usize]);
            if a != b {
                pairs.push([a.min(b), a.max(b)]);
            }
        });
        pairs.sort_unstable();
        pairs.dedup();

        let corners: Vec<[Point; 4]> = self.keys.iter().map(|&k| lattice.corners(k)).collect();
        let mut sets = UnionFind::new(4 * self.keys.len());
        for [a, b] in pairs {
            for (k, p) in corners[a as usize].iter().enumerate() {
                if let Some(l) = corners[b as usize].iter().position(|q| q == p) {
                    sets.union(4 * a + k as u32, 4 * b + l as u32);
                }
            }
        }

        let mut index = vec![u32::MAX; 4 * self.keys.len()];
        for (t, corners) in corners.iter().enumerate() {
            let nodes = std::array::from_fn(|k| {
                let root = sets.find((4 * t + k) as u32) as usize;
                if index[root] == u32::MAX {
                    index[root] = self.positions.len() as u32;
                    self.positions.push(lattice.place(corners[k]));
                }
                index[root]
            });
            self.nodes.push(nodes);
        }
    }

    /// Number of tetrahedra.
    pub fn len(&self) -> usize {
        self.keys.len()
    }
}

/// Calls `f` for every pair of linked inside points.
pub(super) fn for_each_link(samples: &Samples, mut f: impl FnMut(u32, u32)) {
    for i in 0..samples.cells.len() {
        for axis in 0..3 {
            if let Some(j) = samples.next(i, axis) {
                f(i as u32, j);
            }
        }
    }
}
