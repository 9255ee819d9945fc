//! Eq. 9 as it stands, solved densely: the reference that the fast solvers are measured against.
//! It allocates and costs the cube of the number of unknowns.

use crate::math::Vec3;
use crate::solver::{BlockMatrix, DenseLu};

/// The velocities and joint impulses of `[A Jᵀ; J 0] [v; λ] = [b; c]`, where A and b are the
/// whole coupled system (skeleton and flesh) and `J` has one dense row per joint constraint.
/// `None` when the matrix is singular.
pub fn solve_monolithic(
    A: &BlockMatrix,
    b: &[Vec3],
    J: &[Vec<f64>],
    c: &[f64],
) -> Option<(Vec<Vec3>, Vec<f64>)> {
    let (n, m) = (3 * b.len(), J.len());
    let mut lu = DenseLu::new(n + m);
    for i in 0..b.len() {
        for k in A.row(i) {
            let j = A.columns[k] as usize;
            for (e, value) in A.blocks[k].iter().enumerate() {
                lu.add(3 * i + e / 3, 3 * j + e % 3, *value);
            }
        }
    }
    for (r, row) in J.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            lu.add(n + r, j, *value);
            lu.add(j, n + r, *value);
        }
    }
    let mut x: Vec<f64> = b.iter().flat_map(|b| [b.x, b.y, b.z]).chain(c.iter().copied()).collect();
    if !lu.factor() {
        return None;
    }
    lu.solve(&mut x);
    let v = x[..n].chunks_exact(3).map(Vec3::from_column_slice).collect();
    Some((v, x[n..].to_vec()))
}
