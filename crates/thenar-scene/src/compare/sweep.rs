//! The error of splitting over coupling stiffness and time step.
//!
//! For each pair of the two the monolithic solver brings the scene to a moment. From there, for
//! each two-step scheme, first single steps are compared, then both go their own way, to see
//! whether the scheme diverges.

use super::{
    CompareError, CompareMode, Comparison, Divergence, MONOLITHIC, Peak, Scheme, TWO_STEP,
};
use crate::SceneError;
use crate::format::Scene;
use crate::session::Session;
use std::path::Path;
use thenar_core::World;
use thenar_core::model::SolverKind;

/// The schemes that a sweep measures.
pub const SCHEMES: [(Scheme, &str); 3] = [
    (Scheme::Paper, "paper"),
    (Scheme::Yielding, "yielding"),
    (Scheme::Closed, "yielding, closed"),
];

/// Fewest steps in which a scheme must show that it is stable.
const STEPS_MIN: u64 = 120;

/// Parameters of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Coupling stiffnesses per volume of flesh \[N/m⁴\].
    pub stiffness: Vec<f64>,
    /// Time steps \[s\].
    pub time_steps: Vec<f64>,
    /// Simulated time at which comparing begins \[s\].
    pub from: f64,
    /// Simulated time over which single steps are compared, and both go their own way \[s\].
    pub seconds: f64,
}

/// One stiffness at one time step.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPoint {
    /// Coupling stiffness \[N/m⁴\].
    pub stiffness: f64,
    /// Time step \[s\].
    pub time_step: f64,
    /// Largest over-correction γ of a jointed bone by the paper's scheme
    /// (`World::joint_over_correction`).
    pub over_correction: f64,
    /// By the monolithic solver, largest over the single steps: joint gap \[m\].
    pub monolithic_joint_gap: f64,
    /// The schemes, in the order of [`SCHEMES`].
    pub schemes: [SchemeResult; 3],
}

/// One scheme.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SchemeResult {
    /// Single steps: distance of bones after one step \[m\].
    pub position: Peak,
    /// Single steps: angle of bones after one step \[rad\].
    pub rotation: Peak,
    /// Single steps: largest joint gap \[m\].
    pub joint_gap: f64,
    /// Single steps: difference of drive force \[N\].
    pub drive_force: Peak,
    /// Steps that could not be solved.
    pub failed: u64,
    /// On its own way: when it diverged.
    pub diverged: Option<Divergence>,
    /// On its own way, up to then: distance of bones \[m\].
    pub drift: Peak,
}

/// Why a sweep was not made.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The scene cannot be built.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The solvers cannot be compared on this scene.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// The scene has no flesh bound to bones.
    #[error("no flesh of this scene is bound to bones, so there is no coupling to sweep")]
    NoCoupling,
    /// The monolithic solver itself failed.
    #[error("the monolithic solver failed at {0} N/m⁴ and a step of {1} s")]
    Monolithic(f64, f64),
}

/// Makes a sweep; `tell` hears of each point in order.
///
/// # Errors
/// The scene has no coupling, cannot be built with these values, or is not solved.
pub fn sweep(
    scene: &Scene,
    file: &Path,
    plan: &Plan,
    mut tell: impl FnMut(&SweepPoint),
) -> Result<Vec<SweepPoint>, SweepError> {
    let mut points = Vec::new();
    for &time_step in &plan.time_steps {
        for &stiffness in &plan.stiffness {
            let point = point(scene, file, plan, stiffness, time_step)?;
            tell(&point);
            points.push(point);
        }
    }
    Ok(points)
}

/// The scene with another coupling and step.
fn changed(scene: &Scene, stiffness: f64, time_step: f64) -> Scene {
    let mut scene = scene.clone();
    scene.time_step = time_step;
    scene.hand.iter_mut().for_each(|hand| hand.coupling_stiffness = Some(stiffness));
    for bind in scene.soft.iter_mut().flat_map(|soft| &mut soft.bind) {
        (bind.stiffness, bind.node_stiffness) = (Some(stiffness), None);
    }
    scene
}

fn point(
    scene: &Scene,
    file: &Path,
    plan: &Plan,
    stiffness: f64,
    time_step: f64,
) -> Result<SweepPoint, SweepError> {
    let scene = changed(scene, stiffness, time_step);
    let open = || Session::from_scene(scene.clone(), file);
    let mut start = open()?;
    if start.world().model().coupling.bound.is_empty() {
        return Err(SweepError::NoCoupling);
    }
    start.world_mut().set_solver(SolverKind::Monolithic);
    for _ in 0..(plan.from / time_step).round() as u64 {
        if start.step(&mut ()).non_finite {
            return Err(SweepError::Monolithic(stiffness, time_step));
        }
    }
    let mut point = SweepPoint {
        stiffness,
        time_step,
        over_correction: over_correction(start.world()),
        monolithic_joint_gap: 0.0,
        schemes: [SchemeResult::default(); 3],
    };
    for ((scheme, _), measured) in SCHEMES.into_iter().zip(&mut point.schemes) {
        let run = |mode, steps| -> Result<Comparison, SweepError> {
            let mut sessions = [open()?, open()?];
            for session in &mut sessions {
                session.world_mut().restore(start.world().state());
            }
            let mut comparison = Comparison::new(sessions, mode, scheme)?;
            for _ in 0..steps {
                comparison.step(&mut [(), ()]);
                if comparison.has_diverged(TWO_STEP) {
                    break;
                }
            }
            match comparison.summary().sides[MONOLITHIC].failed {
                0 => Ok(comparison),
                _ => Err(SweepError::Monolithic(stiffness, time_step)),
            }
        };
        let steps = (plan.seconds / time_step).round().max(1.0) as u64;
        let single = run(CompareMode::SingleSteps, steps)?;
        let s = single.summary();
        measured.position = s.position;
        measured.rotation = s.rotation;
        measured.drive_force = s.drive_force;
        measured.joint_gap = s.sides[TWO_STEP].joint_gap.max;
        measured.failed = s.sides[TWO_STEP].failed;
        point.monolithic_joint_gap = s.sides[MONOLITHIC].joint_gap.max;
        let apart = run(CompareMode::Trajectories, steps.max(STEPS_MIN))?;
        measured.diverged = apart.summary().sides[TWO_STEP].diverged;
        measured.drift = apart.summary().position;
    }
    Ok(point)
}

/// The largest over-correction γ of a bone that has a joint.
fn over_correction(world: &World) -> f64 {
    let joints = world.desc().joints.iter().filter(|j| j.kind.rows() > 0);
    let bones = joints.flat_map(|j| j.parent.into_iter().chain([j.child]));
    bones.map(|b| world.joint_over_correction(b)).fold(1.0, f64::max)
}
