//! Derivatives of joint rows, joint springs and drives, on the built-in hand.

use super::HAND;
use super::differences::Rows::OneKind;
use super::differences::{Matrix, coordinates, differences, mismatch, scatter_bones};
use crate::lab::validate::case::{CaseError, Check, Figure};
use crate::lab::validate::run::Solver;
use thenar_core::kernels::{JointFrames, axis_states, joint_block, spring_torque};
use thenar_core::kinematics::Tree;
use thenar_core::model::JointLimits;
use thenar_core::{Pose, Vec3, World};
use thenar_scene::session::Random;

const STATES: usize = 10;

fn frames(world: &World, j: usize) -> JointFrames {
    let joint = &world.desc().joints[j];
    let child = world.rigid_pose(joint.child);
    let parent = joint.parent.map(|p| world.rigid_pose(p));
    JointFrames {
        pose_WJ: parent.map_or(joint.pose_PJ, |p| p * joint.pose_PJ),
        pose_WK: child * joint.pose_CK,
        parent: parent.map_or(joint.pose_PJ.position, |p| p.position),
        child: child.position,
    }
}

/// All rows of C, or of J.
fn rows(world: &World) -> Vec<f64> {
    let of = |j: usize| {
        let kind = world.desc().joints[j].kind;
        let C = joint_block(kind, &frames(world, j)).C;
        (0..kind.rows()).map(move |r| C[r]).collect::<Vec<_>>()
    };
    (0..world.desc().joints.len()).flat_map(of).collect()
}

fn jacobian(world: &World) -> Matrix {
    let mut matrix = Vec::new();
    for (j, joint) in world.desc().joints.iter().enumerate() {
        let block = joint_block(joint.kind, &frames(world, j));
        for r in 0..joint.kind.rows() {
            let mut row = vec![0.0; coordinates(world, None)];
            for k in 0..6 {
                row[6 * joint.child as usize + k] = block.J_child[(r, k)];
                if let Some(parent) = joint.parent {
                    row[6 * parent as usize + k] = block.J_parent[(r, k)];
                }
            }
            matrix.push(row);
        }
    }
    matrix
}

/// Torques of joint springs and limits on all bones.
fn spring_torques(world: &World) -> Vec<f64> {
    let mut forces = vec![0.0; coordinates(world, None)];
    let mut add = |bone: u32, torque: Vec3| {
        (0..3).for_each(|k| forces[6 * bone as usize + 3 + k] += torque[k]);
    };
    for (j, joint) in world.desc().joints.iter().enumerate() {
        for (k, axis) in axis_states(joint.kind, &frames(world, j)).iter().enumerate() {
            let Some(axis) = axis else { continue };
            let torque = axis.direction_W
                * spring_torque(&joint.axes[k], joint, JointLimits::Springs, axis.angle).0;
            add(joint.child, torque);
            if let Some(parent) = joint.parent {
                add(parent, -torque);
            }
        }
    }
    forces
}

/// Joints at angles up to a tenth of a radian past their limits.
fn bend(world: &mut World, tree: &Tree, random: &mut Random) {
    let angle = |random: &mut Random, j: usize, k: usize| {
        let Some(limit) = tree.limits(j)[k] else { return 0.0 };
        let (middle, half) = (0.5 * (limit.min + limit.max), 0.5 * (limit.max - limit.min));
        middle + (half + 0.1) * random.symmetric()
    };
    let angles: Vec<[f64; 2]> =
        (0..tree.joints()).map(|j| [0, 1].map(|k| angle(random, j, k))).collect();
    let mut poses = vec![Pose::identity(); tree.bones()];
    tree.forward(&world.rigid_pose(0), &angles, &mut poses);
    for (bone, pose) in poses.iter().enumerate() {
        world.set_rigid_state(bone as u32, *pose, [Vec3::zeros(); 2]);
    }
}

/// Joint rows and springs where the joints hold, drives anywhere.
pub fn skeleton(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut run =
        solver.open(&HAND, &["hand.hand.flesh=false".into(), "solver.limits=springs".into()])?;
    run.step()?; // gives the drives their targets
    let setup = format!("{STATES} states, 16 bones");
    let tree = Tree::of_hand(&run.session().hands()[0].model)
        .map_err(|e| CaseError::Missing(e.to_string()))?;
    let mut input = run.input().clone();
    for target in input.targets.iter_mut().flatten() {
        (target.velocity_W, target.angular_velocity_W) = (Vec3::zeros(), Vec3::zeros());
    }
    let (mut random, mut worst) = (Random::new(8), [0.0_f64; 3]);
    for _ in 0..STATES {
        let mut keep = |k: usize, value: f64| worst[k] = worst[k].max(value);
        let mut world = run.world().clone();
        bend(&mut world, &tree, &mut random);
        keep(
            0,
            mismatch(
                &world,
                OneKind,
                &jacobian(&world),
                &differences(&world, None, rows),
                |_, _| true,
            ),
        );
        let slope = differences(&world, None, |w| vec![-w.energy(&input).joint]);
        keep(1, mismatch(&world, OneKind, &vec![spring_torques(&world)], &slope, |_, _| true));

        scatter_bones(&mut world, 0.02, &mut random);
        let slope = differences(&world, None, |w| vec![-w.energy(&input).drive]);
        let bones = 0..world.desc().rigids.len() as u32;
        let drives =
            bones.flat_map(|b| world.drive_wrench(b, &input)).flat_map(|v| [v.x, v.y, v.z]);
        keep(2, mismatch(&world, OneKind, &vec![drives.collect()], &slope, |_, _| true));
    }
    let names = ["joint rows J = dC/dq", "joint springs and limits = -dE/dq", "drives = -dE/dq"];
    let row = |(what, worst): (&str, f64)| Figure::new(what, &setup, 1e-6, worst, Check::AtMost);
    Ok(names.into_iter().zip(worst).map(row).collect())
}
