//! Goal: the monolithic solver gives the solution of Eq. 9, joints included, to the velocity error
//! asked for. Method: several rigs, stirred, then stepped once from the same state by it and by the
//! dense reference.

use crate::common::{FLESH, bar, body, finger};
use thenar_core::model::{
    Axis, Binding, Coupling, Drive, FixedNode, JointDesc, JointKind, Motion, PoseOffsets, Skinning,
    SoftDesc, SolverKind, Springs, WorldDesc,
};
use thenar_core::random::Random;
use thenar_core::world::{Input, Target};
use thenar_core::{Pose, Quat, Vec3, World};

const DRIVE: Drive =
    Drive { stiffness: 400.0, damping: 1.0, angular_stiffness: 0.4, angular_damping: 1e-3 };

/// Three bones in a bar of flesh, joined by these kinds; the last hangs on a chain of one more.
fn chain(kinds: [JointKind; 3], kappa: f64, h: f64) -> WorldDesc {
    let mut desc = WorldDesc { time_step: h, ..WorldDesc::default() };
    for i in 0..4 {
        let at = Vec3::new(0.01 + 0.02 * f64::from(i), 0.008, 0.008);
        desc.add_rigid(body(&format!("bone {i}"), 0.003, [5e-8, 2e-7, 2.5e-7], at));
    }
    for (i, kind) in (0..).zip(kinds) {
        let half = Vec3::new(0.01, 0.0, 0.0);
        let turn = Quat::from_scaled_axis(Vec3::new(0.3, -1.2, 0.4));
        desc.joints.push(JointDesc {
            name: format!("joint {i}"),
            kind,
            parent: Some(i),
            child: i + 1,
            pose_PJ: Pose::new(half, turn),
            pose_CK: Pose::new(-half, turn),
            axes: [Axis { stiffness: 0.02, damping: 1e-4, ..Axis::default() }; 2],
            limit_stiffness: 2.0,
            limit_damping: 1e-3,
        });
    }
    let mut flesh = bar(Vec3::new(0.06, 0.016, 0.016), [6, 2, 2], FLESH);
    flesh.stiffness_damping = 1e-3;
    let binding = |x: &Vec3| {
        let along = (x.x / 0.02 - 0.5).clamp(0.0, 1.999);
        let (bone, weight) = (along as u32, along.fract());
        Binding { bones: [bone, bone + 1], weights: [1.0 - weight, weight] }
    };
    let volume = 0.06 * 0.016 * 0.016 / flesh.nodes.len() as f64;
    desc.add_soft(SoftDesc {
        name: "chain".into(),
        coupling: Some(Coupling {
            bindings: flesh.nodes.iter().map(binding).collect(),
            springs: Springs::PerNode(vec![kappa * volume; flesh.nodes.len()]),
            damping_time: 1e-3,
            skinning: Skinning::Linear,
        }),
        flesh,
        pose_WM: Pose::identity(),
        velocity_W: Vec3::zeros(),
    });
    desc
}

/// Two fingers, a free box, a loose soft block; the first finger's root is moved from outside, and
/// some nodes of the second are held.
fn company(kappa: f64, h: f64) -> WorldDesc {
    let mut desc = finger(kappa, h);
    desc.rigids[0].motion = Motion::Prescribed;
    let other = finger(kappa, h);
    for rigid in other.rigids {
        let moved = Pose::new(rigid.pose_WB.position + Vec3::z() * 0.05, rigid.pose_WB.rotation);
        desc.add_rigid(thenar_core::model::RigidDesc {
            name: format!("other {}", rigid.name),
            pose_WB: moved,
            ..rigid
        });
    }
    desc.joints.extend(other.joints.into_iter().map(|j| JointDesc {
        parent: j.parent.map(|p| p + 2),
        child: j.child + 2,
        ..j
    }));
    desc.add_rigid(body("box", 0.1, [1e-5, 2e-5, 3e-5], Vec3::new(0.0, 0.1, 0.0)));
    for mut soft in other.softs {
        soft.pose_WM = Pose::translation(0.0, 0.0, 0.05);
        if let Some(coupling) = &mut soft.coupling {
            for binding in &mut coupling.bindings {
                binding.bones = binding.bones.map(|b| b + 2);
            }
        }
        soft.flesh.fixed = vec![
            FixedNode { node: 0, axes: [true, true, true] },
            FixedNode { node: 13, axes: [false, true, false] },
        ];
        desc.add_soft(soft);
    }
    desc.add_soft(SoftDesc {
        name: "block".into(),
        flesh: bar(Vec3::repeat(0.02), [2, 2, 2], FLESH),
        pose_WM: Pose::translation(0.0, 0.2, 0.0),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    desc
}

fn rigs(kappa: f64, h: f64) -> Vec<(&'static str, WorldDesc)> {
    use JointKind::{Ball, Fixed, Hinge, Universal};
    vec![
        ("finger", finger(kappa, h)),
        ("ball, universal, hinge", chain([Ball, Universal, Hinge], kappa, h)),
        ("fixed, hinge, ball", chain([Fixed, Hinge, Ball], kappa, h)),
        ("two fingers, box, block", company(kappa, h)),
        ("offsets by pose", shifted(chain([Ball, Universal, Hinge], kappa, h), Skinning::Linear)),
        ("and joint skinning", shifted(company(kappa, h), Skinning::Joint)),
    ]
}

/// Targets between two bones are shifted by up to 2 mm where their joint is turned by half a
/// radian, one way or another.
fn shifted(mut desc: WorldDesc, skinning: Skinning) -> WorldDesc {
    let mut random = Random::new(3);
    for (j, joint) in (0..).zip(&desc.joints) {
        for (s, soft) in (0..).zip(&desc.softs) {
            let both = |binding: &Binding| {
                let bones = [Some(binding.bones[0]), Some(binding.bones[1])];
                [Some(joint.child), joint.parent].iter().all(|b| bones.contains(b))
                    && binding.weights.iter().all(|w| *w > 0.0)
            };
            let bindings = soft.coupling.iter().flat_map(|coupling| &coupling.bindings);
            let nodes: Vec<u32> =
                (0..).zip(bindings).filter(|(_, b)| both(b)).map(|(n, _)| n).collect();
            let poses = [Vec3::z(), Vec3::new(-0.6, 0.8, 0.0)];
            desc.pose_offsets.push(PoseOffsets {
                soft: s,
                joint: j,
                poses: poses.map(|axis| Quat::from_scaled_axis(axis * 0.5)).to_vec(),
                offsets: (0..2 * nodes.len()).map(|_| random.vector(0.002)).collect(),
                nodes,
            });
        }
    }
    for coupling in desc.softs.iter_mut().filter_map(|soft| soft.coupling.as_mut()) {
        coupling.skinning = skinning;
    }
    assert!(desc.pose_offsets.iter().any(|given| given.nodes.len() > 5));
    desc
}

/// A world in motion: driven to a place beside its own, with joint and node forces on it.
fn stirred(mut desc: WorldDesc) -> (World, Input) {
    desc.drives = vec![Some(DRIVE); desc.rigids.len()];
    desc.solver.kind = SolverKind::DenseReference;
    let poses: Vec<Pose> = desc.rigids.iter().map(|r| r.pose_WB).collect();
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    let mut random = Random::new(9);
    for (b, pose) in poses.iter().enumerate() {
        let turn = Quat::from_scaled_axis(random.vector(0.3));
        input.targets[b] = Some(Target {
            pose_WB: Pose::new(pose.position + random.vector(0.004), turn * pose.rotation),
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
        });
        input.prescribed[b] = [random.vector(0.05), random.vector(1.0)];
    }
    input.node_forces.iter_mut().for_each(|f| *f = random.vector(0.003));
    input.joint_torques.iter_mut().for_each(|t| *t = [0; 2].map(|_| 0.003 * random.symmetric()));
    for _ in 0..3 {
        assert!(!world.step(&input, &mut ()).non_finite);
    }
    (world, input)
}

/// Largest difference of velocity, bodies' turning taken at 5 cm \[m/s\].
fn difference(a: &World, b: &World) -> f64 {
    let mut largest = 0.0_f64;
    for i in 0..a.desc().rigids.len() as u32 {
        let ([va, wa], [vb, wb]) = (a.rigid_velocity(i), b.rigid_velocity(i));
        largest = largest.max((va - vb).norm()).max((wa - wb).norm() * 0.05);
    }
    for s in 0..a.desc().softs.len() as u32 {
        let pairs = a.node_velocities(s).iter().zip(b.node_velocities(s));
        largest = pairs.map(|(a, b)| (a - b).norm()).fold(largest, f64::max);
    }
    largest
}

fn speed(world: &World) -> f64 {
    let nodes = (0..world.desc().softs.len() as u32).flat_map(|s| world.node_velocities(s));
    nodes.map(|v| v.norm()).fold(0.0, f64::max)
}

#[test]
fn the_tolerance_is_honoured() {
    for kappa in [1e6, 1e8, 1e10, 1e12] {
        for h in [2.5e-4, 1e-3, 5e-3, 2e-2] {
            for (name, desc) in rigs(kappa, h) {
                let (mut dense, input) = stirred(desc);
                let start = dense.clone();
                dense.step(&input, &mut ());
                for decade in 2..=8 {
                    let tolerance = 10_f64.powi(-decade);
                    let mut world = start.clone();
                    let mut settings = world.desc().solver;
                    settings.kind = SolverKind::Monolithic;
                    settings.velocity_tolerance = tolerance;
                    world.set_solver_settings(settings).unwrap();
                    let report = world.step(&input, &mut ());
                    let error = difference(&world, &dense);
                    let case = format!("{name}, kappa {kappa:.0e}, h {h}, asked {tolerance:.0e}");
                    assert!(!report.fell_back && !report.non_finite, "{case}: {report:?}");
                    // An iteration that ends after a round or two has not yet seen by how much
                    // rounds make its error less, and is off by up to ten times as much.
                    let most = if decade == 2 { 10.0 * tolerance } else { tolerance };
                    assert!(error < most, "{case}: {error}");
                }
                assert!(speed(&dense) > 1e-3, "{name} must move: {} m/s", speed(&dense));
            }
        }
    }
}

/// Joint rows hold to the round-off of Eq. 9's, however coarse the tolerance: after a step the gap
/// is of second order in the step alone.
#[test]
fn joints_hold_at_any_tolerance() {
    for tolerance in [1e-2, 1e-8] {
        let mut gaps = Vec::new();
        for h in [2e-3, 1e-3] {
            let (mut world, input) = stirred(finger(1e8, h));
            let mut settings = world.desc().solver;
            settings.kind = SolverKind::Monolithic;
            settings.velocity_tolerance = tolerance;
            world.set_solver_settings(settings).unwrap();
            for _ in 0..(0.1 / h) as usize {
                assert!(!world.step(&input, &mut ()).fell_back);
            }
            gaps.push(world.joint_error(0).0);
        }
        assert!(gaps[0] < 2e-6 && gaps[1] < 0.5 * gaps[0].max(1e-9), "{gaps:?} m");
    }
}

/// A joint given twice closes a loop whose every row depends on others: nothing may change.
#[test]
fn a_joint_given_twice_changes_nothing() {
    let mut desc = finger(1e8, 1e-3);
    (desc.solver.kind, desc.solver.velocity_tolerance) = (SolverKind::Monolithic, 1e-9);
    let mut once = World::new(desc.clone()).unwrap();
    let mut again = JointDesc { name: "again".into(), ..desc.joints[0].clone() };
    again.axes.iter_mut().for_each(|axis| *axis = Axis::default());
    desc.joints.push(again);
    let mut twice = World::new(desc).unwrap();
    let (mut input, mut twice_input) = (once.input(), twice.input());
    for input in [&mut input, &mut twice_input] {
        input.joint_torques[0][0] = 0.004;
    }
    for _ in 0..50 {
        assert!(!once.step(&input, &mut ()).fell_back);
        assert!(!twice.step(&twice_input, &mut ()).fell_back);
    }
    assert!(once.joint_angles(0)[0].abs() > 1e-3, "it must move");
    for b in 0..once.model().rigids.len() as u32 {
        let (a, b) = (once.rigid_pose(b), twice.rigid_pose(b));
        assert!((a.position - b.position).norm() < 1e-9 && a.rotation.angle_to(&b.rotation) < 1e-7);
    }
}

/// Where one iteration solves all, what follows must not spoil it: a free body falls by
/// `g h² n (n + 1) / 2` in n steps, whatever the round-off.
#[test]
fn a_free_body_falls_exactly_at_any_step() {
    for k in 1..=200 {
        let h = 1e-4 * f64::from(k);
        let mut desc = WorldDesc { time_step: h, ..WorldDesc::default() };
        desc.add_rigid(body("ball", 0.1 + 1e-3 * f64::from(k), [1e-4; 3], Vec3::zeros()));
        let mut world = World::new(desc).unwrap();
        let input = world.input();
        (0..30).for_each(|_| assert!(!world.step(&input, &mut ()).fell_back, "h {h}"));
        let (y, expected) = (world.rigid_pose(0).position.y, -9.81 * h * h * 30.0 * 31.0 / 2.0);
        assert!((y - expected).abs() < 1e-12, "h {h}: {y} m, theory {expected} m");
    }
}
