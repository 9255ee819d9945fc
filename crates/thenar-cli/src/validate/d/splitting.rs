//! The two-step scheme against Eq. 9 solved in one piece, one step from the same state.

use super::{FINGER, HAND};
use crate::validate::case::{CaseError, Check, Figure, SceneText};
use crate::validate::run::Run;
use thenar::model::{FleshInStep1, SolverKind};
use thenar::{Vec3, World};

/// What one step of the two-step scheme does differently.
#[derive(Clone, Copy, Default)]
struct Difference {
    /// Largest difference of a bone's velocity \[m/s\].
    velocity: f64,
    /// Largest violation of a joint that the exact step does not have \[m\].
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

/// One step of `h` from where `start` is.
fn stepped(start: &Run, kind: SolverKind, flesh: FleshInStep1, h: f64) -> World {
    let mut world = start.world().clone();
    world.set_time_step(h);
    world.set_solver(kind);
    world.set_step1_flesh(flesh);
    world.step(start.input(), &mut ());
    world
}

fn difference(two_step: &World, exact: &World) -> Difference {
    let bones = 0..exact.desc().rigids.len() as u32;
    let apart = |b: u32| (two_step.rigid_velocity(b)[0] - exact.rigid_velocity(b)[0]).norm();
    let joints = 0..exact.desc().joints.len() as u32;
    let gap = |j: u32| (joint_gap(two_step, j) - joint_gap(exact, j)).norm();
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
    /// When the two are compared \[s\].
    time: f64,
}

const STEPS: [f64; 3] = [1e-3, 1e-4, 1e-5];

/// Flesh frozen in step 1 (the paper) and lumped (the default), at one coupling stiffness.
fn compare(setting: &Setting, kappa: f64) -> Result<Vec<Figure>, CaseError> {
    let stiffness = setting.stiffness.iter().map(|key| format!("{key}={kappa:e}"));
    let exactly = ["solver.cg_tolerance=1e-12", "solver.cg_iterations_max=20000"];
    let overrides: Vec<String> = stiffness.chain(exactly.map(String::from)).collect();
    let mut start = Run::open(setting.scene, &overrides)?;
    start.to(setting.time)?;
    let flesh = [FleshInStep1::Frozen, FleshInStep1::Lumped];
    let mut found = [[Difference::default(); 3]; 2];
    for (i, h) in STEPS.into_iter().enumerate() {
        let exact = stepped(&start, SolverKind::Monolithic, FleshInStep1::Lumped, h);
        for (k, flesh) in flesh.into_iter().enumerate() {
            let two_step = stepped(&start, SolverKind::TwoStep, flesh, h);
            found[k][i] = difference(&two_step, &exact);
        }
    }
    let mut figures = Vec::new();
    for (flesh, found) in ["frozen", "lumped"].into_iter().zip(&found) {
        let name = format!("{}, {flesh}, {kappa:.0e} N/m4", setting.name);
        figures.extend(rows(&name, &start.setup_at(STEPS[0]), found));
    }
    Ok(figures)
}

/// The differences at the largest step, and the largest ratio from each step to the next.
fn rows(name: &str, coarse: &str, found: &[Difference; 3]) -> [Figure; 4] {
    let row = |what: &str, setup: &str, expected, got, check| {
        Figure::new(format!("{name}: {what}"), setup, expected, got, check)
    };
    let ratio = |of: fn(&Difference) -> f64| {
        found.windows(2).map(|w| of(&w[1]) / of(&w[0])).fold(0.0, f64::max)
    };
    let steps = "h = 1, 0.1, 0.01 ms";
    [
        row("bones [m/s]", coarse, 0.0, found[0].velocity, Check::Report),
        row("joints [m]", coarse, 0.0, found[0].joint, Check::Report),
        row("bones, at h/10", steps, 0.5, ratio(|d| d.velocity), Check::AtMost),
        row("joints, at h/10", steps, 0.5, ratio(|d| d.joint), Check::AtMost),
    ]
}

/// A finger bending, and the hand halfway to a fist; coupling stiffness k, 10 k, 100 k.
pub fn both_scenes() -> Result<Vec<Figure>, CaseError> {
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
            figures.extend(compare(setting, kappa)?);
        }
    }
    Ok(figures)
}
