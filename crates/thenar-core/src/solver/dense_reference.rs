//! Eq. 9 as it stands, `[A Jᵀ; J 0] [v; λ] = [b; c]`, factored densely, with contact resolved
//! through the exact compliance of the whole constrained system: the reference that the fast
//! solvers are measured against. It allocates and costs the cube of the number of unknowns.

use crate::math::{Mat3, Vec3};
use crate::model::Cone;
use crate::solver::{BlockMatrix, ContactRows, Convergence, DenseLu, joint_compliance};

/// The factored system.
pub struct DenseSystem {
    lu: DenseLu,
    unknowns: usize,
}

impl DenseSystem {
    /// Factors the whole system; `J` has one dense row per joint constraint. `None` when it is
    /// singular.
    pub fn new(A: &BlockMatrix, J: &[Vec<f64>]) -> Option<Self> {
        let unknowns = 3 * A.rows();
        J.iter()
            .for_each(|row| debug_assert_eq!(row.len(), unknowns, "numbers of a row, unknowns"));
        let mut lu = DenseLu::new(unknowns + J.len());
        for i in 0..A.rows() {
            for k in A.row(i) {
                let j = A.columns[k] as usize;
                for (e, value) in A.blocks[k].iter().enumerate() {
                    lu.add(3 * i + e % 3, 3 * j + e / 3, *value);
                }
            }
        }
        for (r, row) in J.iter().enumerate() {
            let diagonal = |j: usize| A.blocks[A.diagonal[j / 3] as usize][4 * (j % 3)];
            let entries = row.iter().enumerate().map(|(j, value)| (*value, diagonal(j)));
            lu.add(unknowns + r, unknowns + r, -joint_compliance(entries));
            for (j, value) in row.iter().enumerate() {
                lu.add(unknowns + r, j, *value);
                lu.add(j, unknowns + r, *value);
            }
        }
        lu.factor().then_some(Self { lu, unknowns })
    }

    /// Velocities and joint impulses for this right-hand side.
    pub fn solve(&self, b: &[Vec3], c: &[f64]) -> (Vec<Vec3>, Vec<f64>) {
        debug_assert_eq!(3 * b.len(), self.unknowns, "numbers on the right-hand side, unknowns");
        debug_assert_eq!(
            c.len(),
            self.lu.size() - self.unknowns,
            "rates of joints, rows of joints"
        );
        let mut x: Vec<f64> = b.iter().flat_map(|b| [b.x, b.y, b.z]).collect();
        x.extend_from_slice(c);
        self.lu.solve(&mut x);
        let v = x[..self.unknowns].chunks_exact(3).map(Vec3::from_column_slice).collect();
        (v, x[self.unknowns..].to_vec())
    }

    /// The change of velocities that contact makes, joints held: projected Gauss-Seidel on
    /// `W = J_c K⁻¹ J_cᵀ` (velocities marked `known` do not respond), from the present impulses,
    /// until none changes by more than `tolerance` of the largest. The start matters: with friction
    /// there may be several solutions.
    pub fn contact(
        &self,
        contacts: &mut ContactRows,
        known: &[[bool; 3]],
        cone: Cone,
        tolerance: f64,
    ) -> (Vec<Vec3>, Convergence) {
        let rows = self.unknowns / 3;
        debug_assert_eq!(known.len(), rows, "rows that are known or not, block rows");
        debug_assert!(tolerance > 0.0, "a tolerance of {tolerance}, not above 0");
        let joints = vec![0.0; self.lu.size() - self.unknowns];
        let columns: Vec<[Vec<Vec3>; 3]> = contacts
            .rows
            .iter()
            .map(|row| {
                std::array::from_fn(|axis| {
                    let mut f = vec![Vec3::zeros(); rows];
                    contacts.scatter(row, &row.frame.row(axis).transpose(), &mut f);
                    for (f, known) in f.iter_mut().zip(known) {
                        (0..3).filter(|&k| known[k]).for_each(|k| f[k] = 0.0);
                    }
                    self.solve(&f, &joints).0
                })
            })
            .collect();
        let mut u = vec![Vec3::zeros(); rows];
        for i in 0..contacts.rows.len() {
            let row = &contacts.rows[i];
            let own: [Vec3; 3] = std::array::from_fn(|axis| {
                row.frame * contacts.relative_velocity(row, &columns[i][axis])
            });
            contacts.rows[i].response = Mat3::from_columns(&own);
            let lambda = contacts.rows[i].lambda;
            for (axis, column) in columns[i].iter().enumerate() {
                u.iter_mut().zip(column).for_each(|(u, c)| *u += c * lambda[axis]);
            }
        }

        let mut convergence = Convergence { iterations: 0, residual: 1.0 };
        while convergence.residual > tolerance && convergence.iterations < 100_000 {
            let (mut change, mut largest) = (0.0_f64, 1e-300_f64);
            for i in 0..contacts.rows.len() {
                let row = &contacts.rows[i];
                let value = row.frame * contacts.relative_velocity(row, &u) - row.target;
                let lambda = row.projected(cone, &value);
                let delta = lambda - row.lambda;
                if delta != Vec3::zeros() {
                    for (axis, column) in columns[i].iter().enumerate() {
                        for (u, c) in u.iter_mut().zip(column) {
                            *u += c * delta[axis];
                        }
                    }
                }
                change = change.max(delta.norm());
                largest = largest.max(lambda.norm());
                contacts.rows[i].lambda = lambda;
            }
            convergence.iterations += 1;
            convergence.residual = change / largest;
        }
        (u, convergence)
    }
}
