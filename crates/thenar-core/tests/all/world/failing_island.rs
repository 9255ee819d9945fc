//! Goal: a step that fails in one part of the world is made safely there and nowhere else. Method:
//! an elastic block whose equations are not solved to tolerance in any step, beside bodies that
//! fly; their paths are those of backward Euler, in which gravity alone acts.

use crate::common::{FLESH, bar, body};
use thenar_core::model::{Law, Material, SoftDesc, SolverKind, WorldDesc};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Vec3, World};

/// Time step \[s\].
const H: f64 = 0.002;
/// Velocity at the start \[m/s\].
const START: Vec3 = Vec3::new(1.5, 4.0, -0.7);

/// A block that swings, so stiff and with so few iterations that no step of it is solved.
fn block(desc: &mut WorldDesc) {
    let material = Material { law: Law::Corotational, young: 1e9, poisson: 0.45, ..FLESH };
    let mut flesh = bar(Vec3::new(0.2, 0.02, 0.02), [10, 2, 2], material);
    flesh.nodes.iter_mut().for_each(|x| x.y *= 1.0 + 3.0 * x.x);
    desc.add_soft(SoftDesc {
        name: "block".into(),
        flesh,
        pose_WM: Pose::translation(0.0, 0.0, 0.0),
        velocity_W: Vec3::new(0.0, 0.0, 0.3),
        coupling: None,
    });
    desc.solver.cg_iterations_max = 1;
    // In halved steps the ball would follow another path than that below, of whole steps of
    // backward Euler.
    desc.solver.step_halvings_max = 0;
}

/// Where a body is after so many steps of backward Euler: `x = x₀ + n h v₀ + ½ n (n + 1) h² g`.
fn thrown(from: Vec3, steps: u32) -> Vec3 {
    let n = f64::from(steps);
    from + START * (n * H) + Vec3::new(0.0, -9.81, 0.0) * (0.5 * n * (n + 1.0) * H * H)
}

#[test]
fn a_ball_flies_on_while_a_block_fails_every_step() {
    let mut desc = WorldDesc { time_step: H, ..WorldDesc::default() };
    desc.solver.kind = SolverKind::Monolithic;
    block(&mut desc);
    let from = Vec3::new(1.0, 0.5, 0.2);
    let mut ball = body("ball", 0.3, [1e-4; 3], from);
    ball.velocity_W = START;
    ball.angular_velocity_W = Vec3::new(0.0, 3.0, 0.0);
    ball.shape = Some(Shape::Sphere { radius: 0.03 });
    let ball = desc.add_rigid(ball);
    let mut world = World::new(desc).unwrap();
    // The block is bent by hand before every step.
    let input = world.input();
    for step in 1..=200 {
        let bend = 0.01 * f64::from(step % 7);
        let bent = |x: &Vec3| x + Vec3::y() * (bend * (40.0 * x.x).sin());
        let bent: Vec<Vec3> = world.nodes(0).iter().map(bent).collect();
        world.set_nodes(0, &bent);
        let report = world.step(&input, &mut ());
        assert!(report.fell_back && !report.non_finite, "step {step}: {report:?}");
        let off = (world.rigid_pose(ball).position - thrown(from, step)).norm();
        assert!(off < 1e-12, "step {step}: {off} m off, {report:?}");
        let [_, spin] = world.rigid_velocity(ball);
        assert!((spin - Vec3::new(0.0, 3.0, 0.0)).norm() < 1e-12, "step {step}: {spin}");
    }
}

/// Forces that move a grain by 1e12 m in a step, before and after which it is where it was.
#[test]
fn a_ball_flies_on_while_a_grain_gives_numbers_beyond_sense() {
    for kind in [SolverKind::Monolithic, SolverKind::TwoStep, SolverKind::DenseReference] {
        let mut desc = WorldDesc { time_step: H, ..WorldDesc::default() };
        desc.solver.kind = kind;
        let from = Vec3::new(1.0, 0.5, 0.2);
        let mut ball = body("ball", 0.3, [1e-4; 3], from);
        ball.velocity_W = START;
        let ball = desc.add_rigid(ball);
        let grain = desc.add_rigid(body("grain", 1e-9, [1e-15; 3], Vec3::zeros()));
        let mut world = World::new(desc).unwrap();
        let mut input = world.input();
        for force in [1e12, f64::INFINITY, f64::NAN, 1e300] {
            input.wrenches[grain as usize] = [Vec3::x() * force, Vec3::zeros()];
            for _ in 0..20 {
                let report = world.step(&input, &mut ());
                assert!(report.non_finite && !report.taken_back, "{kind:?} {force}: {report:?}");
                assert_eq!(world.rigid_pose(grain).position, Vec3::zeros());
                assert_eq!(world.rigid_velocity(grain), [Vec3::zeros(); 2]);
            }
        }
        let off = (world.rigid_pose(ball).position - thrown(from, 80)).norm();
        assert!(off < 1e-12 && (world.time() - 80.0 * H).abs() < 1e-12, "{kind:?}: {off} m off");
        // And the grain moves again as soon as nothing pulls.
        input.wrenches[grain as usize] = [Vec3::zeros(); 2];
        let report = world.step(&input, &mut ());
        assert!(!report.non_finite, "{kind:?}: {report:?}");
        let fell = world.rigid_velocity(grain)[0].y;
        assert!((fell / (-9.81 * H) - 1.0).abs() < 1e-9, "{kind:?}: {fell} m/s");
        // Where everything fails, no time passes.
        for b in [ball, grain] {
            input.wrenches[b as usize] = [Vec3::x() * f64::NAN, Vec3::zeros()];
        }
        let time = world.time();
        let report = world.step(&input, &mut ());
        assert!(report.non_finite && report.taken_back && world.time() == time, "{report:?}");
    }
}
