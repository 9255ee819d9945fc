//! Goal: skin whose triangles are large beside the touching part of a ball, and below twice its
//! radius, holds it against a spin, as a patch does. Theory: the ball bulges by 1 µm at three
//! points around the place, `ρ = √(2 R · 1 µm)` from it. Under the load N they give friction across
//! their arms, a moment `μ N ρ` about the normal.

use crate::common::{FLESH, bar, body};
use thenar_core::model::{FixedNode, SoftDesc, SolverKind, WorldDesc};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Vec3, World};

const FRICTION: f64 = 0.6;
/// Load \[N\].
const LOAD: f64 = 1.0;

/// Presses a ball on a slab of cells 20 mm wide at this place for 1 s, so that it is at rest, and
/// then twists it by this part of `μ N ρ` for 0.2 s. Returns how fast it turns about the vertical,
/// in parts of what it would with nothing to hold it.
fn twisted(radius: f64, at: [f64; 2], part: f64, h: f64) -> f64 {
    let mut desc = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
    desc.solver.kind = SolverKind::Monolithic;
    let size = Vec3::new(0.060, 0.010, 0.060);
    let mut flesh = bar(size, [3, 1, 3], FLESH);
    flesh.stiffness_damping = 2e-3;
    flesh.friction = FRICTION;
    let low = (0..flesh.nodes.len() as u32).filter(|&n| flesh.nodes[n as usize].y < 1e-9);
    flesh.fixed = low.map(|node| FixedNode { node, axes: [true; 3] }).collect();
    desc.add_soft(SoftDesc {
        name: "slab".into(),
        flesh,
        pose_WM: Pose::translation(0.0, -size.y, 0.0),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    let mass = 0.05;
    let inertia = 0.4 * mass * radius * radius;
    let start = Vec3::new(at[0], radius + 1e-5, at[1]);
    let mut ball = body("ball", mass, [inertia; 3], start);
    ball.shape = Some(Shape::Sphere { radius });
    ball.friction = FRICTION;
    let ball = desc.add_rigid(ball);
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    let steps = |seconds: f64| (seconds / h).round() as usize;
    input.wrenches[ball as usize][0] = Vec3::y() * -LOAD;
    for _ in 0..steps(1.0) {
        world.step(&input, &mut ());
    }
    let spread = (2.0 * radius * 1e-6).sqrt();
    let twist = part * FRICTION * LOAD * spread;
    input.wrenches[ball as usize][1] = Vec3::y() * twist;
    for _ in 0..steps(0.2) {
        world.step(&input, &mut ());
    }
    world.rigid_velocity(ball)[1].y / (0.2 * twist / inertia)
}

/// Places where the ball comes to rest within that time: while it still rolls, points in front bear
/// all, and it turns more easily.
const PLACES: [[f64; 2]; 3] = [[0.027, 0.024], [0.033, 0.035], [0.024, 0.027]];

/// Half of what friction gives does not turn the ball. Of three times what friction gives a third
/// is lost: a little less where flesh sinks in so that two triangles hold the ball, a little more
/// while it rolls.
#[test]
fn a_ball_on_one_triangle_is_held_against_a_spin() {
    for radius in [0.015, 0.02, 0.04] {
        for at in PLACES {
            for h in [1e-3, 5e-3] {
                let what = format!("{radius} m at {at:?}, {h} s");
                let held = twisted(radius, at, 0.5, h);
                assert!(held.abs() < 0.01, "{what}: turns at {held} of its rate");
                let lost = 1.0 - twisted(radius, at, 3.0, h);
                assert!((lost - 1.0 / 3.0).abs() < 0.1, "{what}: {lost} of its rate lost");
            }
        }
    }
}
