//! Goal: the monolithic solver bears violence at any stiffness and time step, and a step that it
//! cannot make is named, made safely, and forgotten by the next. Method: a driven finger thrashed
//! at random between a plate, a loose box and a soft block; then the same with failures forced.

use crate::common::{FLESH, bar, body, finger};
use thenar_core::model::{Drive, Material, Motion, SoftDesc, SolverSettings, WorldDesc};
use thenar_core::random::Random;
use thenar_core::shape::Shape;
use thenar_core::world::{Failure, Input, StepReport, Target};
use thenar_core::{Pose, Quat, Vec3, World};
use thenar_testing::one_in;

const DRIVE: Drive =
    Drive { stiffness: 400.0, damping: 1.0, angular_stiffness: 0.4, angular_damping: 1e-3 };
/// Half of the space that targets jump about in \[m\].
const REACH: f64 = 0.04;

/// A finger of this coupling \[N/m⁴\] and Young's modulus \[Pa\] above a plane, a box of 50 g and a
/// soft block of the same modulus on it.
fn scene(kappa: f64, young: f64, h: f64) -> WorldDesc {
    let mut desc = finger(kappa, h);
    for material in &mut desc.softs[0].flesh.materials {
        material.young = young;
    }
    desc.drives = vec![Some(DRIVE); 2];
    let mut plane = body("ground", 1.0, [1.0; 3], Vec3::y() * -0.02);
    plane.motion = Motion::Prescribed;
    plane.shape = Some(Shape::HalfSpace);
    desc.add_rigid(plane);
    let mut cube = body("box", 0.05, [5e-6; 3], Vec3::new(0.03, -0.01, 0.008));
    cube.shape = Some(Shape::Cuboid { half: Vec3::repeat(0.01) });
    desc.add_rigid(cube);
    let mut flesh = bar(Vec3::repeat(0.02), [2, 2, 2], FLESH);
    flesh.materials.iter_mut().for_each(|m| m.young = young);
    desc.add_soft(SoftDesc {
        name: "block".into(),
        flesh,
        pose_WM: Pose::translation(0.045, -0.02, 0.0),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    desc
}

/// Throws both bones' targets about: anywhere within reach, turned by up to a radian each way.
fn thrash(input: &mut Input, home: &[Pose; 2], random: &mut Random) {
    for (target, home) in input.targets.iter_mut().zip(home) {
        let place = home.position + random.vector(REACH);
        let turn = Quat::from_scaled_axis(random.vector(1.0));
        *target = Some(Target {
            pose_WB: Pose::new(place, turn * home.rotation),
            velocity_W: random.vector(1.0),
            angular_velocity_W: random.vector(10.0),
        });
    }
}

/// Extremes of a run.
#[derive(Debug, Default)]
struct Extremes {
    steps: u32,
    fell_back: u32,
    energy: f64,
    gap: f64,
    depth: f64,
    touching: u32,
}

impl Extremes {
    fn take(&mut self, world: &World, input: &Input, report: &StepReport) {
        self.steps += 1;
        self.fell_back += u32::from(report.fell_back);
        self.energy = self.energy.max(world.energy(input).total());
        self.gap = self.gap.max(report.joint_gap_max);
        self.depth = self.depth.max(report.penetration_max);
        self.touching = self.touching.max(report.contacts_active);
    }
}

/// What the scene can hold at most: both drives stretched across the space and turned by three
/// radians, and flesh stretched by √5 - 1 and off its bones by 1 cm, as a turn of two radians
/// within one long step does (nodes and bones go along tangents).
fn energy_max(kappa: f64, young: f64) -> f64 {
    let far = 3.0 * (2.0 * REACH).powi(2);
    let volume = 0.06 * 0.016 * 0.016 + 0.02 * 0.02 * 0.02;
    DRIVE.stiffness * far
        + DRIVE.angular_stiffness * 9.0
        + 0.5 * young * 1.24 * 1.24 * volume
        + 0.5 * kappa * volume * 1e-4
}

fn start(desc: WorldDesc) -> (World, Input, [Pose; 2]) {
    let world = World::new(desc).unwrap();
    let input = world.input();
    let home = [world.rigid_pose(0), world.rigid_pose(1)];
    (world, input, home)
}

#[test]
fn thrashing_is_borne_at_any_stiffness_and_step() {
    let stiffnesses = [1e7, 1e8, 1e9, 1e10].into_iter();
    let bodies = stiffnesses.flat_map(|kappa| [5e3, 5e4, 5e5, 5e6].map(|young| (kappa, young)));
    let steps = [2.5e-4, 1e-3, 5e-3, 1.0 / 60.0, 0.02];
    for (kappa, young, h) in one_in(7, bodies.flat_map(|(k, e)| steps.map(|h| (k, e, h)))) {
        let (mut world, mut input, home) = start(scene(kappa, young, h));
        let (mut random, mut seen) = (Random::new(7), Extremes::default());
        for i in 0..60 {
            if i % 8 == 0 {
                thrash(&mut input, &home, &mut random);
            }
            let report = world.step(&input, &mut ());
            let case = format!("kappa {kappa:.0e}, E {young:.0e}, h {h}, step {i}");
            assert!(!report.non_finite, "{case}: {report:?}");
            assert_eq!(report.failure.is_some(), report.fell_back, "{case}: {report:?}");
            seen.take(&world, &input, &report);
        }
        let case = format!("kappa {kappa:.0e}, E {young:.0e}, h {h}: {seen:?}");
        let most = energy_max(kappa, young);
        assert!(seen.energy < most, "{case}, {most} J allowed");
        // Turning by ω within a step opens a joint by about (ω h)² times its lever, and the
        // next step closes it.
        assert!(seen.gap < 0.03, "{case}");
        println!("{case}");
    }
}

/// Steps that all fail: motion dies down instead of building up, joints hold, and the first step
/// that may converge again does.
#[test]
fn steps_that_fail_one_after_the_other_stay_calm() {
    for (kappa, h) in [(1e8, 1e-3), (1e9, 1.0 / 60.0), (1e10, 0.02)] {
        let (mut world, mut input, home) = start(scene(kappa, 5e4, h));
        let good = world.desc().solver;
        let bad = SolverSettings { velocity_tolerance: 1e-9, cg_iterations_max: 1, ..good };
        let (mut random, mut seen) = (Random::new(3), Extremes::default());
        world.set_solver_settings(bad).unwrap();
        for i in 0..200 {
            if i % 8 == 0 {
                thrash(&mut input, &home, &mut random);
            }
            let report = world.step(&input, &mut ());
            let case = format!("kappa {kappa:.0e}, h {h}, step {i}: {report:?}");
            assert!(matches!(report.failure, Some(Failure::NotConverged { .. })), "{case}");
            assert!(report.fell_back && !report.non_finite, "{case}");
            seen.take(&world, &input, &report);
        }
        assert!(
            seen.energy < energy_max(kappa, 5e4) && seen.gap < 0.03,
            "kappa {kappa:.0e}, h {h}: {seen:?}"
        );
        world.set_solver_settings(good).unwrap();
        let report = world.step(&input, &mut ());
        assert!(report.failure.is_none() && !report.fell_back, "h {h}: {report:?}");
    }
}

/// A step without forces and contact whose every velocity is right loses nothing by the fall-back:
/// what is shortened is only what brings in energy.
#[test]
fn a_free_flight_is_not_slowed_by_a_failing_neighbour() {
    let mut desc = scene(1e8, 5e4, 1e-3);
    desc.gravity = Vec3::zeros();
    let ball = desc.add_rigid(body("ball", 0.1, [1e-5; 3], Vec3::y()));
    desc.rigids[ball as usize].velocity_W = Vec3::new(1.0, 2.0, 3.0);
    desc.solver.velocity_tolerance = 1e-9;
    desc.solver.cg_iterations_max = 1;
    let (mut world, input, _) = start(desc);
    let report = world.step(&input, &mut ());
    let v = world.rigid_velocity(ball)[0];
    assert!((v - Vec3::new(1.0, 2.0, 3.0)).norm() < 1e-3, "{v} {report:?}");
}

/// Flesh turned inside out: the step says so, nothing blows up, and the flesh finds back.
#[test]
fn flesh_turned_inside_out_comes_back() {
    for h in [1e-3, 1.0 / 60.0] {
        let mut desc = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
        let mut flesh = bar(Vec3::repeat(0.02), [2, 2, 2], FLESH);
        flesh.stiffness_damping = 1e-3;
        desc.add_soft(SoftDesc {
            name: "block".into(),
            flesh,
            pose_WM: Pose::identity(),
            velocity_W: Vec3::zeros(),
            coupling: None,
        });
        let mut world = World::new(desc).unwrap();
        let input = world.input();
        let squeezed: Vec<Vec3> =
            world.nodes(0).iter().map(|x| Vec3::new(x.x, -0.3 * x.y, x.z)).collect();
        world.set_nodes(0, &squeezed);
        let start = world.energy(&input).total();
        let first = world.step(&input, &mut ());
        assert!(first.inverted_tets > 0 && !first.non_finite, "{first:?}");
        let mut last = first;
        for _ in 0..(2.0 / h) as usize {
            last = world.step(&input, &mut ());
            assert!(!last.non_finite && last.failure.is_none(), "h {h}: {last:?}");
            let energy = world.energy(&input).total();
            assert!(energy < 1.5 * start, "h {h}: {energy} of {start} J");
        }
        assert_eq!(last.inverted_tets, 0, "h {h}: {} J left", world.energy(&input).total());
    }
}

/// A cube of 602 surface points falls so fast that without the table all of them, far more than
/// there is room for, would be below it at the end of a step. Those of its lower face keep the
/// others out: no step falls back, and no point ends below the table by more than the tolerance of
/// both velocities and impulses lets it drift in a step, and what four such steps leave: less is
/// not pushed out.
#[test]
fn points_that_others_keep_out_need_no_room() {
    let h = 1.0 / 60.0;
    let mut desc = WorldDesc { time_step: h, ..WorldDesc::default() };
    let mut plane = body("ground", 1.0, [1.0; 3], Vec3::zeros());
    plane.motion = Motion::Prescribed;
    plane.shape = Some(Shape::HalfSpace);
    desc.add_rigid(plane);
    let firm = Material { young: 1e6, ..FLESH };
    desc.add_soft(SoftDesc {
        name: "cube".into(),
        flesh: bar(Vec3::repeat(0.05), [10; 3], firm),
        pose_WM: Pose::translation(0.0, 0.005, 0.0),
        velocity_W: Vec3::new(0.0, -4.0, 0.0),
        coupling: None,
    });
    // 121 points that share a stiff load take many sweeps.
    desc.solver.contact_sweeps_max = 20_000;
    let mut world = World::new(desc).unwrap();
    let input = world.input();
    let above = |world: &World| world.nodes(0).iter().filter(|x| x.y > h * 4.0).count();
    assert_eq!(above(&world), 0, "every point would cross");
    for i in 0..10 {
        let report = world.step(&input, &mut ());
        assert!(report.failure.is_none(), "step {i}: {report:?}");
        let lowest = world.nodes(0).iter().map(|x| x.y).fold(f64::INFINITY, f64::min);
        let residual = report.contact_residual.max(1e-5);
        assert!(lowest > -6.0 * h * residual, "step {i}: {lowest} m, {report:?}");
        assert!(residual < 1e-3, "step {i}: {report:?}");
    }
}

/// More points pressed than the solver has room for: the step is made with those that press most.
#[test]
fn too_many_contacts_are_named_and_survived() {
    let mut desc = WorldDesc { time_step: 5e-3, ..WorldDesc::default() };
    let mut plane = body("ground", 1.0, [1.0; 3], Vec3::zeros());
    plane.motion = Motion::Prescribed;
    plane.shape = Some(Shape::HalfSpace);
    desc.add_rigid(plane);
    desc.add_soft(SoftDesc {
        name: "mat".into(),
        flesh: bar(Vec3::new(0.3, 0.01, 0.3), [22, 1, 22], FLESH),
        pose_WM: Pose::translation(0.0, 0.0005, 0.0),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    let mut world = World::new(desc).unwrap();
    let input = world.input();
    let mut named = 0;
    for i in 0..20 {
        let report = world.step(&input, &mut ());
        assert!(!report.non_finite, "step {i}: {report:?}");
        if let Some(failure) = report.failure {
            assert!(matches!(failure, Failure::TooManyContacts { .. }), "{failure}");
            assert!(report.fell_back);
            // Halving the step would make no room for them.
            assert_eq!(report.parts, 1, "step {i}: {report:?}");
            named += 1;
        }
        let lowest = world.nodes(0).iter().map(|x| x.y).fold(f64::INFINITY, f64::min);
        assert!(lowest > -2e-3, "step {i}: sunk to {lowest} m, {report:?}");
    }
    assert!(named > 0, "529 points of the mat must be too many");
}
