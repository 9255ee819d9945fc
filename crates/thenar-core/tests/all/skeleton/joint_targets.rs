//! Goal: a joint goes where its target says, as its spring and damper allow, whatever the solver
//! and the step. Method: statics and steady motion of one rod; momentum of a free pair.

use crate::common::body;
use thenar_core::model::{Axis, JointDesc, JointKind, SolverKind, WorldDesc};
use thenar_core::random::Random;
use thenar_core::world::JointTarget;
use thenar_core::{Pose, Quat, Vec3, World};

const SOLVERS: [SolverKind; 3] =
    [SolverKind::Monolithic, SolverKind::TwoStep, SolverKind::DenseReference];
const STIFFNESS: f64 = 0.2;
const DAMPING: f64 = 0.01;

/// A rod of 40 mm and 20 g on the world, without weight; its joint has a spring and a damper.
fn rod(kind: JointKind, solver: SolverKind, h: f64) -> World {
    let mut desc = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
    desc.solver.kind = solver;
    let child = desc.add_rigid(body("rod", 0.02, [1e-7, 2.7e-6, 2.7e-6], Vec3::x() * 0.02));
    let axis = Axis { stiffness: STIFFNESS, damping: DAMPING, ..Axis::default() };
    desc.joints.push(JointDesc {
        name: "elbow".into(),
        kind,
        parent: None,
        child,
        pose_PJ: Pose::identity(),
        pose_CK: Pose::new(Vec3::x() * -0.02, Quat::identity()),
        axes: [axis; 2],
        limit_stiffness: 0.0,
        limit_damping: 0.0,
    });
    World::new(desc).unwrap()
}

#[test]
fn the_joint_comes_to_rest_at_its_target_less_what_a_load_takes() {
    let load = 0.02;
    for solver in SOLVERS {
        for h in [1e-3, 5e-3, 1.0 / 60.0] {
            let mut world = rod(JointKind::Universal, solver, h);
            let mut input = world.input();
            let angles = [0.4, -0.7];
            input.joint_targets[0] = Some(JointTarget { angles, ..JointTarget::default() });
            input.joint_torques[0] = [0.0, load];
            (0..(4.0 / h) as usize).for_each(|_| _ = world.step(&input, &mut ()));
            let got = world.joint_angles(0);
            let wanted = [angles[0], angles[1] + load / STIFFNESS];
            let off = (0..2).map(|k| (got[k] - wanted[k]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-6, "{solver:?}, {h} s: {got:?} for {wanted:?}");
            // The spring holds the load: half a square of it over its stiffness.
            let stored = world.energy(&input).joint;
            assert!(
                (stored - 0.5 * load * load / STIFFNESS).abs() < 1e-8,
                "{solver:?}: {stored} J"
            );
        }
    }
}

/// A target that moves steadily and tells its rate is followed without lag; one that does not is
/// followed with the lag `d ω / k` of the damper.
#[test]
fn a_moving_target_is_followed_without_lag_if_it_tells_its_rate() {
    let rate = 1.5;
    for kind in [JointKind::Hinge, JointKind::Ball] {
        for h in [1e-3, 1.0 / 60.0] {
            for told in [true, false] {
                let mut world = rod(kind, SolverKind::Monolithic, h);
                let mut input = world.input();
                let mut wanted = 0.0;
                for i in 1..=(1.0 / h) as usize {
                    wanted = rate * h * i as f64;
                    let by = if told { rate } else { 0.0 };
                    input.joint_targets[0] = Some(JointTarget {
                        angles: [wanted, 0.0],
                        rates: [by, 0.0],
                        rotation_JK: Quat::from_scaled_axis(Vec3::x() * wanted),
                        spin_J: Vec3::x() * by,
                        ..JointTarget::default()
                    });
                    let report = world.step(&input, &mut ());
                    assert!(!report.non_finite && report.bad_targets == 0);
                }
                let got = world.rigid_pose(0).rotation.scaled_axis();
                let lag = if told { 0.0 } else { DAMPING * rate / STIFFNESS };
                let off = (got - Vec3::x() * (wanted - lag)).norm();
                assert!(off < 1e-6, "{kind:?}, {h} s, told {told}: {got:?} for {wanted} - {lag}");
            }
        }
    }
}

#[test]
fn a_ball_turns_to_its_target() {
    for solver in SOLVERS {
        let mut world = rod(JointKind::Ball, solver, 2e-3);
        let mut input = world.input();
        let rotation_JK = Quat::from_scaled_axis(Vec3::new(0.9, -1.1, 0.6));
        input.joint_targets[0] = Some(JointTarget { rotation_JK, ..JointTarget::default() });
        (0..2000).for_each(|_| _ = world.step(&input, &mut ()));
        let off = world.rigid_pose(0).rotation.angle_to(&rotation_JK);
        assert!(off < 1e-6 && world.energy(&input).joint < 1e-12, "{solver:?}: {off} rad");
    }
}

/// Torques of drives act in pairs: two free bodies keep their momentum, whatever is asked of the
/// joint between them.
#[test]
fn a_driven_joint_is_internal() {
    for kind in [JointKind::Hinge, JointKind::Universal, JointKind::Ball] {
        let mut desc = WorldDesc { gravity: Vec3::zeros(), ..WorldDesc::default() };
        let parent = desc.add_rigid(body("a", 0.05, [4e-6, 9e-6, 7e-6], Vec3::zeros()));
        let child = desc.add_rigid(body("b", 0.02, [1e-6, 2.7e-6, 2.2e-6], Vec3::x() * 0.05));
        let axis = Axis { stiffness: STIFFNESS, damping: 1e-4, ..Axis::default() };
        desc.joints.push(JointDesc {
            name: "elbow".into(),
            kind,
            parent: Some(parent),
            child,
            pose_PJ: Pose::translation(0.03, 0.0, 0.0),
            pose_CK: Pose::translation(-0.02, 0.0, 0.0),
            axes: [axis; 2],
            limit_stiffness: 0.0,
            limit_damping: 0.0,
        });
        let mut world = World::new(desc).unwrap();
        let mut input = world.input();
        let mut random = Random::new(7);
        let mut turned: f64 = 0.0;
        for _ in 0..500 {
            let target = JointTarget {
                angles: [0; 2].map(|_| random.symmetric()),
                rates: [0; 2].map(|_| random.symmetric()),
                rotation_JK: Quat::from_scaled_axis(random.vector(1.0)),
                spin_J: random.vector(1.0),
                ..JointTarget::default()
            };
            input.joint_targets[0] = Some(target);
            world.step(&input, &mut ());
            turned = turned.max(world.rigid_velocity(1)[1].norm());
        }
        let [linear, angular] = world.momentum();
        assert!(turned > 1.0, "{kind:?}: nothing moved, {turned} rad/s");
        assert!(linear.norm() < 1e-12 && angular.norm() < 1e-10, "{linear:?} {angular:?}");
    }
}

/// A joint held away from its rest by a strong spring is not thrown back to it by one bad number:
/// it is let go for a step, and turns on.
#[test]
fn a_target_that_is_no_number_lets_go_for_a_step() {
    for kind in [JointKind::Hinge, JointKind::Ball] {
        let mut world = rod(kind, SolverKind::Monolithic, 1e-3);
        let mut input = world.input();
        let good = JointTarget {
            angles: [1.0, 0.0],
            rotation_JK: Quat::from_scaled_axis(Vec3::x()),
            ..JointTarget::default()
        };
        input.joint_targets[0] = Some(good);
        (0..4000).for_each(|_| _ = world.step(&input, &mut ()));
        let bad = JointTarget { angles: [f64::NAN, 0.0], ..good };
        input.joint_targets[0] = Some(bad);
        let report = world.step(&input, &mut ());
        assert!(report.bad_targets == 1 && !report.non_finite, "{report:?}");
        let turned = world.rigid_pose(0).rotation.scaled_axis().x;
        assert!((turned - 1.0).abs() < 1e-6, "{kind:?}: {turned} rad");
    }
}

/// Let go, a joint has no spring and no damper: a torque turns the rod by τ/I alone.
#[test]
fn a_joint_that_is_let_go_turns_freely() {
    for solver in SOLVERS {
        let mut world = rod(JointKind::Hinge, solver, 1e-4);
        let mut input = world.input();
        input.joint_targets[0] = Some(JointTarget { gains: [0.0; 2], ..JointTarget::default() });
        let torque = 1e-4;
        input.joint_torques[0] = [torque, 0.0];
        (0..100).for_each(|_| _ = world.step(&input, &mut ()));
        // About x the rod has the inertia of its own axis.
        let (got, wanted) = (world.rigid_velocity(0)[1].x, torque / 1e-7 * 0.01);
        assert!((got / wanted - 1.0).abs() < 1e-4, "{solver:?}: {got} rad/s for {wanted}");
        assert_eq!(world.energy(&input).joint, 0.0);
    }
}
