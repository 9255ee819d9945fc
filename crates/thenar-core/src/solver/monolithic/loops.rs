//! Joints that close loops: the directions of u that would open them are taken out.
//!
//! With the tree's `v_s = Z u + z`, the rows of the joints left over ask for `L u = c`, `L = J Z`.
//! Let the rows of Q be an orthonormal basis of the rows of L; then
//!
//! ```text
//!   u = P y + u_0,   P = 1 - Qᵀ Q,   u_0 = Qᵀ Q u   as L asks,
//!   v_s = (Z P) y + (Z u_0 + z)
//! ```
//!
//! Rows that depend on others bring nothing to Q, as most of those of a planar linkage of hinges.
//! `P Zᵀ A Z P` is singular along Q; adding a multiple of `Qᵀ Q` makes it definite and changes no
//! motion.

use crate::math::{Vec3, Vec6};
use crate::solver::{BlockMatrix, JointBlock};
use std::ops::Range;

/// An axis row counts at this distance \[m\] when compared with point rows.
const LEVER: f64 = 0.05;
/// Rows shorter than this part of what the longest was added up from depend on others.
const DEPENDENT: f64 = 1e-6;

/// Freedoms that move each body, and how.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    /// Index of each body's first column; one more at the end.
    pub first: Vec<usize>,
    /// Freedom that each column belongs to.
    pub dofs: Vec<u32>,
    /// Motion of the body (linear above angular) per unit of the freedom.
    pub values: Vec<Vec6>,
}

impl Columns {
    /// Room for bodies moved by these freedoms.
    pub fn new(paths: &[Vec<u32>]) -> Self {
        let mut first = vec![0];
        for (b, path) in paths.iter().enumerate() {
            first.push(first[b] + path.len());
        }
        let dofs = paths.concat();
        Self { first, values: vec![Vec6::zeros(); dofs.len()], dofs }
    }

    /// Returns the range of a body's columns.
    #[inline]
    pub fn range(&self, body: usize) -> Range<usize> {
        self.first[body]..self.first[body + 1]
    }

    /// Freedoms of a body and their columns.
    #[inline]
    pub fn of(&self, body: usize) -> impl Iterator<Item = (usize, &Vec6)> {
        let range = self.range(body);
        self.dofs[range.clone()].iter().map(|&d| d as usize).zip(&self.values[range])
    }
}

/// A joint that closes a loop.
#[derive(Clone, Copy, Debug)]
pub struct CutJoint {
    /// Number of the joint.
    pub joint: usize,
    /// Bodies of the joint, moving or not.
    pub ends: (Option<u32>, u32),
}

/// One group's loops.
#[derive(Clone, Debug)]
struct LoopGroup {
    dofs: Range<usize>,
    bodies: Vec<usize>,
    cuts: Vec<CutJoint>,
    /// L, row by row, and c.
    rows: Vec<f64>,
    /// Longest row had its two ends' parts not cancelled.
    longest: f64,
    asked: Vec<f64>,
    /// Rows of Q found so far, and how many.
    basis: Vec<f64>,
    rank: usize,
    /// Freedoms u_0 that the rows ask for.
    shift: Vec<f64>,
    /// The multiple of `Qᵀ Q` added: the largest diagonal entry of `Zᵀ diag(A) Z`.
    size: f64,
}

/// The loops of all groups.
#[derive(Clone, Debug)]
pub struct Loops {
    /// Z P.
    pub columns: Columns,
    closed: Vec<LoopGroup>,
}

impl Loops {
    /// Plans them: each group's freedoms, bodies and cut joints. Bodies of groups with cuts are
    /// moved by all freedoms of the group, others by those of `tree`.
    pub fn new(tree: &Columns, groups: Vec<(Range<usize>, Vec<usize>, Vec<CutJoint>)>) -> Self {
        let bodies = tree.first.len() - 1;
        let mut paths: Vec<Vec<u32>> =
            (0..bodies).map(|b| tree.dofs[tree.range(b)].to_vec()).collect();
        let mut closed = Vec::new();
        for (dofs, bodies, cuts) in groups.into_iter().filter(|(.., cuts)| !cuts.is_empty()) {
            for &b in &bodies {
                paths[b] = dofs.clone().map(|d| d as u32).collect();
            }
            let (n, m) = (dofs.len(), 6 * cuts.len());
            closed.push(LoopGroup {
                rows: vec![0.0; n * m],
                longest: 0.0,
                asked: vec![0.0; m],
                basis: vec![0.0; n * n],
                rank: 0,
                shift: vec![0.0; n],
                size: 1.0,
                dofs,
                bodies,
                cuts,
            });
        }
        Self { columns: Columns::new(&paths), closed }
    }

    /// Fills `Z P` from the tree's Z, and adds `Z u_0` to the offsets z, which
    /// for a body that does not move by itself are its velocity.
    pub fn refresh(
        &mut self,
        tree: &Columns,
        A: &BlockMatrix,
        joints: &[JointBlock],
        h: f64,
        offsets: &mut [Vec6],
    ) {
        let Self { columns, closed } = self;
        columns.values.fill(Vec6::zeros());
        for b in 0..offsets.len() {
            let start = columns.first[b];
            let from = columns.dofs.get(start).map_or(0, |&d| d as usize);
            let all = columns.range(b).len() != tree.range(b).len();
            for (k, (dof, column)) in tree.of(b).enumerate() {
                columns.values[start + if all { dof - from } else { k }] = *column;
            }
        }
        for group in closed {
            group.find_rows(tree, joints, h, offsets);
            group.find_basis();
            group.find_size(tree, A);
            for &b in &group.bodies {
                offsets[b] +=
                    tree.of(b).map(|(d, c)| c * group.shift[d - group.dofs.start]).sum::<Vec6>();
                group.project(&mut columns.values[columns.first[b]..columns.first[b + 1]]);
            }
        }
    }

    /// Makes tree coordinates those of the closed system.
    pub fn close(&self, u: &mut [f64]) {
        for group in &self.closed {
            let u = &mut u[group.dofs.clone()];
            u.iter_mut().zip(&group.shift).for_each(|(u, s)| *u -= s);
            for q in group.basis() {
                let along: f64 = q.iter().zip(u.iter()).map(|(q, u)| q * u).sum();
                u.iter_mut().zip(q).for_each(|(u, q)| *u -= along * q);
            }
        }
    }

    /// `y += s Qᵀ Q u`.
    pub fn add_held(&self, u: &[f64], y: &mut [f64]) {
        for group in &self.closed {
            let (u, y) = (&u[group.dofs.clone()], &mut y[group.dofs.clone()]);
            for q in group.basis() {
                let along: f64 = q.iter().zip(u).map(|(q, u)| q * u).sum();
                y.iter_mut().zip(q).for_each(|(y, q)| *y += group.size * along * q);
            }
        }
    }

    /// Adds `s Qᵀ Q` to the square block of the group with these freedoms.
    pub fn stiffen(&self, dofs: &Range<usize>, block: &mut [f64]) {
        for group in self.closed.iter().filter(|group| group.dofs == *dofs) {
            for q in group.basis() {
                for (row, a) in block.chunks_exact_mut(dofs.len()).zip(q) {
                    row.iter_mut().zip(q).for_each(|(x, b)| *x += group.size * a * b);
                }
            }
        }
    }
}

impl LoopGroup {
    fn basis(&self) -> impl Iterator<Item = &[f64]> {
        self.basis.chunks_exact(self.dofs.len().max(1)).take(self.rank)
    }

    /// `L = J Z` and `c = -C/Δt - J z`.
    fn find_rows(&mut self, tree: &Columns, joints: &[JointBlock], h: f64, offsets: &[Vec6]) {
        let n = self.dofs.len();
        self.rows.fill(0.0);
        self.asked.fill(0.0);
        self.longest = 0.0;
        for (k, cut) in self.cuts.iter().enumerate() {
            let block = &joints[cut.joint];
            for r in 0..block.rows {
                let size = if r < 3 { 1.0 } else { LEVER };
                let (at, mut parts) = (6 * k + r, 0.0);
                self.asked[at] = -size * block.C[r] / h;
                let sides = [(Some(cut.ends.1), &block.J_child), (cut.ends.0, &block.J_parent)];
                for (body, J) in sides {
                    let Some(b) = body.map(|b| b as usize) else { continue };
                    self.asked[at] -= size * (J.row(r) * offsets[b])[0];
                    for (dof, column) in tree.of(b) {
                        let part = size * (J.row(r) * column)[0];
                        self.rows[at * n + dof - self.dofs.start] += part;
                        parts += part * part;
                    }
                }
                self.longest = self.longest.max(parts.sqrt());
            }
        }
    }

    /// Q by Gram-Schmidt, longest remaining row first, and u_0.
    fn find_basis(&mut self) {
        let n = self.dofs.len();
        self.rank = 0;
        self.shift.fill(0.0);
        let length = |row: &[f64]| row.iter().map(|x| x * x).sum::<f64>().sqrt();
        while self.rank < n {
            let mut longest = (0, 0.0);
            for (i, row) in self.rows.chunks_exact(n).enumerate() {
                if length(row) > longest.1 {
                    longest = (i, length(row));
                }
            }
            let (pivot, size) = longest;
            if size <= DEPENDENT * self.longest {
                return;
            }
            let (k, value) = (self.rank, self.asked[pivot] / size);
            let q = &mut self.basis[k * n..(k + 1) * n];
            q.iter_mut().zip(&self.rows[pivot * n..]).for_each(|(q, x)| *q = x / size);
            self.shift.iter_mut().zip(q.iter()).for_each(|(s, q)| *s += value * q);
            self.rank += 1;
            // Twice, lest round-off leave what a nearly dependent row was made of.
            for _ in 0..2 {
                for (row, asked) in self.rows.chunks_exact_mut(n).zip(&mut self.asked) {
                    let along: f64 = row.iter().zip(q.iter()).map(|(x, q)| x * q).sum();
                    row.iter_mut().zip(q.iter()).for_each(|(x, q)| *x -= along * q);
                    *asked -= along * value;
                }
            }
        }
    }

    fn find_size(&mut self, tree: &Columns, A: &BlockMatrix) {
        let mut most = 0.0_f64;
        for &b in &self.bodies {
            let diagonal: [Vec3; 2] = [0, 1].map(|part| A.get(A.diagonal[2 * b + part]).diagonal());
            for (_, c) in tree.of(b) {
                let entry: f64 = (0..6).map(|k| diagonal[k / 3][k % 3] * c[k] * c[k]).sum();
                most = most.max(entry);
            }
        }
        self.size = if most > 0.0 { most } else { 1.0 };
    }

    /// `Z P` of one body.
    fn project(&self, columns: &mut [Vec6]) {
        for q in self.basis() {
            let along: Vec6 = columns.iter().zip(q).map(|(c, q)| c * *q).sum();
            columns.iter_mut().zip(q).for_each(|(c, q)| *c -= along * *q);
        }
    }
}
