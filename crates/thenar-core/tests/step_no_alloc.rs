//! Goal: a step allocates nothing, nor does reading its contacts, by taxels too. Method: a global
//! allocator that counts, around steps of a soft finger that falls on a plane, is pressed, and
//! touches a soft block and a box.

mod common;

use common::{FLESH, bar, body, finger};
use thenar_core::model::{
    BodyId, Drive, FrictionTable, Motion, PoseOffsets, Sheet, Skin, SoftDesc, SolverKind, facets,
};
use thenar_core::readout::{ContactReadout, TaxelPlace, TaxelReadout, TaxelSkin};
use thenar_core::shape::Shape;
use thenar_core::world::Target;
use thenar_core::{Pose, Quat, Vec3, World};
use thenar_testing::allocations;

#[global_allocator]
static ALLOCATOR: allocations::Counting = allocations::Counting;

#[test]
fn a_step_allocates_nothing() {
    for kind in [SolverKind::TwoStep, SolverKind::Monolithic] {
        steps_allocate_nothing(kind);
    }
}

fn steps_allocate_nothing(kind: SolverKind) {
    let mut desc = finger(1e8, 2e-3);
    desc.solver.kind = kind;
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
        pose_WM: Pose::translation(0.045, 0.017, 0.0),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    let carried = &desc.softs[0].coupling.as_ref().unwrap().bindings;
    let both = |n: &u32| carried[*n as usize].weights.iter().all(|w| *w > 0.0);
    let nodes: Vec<u32> = (0..carried.len() as u32).filter(both).collect();
    assert!(!nodes.is_empty());
    desc.pose_offsets.push(PoseOffsets {
        soft: 0,
        joint: 0,
        poses: vec![Quat::from_scaled_axis(Vec3::z())],
        offsets: vec![Vec3::y() * 1e-3; nodes.len()],
        nodes,
    });
    let sheet = Sheet {
        thickness: 1e-3,
        young: 2e4,
        poisson: 0.4,
        pretension: 0.5,
        wrinkling: Sheet::WRINKLING,
    };
    for (soft, body) in (0..).zip(&desc.softs) {
        let flesh = &body.flesh;
        let facets = facets(&flesh.nodes, &flesh.tets, &flesh.collision, |_| Some(0));
        desc.skins.push(Skin { soft, sheets: vec![sheet], facets });
    }
    desc.friction_tables.push(FrictionTable {
        bodies: [BodyId::Rigid(2), BodyId::Soft(0)],
        points: vec![[1.0, 0.8], [20.0, 0.4]],
    });
    let drive =
        Drive { stiffness: 400.0, damping: 2.0, angular_stiffness: 0.4, angular_damping: 1e-3 };
    desc.drives[0] = Some(drive);
    let start = desc.rigids[0].pose_WB;
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    let mut readout = ContactReadout::new(&world);
    let flesh = &world.desc().softs[0].flesh;
    let skin = TaxelSkin::new(flesh, Vec::new());
    let places: Vec<TaxelPlace> = (0..30)
        .filter_map(|k| {
            let point = Vec3::new(2e-3 * f64::from(k), 0.0, 8e-3);
            skin.nearest(0, &point, &Vec3::x())
        })
        .collect();
    let mut taxels = TaxelReadout::new(&world, 0, &places, f64::INFINITY).unwrap();

    let mut active = 0;
    let before = allocations::so_far();
    for i in 0..300 {
        let down = 0.003 * f64::from(i) / 300.0;
        input.targets[0] = Some(Target {
            pose_WB: Pose::new(start.position - Vec3::y() * down, start.rotation),
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
        });
        let report = world.step(&input, &mut ());
        assert!(!report.fell_back && !report.non_finite);
        readout.read(&world);
        taxels.read(&world);
        assert_eq!(readout.body(&world, BodyId::Soft(0)).points > 0, report.contacts_active > 0);
        active = active.max(report.contacts_active);
    }
    let after = allocations::so_far();
    assert!(active > 20, "the scene must touch: {active} active contacts");
    assert_eq!(after - before, 0, "allocations in 300 steps");
}
