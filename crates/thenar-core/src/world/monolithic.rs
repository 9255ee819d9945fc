//! A step by the monolithic solver: what it needs of the model, and what it gives the state.

use crate::coupling::{KernelValue, skin_target};
use crate::math::Vec3;
use crate::model::{JointLimits, SolverSettings, WorldDesc};
use crate::solver::monolithic::{Accuracy, CarriedNode, LastContact, Monolithic, Plan, StepSystem};
use crate::solver::{Convergence, Failure, Turning};
use crate::world::fall_back::Tolerance;
use crate::world::model::Model;
use crate::world::scheme::Scheme;
use crate::world::state::{Scratch, State};
use crate::world::{limits, response};

/// The solver of a model that may find `contacts_max` contacts.
pub fn build(desc: &WorldDesc, model: &Model, contacts_max: usize) -> Monolithic {
    let places = desc.softs.iter();
    let positions: Vec<Vec3> =
        places.flat_map(|soft| soft.flesh.nodes.iter().map(|x| soft.pose_WM.point(x))).collect();
    let moves: Vec<bool> = model.rigids.iter().map(|r| r.moves).collect();
    let ends: Vec<_> = model.joints.iter().map(|j| (j.parent, j.child)).collect();
    let rows: Vec<usize> = model.joints.iter().map(|j| j.kind.rows()).collect();
    let mut soft_of_node = vec![0; positions.len()];
    for (s, nodes) in model.soft_nodes.iter().enumerate() {
        soft_of_node[nodes.clone()].fill(s as u32);
    }
    let carried: Vec<CarriedNode> = model
        .coupling
        .bound
        .iter()
        .map(|bound| CarriedNode {
            node: bound.node,
            bones: bound.bones,
            bone_count: bound.bone_count() as u8,
            held: model.known[2 * model.rigids.len() + bound.node as usize],
            weights: bound.weights,
            turning: Turning::NONE,
            spring: 0.0,
            stretch: Vec3::zeros(),
        })
        .collect();
    Monolithic::new(&Plan {
        moves: &moves,
        ends: &ends,
        rows: &rows,
        carried: &carried,
        all_is_bound: model.all_is_bound(),
        soft_of_node: &soft_of_node,
        positions: &positions,
        pattern: &model.pattern,
        contacts_max: contacts_max + limits::rows_max(model),
        bounds_max: limits::rows_max(model),
    })
}

/// Sets A to zero. The blocks between bones and flesh are most of what is not flesh, and the
/// monolithic solver writes none of them.
pub fn clear(monolithic: &Monolithic, scratch: &mut Scratch) {
    if scratch.coupled {
        scratch.clear_matrix();
    } else {
        monolithic.clear(&mut scratch.A);
    }
}

/// The coupling springs at this state (Eq. 6-8).
pub fn couple(
    monolithic: &mut Monolithic,
    model: &Model,
    state: &State,
    h: f64,
    shares: &mut Vec<KernelValue>,
) {
    let coupling = &model.coupling;
    let posed = coupling.offsets.pose(&state.poses_WB, shares);
    for (k, (bound, carried)) in coupling.bound.iter().zip(&mut monolithic.carried).enumerate() {
        let target = skin_target(bound, &state.poses_WB, &posed);
        carried.turning = target.turning;
        carried.spring = h * h * coupling.stiffness[k] + h * coupling.damping[k];
        let stretched = state.x[bound.node as usize] - target.position_W;
        carried.stretch = stretched * (h * coupling.stiffness[k]);
    }
}

/// A step by the monolithic solver. What does not converge is an error, or taken as it is:
/// `tolerance` says.
pub struct MonolithicScheme<'a> {
    pub monolithic: &'a mut Monolithic,
    pub settings: SolverSettings,
    pub tolerance: Tolerance,
}

impl MonolithicScheme<'_> {
    fn accuracy(&self) -> Accuracy {
        Accuracy {
            best_effort: self.tolerance == Tolerance::BestEffort,
            velocity: self.settings.velocity_tolerance,
            iterations_max: self.settings.cg_iterations_max,
            sweeps_max: self.settings.contact_sweeps_max,
        }
    }
}

impl Scheme for MonolithicScheme<'_> {
    /// The monolithic solver keeps its own factor.
    type Factored = ();

    fn limits(&self) -> JointLimits {
        self.settings.limits
    }

    fn clear(&self, scratch: &mut Scratch) {
        clear(self.monolithic, scratch);
    }

    fn couple(
        &mut self,
        model: &Model,
        state: &mut State,
        h: f64,
        scratch: &mut Scratch,
    ) -> Result<(), Failure> {
        couple(self.monolithic, model, state, h, &mut scratch.shares);
        let bounds = scratch.limits.iter().map(|limit| limit.bound(model, state, h));
        self.monolithic.bounds_mut().extend(bounds);
        Ok(())
    }

    fn free(
        &mut self,
        model: &Model,
        state: &mut State,
        h: f64,
        scratch: &mut Scratch,
    ) -> Result<((), Convergence), Failure> {
        if !scratch.b.iter().all(|b| b.iter().all(|x| x.is_finite())) {
            return Err(Failure::NotFinite);
        }
        let accuracy = self.accuracy();
        let step = StepSystem { A: &scratch.A, b: &scratch.b, known: &model.known };
        let touched = state.impulses.iter().any(|(_, impulse)| *impulse != Vec3::zeros());
        let before = LastContact::of(touched, &state.v, model.rigids.len(), &self.settings);
        let Self { monolithic, .. } = self;
        if touched {
            // Near what the step before had without contact.
            state.v.iter_mut().zip(&state.contact_change).for_each(|(v, change)| *v -= change);
        }
        let solved =
            monolithic.solve(&step, &scratch.joints, h, before, &accuracy, &mut state.v)?;
        for (limit, bound) in scratch.limits.iter_mut().zip(monolithic.bounds()) {
            limit.included = bound.impulse;
        }
        Ok(((), Convergence { iterations: solved.iterations, residual: solved.error }))
    }

    /// Contact through the compliance of the whole system.
    fn respond(
        &mut self,
        (): &(),
        model: &Model,
        state: &mut State,
        scratch: &mut Scratch,
    ) -> Result<Convergence, Failure> {
        let (accuracy, cone) = (self.accuracy(), self.settings.cone);
        let step = StepSystem { A: &scratch.A, b: &scratch.b, known: &model.known };
        let change = &mut state.contact_change;
        self.monolithic.respond(&step, &mut scratch.rows, cone, &accuracy, change)
    }

    /// Impulses and velocities may each be off by the tolerance.
    fn residual_max(&self) -> f64 {
        2.0 * self.settings.velocity_tolerance
    }

    /// Shortens velocities until they bring in no energy, where safety is asked for.
    fn finish(
        &mut self,
        model: &Model,
        state: &mut State,
        h: f64,
        scratch: &mut Scratch,
    ) -> Result<(), Failure> {
        if self.tolerance == Tolerance::BestEffort {
            let step = StepSystem { A: &scratch.A, b: &scratch.b, known: &model.known };
            scratch.islands.begin(&scratch.rows);
            self.monolithic.limit_energy(&step, &mut scratch.islands, &mut state.v);
            response::scale_impulses(model, h, state, scratch);
        }
        Ok(())
    }

    fn pushes_out(&self) -> bool {
        self.tolerance == Tolerance::Required
    }

    fn push_out(&mut self, (): &(), model: &Model, scratch: &mut Scratch) {
        let accuracy = Accuracy { best_effort: true, ..self.accuracy() };
        let Scratch { A, b, rows, wishes, push, .. } = scratch;
        let step = StepSystem { A, b, known: &model.known };
        if self.monolithic.push_out(&step, rows, wishes, &accuracy, push).is_err() {
            push.fill(Vec3::zeros());
        }
    }
}
