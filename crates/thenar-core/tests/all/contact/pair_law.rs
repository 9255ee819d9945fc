//! Goal: a pair has Coulomb friction and nothing else: rigid bodies do not bounce, and no point
//! resists rolling or spinning; flesh resists spinning by its patch. Method: bodies dropped, rolled
//! and spun, in both schemes, against energy and momentum.

use crate::common::{FLESH, bar, body};
use thenar_core::model::{FixedNode, Motion, SoftDesc, SolverKind, WorldDesc};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Quat, Vec3, World};

const SCHEMES: [SolverKind; 2] = [SolverKind::Monolithic, SolverKind::TwoStep];

fn floor(kind: SolverKind, h: f64) -> WorldDesc {
    let mut desc = WorldDesc { time_step: h, ..WorldDesc::default() };
    desc.solver.kind = kind;
    let mut plane = body("floor", 1.0, [1.0; 3], Vec3::zeros());
    plane.motion = Motion::Prescribed;
    plane.shape = Some(Shape::HalfSpace);
    desc.add_rigid(plane);
    desc
}

/// A ball of 8 mm radius and 17 g.
fn add_ball(desc: &mut WorldDesc, at: Vec3) -> u32 {
    let (mass, radius) = (0.017, 0.008);
    let mut ball = body("ball", mass, [0.4 * mass * radius * radius; 3], at);
    ball.shape = Some(Shape::Sphere { radius });
    desc.add_rigid(ball)
}

fn step(world: &mut World) {
    let report = world.step(&world.input(), &mut ());
    assert!(!report.fell_back && !report.non_finite, "{report:?}");
}

/// Dropped from a metre, what lands flat or on one point stays down; what lands on an edge first
/// may turn over and slide, but gains nothing, and all of it comes to rest.
#[test]
fn nothing_bounces() {
    for (kind, h) in SCHEMES.into_iter().flat_map(|k| [1e-3, 5e-3, 1.0 / 60.0].map(|h| (k, h))) {
        for (tilt, is_ball) in [(0.0, true), (0.0, false), (1.0, false), (0.8, false)] {
            let case = format!("{kind:?}, h {h}, ball {is_ball}, tilted by {tilt} rad");
            let mut desc = floor(kind, h);
            let i = add_ball(&mut desc, Vec3::y()) as usize;
            if !is_ball {
                desc.rigids[i].shape = Some(Shape::Cuboid { half: Vec3::new(0.02, 0.004, 0.01) });
                desc.rigids[i].pose_WB.rotation = Quat::from_scaled_axis(Vec3::z() * tilt);
            }
            let mut world = World::new(desc).unwrap();
            // What sank in while it turned fast is lifted out again, to where it lies.
            let lying = 0.017 * 9.81 * if is_ball { 0.008 } else { 0.004 };
            let mut before = world.energy(&world.input()).total();
            let mut lowest = f64::INFINITY;
            for _ in 0..(1.2 / h) as u32 {
                step(&mut world);
                let energy = world.energy(&world.input()).total();
                assert!(
                    energy < before.max(lying) + 1e-4 * lying,
                    "{case}: {before} to {energy} J"
                );
                before = energy;
                let height = world.rigid_pose(1).position.y;
                lowest = lowest.min(height);
                assert!(
                    tilt > 0.0 || height < lowest + 2e-5,
                    "{case}: from {lowest} to {height} m"
                );
            }
            assert!(lowest < 0.02 && world.rigid_velocity(1)[0].norm() < 1e-3, "{case}");
        }
    }
}

/// A ball that rolls on a rigid floor rolls on, one that spins on it spins on.
#[test]
fn points_resist_neither_rolling_nor_spinning() {
    for (kind, h) in SCHEMES.into_iter().flat_map(|k| [1e-3, 5e-3].map(|h| (k, h))) {
        let mut desc = floor(kind, h);
        let i = add_ball(&mut desc, Vec3::y() * 0.008) as usize;
        desc.rigids[i].velocity_W = Vec3::x() * 0.08;
        desc.rigids[i].angular_velocity_W = Vec3::new(0.0, 25.0, -10.0);
        let start = desc.rigids[i].clone();
        let mut world = World::new(desc).unwrap();
        for _ in 0..(1.0 / h) as u32 {
            step(&mut world);
        }
        let [v, omega] = world.rigid_velocity(1);
        assert!((v - start.velocity_W).norm() < 1e-4, "{kind:?}, h {h}: {v}");
        let turning = (omega - start.angular_velocity_W).norm();
        assert!(turning < 1e-2, "{kind:?}, h {h}: {omega}");
        let rolled = world.rigid_pose(1).position.x;
        assert!((rolled - 0.08).abs() < 1e-4, "{kind:?}, h {h}: {rolled} m");
    }
}

/// On flesh a spinning ball comes to rest although no law of a pair says so.
#[test]
fn a_soft_patch_resists_spinning() {
    let mut desc = WorldDesc { time_step: 1e-3, ..WorldDesc::default() };
    let size = Vec3::new(0.02, 0.01, 0.02);
    let mut flesh = bar(size, [12, 5, 12], FLESH);
    flesh.stiffness_damping = 5e-3;
    let low = (0..flesh.nodes.len() as u32).filter(|&n| flesh.nodes[n as usize].y < 1e-9);
    flesh.fixed = low.map(|node| FixedNode { node, axes: [true; 3] }).collect();
    desc.add_soft(SoftDesc {
        name: "pad".into(),
        flesh,
        pose_WM: Pose::translation(-0.01, -0.01, -0.01),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    let i = add_ball(&mut desc, Vec3::y() * 0.008) as usize;
    desc.rigids[i].angular_velocity_W = Vec3::y() * 30.0;
    let mut world = World::new(desc).unwrap();
    for _ in 0..600 {
        step(&mut world);
    }
    // With a(F) of Hertz's contact under its weight of 0.17 N the patch brakes by 3π/16 μ F a =
    // 1.2e-4 N m: what turns at 1.3e-5 kg m²/s stops within 0.11 s.
    let spin = world.rigid_velocity(0)[1].y;
    assert!(spin.abs() < 1.0, "{spin} rad/s");
}
