//! Leaving out nodes that hardly any of the body holds.
//!
//! ```text
//!     ○───○
//!    / \ / \        Of the elements around ○ the body fills corners only: with s of their height s³ of their volume. On
//!   ●───●───●       its skin there a load still has s of its weight at ○, which goes 1/s² times as far as it should.
//! ```
//!
//! A weak element is not the matter: one that lies with a whole face in the body gives way as those
//! below it do. But a node that has no other elements has little stiffness and little mass, and a
//! load, or a turn of what it hangs on, flings it. Such a node is left out with its elements, and
//! what they hold of the body is carried by those beside, by extrapolation, as methods of cut cells
//! do (Badia et al. 2018).

use super::pieces::Pieces;
use super::prune::keep_largest_component;
use super::tet;

/// Least stiffness of a node, over the mean of those it shares elements with. A node at the corner
/// of a block of full elements has an eighth of those inside, less what the sampling of the body
/// may miss.
pub const SUPPORT_MIN: f64 = 0.1;

/// The trace of a node's stiffness is a multiple of the sum of `V |∇N|²` over its elements,
/// whatever the law.
struct Support {
    /// Share of each element: the fraction filled times this, corner by corner \[m\].
    shares: Vec<[f64; 4]>,
    /// Elements around each node.
    around: Vec<Vec<u32>>,
}

/// Clears `keep` around nodes with less than `least` of the stiffness of their neighbours, weakest
/// first, as far as the rest hangs together; `point_volume` is the volume of an inside point
/// \[m³\].
pub(super) fn leave_out_unsupported(
    pieces: &Pieces,
    point_volume: f64,
    least: f64,
    keep: &mut Vec<bool>,
) {
    let support = Support::new(pieces, point_volume);
    let mut stays = vec![false; pieces.positions.len()];
    loop {
        let weakest = support.weakest(pieces, keep, least, &stays);
        if weakest.is_empty() {
            return;
        }
        // No two of them share an element, so that mostly all can go at once.
        if support.leave_out(pieces, &weakest, keep) {
            continue;
        }
        for node in weakest {
            stays[node as usize] = !support.leave_out(pieces, &[node], keep);
        }
    }
}

impl Support {
    fn new(pieces: &Pieces, point_volume: f64) -> Self {
        let mut around = vec![Vec::new(); pieces.positions.len()];
        let mut shares = Vec::with_capacity(pieces.len());
        for (t, nodes) in pieces.nodes.iter().enumerate() {
            nodes.iter().for_each(|&n| around[n as usize].push(t as u32));
            let x = nodes.map(|n| pieces.positions[n as usize]);
            let volume = tet::volume(&x);
            let fill = (f64::from(pieces.counts[t]) * point_volume / volume).min(1.0);
            shares.push(tet::gradients(&x).map(|g| fill * volume * g.norm_squared()));
        }
        Self { shares, around }
    }

    /// Nodes that may go: each weaker than all it shares an element with, compared with those
    /// around it.
    fn weakest(&self, pieces: &Pieces, keep: &[bool], least: f64, stays: &[bool]) -> Vec<u32> {
        let mut stiffness = vec![0.0; self.around.len()];
        for (t, nodes) in pieces.nodes.iter().enumerate().filter(|(t, _)| keep[*t]) {
            nodes.iter().zip(self.shares[t]).for_each(|(&n, s)| stiffness[n as usize] += s);
        }
        let ratios: Vec<f64> = (0..self.around.len())
            .map(|n| {
                let beside = self.beside(pieces, keep, n as u32);
                let sum: f64 = beside.iter().map(|&m| stiffness[m as usize]).sum();
                stiffness[n] * beside.len() as f64 / sum
            })
            .collect();
        // Of equals the first. What is not used has no ratio.
        let weaker = |n: u32, m: u32| (ratios[n as usize], n) < (ratios[m as usize], m);
        let may_go = |n: u32| ratios[n as usize] < least && !stays[n as usize];
        (0..ratios.len() as u32)
            .filter(|&n| may_go(n))
            .filter(|&n| {
                let mut beside = self.beside(pieces, keep, n).into_iter();
                beside.all(|m| !may_go(m) || weaker(n, m))
            })
            .collect()
    }

    /// Nodes that share a kept element with one, ascending.
    fn beside(&self, pieces: &Pieces, keep: &[bool], node: u32) -> Vec<u32> {
        let kept = self.around[node as usize].iter().filter(|&&t| keep[t as usize]);
        let mut beside: Vec<u32> = kept.flat_map(|&t| pieces.nodes[t as usize]).collect();
        beside.sort_unstable();
        beside.dedup();
        beside.retain(|&n| n != node);
        beside
    }

    /// Leaves out nodes with their elements; false, and nothing done, when the rest would fall
    /// apart.
    fn leave_out(&self, pieces: &Pieces, nodes: &[u32], keep: &mut Vec<bool>) -> bool {
        let mut rest = keep.clone();
        for &n in nodes {
            self.around[n as usize].iter().for_each(|&t| rest[t as usize] = false);
        }
        let mut largest = rest.clone();
        keep_largest_component(pieces, &mut largest);
        let whole = rest.contains(&true) && largest == rest;
        if whole {
            *keep = rest;
        }
        whole
    }
}
