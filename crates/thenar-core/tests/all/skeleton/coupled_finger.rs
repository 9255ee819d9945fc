//! Goal: skeleton and flesh are coupled as Eq. 6-9 say, and the two-step solution differs from
//! the dense one only as the paper's approximation does (validation D4, D5).
//! Method: a two-bone finger of flesh, stepped by both solvers from the same state.

use crate::common::finger;
use thenar_core::model::{Drive, FleshInStep1, SolverKind, WorldDesc};
use thenar_core::random::Random;
use thenar_core::world::{Input, Target};
use thenar_core::{Pose, Quat, Vec3, World};
use thenar_testing::one_in;

const DRIVE: Drive =
    Drive { stiffness: 400.0, damping: 1.0, angular_stiffness: 0.4, angular_damping: 1e-3 };

const WEAK: Drive =
    Drive { stiffness: 20.0, damping: 0.05, angular_stiffness: 0.02, angular_damping: 5e-5 };

/// The finger by two steps, with this flesh in step 1, with or without closing its joint.
fn with(flesh: FleshInStep1, close_joints: bool, kappa: f64, h: f64) -> WorldDesc {
    let mut desc = finger(kappa, h);
    desc.solver.kind = SolverKind::TwoStep;
    desc.solver.step1_flesh = flesh;
    desc.solver.close_joints = close_joints;
    desc
}

/// Largest speed of the second bone \[m/s\] once the start is over, infinite when a step failed.
fn fastest(desc: WorldDesc, drive: Drive) -> f64 {
    let (mut world, input) = driven(desc, drive);
    let mut speed = 0.0_f64;
    for i in 0..400 {
        if world.step(&input, &mut ()).non_finite {
            return f64::INFINITY;
        }
        if i > 100 {
            speed = speed.max(world.rigid_velocity(1)[0].norm());
        }
    }
    speed
}

/// Root driven to its place, second bone to a bent pose.
fn driven(mut desc: WorldDesc, drive: Drive) -> (World, Input) {
    desc.drives = vec![Some(drive), Some(drive)];
    let start = [desc.rigids[0].pose_WB, desc.rigids[1].pose_WB];
    let world = World::new(desc).unwrap();
    let mut input = world.input();
    let still = |pose_WB: Pose| Target {
        pose_WB,
        velocity_W: Vec3::zeros(),
        angular_velocity_W: Vec3::zeros(),
    };
    input.targets[0] = Some(still(start[0]));
    let turn = Quat::from_scaled_axis(Vec3::z() * -0.5);
    let knuckle = Vec3::new(0.03, 0.008, 0.008);
    input.targets[1] = Some(still(Pose::new(knuckle + turn * Vec3::new(0.015, 0.0, 0.0), turn)));
    (world, input)
}

/// D4: the springs' force on nodes and wrench on bones balance at any state.
#[test]
fn coupling_has_no_net_force_or_torque() {
    let mut desc = finger(1e8, 1e-3);
    desc.gravity = Vec3::zeros();
    let mut world = World::new(desc).unwrap();
    let mut random = Random::new(5);
    for b in 0..2 {
        let pose = world.rigid_pose(b);
        let turn = Quat::from_scaled_axis(random.vector(0.8));
        let moved = Pose::new(pose.position + random.vector(0.01), turn * pose.rotation);
        world.set_rigid_state(b, moved, [Vec3::zeros(); 2]);
    }
    // Node forces as seen by the bones (Newton's third law, Eq. 7 against Eq. 8).
    let (mut force, mut torque, mut size) = (Vec3::zeros(), Vec3::zeros(), 0.0);
    for b in 0..2 {
        let [f, t] = world.coupling_wrench(b);
        force += f;
        torque += t + world.rigid_pose(b).position.cross(&f);
    }
    for (node, f) in world.coupling_forces(0) {
        force += f;
        torque += world.nodes(0)[node as usize].cross(&f);
        size += f.norm();
    }
    assert!(size > 1.0, "the springs must be stretched: {size} N");
    assert!(force.norm() < 1e-12 * size && torque.norm() < 1e-12 * size, "{force} {torque}");
}

/// One step of the frozen-flesh scheme from a settled state is Eq. 10 and 11: it differs from
/// Eq. 9 by an error that shrinks with the step (D5).
#[test]
fn two_steps_approach_the_dense_solution_as_the_step_shrinks() {
    for flesh in [FleshInStep1::Frozen, FleshInStep1::Lumped] {
        let mut errors = Vec::new();
        for h in [2e-3, 1e-3, 5e-4] {
            let mut desc = with(flesh, false, 1e7, h);
            desc.solver.cg_tolerance = 1e-12;
            let (mut two_step, input) = driven(desc.clone(), DRIVE);
            for _ in 0..(0.05 / h) as usize {
                two_step.step(&input, &mut ());
            }
            let mut dense = two_step.clone();
            dense.set_solver(SolverKind::DenseReference);
            two_step.step(&input, &mut ());
            dense.step(&input, &mut ());
            let error = (two_step.rigid_pose(1).position - dense.rigid_pose(1).position).norm();
            errors.push(error);
            assert!(dense.joint_error(0).0 < 2e-5, "{} m", dense.joint_error(0).0);
        }
        assert!(errors[0] < 1e-4, "{flesh:?}: {errors:?} m");
        assert!(errors[2] < 0.5 * errors[0], "{flesh:?}: {errors:?} m");
    }
}

/// Without joints between the bodies the two-step solution is the dense one, but for how
/// positions follow from velocities: the two-step scheme leaves out by how much targets move beyond
/// first order.
#[test]
fn without_joints_two_steps_are_the_dense_solution() {
    let mut desc = finger(1e8, 5e-3);
    desc.joints[0].kind = thenar_core::model::JointKind::Free;
    desc.solver.kind = SolverKind::TwoStep;
    desc.solver.cg_tolerance = 1e-13;
    let (mut a, input) = driven(desc, DRIVE);
    let mut b = a.clone();
    b.set_solver(SolverKind::DenseReference);
    for _ in 0..20 {
        a.step(&input, &mut ());
        b.step(&input, &mut ());
    }
    let worst = a.nodes(0).iter().zip(b.nodes(0)).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(worst < 2e-8, "{worst} m");
}

/// The lumped variant stays bounded at coupling stiffness and steps where the frozen one diverges
/// (the paper's scheme "limits the stiffness of this coupling").
#[test]
fn lumped_flesh_is_stable_where_frozen_flesh_diverges() {
    let steps = [DRIVE, WEAK].into_iter().flat_map(|d| [1e-3, 5e-3, 1.0 / 60.0].map(|h| (d, h)));
    let all = steps.flat_map(|(drive, h)| [1e7, 1e8, 1e9, 1e10].map(|kappa| (drive, h, kappa)));
    for (drive, h, kappa) in one_in(5, all) {
        let speed = fastest(with(FleshInStep1::Lumped, true, kappa, h), drive);
        assert!(speed < 0.5, "h {h}, kappa {kappa}: {speed} m/s");
    }
    for (h, kappa) in [(1e-3, 1e10), (5e-3, 1e9), (1.0 / 60.0, 1e9)] {
        let speed = fastest(with(FleshInStep1::Frozen, false, kappa, h), WEAK);
        assert!(speed > 10.0, "frozen flesh at h {h}, kappa {kappa}: {speed} m/s");
        let speed = fastest(with(FleshInStep1::Lumped, true, kappa, h), WEAK);
        assert!(speed < 0.5, "lumped flesh at h {h}, kappa {kappa}: {speed} m/s");
    }
}

/// What diverges is warned of, and what is not warned of is stable: the stiffest coupling without
/// a warning is found and run, with the paper's scheme and with its joints closed afterwards.
#[test]
fn frozen_flesh_is_warned_of_before_it_diverges() {
    let warned =
        |desc: &WorldDesc| !World::new(desc.clone()).unwrap().stability_warnings().is_empty();
    for close_joints in [false, true] {
        for h in [1e-3, 5e-3, 1.0 / 60.0] {
            let frozen = |kappa: f64| with(FleshInStep1::Frozen, close_joints, kappa, h);
            let (mut calm, mut wild) = (5.0_f64, 12.0_f64);
            assert!(!warned(&frozen(10_f64.powf(calm))) && warned(&frozen(10_f64.powf(wild))));
            for _ in 0..30 {
                let middle = 0.5 * (calm + wild);
                *(if warned(&frozen(10_f64.powf(middle))) { &mut wild } else { &mut calm }) =
                    middle;
            }
            for drive in [DRIVE, WEAK] {
                let speed = fastest(frozen(10_f64.powf(calm)), drive);
                assert!(speed < 0.5, "close {close_joints}, h {h}, kappa 1e{calm:.2}: {speed} m/s");
            }
            let diverging = with(FleshInStep1::Frozen, close_joints, 1e12, h);
            assert!(warned(&diverging));
            let speed = fastest(diverging, WEAK);
            assert!(speed > 10.0, "close {close_joints}, h {h}: only {speed} m/s");
            assert!(!warned(&with(FleshInStep1::Lumped, close_joints, 1e12, h)));
        }
    }
}
