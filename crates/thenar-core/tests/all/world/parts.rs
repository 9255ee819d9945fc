//! Goal: a step that contact does not carry through is made in parts, as steps of their lengths
//! would be. Method: a rod that falls on one end and slaps with the other, against a closed form;
//! the same halves made as steps of their own, bit by bit; scenes where nothing is to be divided.

use crate::common::body;
use thenar_core::condensed::{BoneFrame, RigidState};
use thenar_core::model::{Drive, Motion, SolverKind, WorldDesc};
use thenar_core::shape::Shape;
use thenar_core::world::{Input, Target};
use thenar_core::{Pose, Quat, Vec3, World};

const STEP: f64 = 1.0 / 60.0;
/// Half the rod, and its radius \[m\].
const HALF: f64 = 0.1;
const RADIUS: f64 = 1e-3;
/// How fast it falls \[m/s\].
const SPEED: f64 = 2.0;
/// By so much the right plate is lower: more than a fall of one step \[m\].
const LOWER: f64 = 0.036;

/// A plate that stays, with its upper face at `top`.
fn plate(desc: &mut WorldDesc, x: f64, top: f64) {
    let mut plate = body("plate", 1.0, [1.0; 3], Vec3::new(x, top - 0.01, 0.0));
    plate.motion = Motion::Prescribed;
    plate.shape = Some(Shape::Cuboid { half: Vec3::new(0.05, 0.01, 0.05) });
    desc.add_rigid(plate);
}

/// A thin level rod that falls on a plate with its left end, `gap` below it; by `lower` deeper is a
/// plate below its right end.
fn rod([gap, lower]: [f64; 2], halvings: u32, kind: SolverKind) -> (World, Input) {
    let mut desc = WorldDesc { time_step: STEP, gravity: Vec3::zeros(), ..WorldDesc::default() };
    desc.solver.step_halvings_max = halvings;
    desc.solver.kind = kind;
    plate(&mut desc, -HALF, 0.0);
    plate(&mut desc, HALF, -lower);
    let mass = 0.1;
    let thin = mass * HALF * HALF / 3.0;
    let mut rod = body("rod", mass, [1e-3 * thin, thin, thin], Vec3::y() * (RADIUS + gap));
    // A capsule lies along y of its frame, and here along x of its body.
    let along = Quat::from_scaled_axis(Vec3::z() * -std::f64::consts::FRAC_PI_2);
    rod.pose_BS = Pose::new(Vec3::zeros(), along);
    rod.shape = Some(Shape::Capsule { radius: RADIUS, half_length: HALF });
    rod.velocity_W = -Vec3::y() * SPEED;
    rod.friction = 0.0;
    desc.add_rigid(rod);
    let world = World::new(desc).unwrap();
    let input = world.input();
    (world, input)
}

/// How deep the rod's ends are in their plates \[m\].
fn depth(world: &World, lower: f64) -> f64 {
    let pose = world.rigid_pose(2);
    let [left, right] = [-HALF, HALF].map(|x| pose.point(&(Vec3::x() * x)));
    let above = |end: &Vec3, x: f64| (end.x - x).abs() < 0.05;
    let left = if above(&left, -HALF) { RADIUS - left.y } else { 0.0 };
    let right = if above(&right, HALF) { RADIUS - lower - right.y } else { 0.0 };
    left.max(right)
}

/// A thin rod of half length l that is stopped at a distance a from its middle turns, so that its
/// other end goes on at `v (1 + (3 a/l - 1) / (1 + 3 a²/l²))`: with the edge of a plate at l/2, 9/7
/// of its speed, too fast for a step that did not see it coming.
#[test]
fn an_end_that_slaps_is_seen_coming() {
    for kind in [SolverKind::Monolithic, SolverKind::DenseReference, SolverKind::TwoStep] {
        let (mut deepest, mut divided) = ([0.0_f64; 3], [0; 3]);
        for (i, halvings) in [0, 1, 3].into_iter().enumerate() {
            for tenth in 0..10 {
                let (mut world, input) = rod([1e-3 * f64::from(tenth), LOWER], halvings, kind);
                for _ in 0..12 {
                    let report = world.step(&input, &mut ());
                    assert!(report.parts <= 1 << halvings, "{kind:?}: {report:?}");
                    divided[i] += u32::from(report.parts > 1);
                    deepest[i] = deepest[i].max(depth(&world, LOWER));
                }
            }
        }
        // To first order in the turn, which is of a sixth.
        let unseen = 9.0 / 7.0 * SPEED * STEP - LOWER;
        assert!(deepest[0] > 0.85 * unseen && deepest[0] < unseen, "{kind:?}: {deepest:?} m");
        assert!(deepest[1] <= 0.5e-3, "{kind:?}: {deepest:?} m");
        assert!(deepest[2] <= 0.5e-3, "{kind:?}: {deepest:?} m");
        assert_eq!(divided[0], 0, "{kind:?}");
        let few = |divided: u32| (1..=20).contains(&divided);
        assert!(divided[1..].iter().all(|&n| few(n)), "{kind:?}: {divided:?} of 120 steps");
    }
}

/// Where the end slaps in the second half of the step, neither the step nor this half sees it
/// coming; the last halving looks once more, as far as the end went.
#[test]
fn the_shortest_part_looks_again() {
    let places = [0.020, 0.0155];
    let travel = |h: f64, gap: f64| SPEED * h + 2.0 / 7.0 * (SPEED * h - gap);
    let in_half = places[0] - 0.5 * SPEED * STEP;
    for (h, gap) in [(STEP, places[0]), (0.5 * STEP, in_half)] {
        let way = gap + places[1];
        assert!(SPEED * h + 1e-3 < way && way + 0.5e-3 < travel(h, gap), "no case");
    }
    for kind in [SolverKind::Monolithic, SolverKind::DenseReference, SolverKind::TwoStep] {
        let (mut world, input) = rod(places, 1, kind);
        let report = world.step(&input, &mut ());
        assert_eq!(report.parts, 2, "{kind:?}");
        assert!(depth(&world, places[1]) < 0.5e-3, "{kind:?}: {} m", depth(&world, places[1]));
    }
}

/// A ball that a spring of 200 N/m leads at a constant speed, beside the rod that slaps.
fn driven(halvings: u32) -> (World, Input) {
    let (world, _) = rod([3e-3, LOWER], halvings, SolverKind::Monolithic);
    let mut desc = world.desc().clone();
    let mut ball = body("ball", 0.05, [1e-5; 3], Vec3::new(0.0, 0.3, 0.3));
    ball.shape = Some(Shape::Sphere { radius: 0.01 });
    let id = desc.add_rigid(ball);
    desc.drives[id as usize] = Some(Drive {
        stiffness: 200.0,
        damping: 0.4,
        angular_stiffness: 0.1,
        angular_damping: 1e-4,
    });
    let world = World::new(desc).unwrap();
    let input = world.input();
    (world, input)
}

/// Where the ball is led to at a time.
fn lead(input: &mut Input, t: f64) {
    let (velocity_W, angular_velocity_W) = (Vec3::new(0.4, 0.1, -0.2), Vec3::new(0.5, -1.0, 2.0));
    input.targets[3] = Some(Target {
        pose_WB: Pose::new(
            Vec3::new(0.0, 0.3, 0.3) + velocity_W * t,
            Quat::from_scaled_axis(angular_velocity_W * t),
        ),
        velocity_W,
        angular_velocity_W,
    });
}

/// A step in two parts is two steps of half its length, with drives led to where they are to be in
/// between.
#[test]
fn two_parts_are_two_steps() {
    let ([mut world, mut half], mut input) = ([driven(1).0, driven(0).0], driven(1).1);
    half.set_time_step(0.5 * STEP);
    let mut divided = 0;
    for step in 0..12 {
        let t = STEP * f64::from(step);
        lead(&mut input, t + STEP);
        let before = world.clone();
        let report = world.step(&input, &mut ());
        if report.parts == 1 {
            continue;
        }
        divided += 1;
        assert_eq!(report.parts, 2);
        // What contact remembers is of a whole step in the state that is taken over.
        half.set_time_step(STEP);
        assert!(half.restore(before.state()));
        half.set_time_step(0.5 * STEP);
        for k in 1..=2 {
            lead(&mut input, t + 0.5 * STEP * f64::from(k));
            half.step(&input, &mut ());
        }
        let [a, b] = [&world, &half].map(World::state);
        for (pose, other) in a.poses_WB.iter().zip(&b.poses_WB) {
            assert!((pose.position - other.position).norm() < 1e-12);
            assert!(pose.rotation.angle_to(&other.rotation) < 1e-9);
        }
        for (v, other) in a.v.iter().zip(&b.v) {
            assert!((v - other).norm() < 1e-9, "{v} {other}");
        }
        let forces =
            |world: &World| -> Vec<Vec3> { world.contacts().iter().map(|c| c.force_W).collect() };
        let [a, b] = [forces(&world), forces(&half)];
        assert_eq!(a.len(), b.len());
        a.iter().zip(&b).for_each(|(a, b)| assert!((a - b).norm() < 1e-6, "{a} {b}"));
    }
    assert!(divided > 0, "nothing was divided");
}

/// Touch is told the forces of the last part of a divided step.
#[test]
fn touch_is_told_forces_of_the_last_part() {
    let (mut world, input) = rod([3e-3, LOWER], 3, SolverKind::Monolithic);
    let start = [RigidState::at_rest(Pose::identity())];
    let (mut divided, mut pressed) = (0, 0);
    for _ in 0..12 {
        let report = world.step(&input, &mut ());
        if report.parts == 1 {
            continue;
        }
        divided += 1;
        let mut frame = BoneFrame::new(&start, 16);
        assert!(world.condense(2..3, &input, &mut frame));
        for contact in world.contacts().iter().filter(|c| c.force_W.norm() > 1e-6) {
            let told = frame.response.contacts.iter().map(|c| c.force.norm());
            let off = told.map(|force| (force - contact.force_W.norm()).abs());
            let off = off.fold(f64::INFINITY, f64::min);
            assert!(off < 1e-9 * contact.force_W.norm(), "{off} N of {}", contact.force_W.norm());
            pressed += 1;
        }
    }
    assert!(divided > 0 && pressed > 0, "{divided} divided, {pressed} pressing");
}

/// A step is one part where contact carries it: in free flight, at rest, and rolling at 1 m/s.
#[test]
fn ordinary_steps_are_whole() {
    for speed in [0.0, 1.0] {
        let mut desc = WorldDesc { time_step: STEP, ..WorldDesc::default() };
        let mut floor = body("floor", 1.0, [1.0; 3], Vec3::zeros());
        floor.motion = Motion::Prescribed;
        floor.shape = Some(Shape::HalfSpace);
        desc.add_rigid(floor);
        let mut ball = body("ball", 0.05, [2e-6; 3], Vec3::y() * 0.02);
        ball.shape = Some(Shape::Sphere { radius: 0.01 });
        ball.velocity_W = Vec3::x() * speed;
        desc.add_rigid(ball);
        let mut world = World::new(desc).unwrap();
        let input = world.input();
        for step in 0..120 {
            let report = world.step(&input, &mut ());
            assert_eq!(report.parts, 1, "{speed} m/s, step {step}");
        }
        assert!(world.contacts().iter().any(|c| c.force_W.norm() > 0.4));
    }
}

/// A setting beyond sense is refused.
#[test]
fn so_many_halvings_are_refused() {
    let mut desc = WorldDesc::default();
    desc.solver.step_halvings_max = 11;
    let error = World::new(desc).unwrap_err().to_string();
    assert!(error.contains("step_halvings_max") && error.contains("at most 10"), "{error}");
}
