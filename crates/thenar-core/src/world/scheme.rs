//! Common interface of the schemes of a step: [`Step::find_velocities`](crate::world::step::Step)
//! is the same for all of them but for these parts.

use crate::model::{JointLimits, SolverKind, WorldDesc};
use crate::solver::monolithic::Monolithic;
use crate::solver::{Convergence, Failure};
use crate::world::model::Model;
use crate::world::monolithic;
use crate::world::state::{Scratch, State};

/// The solver that a world's settings choose, with the memory that it alone needs.
#[derive(Clone, Debug)]
pub enum Solver {
    /// Eq. 9 to a velocity tolerance (`world::monolithic`).
    Monolithic(Box<Monolithic>),
    /// The paper's two steps (`world::two_step`).
    TwoStep,
    /// Eq. 9 in one dense piece (`world::reference`).
    #[cfg(any(test, feature = "reference"))]
    DenseReference,
}

impl Solver {
    /// The solver of this kind for a world that may find `contacts_max` contacts.
    pub fn new(kind: SolverKind, desc: &WorldDesc, model: &Model, contacts_max: usize) -> Self {
        match kind {
            SolverKind::Monolithic => {
                Self::Monolithic(Box::new(monolithic::build(desc, model, contacts_max)))
            }
            SolverKind::TwoStep => Self::TwoStep,
            #[cfg(any(test, feature = "reference"))]
            SolverKind::DenseReference => Self::DenseReference,
        }
    }

    /// Starts a step in which contact may cost this many multiply-adds; no bound when `None`.
    pub fn begin_step(&mut self, contact_work_max: Option<u64>) {
        if let Self::Monolithic(monolithic) = self {
            monolithic.begin_step(contact_work_max);
        }
    }

    /// True when contact has spent the multiply-adds that [`Solver::begin_step`] allowed it.
    pub fn was_cut_short(&self) -> bool {
        matches!(self, Self::Monolithic(monolithic) if monolithic.was_cut_short())
    }

    /// The kind of this solver, as settings name it.
    pub fn kind(&self) -> SolverKind {
        match self {
            Self::Monolithic(_) => SolverKind::Monolithic,
            Self::TwoStep => SolverKind::TwoStep,
            #[cfg(any(test, feature = "reference"))]
            Self::DenseReference => SolverKind::DenseReference,
        }
    }
}

/// One way to solve Eq. 9, with its settings. Each part finds in `scratch` what the parts before it
/// left there.
pub trait Scheme {
    /// Data that the solve without contact leaves for the response to contact.
    type Factored;

    /// Returns the mechanism that keeps joints within their range.
    fn limits(&self) -> JointLimits;

    /// Sets A to zero.
    fn clear(&self, scratch: &mut Scratch) {
        scratch.clear_matrix();
    }

    /// The springs between bones and flesh, and all that can be done before the flesh is assembled
    /// (Eq. 6-8, 10).
    ///
    /// # Errors
    /// The bones' system is singular.
    fn couple(
        &mut self,
        model: &Model,
        state: &mut State,
        h: f64,
        scratch: &mut Scratch,
    ) -> Result<(), Failure>;

    /// The state's velocities become those without contact (Eq. 9, 11).
    ///
    /// # Errors
    /// The system cannot be solved.
    fn free(
        &mut self,
        model: &Model,
        state: &mut State,
        h: f64,
        scratch: &mut Scratch,
    ) -> Result<(Self::Factored, Convergence), Failure>;

    /// The impulses of contacts and joint limits in `scratch.rows`, and what they add to the
    /// velocities in `state.contact_change` (Eq. 12).
    ///
    /// # Errors
    /// The system cannot be solved.
    fn respond(
        &mut self,
        factored: &Self::Factored,
        model: &Model,
        state: &mut State,
        scratch: &mut Scratch,
    ) -> Result<Convergence, Failure>;

    /// A residual of [`Scheme::respond`] beyond which contact has not converged.
    fn residual_max(&self) -> f64;

    /// Finishes the step once contact is in the velocities.
    ///
    /// # Errors
    /// The bones' system is singular.
    fn finish(
        &mut self,
        _model: &Model,
        _state: &mut State,
        _h: f64,
        _scratch: &mut Scratch,
    ) -> Result<(), Failure> {
        Ok(())
    }

    /// True when this scheme undoes overlaps. A step that is made safely does not: what that adds
    /// is not known to bring in no energy.
    fn pushes_out(&self) -> bool {
        true
    }

    /// The pseudo-velocity that `scratch.wishes` ask for, into `scratch.push`, which is zero
    /// (`solver::push_out`).
    fn push_out(&mut self, factored: &Self::Factored, model: &Model, scratch: &mut Scratch);
}
