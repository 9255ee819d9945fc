//! Goal: a soft, jointed finger is felt through the whole haptic chain, and no input breaks it.
//! Method: the real world at 60 Hz in the loop with a hand that is led into the floor and out; then
//! seeded hostile states and frames.

use crate::common::{body, finger};
use thenar_core::model::{Digit, Motion};
use thenar_core::random::Random;
use thenar_core::shape::Shape;
use thenar_core::{Mat3, Pose, Quat, Vec3, World};
use thenar_touch::safety::{Guard, Limits, Signal, Status};
use thenar_touch::{
    BoneFrame, CouplingDesign, HandSettings, HapticHand, Pad, Proxy, ProxyMode, ProxyTargets,
    RigidState, Touch,
};

const MS: u64 = 1_000_000;

/// The proxies of the finger's two bones.
fn proxies() -> Vec<Proxy> {
    let inertia = Mat3::from_diagonal(&Vec3::new(3e-8, 2.5e-7, 2.5e-7));
    vec![CouplingDesign::default().proxy(0.003, &inertia); 2]
}

/// Led 6 mm into the floor and out again within three seconds.
#[test]
fn a_soft_finger_feels_the_floor_and_lets_go_of_it() {
    let mut desc = finger(1e8, 1.0 / 60.0);
    let mut floor = body("floor", 1.0, [1.0; 3], Vec3::y() * -0.002);
    floor.motion = Motion::Prescribed;
    floor.shape = Some(Shape::HalfSpace);
    desc.add_rigid(floor);
    let proxies = proxies();
    desc.drives[0] = Some(proxies[0].bone);
    desc.drives[1] = Some(proxies[1].bone);
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    input.gravity = Vec3::zeros();
    let start = [0, 1].map(|i| RigidState::at_rest(world.rigid_pose(i)));
    let mut hand = HapticHand::new(HandSettings::default(), proxies, &start, 0).unwrap();
    let (mut frame, mut back) = (BoneFrame::new(&start, 0), ProxyTargets::new(&start));
    let mut pad = Pad::new(Digit::Index, 1, Vec3::x() * 0.015);

    let (mut pressed, mut jump, mut before) = (0.0_f64, 0.0_f64, 0.0);
    let mut last = 0.0;
    for ms in 0..4000u64 {
        let now = (ms + 1) * MS;
        if ms % 50 == 0 || ms % 50 == 17 || ms % 50 == 33 {
            for (target, proxy) in input.targets.iter_mut().zip(&back.proxies) {
                *target = Some(proxy.target());
            }
            assert!(!world.step(&input, &mut ()).non_finite);
            for i in 0..2 {
                let [velocity_W, angular_velocity_W] = world.rigid_velocity(i);
                let pose_WB = world.rigid_pose(i);
                frame.bones[i as usize] = RigidState { pose_WB, velocity_W, angular_velocity_W };
            }
            (frame.time_ns, frame.step) = (now, frame.step + 1);
        }
        let rate = std::f64::consts::TAU / 3.0;
        let phase = rate * 1e-3 * ms.min(3000) as f64;
        let down = Vec3::y() * -0.004 * (1.0 - phase.cos());
        for (i, state) in start.iter().enumerate() {
            let pose_WB = Pose::new(state.pose_WB.position + down, state.pose_WB.rotation);
            let velocity_W = Vec3::y() * -0.004 * rate * phase.sin();
            hand.lead(i, RigidState { pose_WB, velocity_W, ..*state });
        }
        let report = hand.tick(now, &frame);
        hand.write_targets(now, &mut back);
        last = pad.read(&hand, report.step).pad_force;
        pressed = pressed.max(last);
        jump = jump.max((last - before).abs());
        before = last;
    }
    // Two bones, 6 mm below where the floor lets them: each coupling chain bears up to 400 N/m.
    assert!((0.8..2.4).contains(&pressed), "{pressed} N when pressed");
    assert!(last.abs() < 0.05, "{last} N after letting go");
    assert!(jump < 0.15 * pressed, "{jump} N from one tick to the next, {pressed} N at most");
}

/// A number that is mostly small, sometimes absurd.
fn any(random: &mut Random, size: f64) -> f64 {
    let kind = random.symmetric();
    match (kind * 500.0) as i32 {
        499 => f64::NAN,
        498 => f64::NEG_INFINITY,
        -499 => 1e200 * random.symmetric(),
        -498 => 1e5 * random.symmetric(),
        _ => size * random.symmetric(),
    }
}

fn any_pose(random: &mut Random) -> Pose {
    let place = Vec3::from_fn(|_, _| any(random, 0.2));
    let turn = Vec3::from_fn(|_, _| any(random, 4.0));
    Pose::new(place, Quat::from_scaled_axis(turn))
}

/// States that teleport, flip, freeze or are no numbers, times that jump, frames that lie: every
/// state and force stays finite, and what leaves the guard is within its limits.
#[test]
fn hostile_states_and_frames_leave_finite_forces() {
    let mut live = 0;
    for seed in 1..=20u64 {
        let mut random = Random::new(seed);
        let start = [RigidState::at_rest(Pose::identity()); 2];
        let mode = if seed % 2 == 0 { ProxyMode::Multirate } else { ProxyMode::SharedConstraints };
        let settings = HandSettings { mode, ..HandSettings::default() };
        let mut hand = HapticHand::new(settings, proxies(), &start, 2).unwrap();
        let mut frame = BoneFrame::new(&start, 2);
        let mut pad = Pad::new(Digit::Index, 1, Vec3::x() * 0.01);
        let limits = Limits { ramp: 0.05, engage_force: 5.0, ..Limits::cybergrasp() };
        let mut guard = Guard::<1>::new(limits, 100).unwrap();
        guard.arm();
        let mut now = 1000 * MS;
        for tick in 0..5000 {
            let context = || format!("seed {seed} tick {tick}");
            now = match (random.symmetric() * 1000.0) as i32 {
                999 => now.saturating_sub(100 * MS),
                998 => now + 300 * MS,
                _ => now + MS,
            };
            for bone in 0..2 {
                if random.symmetric() > 0.8 {
                    let [velocity_W, angular_velocity_W] =
                        [0; 2].map(|_| Vec3::from_fn(|_, _| any(&mut random, 3.0)));
                    // Mostly near where the hand is at home.
                    let away = random.symmetric() > 0.98;
                    let pose_WB = if away {
                        any_pose(&mut random)
                    } else {
                        Pose::new(random.vector(0.004), Quat::identity())
                    };
                    if away && random.symmetric() > 0.0 {
                        hand.set_out(bone);
                    }
                    hand.lead(bone, RigidState { pose_WB, velocity_W, angular_velocity_W });
                }
            }
            if random.symmetric() > 0.9 {
                for bone in &mut frame.bones {
                    bone.pose_WB = any_pose(&mut random);
                    bone.velocity_W = Vec3::from_fn(|_, _| any(&mut random, 1.0));
                }
                frame.time_ns = now.saturating_add_signed((any(&mut random, 1e8)) as i64);
                frame.step += 1;
                let response = &mut frame.response;
                response.clear();
                response.springs = proxies().iter().map(|proxy| proxy.bone).collect();
                response.targets.clone_from(&frame.bones);
                response.compliance = (0..144).map(|_| any(&mut random, 1e-2)).collect();
                response.prepare();
            }
            let report = hand.tick(now, &frame);
            assert!(hand.proxies().states().iter().all(RigidState::is_finite), "{}", context());
            let reading = pad.read(&hand, report.step);
            assert!(
                hand.proxies()
                    .device_wrenches()
                    .iter()
                    .flatten()
                    .all(|v| v.iter().all(|x| x.is_finite())),
                "{}",
                context()
            );
            if matches!(guard.status(), Status::Tripped(_)) {
                guard.arm();
            }
            let [force] = guard.tick(
                now,
                &Signal {
                    force: [reading.pad_force],
                    velocity: [reading.opening_velocity.clamp(-1.0, 1.0)],
                    simulation_ns: now,
                    tracking_ns: now,
                    device_ns: now,
                    enabled: true,
                },
            );
            assert!((0.0..=6.0).contains(&force), "{}: {force} N", context());
            live += u32::from(force > 0.0);
        }
    }
    assert!(live > 1000, "the attack must have been felt: {live} ticks");
}
