//! Goal: no input stops a world for good: what cannot be computed is reported, taken back, and the
//! next step goes on. Method: worlds at the edge of what can be described, and inputs past it.

use crate::common::{FLESH, bar, body, finger};
use std::sync::Arc;
use thenar_core::model::{
    Axis, BodyId, Cone, Drive, FixedNode, JointDesc, JointKind, Motion, PairRule, SoftDesc,
    SolverKind, SolverSettings, WorldDesc,
};
use thenar_core::shape::{DistanceGrid, MeshShape, Shape};
use thenar_core::world::{Input, Target};
use thenar_core::{Pose, Quat, Vec3, World};

const DRIVE: Drive =
    Drive { stiffness: 400.0, damping: 1.0, angular_stiffness: 0.4, angular_damping: 1e-3 };

fn still(pose_WB: Pose) -> Target {
    Target { pose_WB, velocity_W: Vec3::zeros(), angular_velocity_W: Vec3::zeros() }
}

/// A driven finger held over a plane.
fn scene() -> (World, Input) {
    let mut desc = finger(1e8, 5e-3);
    desc.drives = vec![Some(DRIVE); 2];
    let mut plane = body("ground", 1.0, [1.0; 3], Vec3::zeros());
    plane.motion = Motion::Prescribed;
    plane.shape = Some(Shape::HalfSpace);
    desc.add_rigid(plane);
    let world = World::new(desc).unwrap();
    let mut input = world.input();
    (0..2).for_each(|b| input.targets[b as usize] = Some(still(world.rigid_pose(b))));
    (world, input)
}

fn hinge(parent: Option<u32>, child: u32, parent_at: Vec3, child_at: Vec3) -> JointDesc {
    let to_z = Quat::from_axis_angle(&Vec3::y_axis(), -std::f64::consts::FRAC_PI_2);
    JointDesc {
        name: format!("hinge {child}"),
        kind: JointKind::Hinge,
        parent,
        child,
        pose_PJ: Pose::new(parent_at, to_z),
        pose_CK: Pose::new(child_at, to_z),
        axes: [Axis::default(); 2],
        limit_stiffness: 0.0,
        limit_damping: 0.0,
    }
}

#[test]
fn one_bad_step_does_not_spoil_the_next() {
    type Spoil = fn(&mut Input, f64);
    let spoils: [(&str, Spoil); 6] = [
        ("target", |i, x| i.targets[0] = Some(still(Pose::translation(x, 0.0, 0.0)))),
        ("target speed", |i, x| {
            i.targets[1] =
                Some(Target { angular_velocity_W: Vec3::repeat(x), ..i.targets[1].unwrap() });
        }),
        ("force", |i, x| i.node_forces[3].y = x),
        ("wrench", |i, x| i.wrenches[1] = [Vec3::repeat(x); 2]),
        ("prescribed", |i, x| i.prescribed[2][0].x = x),
        ("gravity", |i, x| i.gravity.y = x),
    ];
    for (name, spoil) in spoils {
        for x in [f64::NAN, f64::INFINITY, 1e300, 1e150, 1e30] {
            let (mut world, input) = scene();
            (0..3).for_each(|_| assert!(!world.step(&input, &mut ()).non_finite));
            let (time, before) = (world.time(), world.nodes(0).to_vec());
            let mut spoiled = input.clone();
            spoil(&mut spoiled, x);
            let report = world.step(&spoiled, &mut ());
            if name.starts_with("target") && !x.is_finite() {
                // A tracker's bad sample lets go of its bone for a step; the world goes on.
                assert!(report.bad_targets == 1 && !report.non_finite, "{name} {x}: {report:?}");
                assert!(world.time() > time && world.energy(&spoiled).total().is_finite());
                continue;
            }
            assert!(report.non_finite, "{name} {x} must be reported");
            assert_eq!((world.time(), world.nodes(0)), (time, &before[..]), "{name} {x}");
            for i in 0..100 {
                assert!(!world.step(&input, &mut ()).non_finite, "{name} {x}: step {i} after it");
            }
            let moved = world.nodes(0).iter().zip(&before).map(|(a, b)| (a - b).norm());
            assert!(moved.fold(0.0, f64::max) < 0.01, "{name} {x}: it must stay near its targets");
        }
    }
}

#[test]
fn worlds_with_almost_nothing_step() {
    for kind in [SolverKind::TwoStep, SolverKind::Monolithic, SolverKind::DenseReference] {
        let mut desc = WorldDesc::default();
        desc.solver.kind = kind;
        let mut empty = World::new(desc.clone()).unwrap();
        let input = empty.input();
        assert!(!empty.step(&input, &mut ()).non_finite);
        assert!((empty.time() - 1e-3).abs() < 1e-15);

        desc.add_soft(SoftDesc {
            name: "bar".into(),
            flesh: bar(Vec3::repeat(0.02), [1, 1, 1], FLESH),
            pose_WM: Pose::identity(),
            velocity_W: Vec3::zeros(),
            coupling: None,
        });
        let mut flesh = World::new(desc).unwrap();
        let input = flesh.input();
        assert!(!flesh.step(&input, &mut ()).non_finite);
        let fall = flesh.nodes(0)[0].y;
        assert!((fall + 9.81e-6).abs() < 1e-12, "one step of free fall: {fall} m");
    }
}

/// Nodes that are held can be pushed by nothing; a plane 0.1 mm inside them must not matter.
#[test]
fn a_held_node_inside_a_plane_is_left_alone() {
    for axes in [[true; 3], [false, true, false], [true, false, true]] {
        for cone in [Cone::Circular, Cone::Linearised] {
            for kind in [SolverKind::TwoStep, SolverKind::Monolithic, SolverKind::DenseReference] {
                let mut desc = WorldDesc::default();
                desc.solver.kind = kind;
                desc.solver.cone = cone;
                let mut plane = body("ground", 1.0, [1.0; 3], Vec3::y() * 1e-4);
                plane.motion = Motion::Prescribed;
                plane.shape = Some(Shape::HalfSpace);
                desc.add_rigid(plane);
                let mut flesh = bar(Vec3::repeat(0.02), [2, 2, 2], FLESH);
                let bottom = (0..flesh.nodes.len()).filter(|&n| flesh.nodes[n].y == 0.0);
                flesh.fixed = bottom.map(|n| FixedNode { node: n as u32, axes }).collect();
                desc.add_soft(SoftDesc {
                    name: "block".into(),
                    flesh,
                    pose_WM: Pose::identity(),
                    velocity_W: Vec3::zeros(),
                    coupling: None,
                });
                let mut world = World::new(desc).unwrap();
                let input = world.input();
                for _ in 0..20 {
                    let report = world.step(&input, &mut ());
                    assert!(
                        !report.non_finite && report.contacts > 0,
                        "{axes:?} {cone:?} {kind:?}"
                    );
                }
            }
        }
    }
}

/// A planar four-bar of hinges asks for 20 conditions of which 17 are independent. As a
/// parallelogram of massless-like coupler it swings as a pendulum of its cranks and coupler:
/// `I θ̈ = -(m g r) sin θ`, with the coupler's mass at the cranks' ends.
#[test]
fn a_four_bar_swings_like_a_pendulum() {
    let (crank, mass, coupler) = (0.1, 0.02, 0.05);
    let thin = mass * crank * crank / 12.0;
    for kind in [SolverKind::TwoStep, SolverKind::Monolithic, SolverKind::DenseReference] {
        let h = 2e-4;
        let mut desc = WorldDesc { time_step: h, ..WorldDesc::default() };
        desc.solver.kind = kind;
        let angle = 0.05_f64;
        let turn = Quat::from_axis_angle(&Vec3::z_axis(), angle);
        let down = Vec3::new(0.0, -crank, 0.0);
        let end = turn * down;
        for (i, x) in [0.0, 0.06].into_iter().enumerate() {
            let mut bar =
                body(&format!("crank {i}"), mass, [thin, 1e-7, thin], end * 0.5 + Vec3::x() * x);
            bar.pose_WB.rotation = turn;
            desc.add_rigid(bar);
        }
        desc.add_rigid(body("coupler", coupler, [1e-6, 1e-5, 1e-5], end + Vec3::x() * 0.03));
        desc.joints.push(hinge(None, 0, Vec3::zeros(), down * -0.5));
        desc.joints.push(hinge(None, 1, Vec3::x() * 0.06, down * -0.5));
        desc.joints.push(hinge(Some(0), 2, down * 0.5, Vec3::x() * -0.03));
        desc.joints.push(hinge(Some(1), 2, down * 0.5, Vec3::x() * 0.03));
        let mut world = World::new(desc).unwrap();
        let input = world.input();
        let inertia = 2.0 * (thin + mass * 0.25 * crank * crank) + coupler * crank * crank;
        let moment = 9.81 * crank * (mass + coupler);
        let quarter = 0.5 * std::f64::consts::PI * (inertia / moment).sqrt();
        let mut crossed = None;
        for i in 0..(1.2 * quarter / h) as usize {
            let report = world.step(&input, &mut ());
            assert!(
                !report.non_finite && report.joint_gap_max < 1e-6,
                "{kind:?} step {i}: {report:?}"
            );
            if crossed.is_none() && world.rigid_pose(2).position.x < 0.03 {
                crossed = Some(world.time());
            }
        }
        let crossed = crossed.expect("it must reach the bottom");
        assert!(
            (crossed / quarter - 1.0).abs() < 0.01,
            "{kind:?}: {crossed} s, theory {quarter} s"
        );
    }
}

/// A joint between bodies that are both moved from outside asks for what cannot be given.
#[test]
fn a_joint_between_prescribed_bodies_is_harmless() {
    for kind in [SolverKind::TwoStep, SolverKind::Monolithic, SolverKind::DenseReference] {
        for looped in [false, true] {
            let mut desc = WorldDesc::default();
            desc.solver.kind = kind;
            for i in 0..4 {
                let mut link = body(&format!("link {i}"), 0.1, [1e-5; 3], Vec3::x() * f64::from(i));
                link.motion = if i < 2 { Motion::Prescribed } else { Motion::Dynamic };
                desc.add_rigid(link);
            }
            let half = Vec3::x() * 0.5;
            desc.joints.push(hinge(Some(0), 1, half, -half));
            desc.joints.push(hinge(Some(1), 2, half, -half));
            desc.joints.push(hinge(Some(2), 3, half, -half));
            if looped {
                desc.joints.push(hinge(None, 3, half * 7.0, half));
            }
            let mut world = World::new(desc).unwrap();
            let input = world.input();
            for _ in 0..20 {
                let report = world.step(&input, &mut ());
                assert!(
                    !report.non_finite && report.joint_gap_max < 1e-4,
                    "{kind:?} {looped} {report:?}"
                );
            }
        }
    }
}

/// A plate put on the other side of a soft block is a new neighbour, not one that went through it.
#[test]
fn a_body_put_elsewhere_has_not_passed_through() {
    let mut desc = WorldDesc { gravity: Vec3::zeros(), ..WorldDesc::default() };
    let mut plate = body("plate", 1.0, [1.0; 3], Vec3::new(0.01, -0.0015, 0.01));
    plate.motion = Motion::Prescribed;
    plate.shape = Some(Shape::Cuboid { half: Vec3::new(0.05, 0.001, 0.05) });
    let plate = desc.add_rigid(plate);
    desc.add_soft(SoftDesc {
        name: "block".into(),
        flesh: bar(Vec3::new(0.02, 0.002, 0.02), [2, 1, 2], FLESH),
        pose_WM: Pose::identity(),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    let mut world = World::new(desc).unwrap();
    let input = world.input();
    assert!(world.step(&input, &mut ()).contacts > 0, "the plate must be near the block");
    world.set_rigid_state(plate, Pose::translation(0.01, 0.0035, 0.01), [Vec3::zeros(); 2]);
    for _ in 0..10 {
        let report = world.step(&input, &mut ());
        assert!(report.penetration_max == 0.0 && report.contacts_active == 0, "{report:?}");
    }
}

#[test]
fn the_time_step_can_change_while_it_runs() {
    let (mut world, input) = scene();
    for (i, h) in [5e-3, 1e-3, 1.0 / 60.0, 2e-4, 5e-3].into_iter().enumerate() {
        world.set_time_step(h);
        for h in [f64::NAN, -1.0, 0.0, 1e300, f64::INFINITY] {
            world.set_time_step(h);
        }
        assert_eq!(world.time_step(), h, "change {i}");
        for _ in 0..30 {
            assert!(!world.step(&input, &mut ()).non_finite);
        }
        let speed = world.node_velocities(0).iter().map(|v| v.norm()).fold(0.0, f64::max);
        assert!(speed < 0.1, "a step of {h} s must not kick: {speed} m/s");
    }
}

/// A refusal names the setting and its value, and leaves all of them, and the world, as they were.
#[test]
fn solver_settings_out_of_range_are_refused_by_name() {
    let (mut world, _) = scene();
    let (good, hash) = (world.desc().solver, world.state_hash());
    let other = |good: SolverSettings| SolverSettings { kind: SolverKind::TwoStep, ..good };
    for (bad, said) in [
        (
            SolverSettings { velocity_tolerance: 0.0, ..other(good) },
            "solver: velocity_tolerance must be positive [m/s], got 0",
        ),
        (
            SolverSettings { cg_tolerance: 1.0, ..other(good) },
            "solver: cg_tolerance must be positive and below 1, got 1",
        ),
        (
            SolverSettings { contact_sweeps_max: 0, ..other(good) },
            "solver: contact_sweeps_max must be at least 1, got 0",
        ),
        (
            SolverSettings { step_halvings_max: 11, ..other(good) },
            "solver: step_halvings_max must be at most 10, got 11",
        ),
    ] {
        assert_eq!(world.set_solver_settings(bad).unwrap_err().to_string(), said);
        assert_eq!((world.desc().solver, world.state_hash()), (good, hash), "{said}");
    }
    assert_eq!(world.set_solver_settings(other(good)), Ok(()));
    assert_eq!(world.desc().solver.kind, SolverKind::TwoStep);
}

#[test]
fn wrong_pairs_and_meshes_are_refused_by_name() {
    let mut desc = WorldDesc::default();
    desc.add_rigid(body("a", 1.0, [1.0; 3], Vec3::zeros()));
    let refused = |desc: &WorldDesc, text: &str| {
        let problem = World::new(desc.clone()).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(problem.contains(text), "{problem:?} must name {text:?}");
    };
    let rule = |b: BodyId, mu: f64| PairRule { bodies: [BodyId::Rigid(0), b], friction: Some(mu) };
    for mu in [-0.1, f64::NAN, f64::INFINITY] {
        desc.pairs = vec![rule(BodyId::Rigid(0), mu)];
        refused(&desc, "pair: friction");
    }
    for b in [BodyId::Rigid(1), BodyId::Soft(0)] {
        desc.pairs = vec![rule(b, 0.5)];
        refused(&desc, "pair: body");
    }
    desc.pairs.clear();

    let mesh = MeshShape::new(
        vec![Vec3::zeros(), Vec3::x(), Vec3::y()],
        vec![[0, 1, 2]],
        DistanceGrid { origin: Vec3::zeros(), cell: 1.0, dims: [2; 3], values: vec![0.0; 8] },
    );
    let mut with = |mesh: MeshShape| {
        desc.rigids[0].shape = Some(Shape::Mesh(Arc::new(mesh)));
        desc.clone()
    };
    assert!(World::new(with(mesh.clone())).is_ok());
    let wrong = MeshShape::new(mesh.points.clone(), vec![[0, 1, 3]], mesh.grid.clone());
    refused(&with(wrong), "a: mesh point 3");
    let grid = |f: fn(&mut DistanceGrid)| {
        let mut mesh = mesh.clone();
        f(&mut mesh.grid);
        mesh
    };
    refused(&with(grid(|g| g.dims[1] = 3)), "a: number of grid values");
    refused(&with(grid(|g| g.dims[0] = 1)), "a: grid size");
    refused(&with(grid(|g| g.cell = 0.0)), "a: grid spacing");
    refused(&with(grid(|g| g.values[2] = f32::NAN)), "a: grid value");
}
