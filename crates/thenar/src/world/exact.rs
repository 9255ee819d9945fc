//! A step by the exact solver: what it needs of the model, and what it gives the state.

use crate::coupling::skin_target;
use crate::math::Vec3;
use crate::model::SolverSettings;
use crate::solver::exact::{Accuracy, Carried, Exact, Plan, StepSystem};
use crate::solver::{Convergence, Failure};
use crate::world::fall_back::Care;
use crate::world::limits;
use crate::world::model::Model;
use crate::world::state::{Scratch, State};

/// The solver of a model whose nodes rest at `positions`.
pub fn build(model: &Model, positions: &[Vec3], contacts_max: usize) -> Exact {
    let moves: Vec<bool> = model.rigids.iter().map(|r| r.moves).collect();
    let ends: Vec<_> = model.joints.iter().map(|j| (j.parent, j.child)).collect();
    let rows: Vec<usize> = model.joints.iter().map(|j| j.kind.rows()).collect();
    let mut soft_of_node = vec![0; positions.len()];
    for (s, nodes) in model.soft_nodes.iter().enumerate() {
        soft_of_node[nodes.clone()].fill(s as u32);
    }
    let carried: Vec<Carried> = model
        .coupling
        .bound
        .iter()
        .map(|bound| Carried {
            node: bound.node,
            bones: bound.bones,
            carriers: bound.carriers() as u8,
            held: model.known[2 * model.rigids.len() + bound.node as usize],
            weights: bound.weights,
            levers: [Vec3::zeros(); 2],
            spring: 0.0,
            stretch: Vec3::zeros(),
        })
        .collect();
    Exact::new(&Plan {
        moves: &moves,
        ends: &ends,
        rows: &rows,
        carried: &carried,
        soft_of_node: &soft_of_node,
        positions,
        pattern: &model.pattern,
        contacts_max,
        bounds_max: limits::rows_max(model),
    })
}

/// The coupling springs at this state (Eq. 6-8).
pub fn couple(model: &Model, state: &State, h: f64, scratch: &mut Scratch) {
    let Some(exact) = &mut scratch.exact else { return };
    let coupling = &model.coupling;
    for (k, (bound, carried)) in coupling.bound.iter().zip(&mut exact.carried).enumerate() {
        let target = skin_target(bound, &state.poses_WB);
        carried.levers = target.levers_W;
        carried.spring = h * h * coupling.stiffness[k] + h * coupling.damping[k];
        let stretched = state.x[bound.node as usize] - target.position_W;
        carried.stretch = stretched * (h * coupling.stiffness[k]);
    }
}

/// Velocities without contact. What does not converge is an error, or taken as it is: `care` tells.
///
/// # Errors
/// The system cannot be solved to tolerance.
pub fn solve(
    settings: &SolverSettings,
    care: Care,
    model: &Model,
    state: &mut State,
    h: f64,
    scratch: &mut Scratch,
) -> Result<Convergence, Failure> {
    let Some(exact) = &mut scratch.exact else { return Err(Failure::NotPositiveDefinite) };
    if !scratch.b.iter().all(|b| b.iter().all(|x| x.is_finite())) {
        return Err(Failure::NotFinite);
    }
    let step = StepSystem { A: &scratch.A, b: &scratch.b, known: &model.known };
    let accuracy = accuracy(settings, care);
    let touched = state.impulses.iter().any(|(_, impulse)| *impulse != Vec3::zeros());
    if touched {
        // Near what the step before had without contact.
        state.v.iter_mut().zip(&state.contact_change).for_each(|(v, change)| *v -= change);
    }
    let solved = exact.solve(&step, &scratch.joints, h, touched, &accuracy, &mut state.v)?;
    Ok(Convergence { iterations: solved.iterations, residual: solved.error })
}

/// How accurately this step is solved.
pub fn accuracy(settings: &SolverSettings, care: Care) -> Accuracy {
    Accuracy {
        best_effort: care == Care::Safe,
        velocity: settings.velocity_tolerance,
        iterations_max: settings.cg_iterations_max,
        sweeps_max: settings.contact_sweeps_max,
    }
}

/// Contact through the compliance of the whole system; leaves Δv in the state's contact change.
///
/// # Errors
/// The flesh cannot be factored; where accuracy is asked for, also when it cannot be had.
pub fn respond(
    settings: &SolverSettings,
    care: Care,
    model: &Model,
    state: &mut State,
    scratch: &mut Scratch,
) -> Result<Convergence, Failure> {
    let Some(exact) = &mut scratch.exact else { return Err(Failure::NotPositiveDefinite) };
    let step = StepSystem { A: &scratch.A, b: &scratch.b, known: &model.known };
    let accuracy = accuracy(settings, care);
    let change = &mut state.contact_change;
    exact.respond(&step, &mut scratch.rows, settings.cone, &accuracy, change)
}

/// Shortens the velocities until they bring in no energy, and returns by how much: see
/// [`Exact::calm`].
pub fn calm(model: &Model, state: &mut State, scratch: &mut Scratch) -> f64 {
    let Some(exact) = &mut scratch.exact else { return 1.0 };
    let step = StepSystem { A: &scratch.A, b: &scratch.b, known: &model.known };
    exact.calm(&step, &mut state.v)
}
