//! Two solvers on one scene, side by side: the two-step scheme of the paper against the monolithic
//! solution of the same equations.
//!
//! [`Comparison`] steps two sessions of the same scene, which get the same motions and loads (and
//! springs as joint limits, as the two-step scheme has no others), and measures after each step how
//! far they are apart. Its [`CompareMode`] says whether each goes its own way, or both set out anew
//! from the monolithic state in every step, which leaves the error of splitting alone. [`sweep`]
//! does the latter over coupling stiffness and time step.

mod bodies;
mod columns;
mod deviation;
mod divergence;
mod moment;
mod summary;
pub mod sweep;

pub use bodies::{Bodies, Object};
pub use deviation::Deviation;
pub use divergence::{Cause, Divergence};
pub use moment::{Moment, SideMoment};
pub use summary::{ObjectSummary, PartSummary, Peak, SideSummary, Summary};

use crate::session::{Column, Session};
use divergence::DivergenceMonitor;
use thenar_core::model::{FleshInStep1, JointLimits, SolverKind, SolverSettings};
use thenar_core::world::{ModelError, StageTimer};

/// Index of the two-step scheme wherever both are listed.
pub const TWO_STEP: usize = 0;
/// Index of the monolithic solver.
pub const MONOLITHIC: usize = 1;
/// Names of both, in columns and reports.
pub const SIDES: [&str; 2] = ["two-step", "monolithic"];

/// State from which each step sets out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CompareMode {
    /// From where the same solver went before: how far the motions drift apart.
    Trajectories,
    /// Both from the monolithic state: what one step does differently. Inner tolerances are
    /// tightened, so that the difference is that of the schemes.
    SingleSteps,
}

/// A variant of the two-step scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// With the scene's settings.
    AsSet,
    /// Scheme as the paper prints it: flesh frozen in step 1, joints left to the next step.
    Paper,
    /// Flesh that yields in step 1 by its own inertia; joints left to the next step.
    Yielding,
    /// Yielding flesh, and joints closed once more at the end of the step: our default.
    Closed,
}

impl Scheme {
    /// Turns settings into those of this scheme.
    pub fn apply(self, settings: &mut SolverSettings) {
        settings.kind = SolverKind::TwoStep;
        (settings.step1_flesh, settings.close_joints) = match self {
            Self::AsSet => (settings.step1_flesh, settings.close_joints),
            Self::Paper => (FleshInStep1::Frozen, false),
            Self::Yielding => (FleshInStep1::Lumped, false),
            Self::Closed => (FleshInStep1::Lumped, true),
        };
    }
}

/// Why two solvers cannot be compared on a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompareError {
    /// Nothing moves by forces.
    #[error("nothing in this scene moves by forces, so there is nothing to compare")]
    NothingMoves,
    /// A solver does not take the settings that it would be compared with.
    #[error("the settings to compare with are refused: {0}")]
    Settings(#[from] ModelError),
}

/// Two sessions of one scene that are stepped together.
#[derive(Debug)]
pub struct Comparison {
    sessions: [Session; 2],
    mode: CompareMode,
    bodies: Bodies,
    monitors: [DivergenceMonitor; 2],
    moment: Moment,
    columns: Vec<Column>,
    row: Vec<f64>,
    summary: Summary,
    steps: u64,
}

impl Comparison {
    /// Compares on a scene that was opened twice, the same way.
    ///
    /// # Errors
    /// Nothing in the scene moves by forces, or a solver refuses its settings.
    pub fn new(
        mut sessions: [Session; 2],
        mode: CompareMode,
        scheme: Scheme,
    ) -> Result<Self, CompareError> {
        for (side, session) in sessions.iter_mut().enumerate() {
            let mut settings = session.world().desc().solver;
            match side {
                TWO_STEP => scheme.apply(&mut settings),
                _ => settings.kind = SolverKind::Monolithic,
            }
            // The two-step scheme knows no other; both must have the same model.
            settings.limits = JointLimits::Springs;
            if mode == CompareMode::SingleSteps {
                tighten(&mut settings);
            }
            session.world_mut().set_solver_settings(settings)?;
        }
        let bodies = Bodies::of(&sessions[MONOLITHIC]);
        if bodies.bones.is_empty() && bodies.objects.is_empty() {
            return Err(CompareError::NothingMoves);
        }
        let columns = columns::columns(&bodies);
        let monitors = [0, 1].map(|side| DivergenceMonitor::new(&sessions[side]));
        let moment = Moment::of(&sessions, &bodies, [true; 2]);
        let summary = Summary::new(&moment, &bodies);
        let mut comparison = Self {
            row: Vec::with_capacity(columns.len()),
            sessions,
            mode,
            bodies,
            monitors,
            moment,
            columns,
            summary,
            steps: 0,
        };
        comparison.fill_row();
        Ok(comparison)
    }

    /// One step of each. The one that goes first changes from step to step, so that neither always
    /// finds the other's leavings in the caches. One that has diverged rests.
    pub fn step(&mut self, timers: &mut [impl StageTimer; 2]) {
        if self.mode == CompareMode::SingleSteps {
            let [two_step, monolithic] = &mut self.sessions;
            two_step.world_mut().restore(monolithic.world().state());
        }
        let first = (self.steps % 2) as usize;
        for side in [first, 1 - first] {
            if !self.has_diverged(side) {
                let report = self.sessions[side].step(&mut timers[side]);
                self.summary.sides[side].failed += u64::from(report.non_finite);
                self.summary.sides[side].fell_back += u64::from(report.fell_back);
            }
        }
        self.steps += 1;
        if self.mode == CompareMode::Trajectories {
            self.find_divergence();
        }
        let usable =
            [0, 1].map(|side| !self.has_diverged(side) && !self.sessions[side].report().non_finite);
        self.moment = Moment::of(&self.sessions, &self.bodies, usable);
        self.summary.take(&self.moment);
        self.fill_row();
    }

    fn find_divergence(&mut self) {
        let energies = [0, 1].map(|side| divergence::inner_energy(&self.sessions[side]));
        let others: [f64; 2] =
            [self.monitors[MONOLITHIC].energy_max, self.monitors[TWO_STEP].energy_max];
        for side in 0..2 {
            if self.has_diverged(side) {
                continue;
            }
            let alone = self.has_diverged(1 - side);
            let bound = (!alone).then_some(others[side]);
            let found = self.monitors[side].find(&self.sessions[side], energies[side], bound);
            self.summary.sides[side].diverged = found;
        }
        for side in 0..2 {
            if !self.has_diverged(side) {
                self.monitors[side].energy_max = self.monitors[side].energy_max.max(energies[side]);
            }
        }
    }

    fn fill_row(&mut self) {
        self.row.clear();
        columns::row(&self.moment, &self.bodies, &mut self.row);
    }

    /// True once this side has diverged.
    pub fn has_diverged(&self, side: usize) -> bool {
        self.summary.sides[side].diverged.is_some()
    }

    /// True while one of them still moves.
    pub fn goes_on(&self) -> bool {
        !(self.has_diverged(TWO_STEP) && self.has_diverged(MONOLITHIC))
    }

    /// Name and unit of each number in [`Comparison::row`].
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Compared quantities after the last step; NaN where a side has diverged.
    pub fn row(&self) -> &[f64] {
        &self.row
    }

    /// Distances, angles and forces apart after the last step.
    pub fn moment(&self) -> &Moment {
        &self.moment
    }

    /// Bodies that are compared.
    pub fn bodies(&self) -> &Bodies {
        &self.bodies
    }

    /// Means and extremes so far.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// The two sessions.
    pub fn sessions(&self) -> &[Session; 2] {
        &self.sessions
    }

    /// Mode of the comparison.
    pub fn mode(&self) -> CompareMode {
        self.mode
    }

    /// Steps done.
    pub fn steps(&self) -> u64 {
        self.steps
    }
}

/// Inner solvers far more accurate than any difference that is looked for.
pub(crate) fn tighten(settings: &mut SolverSettings) {
    settings.cg_tolerance = settings.cg_tolerance.min(1e-10);
    settings.cg_iterations_max = settings.cg_iterations_max.max(5000);
    settings.velocity_tolerance = settings.velocity_tolerance.min(1e-8);
    // Both make the same steps.
    settings.step_halvings_max = 0;
    settings.contact_tolerance = settings.contact_tolerance.min(1e-8);
    settings.contact_sweeps_max = settings.contact_sweeps_max.max(5000);
}
