//! Elimination order of the flesh nodes: nested dissection by position (George 1973).
//!
//! The nodes are halved across one of the three axes, whichever needs the fewest nodes to separate
//! the halves; the halves come first, their separator last, and each half is treated likewise.

use crate::math::Vec3;
use crate::solver::BlockMatrix;

/// Pieces up to this size are not divided further.
const LEAF: usize = 6;

/// The order in which to eliminate the nodes, whose rows in `a` begin at `row0`.
pub fn nested_dissection(a: &BlockMatrix, row0: usize, positions: &[Vec3]) -> Vec<u32> {
    let mut order = Vec::with_capacity(positions.len());
    let mut work = Dissection { a, row0, positions, side: vec![0; positions.len()], stamp: 0 };
    work.dissect((0..positions.len() as u32).collect(), &mut order);
    order
}

struct Dissection<'a> {
    a: &'a BlockMatrix,
    row0: usize,
    positions: &'a [Vec3],
    /// `2 stamp` or `2 stamp + 1` for the two sides of the present cut.
    side: Vec<u32>,
    stamp: u32,
}

impl Dissection<'_> {
    fn dissect(&mut self, mut nodes: Vec<u32>, order: &mut Vec<u32>) {
        if nodes.len() <= LEAF {
            order.extend(nodes);
            return;
        }
        let mut best: Option<[Vec<u32>; 3]> = None;
        for axis in 0..3 {
            let along = |n: &u32| self.positions[*n as usize][axis];
            nodes.sort_unstable_by(|a, b| along(a).total_cmp(&along(b)).then(a.cmp(b)));
            let parts = self.cut(&nodes);
            if best.as_ref().is_none_or(|b| parts[2].len() < b[2].len()) {
                best = Some(parts);
            }
        }
        let Some([left, right, separator]) = best else { return };
        if left.is_empty() && right.is_empty() {
            order.extend(separator);
            return;
        }
        self.dissect(left, order);
        self.dissect(right, order);
        order.extend(separator);
    }

    /// Halves sorted nodes: left, right, and the smaller set that separates them.
    fn cut(&mut self, nodes: &[u32]) -> [Vec<u32>; 3] {
        self.stamp += 1;
        let half = nodes.len() / 2;
        for (k, &n) in nodes.iter().enumerate() {
            self.side[n as usize] = 2 * self.stamp + u32::from(k >= half);
        }
        let touches = |n: u32, side: u32| {
            let row = self.a.row(self.row0 + n as usize);
            let mut flesh = self.a.columns[row].iter().filter(|&&j| j as usize >= self.row0);
            flesh.any(|&j| self.side[j as usize - self.row0] == side)
        };
        let (low, high) = (2 * self.stamp, 2 * self.stamp + 1);
        let split = |part: &[u32], other: u32| -> (Vec<u32>, Vec<u32>) {
            part.iter().partition(|&&n| touches(n, other))
        };
        let (left_cut, left) = split(&nodes[..half], high);
        let (right_cut, right) = split(&nodes[half..], low);
        if left_cut.len() <= right_cut.len() {
            [left, nodes[half..].to_vec(), left_cut]
        } else {
            [nodes[..half].to_vec(), right, right_cut]
        }
    }
}
