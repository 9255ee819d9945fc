//! Goal: rolling resistance comes from the patch alone. Theory: where stress lags by a damping time
//! τ (σ = σₑ + τ dσₑ/dt), a pattern that travels at v over the flesh has pressure p = pₑ - τ v
//! ∂pₑ/∂x, and the centre of pressure runs ahead by ∫ x p dA / N = τ v, whatever the shape of the
//! patch: a moment τ v N against rolling (Brilliantov and Pöschel 1998, Europhys. Lett. 42, 511,
//! for spheres).

use crate::common::{FLESH, bar, body};
use thenar_core::model::{FixedNode, Motion, SoftDesc, SolverKind, WorldDesc};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Quat, Vec3, World};

const H: f64 = 1e-3;
const RADIUS: f64 = 0.02;
/// Damping time of the flesh \[s\].
const TAU: f64 = 2e-3;

/// A roller pressed 0.8 mm into a slab and rolled over it: how far the centre of pressure runs
/// ahead \[m\], and the power that rolling takes over speed and normal force, on average over 8 mm
/// of travel.
fn rolled(speed: f64, friction: f64) -> [f64; 2] {
    let mut desc = WorldDesc { time_step: H, gravity: Vec3::zeros(), ..WorldDesc::default() };
    desc.solver.kind = SolverKind::Monolithic;
    let size = Vec3::new(0.040, 0.006, 0.003);
    let mut flesh = bar(size, [40, 6, 2], FLESH);
    flesh.stiffness_damping = TAU;
    flesh.friction = friction;
    let low = (0..flesh.nodes.len() as u32).filter(|&n| flesh.nodes[n as usize].y < 1e-9);
    flesh.fixed = low.map(|node| FixedNode { node, axes: [true; 3] }).collect();
    desc.add_soft(SoftDesc {
        name: "slab".into(),
        flesh,
        pose_WM: Pose::translation(0.0, -size.y, -0.5 * size.z),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    let mut roller = body("roller", 1.0, [1e-4; 3], Vec3::new(0.012, RADIUS + 1e-4, 0.0));
    roller.motion = Motion::Prescribed;
    roller.shape = Some(Shape::Capsule { radius: RADIUS, half_length: 0.01 });
    roller.pose_BS =
        Pose::new(Vec3::zeros(), Quat::from_scaled_axis(Vec3::x() * std::f64::consts::FRAC_PI_2));
    roller.friction = friction;
    let roller = desc.add_rigid(roller);
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    let steps = |seconds: f64| (seconds / H).round() as usize;
    input.prescribed[roller as usize][0] = Vec3::y() * -0.0009 / 0.1;
    for _ in 0..steps(0.1) {
        world.step(&input, &mut ());
    }
    input.prescribed[roller as usize] = [Vec3::x() * speed, Vec3::z() * -speed / RADIUS];
    // Settle over 6 mm, then read over eight whole cells.
    for _ in 0..steps(0.006 / speed) {
        world.step(&input, &mut ());
    }
    let (mut moment, mut normal, mut power) = (0.0, 0.0, 0.0);
    for _ in 0..steps(0.008 / speed) {
        world.step(&input, &mut ());
        let centre = world.rigid_pose(roller).position;
        for c in world.contacts() {
            let (arm, push) = (c.position_W - centre, -c.force_W);
            let [v, w] = input.prescribed[roller as usize];
            moment += arm.x * push.y;
            normal += push.y;
            power -= push.dot(&(v + w.cross(&arm)));
        }
    }
    [moment / normal, power / normal / speed]
}

/// Without friction the pressure does it all: a horizontal force of N τ v / R holds the roller
/// back.
#[test]
fn rolling_is_resisted_by_how_far_the_flesh_lags() {
    for speed in [0.1, 0.2] {
        let [ahead, drag] = rolled(speed, 0.0);
        let expected = TAU * speed;
        assert!((ahead / expected - 1.0).abs() < 0.06, "{ahead} m ahead, theory {expected}");
        let drag_expected = expected / RADIUS;
        assert!((drag / drag_expected - 1.0).abs() < 0.09, "drag {drag} N per N, {drag_expected}");
    }
}

/// With friction the patch sticks to the roller; what slips at its rim takes a little more.
#[test]
fn a_roller_that_sticks_is_resisted_likewise() {
    let [ahead, drag] = rolled(0.2, 0.6);
    let expected = TAU * 0.2;
    assert!((ahead / expected - 1.0).abs() < 0.06, "{ahead} m ahead, theory {expected}");
    let over = drag / (expected / RADIUS);
    assert!((1.0..1.2).contains(&over), "{over} times what the lag takes");
}
