//! Goal: what contact and joint limits remember as impulses of the last step stands for the same
//! forces in a step of another length. Method: bodies at rest, whose forces are known from statics;
//! their impulses are looked at before and after the time step is changed, and so is the first step
//! from them.

use crate::common::body;
use thenar_core::model::{AngleLimit, Axis, JointDesc, JointKind, Motion, SolverKind, WorldDesc};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Vec3, World};

const G: f64 = 9.81;
const MASS: f64 = 0.3;
/// A rod's middle is so far from its hinge \[m\].
const ARM: f64 = 0.02;

/// A ball on a plane, and a rod that its weight holds at the bound of a hinge about z.
fn at_rest(h: f64) -> World {
    let mut desc = WorldDesc { time_step: h, gravity: Vec3::y() * -G, ..WorldDesc::default() };
    desc.solver.kind = SolverKind::Monolithic;
    let mut plane = body("ground", 1.0, [1.0; 3], Vec3::zeros());
    (plane.motion, plane.shape) = (Motion::Prescribed, Some(Shape::HalfSpace));
    desc.add_rigid(plane);
    let mut ball = body("ball", MASS, [5e-5; 3], Vec3::y() * 0.02);
    ball.shape = Some(Shape::Sphere { radius: 0.02 });
    desc.add_rigid(ball);
    let rod = body("rod", MASS, [1e-6, 3e-5, 3e-5], Vec3::new(1.0 + ARM, 1.0, 0.0));
    let child = desc.add_rigid(rod);
    let to_z = thenar_core::Quat::from_axis_angle(&Vec3::y_axis(), -std::f64::consts::FRAC_PI_2);
    let limit = Some(AngleLimit { min: 0.0, max: 1.0 });
    desc.joints.push(JointDesc {
        name: "hinge".into(),
        kind: JointKind::Hinge,
        parent: None,
        child,
        pose_PJ: Pose::new(Vec3::new(1.0, 1.0, 0.0), to_z),
        pose_CK: Pose::new(Vec3::x() * -ARM, to_z),
        axes: [Axis { limit, ..Axis::default() }, Axis::default()],
        limit_stiffness: 10.0,
        limit_damping: 0.01,
    });
    let mut world = World::new(desc).unwrap();
    let input = world.input();
    for _ in 0..(2.0 / h) as usize {
        world.step(&input, &mut ());
    }
    world
}

/// Sizes of what contact \[N s\] and the hinge's bound \[N m s\] remember.
fn remembered(world: &World) -> [f64; 2] {
    let contact = world.state().impulses.iter().map(|(_, impulse)| impulse).sum::<Vec3>();
    [contact.norm(), world.state().limit_impulses[0][0].abs()]
}

#[track_caller]
fn assert_near(got: [f64; 2], wanted: [f64; 2], tolerance: f64, context: &str) {
    for (got, wanted) in got.into_iter().zip(wanted) {
        let off = (got / wanted - 1.0).abs();
        assert!(off < tolerance, "{context}: {got}, expected {wanted}");
    }
}

#[test]
fn remembered_impulses_are_those_of_the_same_forces_in_the_new_step() {
    for (h, new) in [(2e-3, 1e-3), (1e-3, 5e-3), (5e-3, 1e-4)] {
        let statics = |h: f64| [MASS * G * h, MASS * G * ARM * h];
        let mut world = at_rest(h);
        // The solver's accuracy, relative to the load of a step.
        assert_near(remembered(&world), statics(h), 1e-3, "before");
        let before = remembered(&world);
        let exactly = before.map(|impulse| impulse * (new / h));
        let mut retuned = world.clone();
        world.set_time_step(new);
        assert_near(remembered(&world), exactly, 1e-12, "the time step was set");
        retuned.retune(WorldDesc { time_step: new, ..retuned.desc().clone() }).unwrap();
        assert_near(remembered(&retuned), exactly, 1e-12, "the world was retuned");

        // The next step has nothing left to find.
        let (input, pose) = (world.input(), world.rigid_pose(1));
        let report = world.step(&input, &mut ());
        assert!(!report.contact_unconverged && !report.fell_back, "{report:?}");
        assert_near(remembered(&world), statics(new), 1e-3, "a step later");
        let moved = (world.rigid_pose(1).position - pose.position).norm();
        assert!(moved < 1e-3 * G * new * new, "{moved} m");
    }
}
