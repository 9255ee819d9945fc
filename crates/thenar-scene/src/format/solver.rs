//! Solver settings.

use crate::text::{table, words};

/// Old spelling of "monolithic", read wherever a solver is named, and offered nowhere.
pub const MONOLITHIC_ONCE: &str = "exact";

words! {
    /// The solver that steps the world.
    pub enum SolverWord {
        /// Eq. 9 with its joint rows and contacts, to a velocity tolerance.
        "monolithic" => Monolithic,
        /// Skeleton first, then flesh and skeleton without joints (paper, Sec. 4).
        "two-step" => TwoStep,
    } once {
        MONOLITHIC_ONCE => "monolithic",
    }
}

words! {
    /// Friction cone.
    pub enum ConeWord {
        /// The exact circular Coulomb cone.
        "circular" => Circular,
        /// The paper's linearised cone, a four-sided pyramid.
        "linearised" => Linearised,
    }
}

words! {
    /// Mechanism that keeps joints within their range.
    pub enum JointLimitsWord {
        /// Bounds that no load passes.
        "rows" => Rows,
        /// Stiff springs past the bounds.
        "springs" => Springs,
    }
}

words! {
    /// Assumption of step 1 about the flesh.
    pub enum FleshWord {
        /// Flesh yields by its own inertia; stable at stiff couplings too.
        "lumped" => Lumped,
        /// Flesh does not move (Eq. 10); diverges when the coupling is stiff.
        "frozen" => Frozen,
    }
}

table! {
    /// Solver settings; what is left out keeps the library's default.
    pub struct SolverTable {
        /// "monolithic" (default: joints, flesh and contact in one system) or "two-step" (the
        /// paper's).
        kind: Option<SolverWord>;
        /// Velocity error of the monolithic solver [m/s]. Default 1e-5.
        velocity_tolerance: Option<f64> where TOLERANCE;
        /// Friction cone: "circular" (default) or "linearised".
        cone: Option<ConeWord>;
        /// Joint limits: "rows" (default; bounds that no load passes, in one system with contact)
        /// or "springs" (`limit_stiffness` and `limit_damping` of the joint; always so with the
        /// two-step solver).
        limits: Option<JointLimitsWord>;
        /// Flesh in step 1: "lumped" (default) or "frozen" (the paper's).
        step1_flesh: Option<FleshWord>;
        /// Close the joints once more at the end of each step: default true with lumped flesh;
        /// false with frozen flesh, as in the paper, which leaves that to the next step.
        close_joints: Option<bool>;
        /// Two-step: conjugate gradients stop at this residual relative to the right-hand side.
        /// Default 1e-5.
        cg_tolerance: Option<f64> where TOLERANCE;
        /// Most conjugate-gradient iterations of either solver. Default 500.
        cg_iterations_max: Option<u32> where ITERATIONS;
        /// Constraint anticipation stops at this relative residual. Default 1e-4.
        contact_tolerance: Option<f64> where TOLERANCE;
        /// Most sweeps of either solver over the contacts. Default 200.
        contact_sweeps_max: Option<u32> where ITERATIONS;
        /// Largest number of multiply-adds that the monolithic solver spends on the law of contact
        /// in a step; then it makes its last sweeps and reports the error that is left. A processor
        /// core does some 4e9 a second. Default: no bound in `thenar run`; what a core does in one
        /// `time_step` where a scene runs live (`thenar serve`, `thenar touch`).
        contact_work_max: Option<f64> where WORK;
        /// Gauss-Seidel passes over the contacts within one sweep. Default 2.
        contact_inner_passes: Option<u32> where ITERATIONS;
        /// Points nearer than this become constraints before they touch [m]. Default 0.001.
        contact_margin: Option<f64> where MARGIN;
        /// A step that contact does not carry through (an overlap grows in it by half the margin or
        /// half the thickness of a thin rigid body, or the monolithic solver is off by a hundred
        /// tolerances) is made in halves, and these again, at most this number of times. Zero never
        /// divides a step, which bounds its cost. Default 5.
        step_halvings_max: Option<u32> where HALVINGS;
    }
}
