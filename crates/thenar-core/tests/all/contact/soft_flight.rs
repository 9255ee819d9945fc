//! Goal: soft bodies that fly so fast that they would pass within one step meet if they are in each
//! other's way, and only then. Method: slabs and balls thrown at each other and past each other;
//! statics of free flight gives what must come of it: momentum stays, nobody changes sides, and who
//! passes at a clearance flies on to the last bit of its momentum.

use crate::common::{FLESH, bar};
use thenar_core::model::{Flesh, SoftDesc, WorldDesc};
use thenar_core::{Pose, Quat, Vec3, World};

const STEPS: [f64; 2] = [5e-3, 1.0 / 60.0];
const SPEEDS: [f64; 3] = [2.0, 10.0, 30.0];
/// Between the bodies that pass each other \[m\].
const CLEARANCE: f64 = 2e-3;

/// A box about the origin with cells of about 5 mm, but at least two.
fn block(size: Vec3) -> Flesh {
    let cells = |k: usize| (size[k] / 5e-3).round().max(2.0) as usize;
    let mut flesh = bar(size, [cells(0), cells(1), cells(2)], FLESH);
    flesh.nodes.iter_mut().for_each(|x| *x -= 0.5 * size);
    flesh.stiffness_damping = 2e-3;
    flesh
}

/// A ball: shells of a cube made round.
fn ball(diameter: f64) -> Flesh {
    let mut flesh = block(Vec3::repeat(diameter));
    for x in flesh.nodes.iter_mut().filter(|x| x.amax() > 0.0) {
        *x *= x.amax() / x.norm();
    }
    flesh
}

/// A soft body, how it lies and flies.
struct Thrown {
    flesh: Flesh,
    pose_WM: Pose,
    velocity_W: Vec3,
    spin_W: Vec3,
}

fn world(h: f64, bodies: [Thrown; 2]) -> World {
    let mut desc = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
    for Thrown { flesh, pose_WM, velocity_W, .. } in &bodies {
        desc.add_soft(SoftDesc {
            name: format!("soft {}", desc.softs.len()),
            flesh: flesh.clone(),
            pose_WM: *pose_WM,
            velocity_W: *velocity_W,
            coupling: None,
        });
    }
    let mut world = World::new(desc).unwrap();
    let mut state = world.state().clone();
    let first = state.v.len() - state.x.len();
    for (soft, Thrown { pose_WM, spin_W, .. }) in (0..).zip(&bodies) {
        for n in world.node_range(soft) {
            let arm = state.x[n] - pose_WM.position;
            state.v[first + n] += spin_W.cross(&arm);
        }
    }
    assert!(world.restore(&state));
    world
}

/// Means over one body's mass.
fn mean(world: &World, soft: u32, values: &[Vec3]) -> Vec3 {
    let masses = world.node_masses(soft);
    let sum: Vec3 = values.iter().zip(masses).map(|(x, m)| x * *m).sum();
    sum / masses.iter().sum::<f64>()
}

/// Where the nodes are that lie on the line through its middle along `way`: what flies at the
/// other.
fn core(world: &World, soft: u32, way: Vec3) -> Vec3 {
    let rest = &world.desc().softs[soft as usize].flesh.nodes;
    let on_line = |x: &Vec3| (x - way * x.dot(&way)).norm() < 1e-9;
    let on = rest.iter().zip(world.nodes(soft)).filter(|(x, _)| on_line(x));
    on.clone().map(|(_, x)| x).sum::<Vec3>() / on.count() as f64
}

fn velocity(world: &World, soft: u32) -> Vec3 {
    mean(world, soft, world.node_velocities(soft))
}

/// Two bodies that fly at each other along `way`, as far apart as makes them pass within the first
/// step or at its middle, and meet in the second.
fn collide(h: f64, speed: f64, flesh: [Flesh; 2], way: Vec3, thickness: f64, turn: Quat) {
    let travel = speed * h;
    for gap in [0.02 * travel, (travel - 2.0 * thickness).max(0.5 * travel) * 0.9, 1.3 * travel] {
        let apart = 0.5 * (thickness + gap + 1e-4);
        let [a, b] = flesh.clone();
        let thrown = |flesh, side: f64, rotation| Thrown {
            flesh,
            pose_WM: Pose::new(way * (side * apart), rotation),
            velocity_W: way * (-0.5 * side * speed),
            spin_W: Vec3::zeros(),
        };
        let mut world = world(h, [thrown(a, -1.0, Quat::identity()), thrown(b, 1.0, turn)]);
        let input = world.input();
        let masses = [0, 1].map(|s| world.node_masses(s).iter().sum::<f64>());
        let momentum =
            |world: &World| velocity(world, 0) * masses[0] + velocity(world, 1) * masses[1];
        let start = momentum(&world);
        let scene = format!("{speed} m/s, {h} s, {gap} m apart");
        let (mut pushed, mut divided) = (0.0_f64, false);
        for step in 0..(0.1 / h).ceil() as usize {
            let report = world.step(&input, &mut ());
            assert!(!report.non_finite, "{scene}, step {step}");
            pushed = world.contacts().iter().map(|c| c.force_W.norm()).fold(pushed, f64::max);
            divided |= report.parts > 1;
            let ahead = (core(&world, 1, way) - core(&world, 0, way)).dot(&way);
            assert!(
                ahead > 0.25 * thickness,
                "{scene}, step {step}: the middles are {ahead} m apart"
            );
        }
        // Of a step made in parts only the last one's contacts are told; how they part shows the
        // others.
        assert!(pushed > 0.0 || divided, "{scene}: nothing carries");
        let parting = (velocity(&world, 1) - velocity(&world, 0)).dot(&way);
        assert!(parting > -1e-3 * speed, "{scene}: they part at {parting} m/s");
        let lost = (momentum(&world) - start).norm();
        assert!(lost < 1e-5 * masses[0] * speed, "{scene}: {lost} kg m/s");
    }
}

#[test]
fn slabs_thrown_at_each_other_face_to_face_meet() {
    for h in STEPS {
        for speed in SPEEDS {
            let slab = block(Vec3::new(0.004, 0.02, 0.02));
            collide(h, speed, [slab.clone(), slab], Vec3::x(), 0.004, Quat::identity());
        }
    }
}

#[test]
fn slabs_thrown_at_each_other_with_their_edges_crossed_meet() {
    for h in STEPS {
        for speed in SPEEDS {
            let rod = block(Vec3::new(0.004, 0.004, 0.04));
            let turn = Quat::from_scaled_axis(Vec3::x() * std::f64::consts::FRAC_PI_2);
            collide(h, speed, [rod.clone(), rod], Vec3::x(), 0.004, turn);
        }
    }
}

#[test]
fn balls_thrown_at_each_other_meet() {
    for h in STEPS {
        for speed in SPEEDS {
            collide(h, speed, [ball(0.02), ball(0.02)], Vec3::x(), 0.02, Quat::identity());
        }
    }
}

/// Balls and rods that fly past each other in opposite directions, spinning or not.
#[test]
fn what_passes_at_a_clearance_is_not_touched() {
    let rod = block(Vec3::new(0.04, 0.006, 0.006));
    // A rod turns about its axis: within a circle around its corners.
    let flesh = [(ball(0.02), 0.02), (rod, 0.006 * std::f64::consts::SQRT_2)];
    for h in STEPS {
        for speed in SPEEDS {
            for (flesh, thickness) in &flesh {
                // Points go straight in a step: of more than so much turning bodies swell.
                for spin in [0.0, 0.1 / h, 0.3 / h] {
                    for start in [0.5, 0.9, 1.7] {
                        let side = |s: f64| Thrown {
                            flesh: flesh.clone(),
                            pose_WM: Pose::translation(
                                0.5 * s * start * speed * h,
                                0.5 * s * (thickness + CLEARANCE),
                                0.0,
                            ),
                            velocity_W: Vec3::x() * (-0.5 * s * speed),
                            spin_W: Vec3::x() * (s * spin),
                        };
                        let mut world = world(h, [side(-1.0), side(1.0)]);
                        let before = [0, 1].map(|s| velocity(&world, s));
                        let input = world.input();
                        for step in 0..3 {
                            world.step(&input, &mut ());
                            let force = world.contacts().iter().map(|c| c.force_W.norm());
                            let force = force.fold(0.0, f64::max);
                            assert!(
                                force == 0.0,
                                "{speed} m/s, {h} s, {thickness} m, {spin} rad/s, from {start}: \
                                 {force} N in step {step}"
                            );
                        }
                        let now = [0, 1].map(|s| velocity(&world, s));
                        for (a, b) in before.iter().zip(&now) {
                            assert!((b - a).norm() < 1e-6 * speed, "{b} m/s of {a}");
                        }
                    }
                }
            }
        }
    }
}
