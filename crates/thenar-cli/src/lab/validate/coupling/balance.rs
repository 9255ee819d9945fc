//! Action and reaction between flesh and bones.

use super::HAND;
use crate::lab::validate::case::{Basis, CaseError, Check, Figure};
use crate::lab::validate::run::Solver;
use thenar_core::{Pose, Quat, Vec3, World};
use thenar_scene::session::Random;

/// Net force and net torque about the origin of all coupling springs and dampers, relative to the
/// sums of the sizes of forces and of their torques.
fn imbalance(world: &World, soft: u32) -> [f64; 2] {
    let (mut force, mut torque, mut size) = (Vec3::zeros(), Vec3::zeros(), [0.0; 2]);
    for bone in 0..world.desc().rigids.len() as u32 {
        let [f, t] = world.coupling_wrench(bone);
        force += f;
        torque += t + world.rigid_pose(bone).position.cross(&f);
    }
    let x = world.nodes(soft);
    for (node, f) in world.coupling_forces(soft) {
        let moment = x[node as usize].cross(&f);
        force += f;
        torque += moment;
        size[0] += f.norm();
        size[1] += moment.norm();
    }
    [force.norm() / size[0], torque.norm() / size[1]]
}

/// Bones and nodes anywhere: by up to 10 mm along each axis, and 90 degrees; bones moving.
fn scatter(world: &mut World, soft: u32, random: &mut Random) {
    let mut vector = |size: f64| random.vector(size);
    for bone in 0..world.desc().rigids.len() as u32 {
        let pose = world.rigid_pose(bone);
        let axis = vector(1.0).normalize();
        let turn = Quat::from_scaled_axis(axis * (std::f64::consts::FRAC_PI_2 * vector(1.0).x));
        let moved = Pose::new(pose.position + vector(0.01), turn * pose.rotation);
        world.set_rigid_state(bone, moved, [vector(1.0), vector(10.0)]);
    }
    let moved: Vec<Vec3> = world.nodes(soft).iter().map(|x| x + vector(0.01)).collect();
    world.set_nodes(soft, &moved);
}

/// At ten random states of the hand, with targets by "lbs".
pub fn linear(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    coupling(solver, "lbs")
}

/// At ten random states of the hand, with targets by "lbs" or "joint".
pub fn coupling(solver: Solver, skinning: &str) -> Result<Vec<Figure>, CaseError> {
    let skinning = format!("hand.hand.skinning={skinning}");
    let worst = |damping_time: f64| -> Result<([f64; 2], String), CaseError> {
        let given = format!("hand.hand.coupling_damping_time={damping_time:e}");
        let mut run = solver.open(&HAND, &[given, skinning.clone()])?;
        let setup = run.setup();
        let session = run.session();
        let flesh = session.hands()[0].flesh();
        let soft = flesh.ok_or_else(|| CaseError::Missing("the hand has no flesh".into()))?;
        let start = session.world().clone();
        let (mut random, mut worst) = (Random::new(4), [0.0_f64; 2]);
        for _ in 0..10 {
            let mut world = start.clone();
            scatter(&mut world, soft, &mut random);
            let found = imbalance(&world, soft);
            worst = [worst[0].max(found[0]), worst[1].max(found[1])];
        }
        Ok((worst, setup))
    };
    let ([force, torque], setup) = worst(0.0)?;
    let ([damped_force, damped_torque], _) = worst(1e-3)?;
    let row = |what: &str, got| {
        Figure::new(what, &setup, 1e-10, got, Check::AtMost).rests_on(Basis::Construction)
    };
    Ok(vec![
        row("springs: net force / sum of forces", force),
        row("springs: net torque / sum of torques", torque),
        row("with dampers: net force / sum of forces", damped_force),
        row("with dampers: net torque / sum of torques", damped_torque).or_cannot(
            "a damper resists the motion of a node against its target in all directions, and the \
             two are apart by the spring's stretch: the torque is damping force times stretch",
        ),
    ])
}
