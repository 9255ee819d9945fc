//! The linear systems of a step and their solvers.
//!
//! Unknowns are velocities in blocks of three: rigid body `b` owns block rows `2b` (linear, at
//! its centre of mass) and `2b + 1` (angular); node `n` owns row `2B + n`, with B rigid bodies.
//! In the paper's words the first `2B` rows are the skeleton `v_s`, the rest the flesh `v_f`.

mod anticipation;
mod articulated;
mod block_matrix;
mod conjugate_gradients;
mod contact_law;
mod contact_rows;
mod dense;
#[cfg(any(test, feature = "reference"))]
mod dense_reference;
mod diagonal;
mod failure;
mod islands;
pub mod monolithic;
mod push_out;
pub mod tree;
mod turning;

pub use anticipation::{Anticipation, AnticipationSettings};
pub use articulated::{Articulated, JointBlock};
pub use block_matrix::BlockMatrix;
pub use conjugate_gradients::{CgWorkspace, conjugate_gradients, weigh_energy};
pub(crate) use contact_law::is_on_rim;
pub use contact_law::project;
pub use contact_rows::{ContactRow, ContactRows, TURN_LEVER};
pub use dense::DenseLu;
#[cfg(any(test, feature = "reference"))]
pub use dense_reference::DenseSystem;
pub use diagonal::BlockDiagonal;
pub use failure::Failure;
pub use islands::Islands;
pub use push_out::PushTarget;
pub use turning::{RelativeTerm, Turning};

/// Joints that close a loop often ask twice for the same thing, and a joint between bodies that do
/// not move asks for nothing that can be given. A compliance of this part of a row's own response
/// keeps dense factorisations regular then.
const JOINT_COMPLIANCE: f64 = 1e-12;

/// The compliance of a joint row, from its entries and the diagonal entries of the matrix there.
fn joint_compliance(row: impl Iterator<Item = (f64, f64)>) -> f64 {
    let response: f64 = row.filter(|(j, _)| *j != 0.0).map(|(j, diagonal)| j * j / diagonal).sum();
    if response > 0.0 { JOINT_COMPLIANCE * response } else { 1.0 }
}

/// Outcome of an iterative solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Convergence {
    /// Iterations done.
    pub iterations: u32,
    /// Relative residual reached.
    pub residual: f64,
}
