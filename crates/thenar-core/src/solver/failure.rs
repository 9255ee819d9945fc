//! Why a solver gave no solution.

/// Why the solver that was asked for did not make a step.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Failure {
    /// Input or state hold, or the solution came out with, a number that is not finite or beyond
    /// any sense.
    #[error("a number that is not finite")]
    NotFinite,
    /// The system has no unique solution: a mass or a stiffness is too far from the others, or a
    /// joint is in gimbal lock.
    #[error("the system is not positive definite")]
    NotPositiveDefinite,
    /// The accuracy asked for was not reached.
    #[error("not converged: velocities are off by {residual:.1e} m/s")]
    NotConverged {
        /// Estimated velocity error, or violation of the contact law \[m/s\].
        residual: f64,
    },
    /// More contacts press than there is room for.
    #[error("more than {most} contacts press")]
    TooManyContacts {
        /// Number there is room for.
        most: u32,
    },
}
