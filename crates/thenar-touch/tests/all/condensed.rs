//! Goal: the condensed response that a world publishes is how its bones and contacts really answer.
//! Method: a soft finger comes to rest, free and pressed on a floor; a proxy target is moved a
//! little, and the world is stepped to rest again: what it does is compared with what the frame
//! says that it would.

use crate::common::{body, finger};
use thenar_core::math::rotation_vector;
use thenar_core::model::{AngleLimit, Drive, Motion, SolverKind};
use thenar_core::shape::Shape;
use thenar_core::world::Input;
use thenar_core::{Pose, Quat, Vec3, World};
use thenar_touch::shared::SharedConstraints;
use thenar_touch::{BoneFrame, RigidState};

const DRIVE: Drive =
    Drive { stiffness: 400.0, damping: 1.0, angular_stiffness: 0.16, angular_damping: 4e-4 };
const CONTACTS: usize = 64;

/// A finger of two bones (bodies 0 and 1) over a floor; no weight.
struct Bench {
    world: World,
    input: Input,
}

impl Bench {
    fn new(floor: f64) -> Self {
        Self::with(floor, None)
    }

    fn with(floor: f64, limit: Option<AngleLimit>) -> Self {
        let mut desc = finger(1e8, 1.0 / 60.0);
        desc.gravity = Vec3::zeros();
        desc.joints[0].axes[0].limit = limit.or(desc.joints[0].axes[0].limit);
        let mut ground = body("floor", 1.0, [1.0; 3], Vec3::y() * floor);
        ground.motion = Motion::Prescribed;
        ground.shape = Some(Shape::HalfSpace);
        desc.add_rigid(ground);
        desc.drives[0] = Some(DRIVE);
        desc.drives[1] = Some(DRIVE);
        let world = World::new(desc).unwrap();
        let mut input = world.input();
        for b in 0..2 {
            input.targets[b] = Some(RigidState::at_rest(world.rigid_pose(b as u32)).target());
        }
        Self { world, input }
    }

    fn shift(&mut self, bone: usize, by: Vec3, turn: Vec3) {
        let pose = &mut self.input.targets[bone].as_mut().unwrap().pose_WB;
        pose.position += by;
        pose.rotation = Quat::from_scaled_axis(turn) * pose.rotation;
    }

    /// Until nothing moves any more.
    fn settle(&mut self) {
        for _ in 0..400 {
            assert!(!self.world.step(&self.input, &mut ()).non_finite);
        }
        let fastest = self.world.state().v.iter().map(|v| v.norm()).fold(0.0, f64::max);
        assert!(fastest < 2e-5, "{fastest} m/s");
    }

    fn frame(&mut self) -> BoneFrame {
        let start = [RigidState::at_rest(Pose::identity()); 2];
        let mut frame = BoneFrame::new(&start, CONTACTS);
        assert!(self.world.condense(0..2, &self.input, &mut frame));
        frame
    }

    fn poses(&self) -> [Pose; 2] {
        [0, 1].map(|b| self.world.rigid_pose(b))
    }

    fn targets(&self) -> [RigidState; 2] {
        [0, 1].map(|b| RigidState::at_rest(self.input.targets[b].unwrap().pose_WB))
    }

    /// Total force of the floor on the finger \[N\].
    fn floor_force(&self) -> Vec3 {
        self.world.contacts().iter().map(|contact| contact.force_W).sum()
    }
}

/// The frame's bones, resolved for other proxies; and the total contact force.
fn resolved(frame: &BoneFrame, proxies: &[RigidState]) -> ([Pose; 2], Vec3, u32) {
    let mut shared = SharedConstraints::new(2, CONTACTS);
    shared.begin(&frame.response);
    let report = shared.resolve(&frame.response, proxies, 1e-3, 1e-9, 20_000);
    assert!(report.residual <= 1e-9, "{report:?}");
    let forces = shared.forces().iter().zip(&frame.response.contacts);
    let total = forces.map(|(f, contact)| contact.frame.tr_mul(f)).sum();
    let mut bones = frame.bones.clone();
    shared.place(&frame.bones, &mut bones);
    ([0, 1].map(|b| bones[b].pose_WB), total, report.active)
}

/// Movement of two poses \[m, rad\].
fn movement(from: &[Pose; 2], to: &[Pose; 2]) -> [[Vec3; 2]; 2] {
    [0, 1].map(|b| {
        let turn = to[b].rotation * from[b].rotation.inverse();
        [to[b].position - from[b].position, rotation_vector(&turn)]
    })
}

/// Largest difference, rotations at a lever of 2 cm \[m\].
fn difference(a: &[[Vec3; 2]; 2], b: &[[Vec3; 2]; 2]) -> f64 {
    let parts = a.iter().flatten().zip(b.iter().flatten()).enumerate();
    parts
        .map(|(i, (a, b))| (a - b).norm() * if i % 2 == 1 { 0.02 } else { 1.0 })
        .fold(0.0, f64::max)
}

/// Each target along and about each axis.
#[test]
fn free_bones_answer_as_their_frame_says() {
    let mut bench = Bench::new(-1.0);
    bench.shift(1, Vec3::y() * 0.004, Vec3::z() * 0.2);
    bench.settle();
    let frame = bench.frame();
    assert!(frame.response.contacts.is_empty());
    let start = bench.world.state().clone();
    for bone in 0..2 {
        for axis in 0..6 {
            let unit = Vec3::ith(axis % 3, 1.0);
            let (by, turn) =
                if axis < 3 { (unit * 1e-4, Vec3::zeros()) } else { (Vec3::zeros(), unit * 5e-3) };
            bench.world.restore(&start);
            bench.shift(bone, by, turn);
            bench.settle();
            let really = movement(&[0, 1].map(|b| frame.bones[b].pose_WB), &bench.poses());
            let (said, _, _) = resolved(&frame, &bench.targets());
            let said = movement(&[0, 1].map(|b| frame.bones[b].pose_WB), &said);
            let size = difference(&really, &[[Vec3::zeros(); 2]; 2]);
            let error = difference(&really, &said);
            assert!(
                size > 1e-5 && error < 0.03 * size,
                "bone {bone} axis {axis}: {error} of {size} m"
            );
            bench.shift(bone, -by, -turn);
        }
    }
}

/// Pressed on the floor: deeper, along, back; the flesh yields and the floor does not.
#[test]
fn pressed_bones_and_contacts_answer_as_their_frame_says() {
    let mut bench = Bench::new(0.0);
    bench.shift(0, Vec3::y() * -0.003, Vec3::zeros());
    bench.shift(1, Vec3::y() * -0.003, Vec3::zeros());
    bench.settle();
    let frame = bench.frame();
    let pressed = bench.floor_force();
    assert!((1.0..2.4).contains(&pressed.y), "3 mm on two springs of 400 N/m and flesh: {pressed}");
    // Unmoved proxies: the frame itself.
    let (same, force, _) = resolved(&frame, &bench.targets());
    let bones = [0, 1].map(|b| frame.bones[b].pose_WB);
    assert!(difference(&movement(&bones, &same), &[[Vec3::zeros(); 2]; 2]) < 1e-9);
    assert!((force - pressed).norm() < 1e-6, "{force} {pressed}");

    let start = bench.world.state().clone();
    let ways = [[0.0, -2e-4, 0.0], [0.0, 2e-4, 0.0], [2e-4, 0.0, 0.0], [0.0, -1e-4, 2e-4]];
    for by in ways.map(Vec3::from) {
        bench.world.restore(&start);
        (0..2).for_each(|b| bench.shift(b, by, Vec3::zeros()));
        bench.settle();
        let (said, force, active) = resolved(&frame, &bench.targets());
        let really = movement(&bones, &bench.poses());
        let error = difference(&really, &movement(&bones, &said));
        let (change, told) = (bench.floor_force() - pressed, force - pressed);
        println!(
            "{by:?}: bones move {really:?}, error {:.2} um; force changes by {change:?}, said {told:?}, {active} active",
            1e6 * error
        );
        assert!((change - told).norm() < 0.01 * change.norm(), "{by}: {change} {told}");
        assert!(error < 0.01 * by.norm(), "{by}: {error} m");
        (0..2).for_each(|b| bench.shift(b, -by, Vec3::zeros()));
    }
}

/// A joint at its bound: the finger turns as one piece, until the wearer goes back.
#[test]
fn a_joint_at_its_limit_holds_in_between_too() {
    let mut bench = Bench::with(-1.0, Some(AngleLimit { min: -0.1, max: 0.1 }));
    bench.shift(1, Vec3::zeros(), Vec3::z() * 0.6);
    bench.settle();
    assert!((bench.world.joint_angles(0)[0] - 0.1).abs() < 1e-4);
    let frame = bench.frame();
    let bones = [0, 1].map(|b| frame.bones[b].pose_WB);
    let start = bench.world.state().clone();
    for turn in [0.02, -0.02] {
        bench.world.restore(&start);
        bench.shift(1, Vec3::zeros(), Vec3::z() * turn);
        bench.settle();
        let really = movement(&bones, &bench.poses());
        let (said, ..) = resolved(&frame, &bench.targets());
        let said = movement(&bones, &said);
        assert!((really[0][1].z - really[1][1].z).abs() < 1e-4, "the joint stays at its bound");
        assert!((said[0][1].z - said[1][1].z).abs() < 1e-6, "{said:?}");
        assert!(really[1][1].z.abs() > 0.002);
        assert!(difference(&really, &said) < 0.03 * difference(&really, &[[Vec3::zeros(); 2]; 2]));
        bench.shift(1, Vec3::zeros(), Vec3::z() * -turn);
    }
    // Far back: the joint leaves its bound, as in the world, and further arrives at the other.
    let turned = |poses: &[Pose; 2]| {
        let [a, b] = movement(&bones, poses).map(|part| part[1].z);
        b - a
    };
    for (turn, range, bearing) in [(-0.6, -0.15..-0.05, 0), (-1.2, -0.2001..-0.1999, 1)] {
        bench.world.restore(&start);
        bench.shift(1, Vec3::zeros(), Vec3::z() * turn);
        bench.settle();
        let (said, _, active) = resolved(&frame, &bench.targets());
        let (said, really) = (turned(&said), turned(&bench.poses()));
        assert!(range.contains(&really) && active == bearing, "{really} rad, {active} active");
        assert!((said / really - 1.0).abs() < 0.1, "{said} {really} rad");
        bench.shift(1, Vec3::zeros(), Vec3::z() * -turn);
    }
    // Of another state nothing is known before its first step.
    assert!(!bench.frame().response.contacts.is_empty());
    bench.world.restore(&start);
    assert!(bench.frame().response.contacts.is_empty(), "a limit of the state before");
}

/// What the step does is the same bits with and without frames in between.
#[test]
fn writing_targets_changes_nothing() {
    let hash = |publishes: bool| {
        let mut bench = Bench::new(0.0);
        bench.shift(1, Vec3::new(1e-3, -0.004, 0.0), Vec3::z() * 0.3);
        for _ in 0..30 {
            bench.world.step(&bench.input, &mut ());
            if publishes {
                let before = bench.world.state_hash();
                assert!(!bench.frame().response.contacts.is_empty());
                assert_eq!(bench.world.state_hash(), before);
            }
        }
        bench.world.state_hash()
    };
    assert_eq!(hash(true), hash(false));
}

/// Only the monolithic solver has the response; with another one, or for other bones, there is
/// none, and the bones are told all the same.
#[test]
fn without_the_monolithic_solver_there_is_no_response() {
    let mut bench = Bench::new(0.0);
    bench.world.step(&bench.input, &mut ());
    let mut frame = bench.frame();
    assert!(frame.response.is_ready());
    bench.world.set_solver(SolverKind::TwoStep);
    bench.shift(1, Vec3::y() * 0.01, Vec3::zeros());
    bench.world.step(&bench.input, &mut ());
    assert!(!bench.world.condense(0..2, &bench.input, &mut frame));
    assert!(!frame.response.is_ready());
    assert_eq!(frame.bones[1], RigidState::of(&bench.world, 1));
    bench.world.set_solver(SolverKind::Monolithic);
    assert!(bench.world.condense(0..2, &bench.input, &mut frame));
    assert!(!bench.world.condense(0..1, &bench.input, &mut frame), "frame for two bones");
    assert!(!frame.response.is_ready());
    // A tracker's bad sample lets go of its bone: nothing pulls there, and the rest answers.
    bench.input.targets[1].as_mut().unwrap().pose_WB.position.x = f64::NAN;
    bench.world.step(&bench.input, &mut ());
    assert!(bench.world.condense(0..2, &bench.input, &mut frame));
    assert_eq!(frame.response.springs[1].stiffness, 0.0);
}

/// A frame from a hand that has only begun to follow its proxies says where it will come to rest.
#[test]
fn a_frame_in_motion_says_where_it_comes_to_rest() {
    let free = (-1.0, Vec3::new(0.002, 0.001, 0.0), Vec3::z() * 0.05);
    let pressed = (0.0, Vec3::new(0.0, -0.003, 0.0), Vec3::zeros());
    for (floor, by, turn) in [free, pressed] {
        let mut bench = Bench::new(floor);
        bench.settle();
        (0..2).for_each(|b| bench.shift(b, by, turn * b as f64));
        // Under way: the target's own velocity is no place to come to rest in.
        for target in bench.input.targets[..2].iter_mut().flatten() {
            target.velocity_W = by / 0.1;
        }
        bench.world.step(&bench.input, &mut ());
        let frame = bench.frame();
        bench.input.targets[..2].iter_mut().flatten().for_each(|t| t.velocity_W = Vec3::zeros());
        let bones = [0, 1].map(|b| frame.bones[b].pose_WB);
        let under_way = bench.floor_force();
        let (said, force, _) = resolved(&frame, &bench.targets());
        bench.settle();
        let really = movement(&bones, &bench.poses());
        let size = difference(&really, &[[Vec3::zeros(); 2]; 2]);
        let error = difference(&really, &movement(&bones, &said));
        let (there, changed) = (bench.floor_force(), (bench.floor_force() - under_way).norm());
        println!(
            "{size} m to go, error {error} m; {under_way:?} N to {there:?} N, said {force:?} N"
        );
        assert!(size > 5e-5 && error < 0.02 * size, "{by}: {error} of {size} m");
        assert!((force - there).norm() <= 0.05 * changed, "{by}: {force} of {there} N");
        assert!(floor < 0.0 || changed > 0.02, "{changed} N");
    }
}
