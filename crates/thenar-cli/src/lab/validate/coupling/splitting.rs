//! The two-step scheme against Eq. 9 solved in one piece, one step from the same state.

use super::{FINGER, HAND};
use crate::lab::validate::case::{Basis, CaseError, Check, Figure, SceneText};
use crate::lab::validate::run::{Run, Solver};
use thenar_core::model::{FleshInStep1, SolverKind};
use thenar_core::world::Failure;
use thenar_core::{Vec3, World};

/// Difference that one step of the two-step scheme makes.
#[derive(Clone, Copy, Default)]
struct Difference {
    /// Largest difference of a bone's velocity \[m/s\].
    velocity: f64,
    /// Largest violation of a joint that the monolithic step does not have \[m\].
    joint: f64,
}

/// From the joint's point on the parent to that on the child \[m\].
fn joint_gap(world: &World, j: u32) -> Vec3 {
    let joint = &world.desc().joints[j as usize];
    let on_parent = match joint.parent {
        Some(parent) => world.rigid_pose(parent).point(&joint.pose_PJ.position),
        None => joint.pose_PJ.position,
    };
    world.rigid_pose(joint.child).point(&joint.pose_CK.position) - on_parent
}

/// Scheme that solves a step.
struct Scheme {
    name: &'static str,
    kind: SolverKind,
    flesh: FleshInStep1,
    close_joints: bool,
}

const fn two_step(name: &'static str, flesh: FleshInStep1, close_joints: bool) -> Scheme {
    Scheme { name, kind: SolverKind::TwoStep, flesh, close_joints }
}

/// The paper's scheme; the same with flesh that yields in step 1; and our default, which also
/// closes the joints in the end.
const SCHEMES: [Scheme; 3] = [
    two_step("frozen", FleshInStep1::Frozen, false),
    two_step("lumped", FleshInStep1::Lumped, false),
    two_step("lumped, closed", FleshInStep1::Lumped, true),
];

const MONOLITHIC: Scheme = Scheme {
    name: "monolithic",
    kind: SolverKind::Monolithic,
    flesh: FleshInStep1::Lumped,
    close_joints: false,
};

/// Steps by `h` from where `start` is; an error where the monolithic solution is less exact than
/// asked for, and nothing to compare with.
fn stepped(start: &Run, scheme: &Scheme, h: f64) -> Result<World, CaseError> {
    let mut world = start.world().clone();
    let mut settings = world.desc().solver;
    (settings.kind, settings.step1_flesh) = (scheme.kind, scheme.flesh);
    settings.close_joints = scheme.close_joints;
    settings.velocity_tolerance = TOLERANCE;
    world.set_solver_settings(settings)?;
    world.set_time_step(h);
    let report = world.step(start.input(), &mut ());
    let residual = report.cg_residual;
    let is_exact = scheme.kind != SolverKind::Monolithic || residual <= TOLERANCE;
    let inexact = (!is_exact).then_some(Failure::NotConverged { residual });
    start.check(report.failure.or(inexact))?;
    Ok(world)
}

fn difference(two_step: &World, monolithic: &World) -> Difference {
    let bones = 0..monolithic.desc().rigids.len() as u32;
    let apart = |b: u32| (two_step.rigid_velocity(b)[0] - monolithic.rigid_velocity(b)[0]).norm();
    let joints = 0..monolithic.desc().joints.len() as u32;
    let gap = |j: u32| (joint_gap(two_step, j) - joint_gap(monolithic, j)).norm();
    Difference {
        velocity: bones.map(apart).fold(0.0, f64::max),
        joint: joints.map(gap).fold(0.0, f64::max),
    }
}

/// A scene, and the keys of its coupling stiffness.
struct Setting {
    name: &'static str,
    scene: &'static SceneText,
    stiffness: &'static [&'static str],
    /// Time at which the two are compared \[s\].
    time: f64,
}

/// Estimated error of the monolithic solver, far below the differences \[m/s\].
const TOLERANCE: f64 = 1e-12;

const STEPS: [f64; 3] = [1e-3, 1e-4, 1e-5];

/// Smaller differences are those of the inner solvers, which stop at 1e-12 \[m/s, m\].
const FLOOR: Difference = Difference { velocity: 1e-9, joint: 1e-13 };

/// All schemes, at one coupling stiffness.
fn compare(solver: Solver, setting: &Setting, kappa: f64) -> Result<Vec<Figure>, CaseError> {
    let stiffness = setting.stiffness.iter().map(|key| format!("{key}={kappa:e}"));
    let exactly = ["solver.cg_tolerance=1e-12", "solver.cg_iterations_max=20000"];
    let overrides: Vec<String> = stiffness.chain(exactly.map(String::from)).collect();
    let mut start = solver.open(setting.scene, &overrides)?;
    start.to(setting.time)?;
    let mut found = [[Difference::default(); 3]; SCHEMES.len()];
    for (i, h) in STEPS.into_iter().enumerate() {
        let monolithic = stepped(&start, &MONOLITHIC, h)?;
        for (found, scheme) in found.iter_mut().zip(&SCHEMES) {
            found[i] = difference(&stepped(&start, scheme, h)?, &monolithic);
        }
    }
    let mut figures = Vec::new();
    for (scheme, found) in SCHEMES.iter().zip(&found) {
        let name = format!("{}, {}, {kappa:.0e}", setting.name, scheme.name);
        figures.extend(rows(&name, &start.setup_at(STEPS[0]), found));
    }
    Ok(figures)
}

/// The differences at the largest step, and the largest ratio from each step to the next.
fn rows(name: &str, coarse: &str, found: &[Difference; 3]) -> [Figure; 4] {
    let row = |what: &str, setup: &str, expected, got, check| {
        Figure::new(format!("{name}: {what}"), setup, expected, got, check).rests_on(Basis::Itself)
    };
    let ratio = |of: fn(&Difference) -> f64| {
        let next = |w: &[Difference]| of(&w[1]) / of(&w[0]).max(of(&FLOOR));
        found.windows(2).map(next).fold(0.0, f64::max)
    };
    let steps = "h = 1, 0.1, 0.01 ms";
    [
        row("bones [m/s]", coarse, 0.0, found[0].velocity, Check::Report),
        row("joints [m]", coarse, 0.0, found[0].joint, Check::Report),
        row("bones, at h/10", steps, 0.5, ratio(|d| d.velocity), Check::AtMost),
        row("joints, at h/10", steps, 0.5, ratio(|d| d.joint), Check::AtMost),
    ]
}

/// A finger bending, and the hand halfway to a fist; coupling stiffness k, 10 k, 100 k \[N/m⁴\].
pub fn both_scenes(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let finger = Setting {
        name: "finger",
        scene: &FINGER,
        stiffness: &[
            "soft.flesh.bind.0.stiffness",
            "soft.flesh.bind.1.stiffness",
            "soft.flesh.bind.2.stiffness",
        ],
        time: 0.02,
    };
    let hand = Setting {
        name: "hand",
        scene: &HAND,
        stiffness: &["hand.hand.coupling_stiffness"],
        time: 0.25,
    };
    let mut figures = Vec::new();
    for setting in [&finger, &hand] {
        for kappa in [1e7, 1e8, 1e9] {
            figures.extend(compare(solver, setting, kappa)?);
        }
    }
    Ok(figures)
}
