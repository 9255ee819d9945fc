//! Nesting of a mesh's pieces: those that lie within others.

use super::Bvh;
use crate::work::Stage;
use crate::{RigError, TriMesh};

/// Comparisons between two tellings: some 15 ms.
const EVERY: usize = 1_000_000;
/// Comparisons' worth of a piece that is asked: its tree comes from far memory. 25 000 nested
/// pieces of four triangles took four times as long as the comparisons alone.
const COLD: usize = 4;
/// Pieces asked about beforehand, to know what all of them cost.
const PROBES: usize = 64;

/// Number of the other pieces around the first vertex of each of those in `asked`. All pieces must
/// be closed and face outward.
///
/// # Errors
/// Too many pieces lie within others for a look at all; or the work is to end.
pub(super) fn depths(pieces: &[TriMesh], asked: &[usize]) -> Result<Vec<usize>, RigError> {
    let nest = PieceHierarchy::new(pieces);
    let step = asked.len().div_ceil(PROBES).max(1);
    let probes = asked.iter().step_by(step);
    let expected: usize = probes.map(|&k| nest.cost(k, &nest.around(pieces, k))).sum();
    let expected = expected * step;
    let stage = Stage::new(
        "finding cavities",
        expected,
        expected as f64,
        "too many pieces of the mesh lie within each other; leave inner ones out",
    )?;
    let (mut spent, mut told) = (0, 0);
    let mut depths = Vec::with_capacity(asked.len());
    for &k in asked {
        let around = nest.around(pieces, k);
        spent += nest.cost(k, &around);
        if spent - told > EVERY {
            stage.beyond(spent)?;
            told = spent;
        }
        let p = &pieces[k].positions[0];
        let holds = |j: &&u32| **j as usize != k && nest.hierarchies[**j as usize].contains(p);
        depths.push(around.iter().filter(holds).count());
    }
    Ok(depths)
}

/// Pieces, and a hierarchy over the boxes around them.
struct PieceHierarchy {
    hierarchies: Vec<Bvh>,
    /// Comparisons that each piece takes to say whether it holds its middle.
    costs: Vec<usize>,
    boxes: TriMesh,
    tree: Bvh,
}

impl PieceHierarchy {
    fn new(pieces: &[TriMesh]) -> Self {
        // A triangle between the far corners of a box has that box.
        let boxes = TriMesh {
            positions: pieces.iter().flat_map(TriMesh::bounds).collect(),
            triangles: (0..pieces.len() as u32).map(|k| [2 * k, 2 * k + 1, 2 * k + 1]).collect(),
        };
        let hierarchies: Vec<Bvh> = pieces.iter().map(Bvh::new).collect();
        let middle = |k: usize| (boxes.positions[2 * k] + boxes.positions[2 * k + 1]) * 0.5;
        let costs = hierarchies.iter().enumerate().map(|(k, h)| h.winding_cost(&middle(k)));
        Self { costs: costs.collect(), hierarchies, tree: Bvh::new(&boxes), boxes }
    }

    /// The pieces whose boxes hold the first vertex of piece `k`: outside of its box a piece winds
    /// around nothing.
    fn around(&self, pieces: &[TriMesh], k: usize) -> Vec<u32> {
        let p = pieces[k].positions[0];
        let mut near = self.tree.near(&p, 0.0);
        near.retain(|&j| {
            let [low, high] = [0, 1].map(|end| self.boxes.positions[2 * j as usize + end]);
            (0..3).all(|axis| low[axis] <= p[axis] && p[axis] <= high[axis])
        });
        near
    }

    /// Comparisons, roughly, that it takes to find these pieces and to ask all but piece `k`.
    fn cost(&self, k: usize, around: &[u32]) -> usize {
        let others = around.iter().filter(|&&j| j as usize != k);
        1 + others.map(|&j| COLD * (1 + self.costs[j as usize])).sum::<usize>()
    }
}
