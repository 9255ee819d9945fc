//! Goal: springs, dampers and drives about joint axes act as springs and dampers do, wherever on
//! the circle their rest lies. Method: single bodies against closed forms and recurrences of
//! backward Euler.

use crate::common::body;
use std::f64::consts::TAU;
use thenar_core::model::{
    AngleLimit, Axis, Drive, JointDesc, JointKind, JointLimits, SolverKind, WorldDesc,
};
use thenar_core::world::Target;
use thenar_core::{Pose, Quat, Vec3, World};

/// A body of 0.01 kg m² on a joint at its centre of mass; no gravity.
fn door(kind: JointKind, axes: [Axis; 2], angles: [f64; 2], h: f64) -> World {
    let mut desc = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
    let mut panel = body("door", 1.0, [0.01; 3], Vec3::zeros());
    panel.pose_WB.rotation = thenar_core::kinematics::joint_rotation(kind, angles);
    let child = desc.add_rigid(panel);
    desc.joints.push(JointDesc {
        name: "hinge".into(),
        kind,
        parent: None,
        child,
        pose_PJ: Pose::identity(),
        pose_CK: Pose::identity(),
        axes,
        limit_stiffness: 4.0,
        limit_damping: 0.05,
    });
    World::new(desc).unwrap()
}

fn spring(rest_angle: f64) -> Axis {
    Axis { limit: None, stiffness: 1.0, rest_angle, damping: 0.02 }
}

/// The way from `to` to `from` round the circle, the shorter one.
fn between(from: f64, to: f64) -> f64 {
    (from - to) - TAU * ((from - to) / TAU).round()
}

/// Whatever the rest angle, a door let go 0.15 rad from it swings as about zero, and comes to rest.
#[test]
fn a_rest_angle_may_lie_anywhere() {
    let swing = |kind: JointKind, rest: f64, k: usize| {
        let (mut axes, mut angles) = ([Axis::default(); 2], [0.0; 2]);
        (axes[k], angles[k]) = (spring(rest), rest + 0.15);
        let mut world = door(kind, axes, angles, 1e-3);
        let input = world.input();
        let start = world.energy(&input).total();
        assert!((start - 0.5 * 0.15 * 0.15).abs() < 1e-12, "rest {rest}: {start} J");
        let mut way = Vec::new();
        for _ in 0..3000 {
            world.step(&input, &mut ());
            assert!(world.energy(&input).total() <= start, "rest {rest}");
            assert!(world.joint_rates(0)[k].abs() < 1.6, "rest {rest}: {:?}", world.joint_rates(0));
            way.push(between(world.joint_angles(0)[k], rest));
        }
        way
    };
    // ω₀ = 10 rad/s and a decay of 1/s: 0.15 rad are 0.0075 rad after 3 s.
    for (kind, k) in [(JointKind::Hinge, 0), (JointKind::Universal, 0), (JointKind::Universal, 1)] {
        let reference = swing(kind, 0.0, k);
        assert!(reference[2999].abs() < 0.01);
        for rest in [1.0, 3.0, 3.1, 3.3, -3.0, -3.3, 4.0, 6.2, -9.0, 20.0] {
            let way = swing(kind, rest, k);
            let pairs = way.iter().zip(&reference);
            let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9, "{kind:?}, axis {k}, rest {rest}: off by {off} rad");
        }
    }
}

/// Let go half a turn away and pushed round and round, a spring gives back no more than it took.
#[test]
fn no_way_round_draws_on_a_spring() {
    for (h, rest) in [(1e-3, 3.0), (1e-3, 3.3), (5e-3, -3.0), (1.0 / 60.0, 3.3), (1.0 / 60.0, 0.0)]
    {
        let undamped = Axis { damping: 0.0, ..spring(rest) };
        let mut world = door(JointKind::Hinge, [undamped, Axis::default()], [rest + 3.1, 0.0], h);
        // Enough to pass the top: energy there is π²/2 J.
        world.set_rigid_state(0, world.rigid_pose(0), [Vec3::zeros(), Vec3::x() * 20.0]);
        let input = world.input();
        let mut last = world.energy(&input).total();
        let mut round = 0.0;
        for step in 0..(2.0 / h) as usize {
            let before = world.joint_angles(0)[0];
            world.step(&input, &mut ());
            round += between(world.joint_angles(0)[0], before);
            let now = world.energy(&input).total();
            assert!(now <= last + 1e-12, "h {h}, rest {rest}, step {step}: {last} to {now} J");
            last = now;
        }
        assert!(round.abs() > TAU || h > 2e-3, "h {h}: it must go round: {round} rad");
    }
}

/// Within a range a spring is wound up as its rest angle says, also from across half a turn.
#[test]
fn a_range_says_which_turn_is_meant() {
    for limits in [JointLimits::Rows, JointLimits::Springs] {
        // From 0.2 rad the shorter way to 3.5 rad leads through zero, out of the range.
        let limit = Some(AngleLimit { min: 0.0, max: 4.0 });
        let axis = Axis { limit, damping: 0.2, ..spring(3.5) };
        let mut world = door(JointKind::Hinge, [axis, Axis::default()], [0.2, 0.0], 1e-3);
        let mut settings = world.desc().solver;
        settings.limits = limits;
        world.set_solver_settings(settings).unwrap();
        let input = world.input();
        for _ in 0..3000 {
            world.step(&input, &mut ());
        }
        let off = between(world.joint_angles(0)[0], 3.5);
        assert!(off.abs() < 1e-3, "{limits:?}: {off} rad from rest");
    }
}

/// Past a limit kept by springs both its spring and its damper act: backward Euler's recurrence
/// `(I + h c + h² k) ω₁ = I ω₀ - h k p₀`, p the angle past the limit.
#[test]
fn a_limit_s_spring_is_damped() {
    let h = 1e-4;
    for kind in [SolverKind::Monolithic, SolverKind::TwoStep] {
        let limit = Some(AngleLimit { min: -1.0, max: 0.5 });
        let axis = Axis { limit, ..Axis::default() };
        let mut world = door(JointKind::Hinge, [axis, Axis::default()], [0.5, 0.0], h);
        let mut settings = world.desc().solver;
        (settings.kind, settings.limits) = (kind, JointLimits::Springs);
        world.set_solver_settings(settings).unwrap();
        world.set_rigid_state(0, world.rigid_pose(0), [Vec3::zeros(), Vec3::x()]);
        let input = world.input();
        let (inertia, k, c) = (0.01, 4.0, 0.05);
        let (mut past, mut rate) = (0.0, 1.0);
        for step in 0..1000 {
            world.step(&input, &mut ());
            // The door enters its limit in the first step, at whose start nothing acts yet.
            if step > 0 {
                rate = (inertia * rate - h * k * past) / (inertia + h * c + h * h * k);
            }
            past += h * rate;
            if past < 0.0 {
                assert!(step > 500, "half a period of the damped spring is 0.16 s: {step}");
                break;
            }
            let angle = world.joint_angles(0)[0];
            assert!((angle - 0.5 - past).abs() < 1e-6, "{kind:?}, step {step}: {angle} rad");
            let torque = world.joint_limit_torques(0)[0];
            assert!((torque + k * past + c * rate).abs() < 1e-4, "{kind:?}: {torque} N m");
        }
        // Half a period leaves exp(-c T/4 I) of the rate; undamped it would all come back.
        let left = world.rigid_velocity(0)[1].x;
        assert!((left - rate).abs() < 1e-4 && left > -0.75, "{kind:?}: {left} rad/s");
    }
}

/// The damper of a drive acts against the turning of its target: `(I + h c) ω₁ = I ω₀ + h c ω_t`.
#[test]
fn a_drive_follows_a_turning_target() {
    for kind in [SolverKind::Monolithic, SolverKind::TwoStep] {
        let h = 1e-3;
        let mut desc = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
        desc.solver.kind = kind;
        desc.add_rigid(body("wrist", 0.4, [1e-3; 3], Vec3::zeros()));
        let (c, c_lin) = (0.02, 3.0);
        desc.drives[0] = Some(Drive {
            stiffness: 0.0,
            damping: c_lin,
            angular_stiffness: 0.0,
            angular_damping: c,
        });
        let mut world = World::new(desc).unwrap();
        let mut input = world.input();
        let (turning, going) = (Vec3::new(0.3, -2.0, 1.0), Vec3::new(0.0, 0.5, -0.1));
        input.targets[0] = Some(Target {
            pose_WB: Pose::identity(),
            velocity_W: going,
            angular_velocity_W: turning,
        });
        let (mut share, mut share_lin) = (0.0, 0.0);
        for _ in 0..100 {
            let drive = world.drive_wrench(0, &input);
            let [v, omega] = world.rigid_velocity(0);
            assert!((drive[0] - (going - v) * c_lin).norm() < 1e-12);
            assert!((drive[1] - (turning - omega) * c).norm() < 1e-12);
            world.step(&input, &mut ());
            share = (1e-3 * share + h * c) / (1e-3 + h * c);
            share_lin = (0.4 * share_lin + h * c_lin) / (0.4 + h * c_lin);
            let [v, omega] = world.rigid_velocity(0);
            assert!((omega - turning * share).norm() < 1e-9, "{kind:?}: {omega}");
            assert!((v - going * share_lin).norm() < 1e-9, "{kind:?}: {v}");
        }
        assert!(share > 0.5);
    }
}

/// A target that turns on at a steady rate is followed without lag: spring and damper both know of
/// its motion.
#[test]
fn a_stiff_drive_keeps_up_with_a_turning_target() {
    let h = 1e-3;
    let mut desc = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
    desc.add_rigid(body("wrist", 0.4, [1e-3; 3], Vec3::zeros()));
    let drive =
        Drive { stiffness: 0.0, damping: 0.0, angular_stiffness: 4.0, angular_damping: 0.1 };
    desc.drives[0] = Some(drive);
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    let rate = Vec3::y() * 3.0;
    let mut lag = f64::NAN;
    for step in 1..=2000 {
        let pose_WB =
            Pose::new(Vec3::zeros(), Quat::from_scaled_axis(rate * (h * f64::from(step))));
        input.targets[0] =
            Some(Target { pose_WB, velocity_W: Vec3::zeros(), angular_velocity_W: rate });
        world.step(&input, &mut ());
        lag = world.rigid_pose(0).rotation.angle_to(&pose_WB.rotation);
    }
    // A damper against a target that stood still would hold it back by c ω / k = 0.075 rad.
    assert!(lag < 1e-4, "{lag} rad behind");
}
