//! Block Jacobi: one dense block per group of bodies, 3×3 per node.

use crate::flesh::transposed;
use crate::solver::block_matrix::{Block, add_product, vector};
use crate::solver::monolithic::coarse::Coarse;
use crate::solver::monolithic::{Coordinates, System, small_cholesky};
use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};

/// The inverted block diagonal.
#[derive(Clone, Debug)]
pub struct BlockJacobi {
    /// Cholesky factors of the groups' blocks.
    bodies: Vec<f64>,
    /// Inverses of the nodes' blocks.
    nodes: Vec<Block>,
}

impl BlockJacobi {
    /// Room for `nodes` nodes.
    pub fn new(coarse: &Coarse, nodes: usize) -> Self {
        Self { bodies: vec![0.0; coarse.blocks.len()], nodes: vec![[0.0; 9]; nodes] }
    }

    /// Inverts the diagonal; false when a block is not positive definite.
    pub fn refresh(&mut self, system: &System<'_>, coarse: &Coarse) -> bool {
        self.bodies.copy_from_slice(&coarse.blocks);
        for (g, dofs) in system.bodies.groups().iter().enumerate() {
            if !small_cholesky::factor(&mut self.bodies[coarse.block(g)], dofs.len()) {
                return false;
            }
        }
        dispatch!(Level::new(), simd => self.invert_nodes(simd, system))
    }

    /// The nodes' blocks, eight side by side, by their cofactors.
    #[inline(always)]
    fn invert_nodes<S: Simd>(&mut self, simd: S, system: &System<'_>) -> bool {
        let row0 = 2 * system.bodies.bodies();
        let A = system.A;
        let mut sound = true;
        for (i, out) in self.nodes.chunks_mut(8).enumerate() {
            // Six numbers of each block: its diagonal with the spring, and (0,1), (0,2), (1,2).
            let mut numbers = [[0.0; 8]; 6];
            for lane in 0..8 {
                let n = 8 * i + lane.min(out.len() - 1);
                let block = &A.blocks[A.diagonal[row0 + n] as usize];
                let known = &system.known[row0 + n];
                for axis in 0..3 {
                    let spring = if known[axis] { 0.0 } else { system.springs[n] };
                    numbers[axis][lane] = block[4 * axis] + spring;
                }
                (numbers[3][lane], numbers[4][lane], numbers[5][lane]) =
                    (block[1], block[2], block[5]);
            }
            let [a, b, c] = [
                f64x8::load_array_ref(simd, &numbers[0]),
                f64x8::load_array_ref(simd, &numbers[1]),
                f64x8::load_array_ref(simd, &numbers[2]),
            ];
            let [d, e, f] = [
                f64x8::load_array_ref(simd, &numbers[3]),
                f64x8::load_array_ref(simd, &numbers[4]),
                f64x8::load_array_ref(simd, &numbers[5]),
            ];
            let aa = b.mul_sub(c, f * f);
            let dd = e.mul_sub(f, d * c);
            let ee = d.mul_sub(f, e * b);
            let det = a.mul_add(aa, d.mul_add(dd, e * ee));
            sound &= (det.simd_gt(0.0) & a.simd_gt(0.0) & det.is_finite()).all_true();
            let scale = simd.splat_f64x8(1.0) / det;
            let (aa, dd, ee) = (aa * scale, dd * scale, ee * scale);
            let bb = a.mul_sub(c, e * e) * scale;
            let ff = d.mul_sub(e, a * f) * scale;
            let cc = a.mul_sub(b, d * d) * scale;
            let first = transposed(simd, [aa, dd, ee, dd, bb, ff, ee, ff]);
            let cc = cc.to_array();
            for (lane, out) in out.iter_mut().enumerate() {
                out[..8].copy_from_slice(&first[lane].to_array());
                out[8] = cc[lane];
            }
        }
        sound
    }

    /// Adds `K⁻¹ r` of one group to its freedoms; overwrites r. Nothing where its block is not
    /// positive definite.
    pub fn correct(&mut self, coarse: &Coarse, group: usize, r: &mut [f64], u: &mut [f64]) {
        let block = coarse.block(group);
        let l = &mut self.bodies[block.clone()];
        l.copy_from_slice(&coarse.blocks[block]);
        if small_cholesky::factor(l, r.len()) {
            small_cholesky::forward(l, r.len(), r);
            small_cholesky::backward(l, r.len(), r);
            u.iter_mut().zip(r.iter()).for_each(|(u, r)| *u += r);
        }
    }

    /// The bodies' part: `u = K_uu⁻¹ u`.
    pub fn solve_bodies(&self, system: &System<'_>, coarse: &Coarse, u: &mut [f64]) {
        for (g, dofs) in system.bodies.groups().iter().enumerate() {
            let l = &self.bodies[coarse.block(g)];
            small_cholesky::forward(l, dofs.len(), &mut u[dofs.clone()]);
            small_cholesky::backward(l, dofs.len(), &mut u[dofs.clone()]);
        }
    }

    /// `z = P⁻¹ r`.
    pub fn apply(
        &self,
        system: &System<'_>,
        coarse: &Coarse,
        r: &Coordinates,
        z: &mut Coordinates,
    ) {
        z.u.copy_from_slice(&r.u);
        self.solve_bodies(system, coarse, &mut z.u);
        let inverses = self.nodes.as_flattened();
        dispatch!(Level::new(), simd => {
            for (n, (z, r)) in z.w.iter_mut().zip(&r.w).enumerate() {
                let mut sums = [simd.splat_f64x4(0.0); 3];
                add_product(simd, inverses, n, r, &mut sums);
                *z = vector(sums[0] + sums[1] + sums[2]);
            }
        });
    }
}
