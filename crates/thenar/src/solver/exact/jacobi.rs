//! Block Jacobi: one dense block per group of bodies, 3×3 per node.

use crate::math::{Mat3, Vec3};
use crate::solver::diagonal::invert_symmetric;
use crate::solver::exact::coarse::Coarse;
use crate::solver::exact::{Coordinates, System, small_cholesky};

/// The inverted block diagonal.
#[derive(Clone, Debug)]
pub struct BlockJacobi {
    /// Cholesky factors of the groups' blocks.
    bodies: Vec<f64>,
    nodes: Vec<Mat3>,
}

impl BlockJacobi {
    /// Room.
    pub fn new(coarse: &Coarse, nodes: usize) -> Self {
        Self { bodies: vec![0.0; coarse.blocks.len()], nodes: vec![Mat3::zeros(); nodes] }
    }

    /// Inverts the diagonal; false when a block is not positive definite.
    pub fn refresh(&mut self, system: &System<'_>, coarse: &Coarse) -> bool {
        self.bodies.copy_from_slice(&coarse.blocks);
        for (g, dofs) in system.bodies.groups().iter().enumerate() {
            if !small_cholesky::factor(&mut self.bodies[coarse.block(g)], dofs.len()) {
                return false;
            }
        }
        let row0 = 2 * system.bodies.bodies();
        for (n, out) in self.nodes.iter_mut().enumerate() {
            let mut block = system.A.get(system.A.diagonal[row0 + n]);
            let spring = system.unknown(row0 + n, &Vec3::repeat(system.springs[n]));
            block.set_diagonal(&(block.diagonal() + spring));
            match invert_symmetric(&block) {
                Some(inverse) => *out = inverse,
                None => return false,
            }
        }
        true
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
        for (g, dofs) in system.bodies.groups().iter().enumerate() {
            let l = &self.bodies[coarse.block(g)];
            small_cholesky::forward(l, dofs.len(), &mut z.u[dofs.clone()]);
            small_cholesky::backward(l, dofs.len(), &mut z.u[dofs.clone()]);
        }
        for ((z, r), inverse) in z.w.iter_mut().zip(&r.w).zip(&self.nodes) {
            *z = inverse * r;
        }
    }
}
