//! Weights and targets of linear blend skinning.

use super::{HAND, balance, coupled};
use crate::lab::validate::case::{Basis, CaseError, Check, Figure, SceneText, scene};
use crate::lab::validate::run::Solver;
use thenar_core::{Pose, Quat, Vec3};
use thenar_scene::session::Random;

const TWIST: SceneText = scene!("d03-twist");

/// Weights of the built-in hand: not negative, of sum 1, of one bone or two that a joint joins.
pub fn weights(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut run = solver.open(&HAND, &[])?;
    let setup = run.setup();
    let hand = &run.session().hands()[0].model;
    let bindings = &hand.bindings;
    let joined = |a: u32, b: u32| {
        let parent = |i: u32| hand.bones[i as usize].parent;
        a == b || parent(a) == Some(b) || parent(b) == Some(a)
    };
    let least = bindings.iter().flat_map(|b| b.weights).fold(f64::INFINITY, f64::min);
    let off = bindings.iter().map(|b| (b.weights[0] + b.weights[1] - 1.0).abs());
    let apart = bindings.iter().filter(|b| b.weights[1] > 0.0 && !joined(b.bones[0], b.bones[1]));
    let shared = bindings.iter().filter(|b| b.weights[0] > 0.0 && b.weights[1] > 0.0).count();
    let unbound = hand.flesh.nodes.len() - bindings.len();
    let row = |what: &str, expected, got, check| {
        Figure::new(what, &setup, expected, got, check).rests_on(Basis::Construction)
    };
    Ok(vec![
        row("least weight", 0.0, least, Check::AtLeast),
        row("largest |sum of weights - 1|", 1e-12, off.fold(0.0, f64::max), Check::AtMost),
        row("nodes of bones that no joint joins", 0.0, apart.count() as f64, Check::AtMost),
        row("nodes without a binding", 0.0, unbound as f64, Check::AtMost),
        row("nodes of two bones", 1.0, shared as f64, Check::AtLeast),
    ])
}

fn random_motion(random: &mut Random) -> Pose {
    let mut vector = || random.vector(1.0);
    let turn = vector().normalize() * (std::f64::consts::PI * vector().x);
    Pose::new(vector(), Quat::from_scaled_axis(turn))
}

/// A hundred random motions (up to 1 m and 180 degrees along each axis) of a bent hand.
pub fn rigid_motion(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    moved_as_one(solver, "lbs")
}

fn moved_as_one(solver: Solver, skinning: &str) -> Result<Vec<Figure>, CaseError> {
    let mut run = solver.open(&HAND, &[format!("hand.hand.skinning={skinning}")])?;
    run.to(0.3)?;
    let setup = run.setup();
    let session = run.session();
    let hand = &session.hands()[0];
    let flesh = hand.flesh().ok_or_else(|| CaseError::Missing("the hand has no flesh".into()));
    let (bones, soft) = (hand.handle.bones.clone(), flesh?);
    let world = session.world_mut();
    let mut before = world.nodes(soft).to_vec();
    let mut after = before.clone();
    world.skin_targets(soft, &mut before);
    let poses: Vec<Pose> = bones.clone().map(|b| world.rigid_pose(b)).collect();
    let (mut random, mut worst) = (Random::new(2), 0.0_f64);
    for _ in 0..100 {
        let motion = random_motion(&mut random);
        for (bone, pose) in bones.clone().zip(&poses) {
            world.set_rigid_state(bone, motion * *pose, [Vec3::zeros(); 2]);
        }
        world.skin_targets(soft, &mut after);
        let off = before.iter().zip(&after).map(|(b, a)| (motion.point(b) - a).norm());
        worst = worst.max(off.fold(0.0, f64::max));
    }
    let what = "largest error of a target, 100 motions [m]";
    Ok(vec![Figure::new(what, setup, 1e-12, worst, Check::AtMost).rests_on(Basis::Construction)])
}

/// Twist with weights of one half each: the targets shrink by cos 45 degrees; flesh resists.
pub fn twist(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut run = solver.open(&TWIST, &[])?;
    let [target_0, flesh_0] = run.values(["target.mean", "flesh.mean"])?;
    let [target, flesh] = run.to(1.5)?.values(["target.mean", "flesh.mean"])?;
    let (target, flesh) = (target / target_0, flesh / flesh_0);
    let cos = std::f64::consts::FRAC_1_SQRT_2;
    let setup = run.setup();
    let row = |what: &str, expected, got, check| Figure::new(what, &setup, expected, got, check);
    Ok(vec![
        row("radius of the targets / at rest", cos, target, Check::Absolute(1e-5))
            .rests_on(Basis::Construction),
        row("area of the targets / at rest", 0.5, target * target, Check::Absolute(1e-5))
            .rests_on(Basis::Construction),
        row("radius of the flesh / at rest", cos + 1e-3, flesh, Check::AtLeast),
        row("area of the flesh / at rest", 0.5, flesh * flesh, Check::Report),
    ])
}

/// Figures of D2 to D4 and D6 where rotations are blended about the joint: the radius is kept.
pub fn by_joint(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut run = solver.open(&TWIST, &["soft.flesh.skinning=joint".into()])?;
    let [target_0, flesh_0] = run.values(["target.mean", "flesh.mean"])?;
    let [target, flesh] = run.to(1.5)?.values(["target.mean", "flesh.mean"])?;
    let setup = run.setup();
    let row = |what: &str, got, check| Figure::new(what, &setup, 1.0, got, check);
    let mut figures = vec![
        row("radius of the targets / at rest", target / target_0, Check::Absolute(1e-12))
            .rests_on(Basis::Construction),
        row("radius of the flesh / at rest", flesh / flesh_0, Check::Report),
    ];
    figures.extend(moved_as_one(solver, "joint")?);
    figures.extend(balance::coupling(solver, "joint")?);
    let derivatives = coupled::coupling(solver, "joint")?;
    figures.extend(derivatives.into_iter().map(|figure| figure.rests_on(Basis::Itself)));
    Ok(figures)
}
