//! The whole reduced matrix solved by the flesh factor: flesh first, bodies by their Schur
//! complement.
//!
//! ```text
//!   X = K_ww⁻¹ C,   S = K_uu - Cᵀ X
//!   u = S⁻¹ (r_u - Xᵀ r_w),   w = K_ww⁻¹ r_w - X u
//! ```

use crate::math::Vec3;
use crate::solver::exact::coarse::Coarse;
use crate::solver::exact::factor::{Factor, LANES, Scalar};
use crate::solver::exact::{Coordinates, System, small_cholesky};

/// Factor and Schur complements.
#[derive(Clone, Debug)]
pub struct Direct {
    /// K_ww.
    pub factor: Factor,
    /// X, laid out as C.
    pub X: Vec<Vec3>,
    /// Cholesky factors of S, laid out as K_uu.
    pub schur: Vec<f64>,
}

impl Direct {
    /// Room.
    pub fn new(factor: Factor, coarse: &Coarse) -> Self {
        let X = vec![Vec3::zeros(); coarse.cross.len()];
        Self { factor, X, schur: vec![0.0; coarse.blocks.len()] }
    }

    /// Factors; false when the matrix is not positive definite in the factor's precision.
    pub fn refresh(&mut self, system: &System<'_>, coarse: &Coarse) -> bool {
        if !self.factor.refresh(system) {
            return false;
        }
        self.schur.copy_from_slice(&coarse.blocks);
        let widest = system.bodies.groups().iter().map(|g| g.len()).max().unwrap_or(0);
        self.factor.wanted.fill(true);
        if !coarse.cross.is_empty() {
            for from in (0..widest).step_by(LANES) {
                self.eliminate(from, coarse, system.springs.len());
            }
        }
        (system.bodies.groups().iter().enumerate())
            .all(|(g, dofs)| small_cholesky::factor(&mut self.schur[coarse.block(g)], dofs.len()))
    }

    /// Columns `from..from + LANES` of X in every group, and their part of S.
    fn eliminate(&mut self, from: usize, coarse: &Coarse, nodes: usize) {
        self.factor.clear_many();
        for n in 0..nodes {
            let Some((_, row)) = coarse.cross_of(n) else { continue };
            let columns = coarse.cross[row].iter().skip(from).take(LANES);
            let rhs = self.factor.many_mut(n);
            for (lane, c) in columns.enumerate() {
                (0..3).for_each(|r| rhs[r][lane] = c[r] as Scalar);
            }
        }
        self.factor.solve_many();
        for n in 0..nodes {
            let Some((group, row)) = coarse.cross_of(n) else { continue };
            let (width, solution) = (row.len(), self.factor.many_of(n));
            let block = &mut self.schur[coarse.block(group)];
            let X = &mut self.X[row.clone()];
            for (lane, x) in X.iter_mut().skip(from).take(LANES).enumerate() {
                *x = Vec3::from_fn(|r, _| solution[r][lane] as f64);
            }
            // Only the lower triangle of S is read.
            for (i, c) in coarse.cross[row].iter().enumerate() {
                let to = (from + LANES).min(i + 1);
                for j in from..to.max(from) {
                    block[i * width + j] -= c.dot(&X[j]);
                }
            }
        }
    }

    /// `z = K⁻¹ r` in the factor's precision.
    pub fn apply(
        &mut self,
        system: &System<'_>,
        coarse: &Coarse,
        r: &Coordinates,
        z: &mut Coordinates,
    ) {
        z.u.copy_from_slice(&r.u);
        for (n, r) in r.w.iter().enumerate() {
            if let Some((group, row)) = coarse.cross_of(n) {
                let u = &mut z.u[system.bodies.groups()[group].clone()];
                u.iter_mut().zip(&self.X[row]).for_each(|(u, x)| *u -= x.dot(r));
            }
        }
        for (g, dofs) in system.bodies.groups().iter().enumerate() {
            let l = &self.schur[coarse.block(g)];
            small_cholesky::forward(l, dofs.len(), &mut z.u[dofs.clone()]);
            small_cholesky::backward(l, dofs.len(), &mut z.u[dofs.clone()]);
        }
        z.w.copy_from_slice(&r.w);
        self.factor.solve(&mut z.w);
        for (n, w) in z.w.iter_mut().enumerate() {
            if let Some((group, row)) = coarse.cross_of(n) {
                let u = &z.u[system.bodies.groups()[group].clone()];
                self.X[row].iter().zip(u).for_each(|(x, u)| *w -= x * *u);
            }
        }
    }
}
