//! Goal: a running world takes other parameters, keeps its state, and refuses other bodies.
//! Method: a driven finger and a soft block on a plane, in contact, with twins that differ only in
//! what is tested.

use crate::common::{FLESH, bar, body, finger};
use thenar_core::model::{
    BodyId, Drive, FixedNode, JointKind, Motion, PairRule, SoftDesc, SolverKind, Springs, WorldDesc,
};
use thenar_core::shape::Shape;
use thenar_core::world::{Input, ModelError, Target};
use thenar_core::{Pose, Vec3, World};

const DRIVE: Drive =
    Drive { stiffness: 400.0, damping: 1.0, angular_stiffness: 0.4, angular_damping: 1e-3 };

/// A finger pressed on a plane, a block and a cube beside it.
fn desc() -> WorldDesc {
    let mut desc = finger(1e8, 2e-3);
    desc.drives = vec![Some(DRIVE); 2];
    let mut plane = body("ground", 1.0, [1.0; 3], Vec3::zeros());
    plane.motion = Motion::Prescribed;
    plane.shape = Some(Shape::HalfSpace);
    desc.add_rigid(plane);
    let mut cube = body("cube", 0.05, [1e-5; 3], Vec3::new(0.03, 0.026, 0.008));
    cube.shape = Some(Shape::Cuboid { half: Vec3::repeat(0.01) });
    desc.add_rigid(cube);
    desc.add_soft(SoftDesc {
        name: "block".into(),
        flesh: bar(Vec3::repeat(0.02), [2, 2, 2], FLESH),
        pose_WM: Pose::translation(0.045, 0.001, 0.0),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    desc
}

/// After 60 steps of pressing.
fn pressing() -> (World, Input) {
    let mut world = World::new(desc()).unwrap();
    let mut input = world.input();
    let down = world.rigid_pose(0).position - Vec3::y() * 0.003;
    input.targets[0] = Some(Target {
        pose_WB: Pose::new(down, world.rigid_pose(0).rotation),
        velocity_W: Vec3::zeros(),
        angular_velocity_W: Vec3::zeros(),
    });
    for _ in 0..60 {
        world.step(&input, &mut ());
    }
    assert!(world.contacts().iter().filter(|c| c.force_W.norm() > 0.0).count() > 10);
    (world, input)
}

#[test]
fn the_same_parameters_change_no_bit() {
    let (mut world, input) = pressing();
    let mut twin = world.clone();
    for k in 0..60 {
        if k % 7 == 0 {
            world.retune(world.desc().clone()).unwrap();
            assert_eq!(world.contacts(), twin.contacts());
        }
        let report = world.step(&input, &mut ());
        assert_eq!(report, twin.step(&input, &mut ()));
        assert_eq!(world.state_hash(), twin.state_hash(), "step {k}");
    }
}

#[test]
fn state_stays_and_new_parameters_are_those_of_a_world_built_with_them() {
    let (mut world, input) = pressing();
    // What contact remembers is scaled to another step, and is the same from then on.
    world.set_time_step(1e-3);
    let hash = world.state_hash();
    let mut changed = desc();
    changed.time_step = 1e-3;
    changed.solver.contact_sweeps_max = 50;
    changed.drives[0] = Some(Drive { stiffness: 800.0, ..DRIVE });
    for soft in &mut changed.softs {
        soft.flesh.materials.iter_mut().for_each(|m| (m.young, m.poisson) = (2.0 * m.young, 0.3));
        soft.flesh.materials.iter_mut().for_each(|m| m.density *= 1.5);
        soft.flesh.stiffness_damping = 3e-3;
        soft.flesh.friction = 0.9;
    }
    let coupling = changed.softs[0].coupling.as_mut().unwrap();
    coupling.springs = Springs::PerNode(coupling.springs.stiffness().map(|k| 3.0 * k).collect());
    (changed.rigids[0].mass, changed.rigids[0].inertia) =
        (2.0 * changed.rigids[0].mass, 2.0 * changed.rigids[0].inertia);
    changed.pairs.push(PairRule { bodies: [BodyId::Rigid(2), BodyId::Soft(1)], friction: None });
    world.retune(changed.clone()).unwrap();
    assert_eq!(world.state_hash(), hash);
    assert_eq!(world.time_step(), 1e-3);

    // A world built with them, put into the same state, gives the same energies and, but for what
    // the detector and the contact solver remember, the same step.
    let mut built = World::new(changed).unwrap();
    for b in 0..4 {
        built.set_rigid_state(b, world.rigid_pose(b), world.rigid_velocity(b));
    }
    for soft in 0..2 {
        built.set_nodes(soft, world.nodes(soft));
    }
    let [retuned, fresh] = [&world, &built].map(|w| w.energy(&input));
    assert_eq!(retuned.elastic, fresh.elastic);
    assert_eq!(retuned.coupling, fresh.coupling);
    assert_eq!(retuned.drive, fresh.drive);
    assert_eq!(world.node_masses(1), built.node_masses(1));
    // The pair that was switched off does not touch any more.
    for _ in 0..5 {
        world.step(&input, &mut ());
        let off = [BodyId::Rigid(2), BodyId::Soft(1)];
        assert!(world.contacts().iter().all(|c| !off.iter().all(|b| c.bodies.contains(b))));
    }
}

#[test]
fn another_solver_goes_on_from_the_same_state() {
    let (mut world, input) = pressing();
    let mut dense = desc();
    dense.solver.kind = SolverKind::DenseReference;
    world.retune(dense).unwrap();
    let before = world.rigid_pose(0).position;
    let report = world.step(&input, &mut ());
    assert!(!report.non_finite && report.cg_iterations == 0);
    assert!((world.rigid_pose(0).position - before).norm() < 1e-3);
}

#[test]
fn other_bodies_and_wrong_numbers_are_refused_and_change_nothing() {
    type Change = fn(&mut WorldDesc);
    let changes: [(&str, Change); 14] = [
        ("number of rigid bodies", |d| {
            d.add_rigid(body("more", 1.0, [1.0; 3], Vec3::zeros()));
        }),
        ("number of soft bodies", |d| drop(d.softs.pop())),
        ("number of joints", |d| d.joints.clear()),
        ("kind", |d| d.joints[0].kind = JointKind::Ball),
        ("frames", |d| d.joints[0].pose_PJ.position.x += 1e-9),
        ("name", |d| d.rigids[3].name = "box".into()),
        ("forces", |d| d.rigids[3].motion = Motion::Prescribed),
        ("shape", |d| d.rigids[3].shape = Some(Shape::Sphere { radius: 0.01 })),
        ("shape", |d| d.rigids[3].shape = None),
        ("start pose", |d| d.softs[1].pose_WM.position.y += 1e-9),
        ("mesh", |d| d.softs[1].flesh.nodes[3].x += 1e-9),
        ("held", |d| d.softs[1].flesh.fixed.push(FixedNode { node: 0, axes: [true; 3] })),
        ("surface", |d| d.softs[1].flesh.collision.triangles.truncate(3)),
        ("bound", |d| {
            let coupling = d.softs[0].coupling.as_mut().unwrap();
            let mut springs: Vec<f64> = coupling.springs.stiffness().collect();
            springs[0] = 0.0;
            coupling.springs = Springs::PerNode(springs);
        }),
    ];
    let (mut world, input) = pressing();
    let mut twin = world.clone();
    for (what, change) in changes {
        let mut other = desc();
        change(&mut other);
        let error = world.retune(other).unwrap_err();
        assert!(matches!(error, ModelError::Changed { .. }), "{what}: {error}");
        assert!(error.to_string().contains(what), "{what}: {error}");
    }
    let mut wrong = desc();
    wrong.softs[1].flesh.materials[0].poisson = 0.5;
    assert!(matches!(world.retune(wrong).unwrap_err(), ModelError::Value { .. }));
    world.step(&input, &mut ());
    twin.step(&input, &mut ());
    assert_eq!(world.state_hash(), twin.state_hash());
}

#[test]
fn a_restarted_world_runs_as_a_new_one() {
    let (mut world, input) = pressing();
    world.restart();
    assert!(world.contacts().is_empty());
    let mut fresh = World::new(desc()).unwrap();
    for k in 0..80 {
        assert_eq!(world.state_hash(), fresh.state_hash(), "step {k}");
        world.step(&input, &mut ());
        fresh.step(&input, &mut ());
    }
}

/// The monolithic solver, chosen for a world that was built without it, steps at once.
#[test]
fn another_solver_can_be_chosen() {
    let mut desc = desc();
    desc.solver.kind = SolverKind::TwoStep;
    let mut world = World::new(desc.clone()).unwrap();
    desc.solver.kind = SolverKind::Monolithic;
    let mut monolithic = World::new(desc.clone()).unwrap();
    world.retune(desc).unwrap();
    let input = world.input();
    for _ in 0..5 {
        let report = world.step(&input, &mut ());
        assert!(!report.fell_back, "{report:?}");
        monolithic.step(&input, &mut ());
    }
    assert_eq!(world.state_hash(), monolithic.state_hash());
}
