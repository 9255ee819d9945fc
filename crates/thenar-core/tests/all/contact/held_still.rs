//! Goal: what is held still in a soft pad is pressed by a still force. Method: shapes narrower than
//! the pad's triangles, led 1 mm into it and held there without friction; the force of one step
//! against that of the next.

use crate::common::{bar, body};
use thenar_core::model::{FixedNode, Law, Material, Motion, PairRule, SoftDesc, WorldDesc};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Quat, Vec3, World};
use thenar_testing::one_in;

/// Steepest change of the force on the pad from step to step, in parts of it, once it is held.
fn flicker(shape: &Shape, lowest: f64, turn: Quat, h: f64) -> f64 {
    let mut desc = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
    let material = Material { young: 2e5, poisson: 0.3, density: 1000.0, law: Law::Corotational };
    let size = Vec3::new(0.06, 0.02, 0.04);
    let mut flesh = bar(size, [8, 3, 5], material);
    flesh.nodes.iter_mut().for_each(|x| *x -= Vec3::new(0.5 * size.x, size.y, 0.5 * size.z));
    let ground = |x: &Vec3| x.y < -size.y + 1e-9;
    let held = flesh.nodes.iter().enumerate().filter(|(_, x)| ground(x));
    flesh.fixed = held.map(|(i, _)| FixedNode { node: i as u32, axes: [true; 3] }).collect();
    (flesh.mass_damping, flesh.stiffness_damping) = (1.0, 5e-3);
    let pad = desc.add_soft(SoftDesc {
        name: "pad".into(),
        flesh,
        pose_WM: Pose::identity(),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    let mut thing = body("thing", 0.1, [1e-5; 3], Vec3::zeros());
    thing.motion = Motion::Prescribed;
    thing.shape = Some(shape.clone());
    thing.pose_WB = Pose::new(Vec3::new(1.18e-3, lowest + 0.5e-3, 0.7e-3), turn);
    let thing = desc.add_rigid(thing);
    desc.pairs.push(PairRule {
        bodies: [thenar_core::model::BodyId::Soft(pad), thenar_core::model::BodyId::Rigid(thing)],
        friction: Some(0.0),
    });
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    let (mut last, mut steepest) = (Vec3::zeros(), 0.0_f64);
    for step in 0..(0.6 / h) as usize {
        let t = step as f64 * h;
        input.prescribed[0][0] = if t < 0.15 { -Vec3::y() * 0.01 } else { Vec3::zeros() };
        world.step(&input, &mut ());
        let force: Vec3 = world.contacts().iter().map(|c| c.force_W).sum();
        if t > 0.5 {
            assert!(force.norm() > 0.2, "{shape:?} presses: {force}");
            steepest = steepest.max((force - last).norm() / force.norm());
        }
        last = force;
    }
    steepest
}

#[test]
fn narrow_shapes_press_with_a_still_force() {
    let lying = Quat::from_scaled_axis(Vec3::x() * std::f64::consts::FRAC_PI_2);
    let skewed = Quat::from_scaled_axis(Vec3::y() * 0.4) * lying;
    // With how far its middle lies over its lowest point.
    let narrow = |radius: f64| {
        let side = Shape::Cylinder { radius, half_length: 0.01 };
        let round = Shape::Capsule { radius, half_length: 0.01 };
        // A cone on its side: its axis rises by half its angle, and its middle lies a quarter of it
        // above the base.
        let height = 2.5 * radius;
        let slope = (radius / height).atan();
        let on_side = Quat::from_scaled_axis(Vec3::z() * (std::f64::consts::FRAC_PI_2 + slope));
        [
            (side.clone(), radius, lying),
            (side, radius, skewed),
            (round, radius, lying),
            (Shape::Cone { radius, height }, 0.75 * height * slope.sin(), on_side),
        ]
    };
    let shapes = || [0.004, 0.006, 0.008, 0.01].into_iter().flat_map(narrow);
    let all = [1e-3, 5e-3, 1.0 / 60.0].into_iter().flat_map(|h| shapes().map(move |s| (h, s)));
    for (h, (shape, middle, turn)) in one_in(5, all) {
        let changes = flicker(&shape, middle, turn, h);
        assert!(changes < 1e-3, "{shape:?}, {turn:?}, h {h}: {changes} of the force");
    }
}
