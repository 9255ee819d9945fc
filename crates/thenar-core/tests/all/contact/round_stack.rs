//! Goal: round bodies that lie along each other bear each other. Method: three lying cylinders or
//! capsules, two between walls and one on the gap between them; lighter, heavier, thinner, thicker,
//! not flush; at steps up to 20 ms their axes stay as far apart as their radii say.

use crate::common::body;
use std::f64::consts::FRAC_PI_2;
use thenar_core::model::{Motion, WorldDesc};
use thenar_core::shape::Shape;
use thenar_core::{Mat3, Quat, Vec3, World};

/// The two below.
const RADIUS: f64 = 0.02;
/// Between all surfaces at first.
const APART: f64 = 5e-4;

#[derive(Clone, Copy, Debug)]
struct Stack {
    h: f64,
    /// Mass and radius of the one on top; those below have 0.2 kg.
    top: (f64, f64),
    length: f64,
    /// How far each lies along the axes \[m\].
    along: [f64; 3],
    /// The two below stay where they are.
    on_fixed: bool,
    capsules: bool,
}

const USUAL: Stack = Stack {
    h: 1.0 / 60.0,
    top: (2.0, RADIUS),
    length: 0.05,
    along: [0.0, 1e-3, 2e-3],
    on_fixed: false,
    capsules: false,
};

fn world(stack: &Stack) -> World {
    let mut desc = WorldDesc { time_step: stack.h, ..WorldDesc::default() };
    let beside = RADIUS + APART;
    let mut wall = |name: &str, half: Vec3, at: Vec3| {
        let mut thing = body(name, 1.0, [1.0; 3], at);
        thing.motion = Motion::Prescribed;
        thing.shape = Some(Shape::Cuboid { half });
        desc.add_rigid(thing);
    };
    wall("floor", Vec3::new(0.15, 0.01, 0.15), -Vec3::y() * 0.01);
    let to_wall = 2.0 * beside + 0.01;
    wall("left", Vec3::new(0.01, 0.05, 0.1), Vec3::new(-to_wall, 0.05, 0.0));
    wall("right", Vec3::new(0.01, 0.05, 0.1), Vec3::new(to_wall, 0.05, 0.0));
    let up = ((stack.top.1 + RADIUS).powi(2) - beside.powi(2)).sqrt() + 4.0 * APART;
    let places = [[-beside, beside], [beside, beside], [0.0, beside + up]];
    for (k, [x, y]) in places.into_iter().enumerate() {
        let (mass, radius) = if k == 2 { stack.top } else { (0.2, RADIUS) };
        let mut log = body("log", mass, [1.0; 3], Vec3::new(x, y, stack.along[k]));
        let across = mass * (3.0 * radius.powi(2) + stack.length.powi(2)) / 12.0;
        log.inertia = Mat3::from_diagonal(&Vec3::new(across, 0.5 * mass * radius.powi(2), across));
        log.pose_WB.rotation = Quat::from_axis_angle(&Vec3::x_axis(), FRAC_PI_2);
        let half_length = 0.5 * stack.length;
        log.shape = Some(match stack.capsules {
            true => Shape::Capsule { radius, half_length },
            false => Shape::Cylinder { radius, half_length },
        });
        if stack.on_fixed && k < 2 {
            log.motion = Motion::Prescribed;
        }
        desc.add_rigid(log);
    }
    World::new(desc).expect("a sound world")
}

/// How much nearer to each other than their radii add up to the axes of two bodies are \[m\]: of
/// two that are nearly parallel at the ends of their common length.
fn depth(world: &World, a: u32, b: u32, stack: &Stack) -> f64 {
    let radii = if b == 5 { RADIUS + stack.top.1 } else { 2.0 * RADIUS };
    let [a, b] = [a, b].map(|k| world.rigid_pose(k));
    let [u, v] = [a, b].map(|pose| pose.rotation * Vec3::y());
    let half = 0.5 * stack.length;
    let along = (b.position - a.position).dot(&u);
    let ends = [(-half).max(along - half), half.min(along + half)];
    let apart = ends.map(|s| {
        let to = a.position + s * u - b.position;
        (to - v * to.dot(&v)).norm()
    });
    radii - apart[0].min(apart[1])
}

/// Deepest that any of the three is in another \[m\]: ever, and over the last quarter of 1.5 s; and
/// how far the one on top is from either below at most in that time.
fn depths(stack: &Stack) -> [f64; 3] {
    let mut world = world(stack);
    let input = world.input();
    let steps = (1.5 / stack.h).round() as usize;
    let mut deepest = [0.0_f64; 3];
    for k in 0..steps {
        world.step(&input, &mut ());
        for (a, b) in [(3, 5), (4, 5), (3, 4)] {
            let depth = depth(&world, a, b, stack);
            deepest[0] = deepest[0].max(depth);
            if 4 * k >= 3 * steps {
                deepest[1] = deepest[1].max(depth);
                deepest[2] = deepest[2].max(if b == 5 { -depth } else { 0.0 });
            }
        }
    }
    deepest
}

/// What a body falls on may be expected to fall, too, until it is found to stand: a step that so
/// lets an overlap grow by up to half a contact margin, 0.5 mm, is not made anew, and what there is
/// goes in the next ones: never a whole margin. What lies is within some times what the solver's
/// tolerance makes in four steps, 0.8 µm at 20 ms.
fn all_bear(stacks: &[Stack]) {
    let mut wrong = Vec::new();
    for stack in stacks {
        let [ever, at_last, off] = depths(stack);
        if ever > 1e-3 || at_last > 3e-6 || off > 1e-5 {
            wrong.push(format!("{ever:e} m, at last {at_last:e} m, {off:e} m off: {stack:?}"));
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), stacks.len(), wrong.join("\n"));
}

#[test]
fn cylinders_bear_heavier_and_lighter_ones() {
    let alongs = [[0.0; 3], [0.0, 1e-3, 2e-3], [-0.004, 0.007, 0.001]];
    let mut stacks = Vec::new();
    for (k, mass) in [0.05, 0.2, 0.6, 2.0, 8.0].into_iter().enumerate() {
        for (i, h) in [2e-3, 0.01, 0.014, 1.0 / 60.0, 0.02].into_iter().enumerate() {
            for (j, length) in [0.02, 0.05, 0.09].into_iter().enumerate() {
                let along = alongs[(i + j + k) % 3];
                stacks.push(Stack { h, top: (mass, RADIUS), length, along, ..USUAL });
            }
        }
    }
    all_bear(&stacks);
}

#[test]
fn thin_and_thick_ones_capsules_and_fixed_ones_bear_too() {
    let mut stacks = Vec::new();
    for h in [5e-3, 0.012, 1.0 / 60.0, 0.02] {
        for radius in [0.012, 0.015, 0.03, 0.05] {
            stacks.push(Stack { h, top: (2.0, radius), ..USUAL });
            stacks.push(Stack { h, top: (0.3, radius), length: 0.08, ..USUAL });
        }
        for (on_fixed, capsules) in [(true, false), (false, true), (true, true)] {
            stacks.push(Stack { h, on_fixed, capsules, ..USUAL });
            stacks.push(Stack { h, on_fixed, capsules, top: (0.1, 0.025), ..USUAL });
        }
    }
    all_bear(&stacks);
}
