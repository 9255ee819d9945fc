//! Goal: the condensed response knows what a hand holds: free objects, soft ones, another hand.
//! Method: bones so light that a step of the world moves them as if they came to rest; the frame's
//! prediction for a moved proxy against the full step of the world, and against closed forms.

use crate::common::{bar, body, boundary};
use thenar_core::math::rotation_vector;
use thenar_core::model::{Drive, FixedNode, Law, Material, Motion, SoftDesc, WorldDesc};
use thenar_core::shape::Shape;
use thenar_core::world::Input;
use thenar_core::{Pose, Vec3, World};
use thenar_touch::shared::SharedConstraints;
use thenar_touch::{BoneFrame, RigidState};

/// Time step \[s\].
const STEP: f64 = 1.0 / 60.0;
/// Coupling of a bone \[N/m\].
const STIFFNESS: f64 = 400.0;
/// Radius of a bone, a ball \[m\].
const RADIUS: f64 = 0.008;
const CONTACTS: usize = 64;

fn world_desc() -> WorldDesc {
    WorldDesc { time_step: STEP, gravity: Vec3::zeros(), ..WorldDesc::default() }
}

/// A bone without damping. Its inertia adds m/h² = 0.04 N/m to its coupling: a part in ten
/// thousand.
fn add_bone(desc: &mut WorldDesc, name: &str, position: Vec3) -> u32 {
    let mut bone = body(name, 1e-5, [3e-10; 3], position);
    bone.shape = Some(Shape::Sphere { radius: RADIUS });
    bone.friction = 0.0;
    let bone = desc.add_rigid(bone);
    desc.drives[bone as usize] = Some(Drive {
        stiffness: STIFFNESS,
        damping: 0.0,
        angular_stiffness: 0.16,
        angular_damping: 0.0,
    });
    bone
}

struct Bench {
    world: World,
    input: Input,
}

impl Bench {
    /// Bones 0 to `bones` want to stay where they are.
    fn new(desc: WorldDesc, bones: u32) -> Self {
        let world = World::new(desc).unwrap();
        let mut input = world.input();
        for b in 0..bones {
            input.targets[b as usize] = Some(RigidState::at_rest(world.rigid_pose(b)).target());
        }
        Self { world, input }
    }

    fn target(&mut self, bone: usize) -> &mut Pose {
        &mut self.input.targets[bone].as_mut().unwrap().pose_WB
    }

    fn step(&mut self) {
        assert!(!self.world.step(&self.input, &mut ()).non_finite);
    }

    /// Force of all that touches a body, on it \[N\].
    fn force_on(&self, bone: u32) -> Vec3 {
        let each = self.world.contacts().iter().map(|contact| {
            let [a, b] = contact.bodies.map(|body| body == thenar_core::model::BodyId::Rigid(bone));
            contact.force_W * (f64::from(u8::from(a)) - f64::from(u8::from(b)))
        });
        each.sum()
    }

    fn frame(&mut self, bone: u32) -> BoneFrame {
        let start = [RigidState::at_rest(Pose::identity())];
        let mut frame = BoneFrame::new(&start, CONTACTS);
        assert!(self.world.condense(bone..bone + 1, &self.input, &mut frame));
        frame
    }
}

/// What a frame says of its bone, and of the force on it, when its proxy has moved by `by`.
fn said(frame: &BoneFrame, by: Vec3) -> (Vec3, Vec3) {
    let mut shared = SharedConstraints::new(1, CONTACTS);
    shared.begin(&frame.response);
    let mut proxy = frame.response.targets[0];
    proxy.pose_WB.position += by;
    let report = shared.resolve(&frame.response, &[proxy], 1e-3, 1e-10, 100_000);
    assert!(report.residual <= 1e-10, "{report:?}");
    let mut bones = frame.bones.clone();
    shared.place(&frame.bones, &mut bones);
    let bone = bones[0].pose_WB;
    assert!(rotation_vector(&bone.rotation).norm() < 0.05);
    let spring = frame.response.springs[0].stiffness;
    // Quasi-static: what the coupling pulls less than in the frame, the contacts push more.
    let moved = bone.position - frame.bones[0].pose_WB.position;
    (moved, (moved - by) * spring)
}

/// Pushed by δ a free ball of mass M answers over one step h: f = δ / (1/k + h²/M).
#[test]
fn a_free_object_has_its_inertia_over_a_step() {
    for mass in [0.02, 0.2, 5.0] {
        let mut desc = world_desc();
        add_bone(&mut desc, "bone", Vec3::zeros());
        let mut ball = body("ball", mass, [0.4 * mass * 1e-4; 3], Vec3::x() * (RADIUS + 0.01));
        ball.shape = Some(Shape::Sphere { radius: 0.01 });
        ball.friction = 0.0;
        desc.add_rigid(ball);
        let mut bench = Bench::new(desc, 1);
        bench.step();
        let frame = bench.frame(0);
        let by = Vec3::x() * 5e-4;
        let (moved, force) = said(&frame, by);
        let want = by.x / (1.0 / STIFFNESS + STEP * STEP / mass);
        assert!((force.x / -want - 1.0).abs() < 2e-3, "{mass} kg: {force} N, {want} N");
        assert!((moved.x - (by.x - want / STIFFNESS)).abs() < 2e-3 * by.x, "{mass} kg: {moved}");
        // And so does the world.
        bench.target(0).position += by;
        bench.step();
        let really = bench.force_on(0);
        assert!((force - really).norm() < 5e-3 * want, "{mass} kg: {force} N, really {really} N");
        // Away from it nothing pulls.
        let (moved, force) = said(&frame, -by);
        assert!(force.norm() < 1e-6 && (moved + by).norm() < 1e-8, "{moved} {force}");
    }
}

/// A box between the bones of two hands: each feels it with the other hand behind it,
/// f = δ / (1/k + 1/(M/h² + k')).
#[test]
fn two_hands_feel_each_other_through_what_they_hold() {
    let (mass, half) = (0.15, 0.02);
    for other in [100.0, 400.0, 2000.0] {
        let mut desc = world_desc();
        let reach = half + RADIUS;
        add_bone(&mut desc, "left", Vec3::x() * -reach);
        add_bone(&mut desc, "right", Vec3::x() * reach);
        desc.drives[1].as_mut().unwrap().stiffness = other;
        let mut held = body("box", mass, [4e-5; 3], Vec3::zeros());
        held.shape = Some(Shape::Cuboid { half: Vec3::repeat(half) });
        held.friction = 0.0;
        desc.add_rigid(held);
        let mut bench = Bench::new(desc, 2);
        // Squeezed by 1 mm from both sides, until it rests.
        bench.target(0).position.x += 1e-3;
        bench.target(1).position.x -= 1e-3 * STIFFNESS / other;
        (0..200).for_each(|_| bench.step());
        let squeeze = 1e-3 * STIFFNESS;
        let [left, right] = [0, 1].map(|b| bench.force_on(b).x);
        assert!((left + squeeze).abs() < 1e-3 && (right - squeeze).abs() < 1e-3, "{left} {right}");

        let start = bench.world.state().clone();
        for (hand, own, behind) in [(0, STIFFNESS, other), (1, other, STIFFNESS)] {
            for way in [2e-4, -2e-4] {
                let by = Vec3::x() * way;
                let frame = bench.frame(hand);
                let (_, force) = said(&frame, by);
                let want = -way / (1.0 / own + 1.0 / (mass / (STEP * STEP) + behind));
                assert!(
                    (force.x / want - 1.0).abs() < 5e-3,
                    "{other} N/m, hand {hand}: {force} N, {want} N"
                );
                bench.target(hand as usize).position += by;
                bench.step();
                let pressed = [left, right][hand as usize];
                let really = bench.force_on(hand).x - pressed;
                assert!(
                    (force.x - really).abs() < 0.01 * want.abs(),
                    "{force} N, really {really} N"
                );
                bench.target(hand as usize).position -= by;
                // Back to rest; a restored world knows no forces before its next step.
                bench.world.restore(&start);
                (0..3).for_each(|_| bench.step());
            }
        }
    }
}

/// Bread: soft, with its own inertia over a step, pressed into by 3 mm and then by a little more,
/// less, and along. The whole step of the world is the reference.
#[test]
fn soft_objects_answer_as_their_step_does() {
    let crumb = Material { law: Law::Corotational, young: 2e4, poisson: 0.2, density: 250.0 };
    let size = Vec3::new(0.06, 0.04, 0.06);
    let mut loaf = bar(size, [4, 3, 4], crumb);
    loaf.collision = boundary(&loaf.tets);
    let low = loaf.nodes.iter().enumerate().filter(|(_, x)| x.y < 1e-9);
    loaf.fixed = low.map(|(n, _)| FixedNode { node: n as u32, axes: [true; 3] }).collect();
    loaf.friction = 0.5;
    let mut desc = world_desc();
    let bone = add_bone(&mut desc, "bone", Vec3::new(0.03, size.y + RADIUS, 0.03));
    desc.rigids[bone as usize].friction = 0.5;
    desc.add_soft(SoftDesc {
        name: "bread".into(),
        flesh: loaf,
        pose_WM: Pose::identity(),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    let mut bench = Bench::new(desc, 1);
    // Slowly in, and to rest.
    for _ in 0..60 {
        bench.target(0).position.y -= 5e-5;
        bench.step();
    }
    (0..600).for_each(|_| bench.step());
    let rest = bench.force_on(0);
    assert!((0.2..1.1).contains(&rest.y), "3 mm through 400 N/m and crumb: {rest} N");
    let start = bench.world.state().clone();
    for way in [[0.0, -1e-4, 0.0], [0.0, 1e-4, 0.0], [4e-5, 0.0, 0.0], [2e-5, -1e-4, 1e-5]] {
        let by = Vec3::from(way);
        bench.world.restore(&start);
        bench.step();
        let frame = bench.frame(0);
        let before = (bench.world.rigid_pose(0).position, bench.force_on(0));
        let (moved, force) = said(&frame, by);
        bench.target(0).position += by;
        bench.step();
        let really = bench.world.rigid_pose(0).position - before.0;
        let change = bench.force_on(0) - before.1;
        let context =
            format!("{by:?}: moves {moved:?}, really {really:?}; {force:?} N, really {change:?} N");
        assert!((moved - really).norm() < 0.05 * by.norm(), "{context}");
        assert!((force - change).norm() < 0.05 * STIFFNESS * by.norm(), "{context}");
        assert!(change.norm() > 0.1 * STIFFNESS * by.norm(), "{context}");
        bench.target(0).position -= by;
    }
}

/// A fixed table under the object: nothing yields but the coupling.
#[test]
fn an_object_on_a_table_is_as_hard_as_the_table() {
    let mut desc = world_desc();
    add_bone(&mut desc, "bone", Vec3::y() * (0.02 + RADIUS));
    let mut table = body("table", 1.0, [1.0; 3], Vec3::zeros());
    table.motion = Motion::Prescribed;
    table.shape = Some(Shape::HalfSpace);
    let mut ball = body("ball", 0.1, [4e-6; 3], Vec3::y() * 0.01);
    ball.shape = Some(Shape::Sphere { radius: 0.01 });
    desc.add_rigid(table);
    desc.add_rigid(ball);
    let mut bench = Bench::new(desc, 1);
    bench.target(0).position.y -= 0.002;
    (0..100).for_each(|_| bench.step());
    let pressed = bench.force_on(0).y;
    assert!((pressed - 0.002 * STIFFNESS).abs() < 1e-3, "{pressed} N");
    let frame = bench.frame(0);
    for way in [5e-4, -5e-4] {
        let (moved, force) = said(&frame, Vec3::y() * way);
        assert!((force.y / (-STIFFNESS * way) - 1.0).abs() < 1e-3, "{force} N");
        assert!(moved.norm() < 1e-3 * 5e-4, "{moved} m");
    }
    // Lifted by more than it was pressed it lets go.
    let (moved, force) = said(&frame, Vec3::y() * 0.005);
    assert!((force.y + pressed).abs() < 1e-3 && (moved.y - 0.003).abs() < 1e-5, "{force} {moved}");
}
