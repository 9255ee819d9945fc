//! Many columns of `Y = L⁻¹ R`, half solved, and their products `Yᵀ Y`.
//!
//! HalfSolves are kept in batches of `LANES`: one register per unknown. A right-hand side fills
//! only the supernodes from its nodes up to the root of the elimination tree; the others stay zero,
//! are never touched, and take no part in products.

use crate::solver::monolithic::aligned::Aligned;
use crate::solver::monolithic::dense::{has_wide_registers, load_lines};
use crate::solver::monolithic::factor::{Factor, LANES, Lanes, Scalar};
use crate::solver::monolithic::symbolic::Symbolic;
use fearless_simd::{Simd, SimdBase, SimdFloat, dispatch, f32x16};

/// Batches of columns, in elimination order.
#[derive(Clone, Debug)]
pub struct HalfSolves {
    /// Number of unknowns.
    rows: usize,
    supernodes: usize,
    numbers: Aligned<Scalar>,
    /// Per batch: the supernodes where it is not zero.
    reached: Vec<bool>,
}

impl HalfSolves {
    /// Room for `batches` batches.
    pub fn new(symbolic: &Symbolic, batches: usize) -> Self {
        let (rows, supernodes) = (3 * symbolic.place_of_node.len(), symbolic.supernodes.len());
        Self {
            rows,
            supernodes,
            numbers: Aligned::new(batches * rows * LANES),
            reached: vec![false; batches * supernodes],
        }
    }

    /// Returns the number of batches that there is room for.
    pub fn batches(&self) -> usize {
        self.reached.len().checked_div(self.supernodes).unwrap_or(0)
    }

    /// Sets a batch to zero.
    pub fn clear(&mut self, symbolic: &Symbolic, batch: usize) {
        let first = batch * self.rows;
        let numbers = self.numbers.as_chunks_mut::<LANES>().0;
        let reached = &mut self.reached[batch * self.supernodes..(batch + 1) * self.supernodes];
        for (reached, node) in reached.iter_mut().zip(&symbolic.supernodes) {
            if std::mem::take(reached) {
                let pivots = node.pivots();
                bytemuck::fill_zeroes(&mut numbers[first + pivots.start..first + pivots.end]);
            }
        }
    }

    /// The three rows of a node; they become part of the right-hand sides.
    pub fn node_mut(&mut self, symbolic: &Symbolic, batch: usize, node: usize) -> &mut [Lanes] {
        let place = symbolic.place_of_node[node] as usize;
        self.reached[batch * self.supernodes + symbolic.supernode_of[place] as usize] = true;
        let at = batch * self.rows + 3 * place;
        &mut self.numbers.as_chunks_mut().0[at..at + 3]
    }

    /// `Y = L⁻¹ R` in one batch.
    pub fn half_solve(&mut self, factor: &Factor, batch: usize) {
        let numbers = self.numbers.as_chunks_mut().0;
        factor.forward_many(
            &mut numbers[batch * self.rows..(batch + 1) * self.rows],
            &mut self.reached[batch * self.supernodes..(batch + 1) * self.supernodes],
        );
    }

    /// A batch.
    pub fn batch(&self, batch: usize) -> &[Lanes] {
        &self.numbers.as_chunks().0[batch * self.rows..(batch + 1) * self.rows]
    }

    /// True where a batch is not zero.
    pub fn reaches(&self, batch: usize, supernode: usize) -> bool {
        self.reached[batch * self.supernodes + supernode]
    }
}

/// `to[i] += Σ a_i b` over the given rows: column i of a batch `a` with all columns of a batch `b`.
#[inline(always)]
pub fn add_product<S: Simd>(simd: S, a: &[Lanes], b: &[Lanes], to: &mut [Lanes; LANES]) {
    // What fits into the registers.
    if has_wide_registers::<S>() {
        add_columns::<S, 16>(simd, a, b, 0, to);
    } else {
        // A closure in an iterator of the standard library would be compiled without the vector
        // instructions.
        for first in (0..LANES).step_by(4) {
            add_columns::<S, 4>(simd, a, b, first, to);
        }
    }
}

#[inline(always)]
fn add_columns<S: Simd, const N: usize>(
    simd: S,
    a: &[Lanes],
    b: &[Lanes],
    first: usize,
    to: &mut [Lanes; LANES],
) {
    let mut sums: [_; N] = load_lines(
        simd,
        to,
        #[inline(always)]
        |i| first + i,
    );
    for k in 0..a.len() {
        let (a, b) = (&a[k], f32x16::from_slice(simd, &b[k]));
        for i in 0..N {
            sums[i] = b.mul_add(f32x16::splat(simd, a[first + i]), sums[i]);
        }
    }
    for i in 0..N {
        sums[i].store_slice(&mut to[first + i]);
    }
}

/// `to[i] += Σ a_i b` over the rows of those supernodes of `among` that both batches reach.
pub fn add_common_product(
    factor: &Factor,
    (a, batch_a): (&HalfSolves, usize),
    (b, batch_b): (&HalfSolves, usize),
    among: &[u32],
    to: &mut [Lanes; LANES],
) {
    let (x, y) = (a.batch(batch_a), b.batch(batch_b));
    dispatch!(factor.level, simd => {
        for &s in among {
            if a.reaches(batch_a, s as usize) && b.reaches(batch_b, s as usize) {
                let pivots = factor.symbolic.supernodes[s as usize].pivots();
                add_product(simd, &x[pivots.clone()], &y[pivots], to);
            }
        }
    });
}
