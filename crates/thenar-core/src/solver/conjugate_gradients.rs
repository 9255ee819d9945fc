//! Preconditioned conjugate gradients (Hestenes and Stiefel 1952) for Eq. 11.

use crate::math::Vec3;
use crate::solver::{BlockDiagonal, BlockMatrix, Convergence, Islands};

/// Vectors of one size that the iteration works in.
#[derive(Clone, Debug)]
pub struct CgWorkspace {
    r: Vec<Vec3>,
    z: Vec<Vec3>,
    p: Vec<Vec3>,
    q: Vec<Vec3>,
}

impl CgWorkspace {
    /// Room for `rows` block rows.
    pub fn new(rows: usize) -> Self {
        let zeros = vec![Vec3::zeros(); rows];
        Self { r: zeros.clone(), z: zeros.clone(), p: zeros.clone(), q: zeros }
    }
}

/// Solves `A x = b` from the start value in `x`.
///
/// Stops when `‖b − A x‖ ≤ tolerance ‖b‖`, both in the norm of `D⁻¹`, in which the metres and
/// radians of `b` weigh alike. The residual returned is not finite when `b` or the start is not.
pub fn conjugate_gradients(
    a: &BlockMatrix,
    d: &BlockDiagonal,
    b: &[Vec3],
    x: &mut [Vec3],
    tolerance: f64,
    iterations_max: u32,
    work: &mut CgWorkspace,
) -> Convergence {
    debug_assert_eq!(b.len(), a.rows(), "right-hand sides, block rows");
    debug_assert_eq!(x.len(), a.rows(), "unknowns, block rows");
    debug_assert_eq!(work.r.len(), a.rows(), "rows of room, block rows");
    debug_assert!(tolerance > 0.0, "a tolerance of {tolerance}, not above 0");
    let CgWorkspace { r, z, p, q } = work;
    d.times(b, z);
    let b_norm2 = dot(b, z);
    let stop2 = tolerance * tolerance * b_norm2;

    a.times(x, q);
    for i in 0..r.len() {
        r[i] = b[i] - q[i];
    }
    d.times(r, z);
    let mut rz = dot(r, z);
    p.copy_from_slice(z);
    let mut iterations = 0;
    while rz > stop2 && iterations < iterations_max {
        a.times(p, q);
        let alpha = rz / dot(p, q);
        for i in 0..r.len() {
            x[i] += alpha * p[i];
            r[i] -= alpha * q[i];
        }
        d.times(r, z);
        let rz_new = dot(r, z);
        let beta = rz_new / rz;
        rz = rz_new;
        for i in 0..r.len() {
            p[i] = z[i] + beta * p[i];
        }
        iterations += 1;
    }
    let residual = if b_norm2 == 0.0 { 0.0 } else { (rz / b_norm2).sqrt() };
    Convergence { iterations, residual }
}

/// Weighs for each island the part s of its velocities `v`, at most 1, that has the least
/// `½ v·A v - v·b`; velocities that are given (`known`) stay. Then these velocities take no more
/// energy than `b` gives.
pub fn weigh_energy(
    a: &BlockMatrix,
    b: &[Vec3],
    known: &[[bool; 3]],
    v: &[Vec3],
    work: &mut CgWorkspace,
    islands: &mut Islands,
) {
    debug_assert_eq!(v.len(), a.rows(), "velocities, block rows");
    debug_assert_eq!(known.len(), a.rows(), "rows that are known or not, block rows");
    let CgWorkspace { z: x, p, q, .. } = work;
    for (x, (v, known)) in x.iter_mut().zip(v.iter().zip(known)) {
        *x = Vec3::from_fn(|k, _| if known[k] { 0.0 } else { v[k] });
    }
    a.times(x, q);
    a.times(v, p);
    for row in 0..x.len() {
        islands.add(row, x[row].dot(&q[row]), x[row].dot(&(b[row] - p[row])));
    }
    islands.weigh();
}

fn dot(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}
