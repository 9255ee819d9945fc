//! Goal: rigid bodies and joints move as theory says (validation A). Method: worlds built in code,
//! stepped with nothing but gravity, against the figures computed there by two other codes.

use crate::common::body;
use thenar_core::model::{Axis, JointDesc, JointKind, WorldDesc};
use thenar_core::random::Random;
use thenar_core::{Pose, Quat, Vec3, World};

/// Turns a joint frame so that its x (the hinge axis) points along world z.
fn hinge_about_z(position: Vec3) -> Pose {
    let turn = Quat::from_axis_angle(&Vec3::y_axis(), -std::f64::consts::FRAC_PI_2);
    Pose::new(position, turn)
}

fn hinge(parent: Option<u32>, child: u32, parent_at: Vec3, child_at: Vec3) -> JointDesc {
    JointDesc {
        name: format!("hinge {child}"),
        kind: JointKind::Hinge,
        parent,
        child,
        pose_PJ: hinge_about_z(parent_at),
        pose_CK: hinge_about_z(child_at),
        axes: [Axis::default(); 2],
        limit_stiffness: 0.0,
        limit_damping: 0.0,
    }
}

fn run(world: &mut World, seconds: f64) {
    let input = world.input();
    let steps = (seconds / world.time_step()).round() as usize;
    for _ in 0..steps {
        let report = world.step(&input, &mut ());
        assert!(!report.non_finite);
    }
}

/// A1: the exact recurrence of the scheme, -g h² n (n + 1) / 2.
#[test]
fn free_fall_follows_the_recurrence() {
    for (h, expected) in [(1e-3, -1.228702500), (1.0 / 60.0, -1.267125000)] {
        let mut desc = WorldDesc { time_step: h, ..WorldDesc::default() };
        desc.add_rigid(body("ball", 0.3, [1e-4, 1e-4, 1e-4], Vec3::zeros()));
        let mut world = World::new(desc).unwrap();
        run(&mut world, 0.5);
        let y = world.rigid_pose(0).position.y;
        assert!((y - expected).abs() < 1e-9, "{y}");
    }
}

/// A4: three-link finger; the error at t = 0.05 s must fall in proportion to h.
#[test]
fn three_link_finger_converges_at_first_order() {
    let (m, length) = ([0.020, 0.010, 0.006], [0.045, 0.026, 0.024]);
    let tip_at = |h: f64| {
        let mut desc = WorldDesc { time_step: h, ..WorldDesc::default() };
        let mut x = 0.0;
        for i in 0..3 {
            let thin = m[i] * length[i] * length[i] / 12.0;
            let half = Vec3::new(0.5 * length[i], 0.0, 0.0);
            desc.add_rigid(body(
                &format!("link {i}"),
                m[i],
                [1e-9, thin, thin],
                half + Vec3::x() * x,
            ));
            let parent = (i > 0).then(|| (i - 1) as u32);
            let parent_at =
                if i > 0 { Vec3::new(0.5 * length[i - 1], 0.0, 0.0) } else { Vec3::zeros() };
            desc.joints.push(hinge(parent, i as u32, parent_at, -half));
            x += length[i];
        }
        let mut world = World::new(desc).unwrap();
        run(&mut world, 0.05);
        world.rigid_pose(2).point(&Vec3::new(0.5 * length[2], 0.0, 0.0)) * 1000.0
    };
    let expected = Vec3::new(92.0327, -12.4193, 0.0);
    let errors: Vec<f64> =
        [4e-4, 2e-4, 1e-4].iter().map(|&h| (tip_at(h) - expected).norm()).collect();
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 1.0).abs() < 0.15, "order {order}, errors {errors:?} mm");
    }
    assert!(errors[2] < 0.1, "{errors:?} mm");
}

/// A9: mass on spring and damper, exact backward Euler recurrence. The drive is the spring.
#[test]
fn damped_oscillator_follows_the_recurrence() {
    use thenar_core::model::Drive;
    use thenar_core::world::Target;
    for (h, expected) in [(1e-2, 0.865482), (1e-3, 3.782747), (1e-4, 4.553188)] {
        let mut desc = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
        desc.add_rigid(body("mass", 0.02, [1e-5, 1e-5, 1e-5], Vec3::new(0.01, 0.0, 0.0)));
        desc.drives[0] = Some(Drive {
            stiffness: 100.0,
            damping: 0.2,
            angular_stiffness: 0.0,
            angular_damping: 0.0,
        });
        let mut world = World::new(desc).unwrap();
        let mut input = world.input();
        input.targets[0] = Some(Target {
            pose_WB: Pose::identity(),
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
        });
        for _ in 0..(0.1 / h).round() as usize {
            world.step(&input, &mut ());
        }
        let x = world.rigid_pose(0).position.x * 1000.0;
        assert!((x - expected).abs() < 1e-6, "h {h}: {x} mm");
    }
}

/// A8: internal torques on a free chain leave both momenta alone.
#[test]
fn internal_torques_conserve_momentum() {
    let mut desc = WorldDesc { time_step: 1e-3, gravity: Vec3::zeros(), ..WorldDesc::default() };
    for i in 0..16 {
        let at = Vec3::new(0.03 * f64::from(i), 0.0, 0.0);
        let mut link = body(&format!("link {i}"), 0.01, [2e-7, 8e-7, 9e-7], at);
        link.velocity_W = Vec3::new(0.2, 0.1, -0.3);
        desc.add_rigid(link);
        if i > 0 {
            let half = Vec3::new(0.015, 0.0, 0.0);
            let kind = if i % 3 == 0 { JointKind::Universal } else { JointKind::Hinge };
            let mut joint = hinge(Some(i - 1), i, half, -half);
            joint.kind = kind;
            desc.joints.push(joint);
        }
    }
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    let [p0, l0] = world.momentum();
    let mut random = Random::new(12345);
    for _ in 0..10_000 {
        for torque in &mut input.joint_torques {
            *torque = [0; 2].map(|_| 2e-4 * random.symmetric());
        }
        let report = world.step(&input, &mut ());
        assert!(!report.non_finite);
    }
    let [p, l] = world.momentum();
    assert!((p - p0).norm() < 1e-10 * p0.norm(), "{}", (p - p0).norm());
    assert!((l - l0).norm() < 1e-6 * l0.norm(), "{} of {}", (l - l0).norm(), l0.norm());
    assert!(world.energy(&input).kinetic > 1e-3, "it must have been stirred");
}
