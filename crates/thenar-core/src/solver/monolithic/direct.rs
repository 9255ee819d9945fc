//! The whole reduced matrix solved by the flesh factor `K_ww = L Lᵀ`: flesh first, bodies by their
//! Schur complement.
//!
//! ```text
//!   Y = L⁻¹ C,   S = K_uu - Yᵀ Y
//!   y = L⁻¹ r_w,   u = S⁻¹ (r_u - Yᵀ y),   w = L⁻ᵀ (y - Y u)
//! ```

use crate::solver::monolithic::coarse::Coarse;
use crate::solver::monolithic::factor::{Factor, LANES, Lanes, Scalar};
use crate::solver::monolithic::half_solves::{HalfSolves, add_common_product};
use crate::solver::monolithic::substitution::sum;
use crate::solver::monolithic::{Coordinates, System, small_cholesky, vectors};
use fearless_simd::{Simd, SimdBase, SimdFloat, dispatch, f32x16};
use std::ops::Range;

/// Factor and Schur complements.
#[derive(Clone, Debug)]
pub struct Direct {
    /// Factor of the flesh's block K_ww.
    pub factor: Factor,
    /// Y: column d of a batch k belongs to freedom `LANES k + d` of the row's group.
    pub half: HalfSolves,
    /// Supernodes of each group's flesh.
    pub flesh_of_group: Vec<Vec<u32>>,
    /// Cholesky factors of S, laid out as K_uu.
    pub schur: Vec<f64>,
    /// One register per batch of a group's freedoms.
    sums: Vec<Lanes>,
}

impl Direct {
    /// Room; `groups` are the freedoms of each group.
    pub fn new(factor: Factor, coarse: &Coarse, groups: &[Range<usize>]) -> Self {
        let mut flesh_of_group = vec![Vec::new(); groups.len()];
        for (n, place) in factor.symbolic.place_of_node.iter().enumerate() {
            if let Some((group, _)) = coarse.cross_of(n) {
                flesh_of_group[group].push(factor.symbolic.supernode_of[*place as usize]);
            }
        }
        for supernodes in &mut flesh_of_group {
            supernodes.sort_unstable();
            supernodes.dedup();
        }
        let carried = groups.iter().zip(&flesh_of_group).filter(|(_, flesh)| !flesh.is_empty());
        let batches = carried.map(|(g, _)| g.len().div_ceil(LANES)).max().unwrap_or(0);
        Self {
            half: HalfSolves::new(&factor.symbolic, batches),
            schur: vec![0.0; coarse.blocks.len()],
            sums: vec![[0.0; LANES]; batches],
            flesh_of_group,
            factor,
        }
    }

    /// Factors; false when the matrix is not positive definite in the factor's precision.
    pub fn refresh(&mut self, system: &System<'_>, coarse: &Coarse) -> bool {
        debug_assert_eq!(self.schur.len(), coarse.blocks.len(), "numbers of S, of K_uu");
        if !self.factor.refresh(system) {
            return false;
        }
        self.schur.copy_from_slice(&coarse.blocks);
        for batch in 0..self.half.batches() {
            self.half_solve(batch, coarse, system.springs.len());
        }
        for (g, dofs) in system.bodies.groups().iter().enumerate() {
            let schur = &mut self.schur[coarse.block(g)];
            subtract_flesh(&self.factor, &self.half, &self.flesh_of_group[g], schur, dofs.len());
            if !small_cholesky::factor(schur, dofs.len()) {
                return false;
            }
        }
        true
    }

    /// One batch of Y.
    fn half_solve(&mut self, batch: usize, coarse: &Coarse, nodes: usize) {
        let symbolic = &self.factor.symbolic;
        self.half.clear(symbolic, batch);
        for n in 0..nodes {
            let Some((_, row)) = coarse.cross_of(n) else { continue };
            if row.len() <= batch * LANES {
                continue;
            }
            let rhs = self.half.node_mut(symbolic, batch, n);
            for (lane, c) in coarse.cross[row].iter().skip(batch * LANES).take(LANES).enumerate() {
                (0..3).for_each(|r| rhs[r][lane] = c[r] as Scalar);
            }
        }
        self.half.half_solve(&self.factor, batch);
    }

    /// `z = K⁻¹ r` in the factor's precision.
    pub fn apply(
        &mut self,
        system: &System<'_>,
        coarse: &Coarse,
        r: &Coordinates,
        z: &mut Coordinates,
    ) {
        debug_assert_eq!(r.u.len(), z.u.len(), "freedoms asked, freedoms answered");
        debug_assert_eq!(r.w.len(), z.w.len(), "nodes asked, nodes answered");
        let largest = self.largest(r, system.bodies.groups());
        self.factor.gather(&r.w, largest);
        self.factor.forward();
        z.u.copy_from_slice(&r.u);
        let Self { factor, half, flesh_of_group, schur, sums } = self;
        for (g, dofs) in system.bodies.groups().iter().enumerate() {
            let (flesh, u) = (&flesh_of_group[g], &mut z.u[dofs.clone()]);
            if !flesh.is_empty() {
                dispatch!(factor.level, simd => pull_of_flesh(simd, factor, half, flesh, sums));
                let pulls = sums.as_flattened().iter().map(|s| factor.unscaled(*s));
                u.iter_mut().zip(pulls).for_each(|(u, pull)| *u -= pull);
            }
            let l = &schur[coarse.block(g)];
            small_cholesky::forward(l, dofs.len(), u);
            small_cholesky::backward(l, dofs.len(), u);
            if !flesh.is_empty() {
                let numbers = sums.as_flattened_mut();
                numbers.fill(0.0);
                numbers.iter_mut().zip(u.iter()).for_each(|(s, u)| *s = factor.scaled(*u));
                dispatch!(factor.level, simd => follow_bodies(simd, factor, half, flesh, sums));
            }
        }
        self.factor.backward();
        self.factor.spread(&mut z.w);
    }

    /// The largest number that the factor meets: of the nodes, and of the bodies that carry some.
    fn largest(&self, r: &Coordinates, groups: &[Range<usize>]) -> f64 {
        dispatch!(self.factor.level, _simd => {
            let mut largest = vectors::largest(vectors::flat(&r.w));
            for (freedoms, flesh) in groups.iter().zip(&self.flesh_of_group) {
                if !flesh.is_empty() {
                    largest = largest.max(vectors::largest(&r.u[freedoms.clone()]));
                }
            }
            largest
        })
    }
}

/// Takes `Yᵀ Y` off the lower triangle of a group's n×n block.
fn subtract_flesh(factor: &Factor, half: &HalfSolves, flesh: &[u32], block: &mut [f64], n: usize) {
    let batches = if flesh.is_empty() { 0 } else { n.div_ceil(LANES) };
    for p in 0..batches {
        for q in 0..=p {
            let mut product = [[0.0; LANES]; LANES];
            add_common_product(factor, (half, p), (half, q), flesh, &mut product);
            for i in p * LANES..((p + 1) * LANES).min(n) {
                for j in q * LANES..((q + 1) * LANES).min(i + 1) {
                    block[i * n + j] -= f64::from(product[i - p * LANES][j - q * LANES]);
                }
            }
        }
    }
}

/// `Yᵀ y`, with y in the factor's work space.
#[inline(always)]
fn pull_of_flesh<S: Simd>(
    simd: S,
    factor: &Factor,
    half: &HalfSolves,
    flesh: &[u32],
    sums: &mut [Lanes],
) {
    for (batch, out) in sums.iter_mut().enumerate() {
        let mut sum = f32x16::splat(simd, 0.0);
        for &s in flesh {
            let pivots = factor.symbolic.supernodes[s as usize].pivots();
            let (rows, y) = (&half.batch(batch)[pivots.clone()], &factor.x[pivots]);
            for k in 0..rows.len() {
                sum = f32x16::from_slice(simd, &rows[k]).mul_add(f32x16::splat(simd, y[k]), sum);
            }
        }
        sum.store_slice(out);
    }
}

/// `y -= Y u`, with u in `values`.
#[inline(always)]
fn follow_bodies<S: Simd>(
    simd: S,
    factor: &mut Factor,
    half: &HalfSolves,
    flesh: &[u32],
    values: &[Lanes],
) {
    // Two batches at a time, so that the numbers of one register are summed, not of two.
    for (pair, values) in values.chunks(2).enumerate() {
        let u = f32x16::from_slice(simd, &values[0]);
        let v = if values.len() > 1 { Some(f32x16::from_slice(simd, &values[1])) } else { None };
        for &s in flesh {
            let pivots = factor.symbolic.supernodes[s as usize].pivots();
            let y = &mut factor.x[pivots.clone()];
            let rows = &half.batch(2 * pair)[pivots.clone()];
            let Some(v) = v else {
                for k in 0..rows.len() {
                    y[k] -= sum(&(f32x16::from_slice(simd, &rows[k]) * u));
                }
                continue;
            };
            let more = &half.batch(2 * pair + 1)[pivots];
            for k in 0..rows.len() {
                let product = f32x16::from_slice(simd, &rows[k]) * u;
                y[k] -= sum(&f32x16::from_slice(simd, &more[k]).mul_add(v, product));
            }
        }
    }
}
