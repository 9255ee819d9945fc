//! Goal: joints stay closed however long the step, and closing them costs no momentum and brings in
//! no energy. Method: chains, loops and a soft finger thrown about at 60 Hz, against conservation
//! laws and geometry.

use crate::common::{body, finger};
use std::f64::consts::FRAC_PI_2;
use thenar_core::model::{Axis, JointDesc, JointKind, Motion, SoftDesc, Springs, WorldDesc};
use thenar_core::random::Random;
use thenar_core::{Pose, Quat, Vec3, World};

const FRAME: f64 = 1.0 / 60.0;

/// A joint at rest between two anchors, its x along world z.
fn joint(
    kind: JointKind,
    [parent, child]: [Option<u32>; 2],
    parent_at: Vec3,
    child_at: Vec3,
) -> JointDesc {
    let to_z = Quat::from_axis_angle(&Vec3::y_axis(), -FRAC_PI_2);
    let child = child.unwrap();
    JointDesc {
        name: format!("{parent:?} to {child}"),
        kind,
        parent,
        child,
        pose_PJ: Pose::new(parent_at, to_z),
        pose_CK: Pose::new(child_at, to_z),
        axes: [Axis::default(); 2],
        limit_stiffness: 0.0,
        limit_damping: 0.0,
    }
}

/// Rods of 30 mm end to end along x, tied by joints of all kinds, flying and turning.
fn chain(links: u32) -> WorldDesc {
    let mut desc = WorldDesc { time_step: FRAME, gravity: Vec3::zeros(), ..WorldDesc::default() };
    let half = Vec3::x() * 0.015;
    for i in 0..links {
        let mut rod = body(&format!("rod {i}"), 0.01, [2e-7, 8e-7, 9e-7], half * f64::from(2 * i));
        rod.velocity_W = Vec3::new(0.2, 0.1, -0.3);
        desc.add_rigid(rod);
    }
    let kinds = [JointKind::Hinge, JointKind::Universal, JointKind::Ball, JointKind::Fixed];
    for i in 1..links {
        let kind = kinds[i as usize % 4];
        // Every third joint is declared from the outer body to the inner one.
        let link = if i % 3 == 0 {
            joint(kind, [Some(i), Some(i - 1)], -half, half)
        } else {
            joint(kind, [Some(i - 1), Some(i)], half, -half)
        };
        desc.joints.push(link);
    }
    desc
}

#[test]
fn a_chain_thrown_about_stays_closed_and_keeps_its_momentum() {
    let mut world = World::new(chain(7)).unwrap();
    let mut input = world.input();
    let ([p0, l0], mut random, mut turned) = (world.momentum(), Random::new(5), 0.0_f64);
    for step in 0..1000 {
        if step % 5 == 0 {
            input.joint_torques.iter_mut().flatten().for_each(|t| *t = 1e-3 * random.symmetric());
        }
        let report = world.step(&input, &mut ());
        assert!(!report.fell_back && !report.non_finite, "{report:?}");
        assert!(report.joint_gap_max < 1e-12, "step {step}: {} m", report.joint_gap_max);
        assert!(report.joint_misalignment_max < 1e-7, "{} rad", report.joint_misalignment_max);
        turned = turned.max(FRAME * world.rigid_velocity(3)[1].norm());
    }
    assert!(turned > 0.3, "it must turn far in a step: {turned} rad");
    let [p, l] = world.momentum();
    assert!((p - p0).norm() < 1e-10 * p0.norm(), "{} of {}", (p - p0).norm(), p0.norm());
    assert!((l - l0).norm() < 1e-9 * l0.norm(), "{} of {}", (l - l0).norm(), l0.norm());
}

/// The centre of mass of a free chain goes straight on, whatever its joints do.
#[test]
fn closing_joints_does_not_shift_the_centre_of_mass() {
    let mut world = World::new(chain(5)).unwrap();
    let mut input = world.input();
    input.joint_torques.iter_mut().flatten().for_each(|torque| *torque = 1e-3);
    let centre = |world: &World| (0..5).map(|b| world.rigid_pose(b).position).sum::<Vec3>() / 5.0;
    let start = centre(&world);
    for _ in 0..60 {
        world.step(&input, &mut ());
    }
    let off = centre(&world) - start - Vec3::new(0.2, 0.1, -0.3);
    assert!(off.norm() < 1e-10, "{} m", off.norm());
}

/// A linkage of four bars, its crank driven at 20 rad/s: a third of a radian in a step.
fn linkage(prescribed: bool) -> WorldDesc {
    let mut desc = WorldDesc { time_step: FRAME, ..WorldDesc::default() };
    // Shortest and longest add up to less than the others, so that the crank goes round (Grashof).
    let (crank, coupler, rocker) = (0.04, 0.11, 0.07);
    let pin = Vec3::x() * 0.12;
    // Crank upright; coupler and rocker meet where circles about its end and the pin do.
    let top = Vec3::y() * crank;
    let d = pin - top;
    let along = (coupler * coupler - rocker * rocker + d.norm_squared()) / (2.0 * d.norm());
    let across = (coupler * coupler - along * along).sqrt();
    let side = Vec3::new(-d.y, d.x, 0.0).normalize();
    let meet = top + d.normalize() * along + side * across;
    let bar = |name: &str, from: Vec3, to: Vec3| {
        let length = (to - from).norm();
        let angle = (to.y - from.y).atan2(to.x - from.x);
        let thin = 0.02 * length * length / 12.0;
        let mut bar = body(name, 0.02, [1e-7, thin, thin], (from + to) * 0.5);
        bar.pose_WB.rotation = Quat::from_axis_angle(&Vec3::z_axis(), angle);
        (bar, Vec3::x() * (0.5 * length))
    };
    let (first, a) = bar("crank", Vec3::zeros(), top);
    let (second, b) = bar("coupler", top, meet);
    let (third, c) = bar("rocker", pin, meet);
    desc.add_rigid(first);
    desc.add_rigid(second);
    desc.add_rigid(third);
    let ground = if prescribed {
        let mut frame = body("frame", 1.0, [1.0; 3], Vec3::zeros());
        frame.motion = Motion::Prescribed;
        Some(desc.add_rigid(frame))
    } else {
        None
    };
    desc.joints.push(joint(JointKind::Hinge, [ground, Some(0)], Vec3::zeros(), -a));
    desc.joints.push(joint(JointKind::Hinge, [Some(0), Some(1)], a, -b));
    desc.joints.push(joint(JointKind::Hinge, [ground, Some(2)], pin, -c));
    desc.joints.push(joint(JointKind::Hinge, [Some(1), Some(2)], b, c));
    desc
}

#[test]
fn loops_stay_closed() {
    for prescribed in [false, true] {
        let mut world = World::new(linkage(prescribed)).unwrap();
        let mut input = world.input();
        let (mut widest, mut fastest) = (0.0_f64, 0.0_f64);
        for step in 0..600 {
            let rate = world.rigid_velocity(0)[1].z;
            input.joint_torques[0][0] = 2e-4 * (20.0 - rate);
            if prescribed {
                let t = FRAME * f64::from(step);
                input.prescribed[3] = [Vec3::new(0.0, (9.0 * t).cos(), 0.2), Vec3::y() * 4.0];
            }
            let report = world.step(&input, &mut ());
            assert!(!report.fell_back && !report.non_finite, "step {step}: {report:?}");
            widest = widest.max(report.joint_gap_max);
            assert!(
                report.joint_gap_max < 1e-5,
                "{prescribed}, step {step}: {}",
                report.joint_gap_max
            );
            assert!(report.joint_misalignment_max < 1e-6);
            fastest = fastest.max(rate.abs());
        }
        assert!(fastest > 10.0, "{fastest} rad/s");
        assert!(widest < 1e-5, "{widest} m");
    }
}

/// A free soft finger that turns gains no energy: its flesh goes round with its bones. Velocities
/// are those of where a step began, which lie askew to where it ends by the angle θ of a step: `θ²`
/// of the energy.
#[test]
fn flesh_goes_round_with_its_bones() {
    for (kappa, spin) in [(1e8, 10.0), (1e9, 20.0)] {
        let mut desc = finger(kappa, FRAME);
        desc.gravity = Vec3::zeros();
        desc.softs[0].flesh.mass_damping = 0.0;
        let mut world = World::new(desc).unwrap();
        let input = world.input();
        let (axis, mut state) = (Vec3::z() * spin, world.state().clone());
        let turning = |x: &Vec3| axis.cross(&(x - Vec3::new(0.03, 0.008, 0.008)));
        for b in 0..2 {
            state.v[2 * b] = turning(&state.poses_WB[b].position);
            state.v[2 * b + 1] = axis;
        }
        for (v, x) in state.v[4..].iter_mut().zip(&state.x) {
            *v = turning(x);
        }
        assert!(world.restore(&state));
        let [p0, l0] = world.momentum();
        let start = world.energy(&input).total() * (1.0 + (FRAME * spin).powi(2));
        let mut last = start;
        for step in 0..120 {
            let report = world.step(&input, &mut ());
            assert!(!report.fell_back && report.joint_gap_max < 1e-12, "{report:?}");
            let energy = world.energy(&input);
            let now = energy.total();
            assert!(now < last + 1e-3 * start, "spin {spin}, step {step}: {last} to {now} J");
            // Turned as a whole it is strained by centrifugal force alone, not by the step.
            let strain = energy.elastic + energy.coupling;
            assert!(strain < 1e-3 * start, "spin {spin}, step {step}: {energy:?}");
            last = now.min(start);
        }
        let [p, l] = world.momentum();
        assert!((p - p0).norm() < 1e-9, "{p}");
        // Dampers between bones and stretched flesh have a small torque.
        assert!((l - l0).norm() < 5e-3 * l0.norm(), "{} of {}", (l - l0).norm(), l0.norm());
    }
}

/// Flesh on a bone that turns at a steady rate is strained by its weight in the turn, whatever the
/// step. If it went straight on beside bound nodes that go round, it would be strained by
/// `(Δt ω)²/2` besides: 1.4 % at 60 Hz, and `½ E ε² V` of that is 74 µJ, where its weight stores
/// 0.13.
#[test]
fn flesh_that_no_spring_binds_goes_round_with_its_bone() {
    let stored = |h: f64| {
        let mut desc = finger(1e9, h);
        desc.joints.clear();
        desc.gravity = Vec3::zeros();
        desc.rigids[0].motion = Motion::Prescribed;
        let SoftDesc { flesh, coupling, .. } = &mut desc.softs[0];
        flesh.mass_damping = 0.0;
        let coupling = coupling.as_mut().unwrap();
        let Springs::PerNode(stiffness) = &mut coupling.springs else { panic!("per volume") };
        let springs = coupling.bindings.iter_mut().zip(stiffness);
        for (x, (binding, stiffness)) in flesh.nodes.iter().zip(springs) {
            binding.weights = [1.0, 0.0];
            if (x.y - 0.008).abs() > 1e-6 {
                *stiffness = 0.0;
            }
        }
        let mut world = World::new(desc).unwrap();
        let mut input = world.input();
        input.prescribed[0] = [Vec3::zeros(), Vec3::z() * 10.0];
        for _ in 0..(1.0 / h) as u32 {
            world.step(&input, &mut ());
        }
        world.energy(&input).elastic
    };
    let steps = [1e-3, 5e-3, 0.01, FRAME];
    let energies = steps.map(stored);
    assert!(energies.iter().all(|e| (0.8..1.25).contains(&(e / energies[0]))), "{energies:?} J");
}
