//! Goal: joint limits of the monolithic solver hold under load, push only, give no energy, and are
//! solved together with contact. Method: bones pressed and thrown against their bounds, against
//! statics, energy balance and the dense reference.

use crate::common::{body, finger};
use thenar_core::model::{
    AngleLimit, Axis, Drive, JointDesc, JointKind, JointLimits, Motion, SolverKind, WorldDesc,
};
use thenar_core::random::Random;
use thenar_core::shape::Shape;
use thenar_core::world::Target;
use thenar_core::{Pose, Quat, Vec3, World};

/// A hundredth of a degree.
const HELD: f64 = 1e-2 * std::f64::consts::PI / 180.0;

fn limit(min: f64, max: f64) -> Axis {
    Axis { limit: Some(AngleLimit { min, max }), ..Axis::default() }
}

/// A rod of 40 mm and 20 g that hangs on the world by a joint at its end; along x at zero angles.
/// A hinge turns about z, a universal joint about y, then z.
fn rod(kind: JointKind, axes: [Axis; 2], h: f64) -> WorldDesc {
    let mut desc = WorldDesc { time_step: h, ..WorldDesc::default() };
    desc.solver.kind = SolverKind::Monolithic;
    let child = desc.add_rigid(body("rod", 0.02, [1e-7, 2.7e-6, 2.7e-6], Vec3::x() * 0.02));
    let to_z = Quat::from_axis_angle(&Vec3::y_axis(), -std::f64::consts::FRAC_PI_2);
    desc.joints.push(JointDesc {
        name: "knuckle".into(),
        kind,
        parent: None,
        child,
        pose_PJ: Pose::new(Vec3::zeros(), to_z),
        pose_CK: Pose::new(Vec3::x() * -0.02, to_z),
        axes,
        limit_stiffness: 10.0,
        limit_damping: 0.01,
    });
    desc
}

#[test]
fn a_bound_holds_and_its_torque_balances_the_load() {
    for (applied, h) in [(-5.0, 1e-3), (-5.0, 2e-2), (0.1, 1e-3), (5.0, 2.5e-4)] {
        let mut world = World::new(rod(JointKind::Hinge, [limit(-0.3, 1.2); 2], h)).unwrap();
        let mut input = world.input();
        input.joint_torques[0][0] = applied;
        let mut report = Default::default();
        for _ in 0..(2.0 / h) as usize {
            report = world.step(&input, &mut ());
            assert!(!report.fell_back && !report.non_finite, "{applied} N m, h {h}: {report:?}");
        }
        let [angle, _] = world.joint_angles(0);
        let bound = if applied < 0.0 { -0.3 } else { 1.2 };
        assert!((angle - bound).abs() < HELD, "{applied} N m: {angle} rad");
        let weight = -0.02 * 9.81 * 0.02 * angle.cos();
        let [torque, _] = world.joint_limit_torques(0);
        let balance = torque + applied + weight;
        assert!(balance.abs() < 1e-6 * applied.abs(), "{applied} N m: off by {balance} N m");
        assert_eq!(report.limits_active, 1);
    }
}

#[test]
fn both_axes_of_a_universal_joint_hold() {
    let axes = [limit(-0.35, 0.35), limit(-0.5, 1.6)];
    for sign in [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]] {
        let mut desc = rod(JointKind::Universal, axes, 1e-3);
        desc.gravity = Vec3::zeros();
        let mut world = World::new(desc).unwrap();
        let mut input = world.input();
        input.joint_torques[0] = [0.5 * sign[0], 5.0 * sign[1]];
        for _ in 0..2000 {
            assert!(!world.step(&input, &mut ()).fell_back);
        }
        let (angles, torques) = (world.joint_angles(0), world.joint_limit_torques(0));
        for k in 0..2 {
            let limit = axes[k].limit.unwrap();
            let bound = if sign[k] > 0.0 { limit.max } else { limit.min };
            assert!((angles[k] - bound).abs() < HELD, "{sign:?}, axis {k}: {} rad", angles[k]);
            let balance = torques[k] + input.joint_torques[0][k];
            assert!(balance.abs() < 1e-4, "{sign:?}, axis {k}: {torques:?}");
        }
    }
}

/// Flesh and a spring hold against each other across a soft knuckle: the bound must hold there too,
/// and give nothing once the load turns round.
#[test]
fn a_soft_finger_holds_and_lets_go() {
    let mut desc = finger(1e9, 1e-3);
    desc.gravity = Vec3::zeros();
    desc.solver.kind = SolverKind::Monolithic;
    desc.rigids[0].motion = Motion::Prescribed;
    desc.joints[0].axes[0].limit = Some(AngleLimit { min: -2.0, max: 0.3 });
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    input.joint_torques[0][0] = 5.0;
    for _ in 0..1500 {
        assert!(!world.step(&input, &mut ()).fell_back);
    }
    let [angle, _] = world.joint_angles(0);
    assert!((angle - 0.3).abs() < HELD, "{angle} rad");
    // The knuckle's spring and the bent flesh take their part; both are soft.
    let [torque, _] = world.joint_limit_torques(0);
    assert!(torque < -4.8 && torque > -5.0, "{torque} N m");

    input.joint_torques[0][0] = -1e-3;
    for _ in 0..300 {
        world.step(&input, &mut ());
        let (angle, torque) = (world.joint_angles(0)[0], world.joint_limit_torques(0)[0]);
        assert!(torque <= 0.0, "a bound must not pull: {torque} N m at {angle} rad");
    }
    assert!(world.joint_angles(0)[0] < 0.25);
    assert_eq!(world.joint_limit_torques(0), [0.0; 2]);
}

/// A pendulum that falls into its bound loses what it has of motion, and never gains energy.
#[test]
fn a_stop_gives_no_energy() {
    for h in [2.5e-4, 1e-3, 1e-2] {
        let mut world = World::new(rod(JointKind::Hinge, [limit(-0.7, 3.0); 2], h)).unwrap();
        let input = world.input();
        let mut energy = world.energy(&input).total();
        let mut met = false;
        for _ in 0..(1.0 / h) as usize {
            let report = world.step(&input, &mut ());
            let now = world.energy(&input).total();
            let gain = now - std::mem::replace(&mut energy, now);
            assert!(report.limits_active == 0 || gain < 1e-9, "h {h}: {gain} J to {now} J");
            if report.limits_active > 0 && !met {
                met = true;
                let reached = world.joint_angles(0)[0];
                // A step of 22 rad/s turns by that time h to third order.
                let within = 1e-6 + (22.0 * h).powi(3) / 12.0;
                assert!((reached + 0.7).abs() < within, "h {h}: stopped at {reached} rad");
            }
        }
        assert!(met && world.joint_rates(0)[0].abs() < 1e-6);
    }
}

/// Three bones thrown about by torques a thousand times what their weight needs.
#[test]
fn random_torques_cannot_break_a_bound() {
    let mut random = Random::new(11);
    for h in [2.5e-4, 1e-3, 5e-3] {
        let axes = [limit(-0.35, 0.35), limit(-0.8, 1.6)];
        let mut desc = rod(JointKind::Universal, axes, h);
        for i in 1..3 {
            let at = Vec3::x() * (0.02 + 0.04 * f64::from(i));
            let child = desc.add_rigid(body(&format!("rod {i}"), 0.02, [1e-6, 3e-6, 3e-6], at));
            let mut joint = desc.joints[0].clone();
            joint.name = format!("joint {i}");
            joint.kind = JointKind::Hinge;
            joint.parent = Some(child - 1);
            joint.child = child;
            joint.pose_PJ.position = Vec3::x() * 0.02;
            joint.axes = [limit(0.0, 1.7); 2];
            desc.joints.push(joint);
        }
        let mut world = World::new(desc).unwrap();
        let mut input = world.input();
        let (mut deepest, mut turned, mut active) = (0.0_f64, 0.0_f64, 0);
        for step in 0..2000 {
            if step % 20 == 0 {
                for torque in input.joint_torques.iter_mut().flatten() {
                    *torque = (1e-4 / h).min(0.1) * random.symmetric();
                }
            }
            let report = world.step(&input, &mut ());
            assert!(!report.fell_back && !report.non_finite, "h {h}, step {step}: {report:?}");
            active += report.limits_active;
            for i in 0..3 {
                turned = turned.max(h * world.rigid_velocity(i)[1].norm());
            }
            for (j, joint) in (0..).zip(&world.desc().joints) {
                for (angle, axis) in world.joint_angles(j).iter().zip(&joint.axes) {
                    let limit = axis.limit.unwrap();
                    if joint.kind == JointKind::Universal || axis == &joint.axes[0] {
                        deepest = deepest.max(limit.min - angle).max(angle - limit.max);
                    }
                }
            }
        }
        assert!(active > 500, "h {h}: the bounds must be met: {active}");
        println!("h {h}: {deepest} {turned}");
        // To first order in a step; bones that turn far about two axes pass by the second.
        assert!(deepest < 0.5 * turned * turned, "h {h}: {deepest} rad past a bound");
    }
}

/// Nothing but a bound acts on a soft finger that is turned to and fro: hitting it, holding and
/// letting go agree with the dense reference, mostly without the compliance of the flesh (no
/// sweep).
#[test]
fn bounds_alone_agree_with_the_dense_reference() {
    for (kappa, h) in [(1e8, 1e-3), (1e9, 5e-3)] {
        let mut desc = finger(kappa, h);
        desc.gravity = Vec3::zeros();
        desc.solver.kind = SolverKind::Monolithic;
        desc.solver.velocity_tolerance = 1e-6;
        desc.rigids[0].motion = Motion::Prescribed;
        desc.joints[0].axes[0].limit = Some(AngleLimit { min: -0.03, max: 0.02 });
        let mut world = World::new(desc).unwrap();
        let mut input = world.input();
        let (mut held, mut free, mut unswept) = ([0, 0], 0, 0);
        for step in 0..64 {
            input.joint_torques[0][0] = [0.6, 0.0, -0.6, 0.0][step / 8 % 4];
            let mut dense = world.clone();
            let report = world.step(&input, &mut ());
            assert!(!report.fell_back, "{report:?}");
            unswept += u32::from(report.contact_sweeps == 0);
            let [torque, _] = world.joint_limit_torques(0);
            held[usize::from(torque > 0.0)] += u32::from(torque != 0.0);
            free += u32::from(torque == 0.0);
            dense.set_solver(SolverKind::DenseReference);
            dense.step(&input, &mut ());
            let pairs = world.state().v.iter().zip(&dense.state().v);
            let worst = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            assert!(worst < 1e-4, "step {step}: off by {worst}");
            let other = dense.joint_limit_torques(0)[0];
            assert!((torque - other).abs() < 1e-5, "step {step}: {torque} and {other} N m");
        }
        assert!(held[0] > 5 && held[1] > 5 && free > 2, "held {held:?}, free {free}");
        assert!(unswept > 10, "only {unswept} steps did without the flesh's compliance");
    }
}

/// A finger pressed on a plane until its knuckle can give no more: contact and bound share the
/// load.
#[test]
fn limits_and_contact_agree_with_the_dense_reference() {
    let drive =
        Drive { stiffness: 400.0, damping: 2.0, angular_stiffness: 0.4, angular_damping: 1e-3 };
    for (kappa, h) in [(1e8, 1e-3), (1e9, 5e-3)] {
        let mut desc = finger(kappa, h);
        desc.solver.kind = SolverKind::Monolithic;
        desc.solver.velocity_tolerance = 1e-7;
        desc.solver.contact_sweeps_max = 20_000;
        desc.joints[0].axes[0].limit = Some(AngleLimit { min: -0.02, max: 0.02 });
        let mut plane = body("ground", 1.0, [1.0; 3], Vec3::zeros());
        plane.motion = Motion::Prescribed;
        plane.shape = Some(Shape::HalfSpace);
        desc.add_rigid(plane);
        desc.drives[0] = Some(drive);
        let start = desc.rigids[0].pose_WB;
        let mut world = World::new(desc).unwrap();
        let mut input = world.input();
        let pose_WB = Pose::new(start.position - Vec3::y() * 0.004, start.rotation);
        let zero = Vec3::zeros();
        input.targets[0] = Some(Target { pose_WB, velocity_W: zero, angular_velocity_W: zero });
        input.joint_torques[0][0] = 0.3;
        let mut both = 0;
        for step in 0..40 {
            let mut dense = world.clone();
            let report = world.step(&input, &mut ());
            assert!(!report.fell_back && report.contact_residual < 1e-6, "{report:?}");
            both += u32::from(report.limits_active > 0 && report.contacts_active > 0);
            if step % 13 != 12 {
                continue;
            }
            dense.set_solver(SolverKind::DenseReference);
            dense.step(&input, &mut ());
            let pairs = world.state().v.iter().zip(&dense.state().v);
            // Rates of bones [rad/s] stand beside velocities [m/s] here; both are to be near.
            let worst = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            assert!(worst < 1e-4, "step {step}: off by {worst}");
            let [a, b] = [&world, &dense].map(|w| w.joint_limit_torques(0)[0]);
            assert!((a - b).abs() < 1e-5 && a < 0.0, "step {step}: {a} and {b} N m");
        }
        assert!(both > 20, "bound and contact together in {both} steps");
    }
}

/// As springs, limits yield by torque / stiffness; so they always do in the two-step scheme.
#[test]
fn springs_remain_where_they_are_asked_for() {
    for (kind, limits) in
        [(SolverKind::Monolithic, JointLimits::Springs), (SolverKind::TwoStep, JointLimits::Rows)]
    {
        let mut desc = rod(JointKind::Hinge, [limit(-0.3, 1.2); 2], 1e-3);
        desc.gravity = Vec3::zeros();
        (desc.solver.kind, desc.solver.limits) = (kind, limits);
        let mut world = World::new(desc).unwrap();
        let mut input = world.input();
        input.joint_torques[0][0] = 0.5;
        for _ in 0..4000 {
            world.step(&input, &mut ());
        }
        let [angle, _] = world.joint_angles(0);
        assert!((angle - (1.2 + 0.5 / 10.0)).abs() < 1e-6, "{kind:?}: {angle} rad");
        assert!((world.joint_limit_torques(0)[0] + 0.5).abs() < 1e-6);
    }
}

/// A range that lies across half a turn is a range all the same.
#[test]
fn a_range_may_pass_half_a_turn() {
    for limits in [JointLimits::Rows, JointLimits::Springs] {
        let mut desc = rod(JointKind::Hinge, [limit(2.5, 4.0); 2], 1e-3);
        desc.gravity = Vec3::zeros();
        desc.solver.limits = limits;
        let turn = Quat::from_scaled_axis(Vec3::z() * 3.0);
        desc.rigids[0].pose_WB = Pose::new(turn * (Vec3::x() * 0.02), turn);
        let mut world = World::new(desc).unwrap();
        let mut input = world.input();
        input.joint_torques[0][0] = 0.01;
        for _ in 0..2000 {
            world.step(&input, &mut ());
        }
        let past = world.joint_angles(0)[0] + std::f64::consts::TAU - 4.0;
        assert!(past.abs() < 2e-3, "{limits:?}: {past} rad past the bound");
    }
}
