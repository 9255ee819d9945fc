//! Goal: contact pushes, holds and slips as Coulomb says (validation C). Method: boxes and soft
//! blocks on planes, against closed formulas; the flesh cases also against the dense reference.

use crate::common::{FLESH, bar, body, finger};
use thenar_core::model::{BodyId, Cone, Drive, Motion, PairRule, SoftDesc, SolverKind, WorldDesc};
use thenar_core::shape::Shape;
use thenar_core::world::Target;
use thenar_core::{Pose, Quat, Vec3, World};

fn ground(desc: &mut WorldDesc) -> u32 {
    let mut plane = body("ground", 1.0, [1.0; 3], Vec3::zeros());
    plane.motion = Motion::Prescribed;
    plane.shape = Some(Shape::HalfSpace);
    desc.add_rigid(plane)
}

fn cube(desc: &mut WorldDesc, half: f64, mass: f64, at: Vec3) -> u32 {
    let inertia = mass * 4.0 * half * half / 6.0;
    let mut cube = body(&format!("cube {}", desc.rigids.len()), mass, [inertia; 3], at);
    cube.shape = Some(Shape::Cuboid { half: Vec3::repeat(half) });
    desc.add_rigid(cube)
}

fn friction(desc: &mut WorldDesc, a: BodyId, b: BodyId, mu: f64) {
    desc.pairs.push(PairRule { bodies: [a, b], friction: Some(mu) });
}

/// C7: a box thrown along a plane stops after v²/(2 μ g).
#[test]
fn sliding_to_rest() {
    let mut desc = WorldDesc { time_step: 1e-4, ..WorldDesc::default() };
    desc.solver.velocity_tolerance = 1e-8;
    let plane = ground(&mut desc);
    let body = cube(&mut desc, 0.02, 0.1, Vec3::new(0.0, 0.02, 0.0));
    desc.rigids[body as usize].velocity_W = Vec3::new(0.5, 0.0, 0.0);
    friction(&mut desc, BodyId::Rigid(plane), BodyId::Rigid(body), 0.4);
    let mut world = World::new(desc).unwrap();
    let input = world.input();
    for _ in 0..2000 {
        world.step(&input, &mut ());
    }
    let x = world.rigid_pose(body).position.x * 1e3;
    assert!((x / 31.855 - 1.0).abs() < 0.02, "{x} mm");
    assert!(world.rigid_velocity(body)[0].norm() < 1e-6);
}

/// C4: on a slope of 20° a cube slides at μ = 0.3 with 0.5897 m/s² and stays at μ = 0.4, rigid or
/// soft.
#[test]
fn slope_of_twenty_degrees() {
    let angle = 20.0_f64.to_radians();
    let gravity = Vec3::new(9.81 * angle.sin(), -9.81 * angle.cos(), 0.0);
    for soft in [false, true] {
        for mu in [0.3, 0.4] {
            let mut desc = WorldDesc { time_step: 1e-3, gravity, ..WorldDesc::default() };
            let plane = ground(&mut desc);
            let id = if soft {
                let flesh = bar(Vec3::repeat(0.04), [3, 3, 3], FLESH);
                BodyId::Soft(desc.add_soft(SoftDesc {
                    name: "block".into(),
                    flesh,
                    pose_WM: Pose::identity(),
                    velocity_W: Vec3::zeros(),
                    coupling: None,
                }))
            } else {
                BodyId::Rigid(cube(&mut desc, 0.02, 0.1, Vec3::new(0.0, 0.02, 0.0)))
            };
            friction(&mut desc, BodyId::Rigid(plane), id, mu);
            let mut world = World::new(desc).unwrap();
            let input = world.input();
            let speed = |world: &World| match id {
                BodyId::Soft(s) => {
                    let m = world.node_masses(s);
                    let v = world.node_velocities(s).iter().zip(m).map(|(v, m)| v.x * m);
                    v.sum::<f64>() / m.iter().sum::<f64>()
                }
                BodyId::Rigid(b) => world.rigid_velocity(b)[0].x,
            };
            for _ in 0..500 {
                world.step(&input, &mut ());
            }
            let before = speed(&world);
            for _ in 0..500 {
                world.step(&input, &mut ());
            }
            let acceleration = (speed(&world) - before) / 0.5;
            let expected = if mu == 0.3 { 0.589702 } else { 0.0 };
            let error = (acceleration - expected).abs();
            assert!(error < 0.01 * 0.589702, "soft {soft}, mu {mu}: {acceleration} m/s²");
        }
    }
}

/// C6: five boxes on each other rest, and each carries what lies on it.
#[test]
fn stack_of_five() {
    let mut desc = WorldDesc { time_step: 1e-3, ..WorldDesc::default() };
    ground(&mut desc);
    for i in 0..5 {
        cube(&mut desc, 0.02, 0.1, Vec3::new(0.0, 0.02 + 0.04 * f64::from(i), 0.0));
    }
    let mut world = World::new(desc).unwrap();
    let input = world.input();
    let start: Vec<Vec3> = (1..6).map(|b| world.rigid_pose(b).position).collect();
    for _ in 0..5000 {
        world.step(&input, &mut ());
    }
    for k in 1..6_u32 {
        let drift = (world.rigid_pose(k).position - start[k as usize - 1]).norm();
        assert!(drift < 1e-4, "box {k} drifted {drift} m");
        let below: f64 = (world.contacts().iter())
            .filter(|c| {
                c.bodies.contains(&BodyId::Rigid(k)) && c.bodies.contains(&BodyId::Rigid(k - 1))
            })
            .map(|c| c.force_W.y.abs())
            .sum();
        let carried = f64::from(6 - k) * 0.1 * 9.81;
        assert!((below / carried - 1.0).abs() < 0.01, "under box {k}: {below} of {carried} N");
    }
}

/// A soft finger pressed on a plane by its drives: the two-step solver with constraint anticipation
/// against the dense one; at rest the plane carries what the drives and weight put on.
#[test]
fn pressed_finger_agrees_with_the_dense_reference() {
    for cone in [Cone::Circular, Cone::Linearised] {
        let mut desc = finger(1e8, 2e-3);
        desc.solver.kind = SolverKind::TwoStep;
        desc.solver.cone = cone;
        desc.solver.contact_tolerance = 1e-6;
        desc.solver.contact_sweeps_max = 2000;
        desc.solver.cg_tolerance = 1e-8;
        let plane = ground(&mut desc);
        let drive =
            Drive { stiffness: 400.0, damping: 2.0, angular_stiffness: 0.4, angular_damping: 1e-3 };
        desc.drives[0] = Some(drive);
        desc.drives[1] = Some(drive);
        let poses = [desc.rigids[0].pose_WB, desc.rigids[1].pose_WB];
        let mut world = World::new(desc).unwrap();
        let mut input = world.input();
        for b in 0..2 {
            input.targets[b] = Some(Target {
                pose_WB: Pose::new(
                    poses[b].position - Vec3::new(0.0, 0.003, 0.0),
                    Quat::from_scaled_axis(Vec3::z() * -0.1) * poses[b].rotation,
                ),
                velocity_W: Vec3::zeros(),
                angular_velocity_W: Vec3::zeros(),
            });
        }
        for _ in 0..400 {
            let report = world.step(&input, &mut ());
            assert!(!report.non_finite && report.inverted_tets == 0);
        }
        let report = world.step(&input, &mut ());
        let force = |world: &World| -> f64 { world.contacts().iter().map(|c| c.force_W.y).sum() };
        let on_plane = force(&world);
        let weight: f64 = 9.81 * (world.node_masses(0).iter().sum::<f64>() + 0.006);
        let driven: f64 = (0..2).map(|b| -world.drive_wrench(b, &input)[0].y).sum();
        assert!((on_plane / (weight + driven) - 1.0).abs() < 0.01, "{on_plane} N");
        assert!(on_plane > 0.5 && report.penetration_max < 1e-5, "{report:?}");
        let _ = plane;

        let mut dense = world.clone();
        dense.set_solver(SolverKind::DenseReference);
        for _ in 0..30 {
            dense.step(&input, &mut ());
        }
        let difference = (force(&dense) / on_plane - 1.0).abs();
        assert!(difference < 0.005, "{cone:?}: {} against {on_plane} N", force(&dense));
        let moved = (dense.rigid_pose(1).position - world.rigid_pose(1).position).norm();
        assert!(moved < 2e-5, "{cone:?}: bone off by {moved} m");
    }
}
