//! The block diagonal D of the system matrix, inverted: 6×6 for rigid bodies, 3×3 for nodes.

use crate::math::{Mat3, Mat6, Vec3, Vec6};
use crate::solver::BlockMatrix;

/// `D⁻¹`, the preconditioner of conjugate gradients and the local response of constraint
/// anticipation.
#[derive(Clone, Debug)]
pub struct BlockDiagonal {
    /// Per rigid body.
    pub rigid: Vec<Mat6>,
    /// Per node.
    pub node: Vec<Mat3>,
}

impl BlockDiagonal {
    /// Room for this many bodies and nodes.
    pub fn new(rigids: usize, nodes: usize) -> Self {
        Self { rigid: vec![Mat6::identity(); rigids], node: vec![Mat3::identity(); nodes] }
    }

    /// Inverts the diagonal blocks of `a`. Returns false when one is not positive definite.
    pub fn refresh(&mut self, a: &BlockMatrix) -> bool {
        let rigids = self.rigid.len();
        let mut ok = true;
        for (b, inverse) in self.rigid.iter_mut().enumerate() {
            match rigid_block(a, b).cholesky() {
                Some(c) => *inverse = c.inverse(),
                None => ok = false,
            }
        }
        for (n, inverse) in self.node.iter_mut().enumerate() {
            match invert_symmetric(&a.get(a.diagonal[2 * rigids + n])) {
                Some(m) => *inverse = m,
                None => ok = false,
            }
        }
        ok
    }

    /// `z = D⁻¹ r`.
    pub fn times(&self, r: &[Vec3], z: &mut [Vec3]) {
        let rigids = self.rigid.len();
        for b in 0..rigids {
            self.rigid_times(b, r[2 * b], r[2 * b + 1], z);
        }
        for (n, inverse) in self.node.iter().enumerate() {
            z[2 * rigids + n] = inverse * r[2 * rigids + n];
        }
    }

    /// The two rows of rigid body `b` of `D⁻¹ r`.
    #[inline]
    pub fn rigid_times(&self, b: usize, linear: Vec3, angular: Vec3, z: &mut [Vec3]) {
        let r = Vec6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z);
        let y = self.rigid[b] * r;
        z[2 * b] = Vec3::new(y[0], y[1], y[2]);
        z[2 * b + 1] = Vec3::new(y[3], y[4], y[5]);
    }
}

/// The 6×6 diagonal block of rigid body `b`.
pub fn rigid_block(a: &BlockMatrix, b: usize) -> Mat6 {
    let mut m = Mat6::zeros();
    for r in 0..2 {
        for c in 0..2 {
            let block = a.get(a.entry((2 * b + r) as u32, (2 * b + c) as u32));
            m.fixed_view_mut::<3, 3>(3 * r, 3 * c).copy_from(&block);
        }
    }
    m
}

/// Inverse of a symmetric positive definite 3×3 matrix by cofactors.
pub(super) fn invert_symmetric(m: &Mat3) -> Option<Mat3> {
    let c00 = m.m22 * m.m33 - m.m23 * m.m23;
    let c01 = m.m13 * m.m23 - m.m12 * m.m33;
    let c02 = m.m12 * m.m23 - m.m13 * m.m22;
    let det = m.m11 * c00 + m.m12 * c01 + m.m13 * c02;
    if !(det > 0.0 && m.m11 > 0.0 && det.is_finite()) {
        return None;
    }
    let c11 = m.m11 * m.m33 - m.m13 * m.m13;
    let c12 = m.m12 * m.m13 - m.m11 * m.m23;
    let c22 = m.m11 * m.m22 - m.m12 * m.m12;
    Some(Mat3::new(c00, c01, c02, c01, c11, c12, c02, c12, c22) / det)
}
