//! Step 1 of the paper (Eq. 10): bone velocities that satisfy the joints, in time linear in the
//! number of bones (Baraff 1996).
//!
//! The system is `[S Jᵀ; J 0] [v; λ] = [r; c]`. Bones are eliminated leaves first, each followed
//! by the joint to its parent. The extra blocks of S between adjacent bones (joint springs, and
//! flesh nodes bound to both) make bone, joint and parent a triangle; eliminating in the order
//! child, joint, parent touches only blocks of that triangle, so nothing fills in:
//!
//! ```text
//!   N    = -J_a S_aa⁻¹ J_aᵀ           the joint's pivot, negative definite
//!   J_b' =  J_b - J_a S_aa⁻¹ S_ab
//!   S_bb -= S_abᵀ S_aa⁻¹ S_ab + J_b'ᵀ N⁻¹ J_b'
//! ```
//!
//! Jointed bodies that close a loop are solved by a dense factorisation instead; loops that ask for
//! the same thing twice (a planar four-bar of hinges) share the impulse.

use crate::math::{Mat6, Vec6};
use crate::solver::tree::{Link, leaves_first};
use crate::solver::{DenseLu, joint_compliance};

/// The linearised rows of one joint, padded with zero rows to six.
#[derive(Clone, Copy, Debug)]
pub struct JointBlock {
    /// Number of rows in use.
    pub rows: usize,
    /// Derivative by the parent's velocity; zero when the parent is the world.
    pub J_parent: Mat6,
    /// Derivative by the child's velocity.
    pub J_child: Mat6,
    /// Constraint value C at the start of the step, in metres and radians.
    pub C: Vec6,
}

impl JointBlock {
    /// No rows.
    pub fn empty() -> Self {
        Self { rows: 0, J_parent: Mat6::zeros(), J_child: Mat6::zeros(), C: Vec6::zeros() }
    }
}

/// Factors that elimination leaves for back-substitution.
#[derive(Clone, Copy, Debug)]
struct Factor {
    S_inv: Mat6,
    S_ab: Mat6,
    N_inv: Mat6,
    J_a: Mat6,
    J_b: Mat6,
    r_a: Vec6,
    r_j: Vec6,
}

/// The elimination order of a set of jointed bodies, and its workspace.
#[derive(Clone, Debug)]
pub struct Articulated {
    links: Vec<Link>,
    factors: Vec<Factor>,
    /// Used instead when joints close loops.
    dense: Option<(DenseLu, Vec<f64>)>,
    ends: Vec<(Option<u32>, u32)>,
}

impl Articulated {
    /// Plans the elimination. `moves[b]` tells whether body b has unknowns; `ends` holds parent
    /// and child of each joint; `rows` the joints' rows.
    pub fn new(moves: &[bool], ends: &[(Option<u32>, u32)], rows: &[usize]) -> Self {
        let links = leaves_first(moves, ends);
        let bones = moves.len();
        let dense = links.is_none().then(|| {
            let n = 6 * bones + rows.iter().sum::<usize>();
            (DenseLu::new(n), vec![0.0; n])
        });
        let links = links.unwrap_or_default();
        let zero = Factor {
            S_inv: Mat6::zeros(),
            S_ab: Mat6::zeros(),
            N_inv: Mat6::zeros(),
            J_a: Mat6::zeros(),
            J_b: Mat6::zeros(),
            r_a: Vec6::zeros(),
            r_j: Vec6::zeros(),
        };
        Self { factors: vec![zero; links.len()], links, dense, ends: ends.to_vec() }
    }

    /// Solves `[S Jᵀ; J 0] [v; λ] = [r; c]`.
    ///
    /// `S_diagonal[b]` is S_bb (overwritten); `S_edge[j]` is the block of S with the rows of joint
    /// j's child and the columns of its parent. Bodies that do not move must have `S_bb = I`,
    /// `r = 0`. Returns false when a pivot is singular.
    pub fn solve(
        &mut self,
        S_diagonal: &mut [Mat6],
        S_edge: &[Mat6],
        joints: &[JointBlock],
        r: &mut [Vec6],
        c: &[Vec6],
        v: &mut [Vec6],
        lambda: &mut [Vec6],
    ) -> bool {
        debug_assert_eq!(joints.len(), self.ends.len(), "blocks of joints, joints planned for");
        debug_assert_eq!(c.len(), joints.len(), "right-hand sides of joints, joints");
        debug_assert_eq!(r.len(), S_diagonal.len(), "right-hand sides of bodies, bodies");
        debug_assert_eq!(v.len(), S_diagonal.len(), "velocities of bodies, bodies");
        if self.dense.is_some() {
            return self.solve_dense(S_diagonal, S_edge, joints, r, c, v, lambda);
        }
        for (link, factor) in self.links.iter().zip(&mut self.factors) {
            if !eliminate(link, factor, S_diagonal, S_edge, joints, r, c) {
                return false;
            }
        }
        for (link, factor) in self.links.iter().zip(&self.factors).rev() {
            substitute(link, factor, v, lambda);
        }
        true
    }

    fn solve_dense(
        &mut self,
        S_diagonal: &[Mat6],
        S_edge: &[Mat6],
        joints: &[JointBlock],
        r: &[Vec6],
        c: &[Vec6],
        v: &mut [Vec6],
        lambda: &mut [Vec6],
    ) -> bool {
        let Some((lu, x)) = &mut self.dense else { return false };
        lu.restart(lu.size());
        for (b, S) in S_diagonal.iter().enumerate() {
            add_block(lu, 6 * b, 6 * b, 6, S);
            x[6 * b..6 * b + 6].copy_from_slice(r[b].as_slice());
        }
        let mut row = 6 * S_diagonal.len();
        for (j, joint) in joints.iter().enumerate() {
            let (parent, child) = self.ends[j];
            let child = 6 * child as usize;
            add_rows(lu, row, child, joint.rows, &joint.J_child);
            if let Some(parent) = parent {
                let parent = 6 * parent as usize;
                add_rows(lu, row, parent, joint.rows, &joint.J_parent);
                add_block(lu, child, parent, 6, &S_edge[j]);
                add_block(lu, parent, child, 6, &S_edge[j].transpose());
            }
            for k in 0..joint.rows {
                let of_child =
                    (0..6).map(|i| (joint.J_child[(k, i)], S_diagonal[child / 6][(i, i)]));
                let of_parent = parent.into_iter().flat_map(|p| {
                    (0..6).map(move |i| (joint.J_parent[(k, i)], S_diagonal[p as usize][(i, i)]))
                });
                lu.add(row + k, row + k, -joint_compliance(of_child.chain(of_parent)));
            }
            x[row..row + joint.rows].copy_from_slice(&c[j].as_slice()[..joint.rows]);
            row += joint.rows;
        }
        if !lu.factor() {
            return false;
        }
        lu.solve(x);
        for (b, v) in v.iter_mut().enumerate() {
            *v = Vec6::from_column_slice(&x[6 * b..6 * b + 6]);
        }
        let mut row = 6 * S_diagonal.len();
        for (joint, lambda) in joints.iter().zip(lambda) {
            lambda.fill(0.0);
            lambda.as_mut_slice()[..joint.rows].copy_from_slice(&x[row..row + joint.rows]);
            row += joint.rows;
        }
        true
    }
}

fn eliminate(
    link: &Link,
    factor: &mut Factor,
    S_diagonal: &mut [Mat6],
    S_edge: &[Mat6],
    joints: &[JointBlock],
    r: &mut [Vec6],
    c: &[Vec6],
) -> bool {
    let Some(cholesky) = S_diagonal[link.bone].cholesky() else { return false };
    let S_inv = cholesky.inverse();
    factor.S_inv = S_inv;
    factor.r_a = r[link.bone];
    let Some(j) = link.joint else { return true };

    let joint = &joints[j];
    let (J_a, J_other) = if link.reversed {
        (joint.J_parent, joint.J_child)
    } else {
        (joint.J_child, joint.J_parent)
    };
    let SJt = S_inv * J_a.transpose();
    let mut minus_N = J_a * SJt;
    for k in joint.rows..6 {
        minus_N[(k, k)] = 1.0;
    }
    let Some(cholesky) = minus_N.cholesky() else { return false };
    factor.N_inv = -cholesky.inverse();
    factor.J_a = J_a;
    factor.r_j = c[j] - SJt.transpose() * factor.r_a;
    let Some(b) = link.parent else { return true };

    factor.S_ab = if link.reversed { S_edge[j].transpose() } else { S_edge[j] };
    factor.J_b = J_other - SJt.transpose() * factor.S_ab;
    let StS = factor.S_ab.transpose() * S_inv;
    let JtN = factor.J_b.transpose() * factor.N_inv;
    S_diagonal[b] -= StS * factor.S_ab + JtN * factor.J_b;
    r[b] -= StS * factor.r_a + JtN * factor.r_j;
    true
}

fn substitute(link: &Link, factor: &Factor, v: &mut [Vec6], lambda: &mut [Vec6]) {
    let mut r = factor.r_a;
    if let Some(j) = link.joint {
        let v_b = link.parent.map_or(Vec6::zeros(), |b| v[b]);
        lambda[j] = factor.N_inv * (factor.r_j - factor.J_b * v_b);
        r -= factor.J_a.transpose() * lambda[j];
        if link.parent.is_some() {
            r -= factor.S_ab * v_b;
        }
    }
    v[link.bone] = factor.S_inv * r;
}

fn add_block(lu: &mut DenseLu, i0: usize, j0: usize, rows: usize, m: &Mat6) {
    for i in 0..rows {
        for j in 0..6 {
            lu.add(i0 + i, j0 + j, m[(i, j)]);
        }
    }
}

fn add_rows(lu: &mut DenseLu, row: usize, column: usize, rows: usize, J: &Mat6) {
    add_block(lu, row, column, rows, J);
    for i in 0..rows {
        for j in 0..6 {
            lu.add(column + j, row + i, J[(i, j)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn random_mat6(random: &mut Random) -> Mat6 {
        Mat6::from_fn(|_, _| random.range(-1.0, 1.0))
    }

    /// A random system over `ends`, solved by the tree order and by dense LU, must agree.
    fn check(moves: &[bool], ends: &[(Option<u32>, u32)], rows: &[usize], loops: bool) {
        let mut random = Random::new(7);
        let n = moves.len();
        let edge: Vec<Mat6> = ends
            .iter()
            .map(|&(p, c)| match p {
                Some(p) if moves[p as usize] && moves[c as usize] => 0.3 * random_mat6(&mut random),
                _ => Mat6::zeros(),
            })
            .collect();
        let diagonal: Vec<Mat6> = moves
            .iter()
            .map(|&m| {
                let a = random_mat6(&mut random);
                if m { a * a.transpose() + Mat6::identity() * 8.0 } else { Mat6::identity() }
            })
            .collect();
        let joints: Vec<JointBlock> = ends
            .iter()
            .zip(rows)
            .map(|(&(p, c), &rows)| {
                let mut block = JointBlock { rows, ..JointBlock::empty() };
                for i in 0..rows {
                    for j in 0..6 {
                        if moves[c as usize] {
                            block.J_child[(i, j)] = random.range(-1.0, 1.0);
                        }
                        if p.is_some_and(|p| moves[p as usize]) {
                            block.J_parent[(i, j)] = random.range(-1.0, 1.0);
                        }
                    }
                }
                block
            })
            .collect();
        let mut vec6 = |on: bool| {
            if on { Vec6::from_fn(|_, _| random.range(-1.0, 1.0)) } else { Vec6::zeros() }
        };
        let r: Vec<Vec6> = moves.iter().map(|&m| vec6(m)).collect();
        let c: Vec<Vec6> = rows
            .iter()
            .map(|&rows| {
                let mut c = vec6(true);
                c.as_mut_slice()[rows..].fill(0.0);
                c
            })
            .collect();

        let mut solver = Articulated::new(moves, ends, rows);
        assert_eq!(solver.dense.is_some(), loops, "loops take the dense path");
        let mut v = vec![Vec6::zeros(); n];
        let mut lambda = vec![Vec6::zeros(); ends.len()];
        assert!(solver.solve(
            &mut diagonal.clone(),
            &edge,
            &joints,
            &mut r.clone(),
            &c,
            &mut v,
            &mut lambda
        ));

        // Both block rows of the system, by hand.
        for b in 0..n {
            let mut left = diagonal[b] * v[b];
            for (j, &(p, ch)) in ends.iter().enumerate() {
                let p = p.map(|p| p as usize);
                if ch as usize == b {
                    left += joints[j].J_child.transpose() * lambda[j];
                    left += p.map_or(Vec6::zeros(), |p| edge[j] * v[p]);
                }
                if p == Some(b) {
                    left += joints[j].J_parent.transpose() * lambda[j];
                    left += edge[j].transpose() * v[ch as usize];
                }
            }
            assert!((left - r[b]).norm() < 1e-10, "bone {b}: {}", (left - r[b]).norm());
        }
        for (j, &(p, ch)) in ends.iter().enumerate() {
            let p = p.map_or(Vec6::zeros(), |p| joints[j].J_parent * v[p as usize]);
            let gap = joints[j].J_child * v[ch as usize] + p - c[j];
            assert!(gap.norm() < 1e-10, "joint {j}: {}", gap.norm());
        }
    }

    #[test]
    fn a_branching_tree_solves_the_kkt_system() {
        let ends = [(Some(0), 1), (Some(1), 2), (Some(0), 3), (Some(3), 4), (None, 5)];
        check(&[true; 6], &ends, &[5, 5, 4, 3, 6], false);
    }

    #[test]
    fn a_chain_anchored_at_its_far_end_and_a_free_joint() {
        let ends = [(Some(0), 1), (Some(1), 2), (Some(2), 3)];
        check(&[true, true, true, false], &ends, &[0, 5, 4], false);
    }

    #[test]
    fn loops_take_the_dense_path() {
        let ends = [(None, 0), (Some(0), 1), (Some(1), 2), (None, 2)];
        check(&[true; 3], &ends, &[3, 3, 3, 3], true);
    }
}
