//! Goal: bodies that overlap come apart without a speed, at any step; joints past a bound turn back
//! so, too; what contradicts itself stays bounded. Method: bodies that start overlapping, against
//! energy and statics, and the three solvers against each other.

use crate::common::{FLESH, bar, body};
use thenar_core::model::{
    AngleLimit, Axis, BodyId, JointDesc, JointKind, Material, Motion, SoftDesc, SolverKind,
    WorldDesc,
};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Quat, Vec3, World};

const STEPS: [f64; 3] = [1e-4, 1e-3, 1.0 / 60.0];
/// How fast overlaps go at a contact margin of 1 mm \[m/s\]: an elastic body pushed so would rise
/// by a tenth of the margin, `2 s²/g`.
const SPEED: f64 = 0.02215;

fn plane(desc: &mut WorldDesc, name: &str, pose_WB: Pose) {
    let mut plane = body(name, 1.0, [1.0; 3], Vec3::zeros());
    plane.pose_WB = pose_WB;
    plane.motion = Motion::Prescribed;
    plane.shape = Some(Shape::HalfSpace);
    desc.add_rigid(plane);
}

fn cuboid(desc: &mut WorldDesc, half: Vec3, mass: f64, pose_WB: Pose) -> u32 {
    let i = |a: f64, b: f64| mass * (a * a + b * b) / 3.0;
    let inertia = [i(half.y, half.z), i(half.x, half.z), i(half.x, half.y)];
    let mut cuboid = body("box", mass, inertia, Vec3::zeros());
    cuboid.pose_WB = pose_WB;
    cuboid.shape = Some(Shape::Cuboid { half });
    desc.add_rigid(cuboid)
}

fn soft_cube(desc: &mut WorldDesc, edge: f64, cells: usize, young: f64, at: Vec3) {
    let material = Material { young, density: 1000.0, ..FLESH };
    desc.add_soft(SoftDesc {
        name: "cube".into(),
        flesh: bar(Vec3::repeat(edge), [cells; 3], material),
        pose_WM: Pose::new(at, Quat::identity()),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
}

fn is_sound(world: &mut World) {
    let report = world.step(&world.input(), &mut ());
    assert!(!report.fell_back && !report.non_finite && !report.contact_unconverged, "{report:?}");
}

#[test]
fn a_rigid_ball_comes_out_without_a_hop_at_any_step_and_depth() {
    for h in STEPS {
        for depth in [1e-4, 4e-4, 1e-2] {
            let mut desc = WorldDesc { time_step: h, ..WorldDesc::default() };
            plane(&mut desc, "ground", Pose::identity());
            let (mass, radius) = (10.0, 0.05);
            let at = Vec3::y() * (radius - depth);
            let mut ball = body("ball", mass, [0.4 * mass * radius * radius; 3], at);
            ball.shape = Some(Shape::Sphere { radius });
            desc.add_rigid(ball);
            let mut world = World::new(desc).unwrap();
            for _ in 0..(1.2 / h) as u32 {
                is_sound(&mut world);
                let up = world.rigid_pose(1).position.y - radius;
                let fast = world.rigid_velocity(1)[0].norm();
                let case = format!("h {h}, depth {depth}");
                assert!(up < 1e-6 && fast < 1e-4, "{case}: {up} m up, {fast} m/s");
            }
            let left = radius - world.rigid_pose(1).position.y;
            assert!(left < 2e-6, "h {h}, depth {depth}: {left} m deep");
        }
    }
}

#[test]
fn a_heavy_soft_cube_is_back_on_the_ground_within_half_a_second() {
    for cells in [1, 2, 4] {
        let mut desc = WorldDesc { time_step: 1e-3, ..WorldDesc::default() };
        plane(&mut desc, "ground", Pose::identity());
        soft_cube(&mut desc, 0.2, cells, 2e5, Vec3::y() * -2.5e-3);
        desc.softs[0].flesh.mass_damping = 1.0;
        desc.softs[0].flesh.stiffness_damping = 0.005;
        let mut world = World::new(desc).unwrap();
        for i in 0..1000 {
            is_sound(&mut world);
            let heights = world.nodes(0).iter().map(|x| x.y);
            let (least, bottom) = heights.fold((f64::INFINITY, 0.0_f64), |(a, b), y| {
                (a.min(y), if y < 0.02 { b.max(y) } else { b })
            });
            assert!(bottom < 1e-4, "{cells} cells, step {i}: hops {bottom} m");
            assert!(least > -2.6e-3, "{cells} cells, step {i}: {least} m");
            assert!(i < 500 || least > -5e-6, "{cells} cells, step {i}: {least} m");
        }
    }
}

/// With nothing to hold it down an elastic cube leaves at twice the speed at most, whatever
/// its stiffness: faster by what one step adds where a step is longer than it takes to swing.
#[test]
fn an_overlap_gives_an_elastic_body_no_more_energy_than_told() {
    for young in [1e4, 1e5, 1e6] {
        for h in STEPS {
            let gravity = Vec3::zeros();
            let mut desc = WorldDesc { time_step: h, gravity, ..WorldDesc::default() };
            plane(&mut desc, "ground", Pose::identity());
            soft_cube(&mut desc, 0.04, 2, young, Vec3::y() * -2.5e-3);
            let mut world = World::new(desc).unwrap();
            let mass: f64 = world.node_masses(0).iter().sum();
            let most = 0.5 * mass * (2.0 * SPEED).powi(2);
            let input = world.input();
            let mut kinetic = 0.0_f64;
            for _ in 0..(0.5 / h) as u32 {
                is_sound(&mut world);
                kinetic = kinetic.max(world.energy(&input).kinetic);
            }
            assert!(kinetic < most, "E {young}, h {h}: {kinetic} of {most} J");
            assert!(world.nodes(0).iter().all(|x| x.y > -1e-5), "E {young}, h {h}: still in");
        }
    }
}

/// A box of 20 mm between walls 18 mm apart stays between them, still, and is not pressed harder
/// from step to step; a soft one, too.
#[test]
fn contacts_that_contradict_each_other_stay_bounded() {
    for soft in [false, true] {
        for h in STEPS {
            let mut desc =
                WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
            plane(&mut desc, "floor", Pose::translation(0.0, -9e-3, 0.0));
            let down = Quat::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI);
            plane(&mut desc, "lid", Pose::new(Vec3::y() * 9e-3, down));
            if soft {
                soft_cube(&mut desc, 0.02, 2, 5e4, Vec3::new(0.0, -0.01, 0.0));
            } else {
                cuboid(&mut desc, Vec3::repeat(0.01), 0.05, Pose::translation(0.0, 4e-4, 0.0));
            }
            let mut world = World::new(desc).unwrap();
            let mut forces = Vec::new();
            for _ in 0..(0.8 / h) as u32 {
                let report = world.step(&world.input(), &mut ());
                assert!(!report.fell_back && !report.non_finite, "{report:?}");
                let all = world.contacts().iter().map(|c| c.force_W.y.abs());
                forces.push(all.sum::<f64>());
            }
            let case = format!("soft {soft}, h {h}");
            let last = forces.len() - 1;
            if soft {
                // Young's modulus times 10 % of strain on 4 cm², confined by friction, on two
                // sides.
                assert!(forces[last] > 2.0 && forces[last] < 10.0, "{case}: {} N", forces[last]);
                let change = forces[last] / forces[last / 2] - 1.0;
                assert!(change.abs() < 0.05, "{case}: {forces:?}");
                assert!(world.node_velocities(0).iter().all(|v| v.norm() < 1e-3), "{case}");
            } else {
                assert!(forces.iter().all(|f| *f < 1e-3), "{case}: {forces:?}");
                let y = world.rigid_pose(2).position.y;
                assert!(y.abs() < 4.01e-4, "{case}: {y} m off the middle");
            }
        }
    }
}

/// A rod on a hinge about z with this range, at zero angle.
fn hinged_rod(h: f64, limit: AngleLimit) -> World {
    let mut desc = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
    let rod = desc.add_rigid(body("rod", 0.02, [1e-7, 2.7e-6, 2.7e-6], Vec3::x() * 0.02));
    let to_z = Quat::from_axis_angle(&Vec3::y_axis(), -std::f64::consts::FRAC_PI_2);
    desc.joints.push(JointDesc {
        name: "hinge".into(),
        kind: JointKind::Hinge,
        parent: None,
        child: rod,
        pose_PJ: Pose::new(Vec3::zeros(), to_z),
        pose_CK: Pose::new(Vec3::x() * -0.02, to_z),
        axes: [Axis { limit: Some(limit), ..Axis::default() }; 2],
        limit_stiffness: 10.0,
        limit_damping: 0.01,
    });
    World::new(desc).unwrap()
}

/// At a lever of 50 mm a joint turns back as fast as an overlap goes, no faster, and keeps nothing
/// of it.
#[test]
fn a_joint_past_its_bound_turns_back_without_a_rate() {
    for (h, past) in STEPS.into_iter().flat_map(|h| [(h, 0.05), (h, 0.15)]) {
        let mut world = hinged_rod(h, AngleLimit { min: past, max: 1.0 });
        let mut before = 0.0;
        for _ in 0..(0.5 / h) as u32 {
            is_sound(&mut world);
            let rate = world.joint_rates(0)[0].abs();
            assert!(rate < 1e-4, "h {h}: {rate} rad/s");
            let angle = world.joint_angles(0)[0];
            let turning = (angle - std::mem::replace(&mut before, angle)) / h;
            assert!(turning < 1.001 * SPEED / 0.05, "h {h}: turned back at {turning} rad/s");
        }
        let angle = world.joint_angles(0)[0];
        assert!((angle - past).abs() < 1e-4, "h {h}: {angle} rad");
        assert!(world.rigid_velocity(0)[0].norm() < 1e-5);
    }
}

/// A tilted box with its lowest corners in the ground: all three solvers move it alike.
#[test]
fn all_solvers_push_out_alike() {
    let tilt = Quat::from_euler_angles(0.02, 0.0, 0.03);
    let run = |kind| {
        let gravity = Vec3::zeros();
        let mut desc = WorldDesc { time_step: 1e-3, gravity, ..WorldDesc::default() };
        desc.solver.kind = kind;
        desc.solver.contact_tolerance = 1e-8;
        desc.solver.contact_sweeps_max = 2000;
        desc.solver.velocity_tolerance = 1e-7;
        plane(&mut desc, "ground", Pose::identity());
        let b = cuboid(&mut desc, Vec3::repeat(0.02), 0.1, Pose::new(Vec3::y() * 0.02, tilt));
        let mut world = World::new(desc).unwrap();
        for _ in 0..5 {
            world.step(&world.input(), &mut ());
        }
        (world.rigid_pose(b), world.rigid_velocity(b))
    };
    let (want, v) = run(SolverKind::DenseReference);
    for kind in [SolverKind::Monolithic, SolverKind::TwoStep] {
        let (pose, [linear, _]) = run(kind);
        let off = (pose.position - want.position).norm();
        assert!(off < 1e-8, "{kind:?}: {off} m of {}", pose.position.y - 0.02);
        assert!(pose.rotation.angle_to(&want.rotation) < 1e-6, "{kind:?}");
        assert!((linear - v[0]).norm() < 1e-5, "{kind:?}: {linear} {}", v[0]);
    }
    let corner = |pose: &Pose| pose.point(&Vec3::new(-0.02, -0.02, -0.02)).y;
    let corners = [corner(&Pose::new(Vec3::y() * 0.02, tilt)), corner(&want)];
    assert!(corners[0] < -1e-4 && corners[1] > corners[0] + 2e-5, "pushed up: {corners:?} m");
}

/// What a step remembers of the one before is of its length: a box at rest needs no sweep more when
/// steps become ten times as long, and torques of limits are what they were.
#[test]
fn remembered_impulses_follow_the_time_step() {
    let mut desc = WorldDesc { time_step: 1e-3, ..WorldDesc::default() };
    plane(&mut desc, "ground", Pose::identity());
    cuboid(&mut desc, Vec3::repeat(0.02), 0.1, Pose::translation(0.0, 0.02, 0.0));
    let mut world = World::new(desc).unwrap();
    for _ in 0..200 {
        is_sound(&mut world);
    }
    let carried =
        |world: &World| world.state().impulses.iter().map(|(_, i)| i.y.abs()).sum::<f64>();
    for h in [1e-2, 5e-4] {
        world.set_time_step(h);
        let want = 0.1 * 9.81 * h;
        assert!((carried(&world) / want - 1.0).abs() < 1e-3, "{} N s", carried(&world));
        let report = world.step(&world.input(), &mut ());
        assert!(report.contact_sweeps <= 1, "{report:?}");
        let bears = |c: &&thenar_core::world::ContactPoint| c.bodies.contains(&BodyId::Rigid(1));
        let force: f64 = world.contacts().iter().filter(bears).map(|c| c.force_W.y.abs()).sum();
        assert!((force / 0.981 - 1.0).abs() < 1e-2, "{force} N");
    }
}
