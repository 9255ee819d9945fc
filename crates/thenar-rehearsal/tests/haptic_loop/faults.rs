//! Faults put in: poses that are NaN, that teleport, that stop coming; devices that fall silent.

use crate::rig::{MS, PRESS, Rig, blocked, check_outputs, limits};
use thenar_core::{Pose, Quat, Vec3};
use thenar_link::Rendering;
use thenar_link::haptic_loop::{LoopMode, Settings};
use thenar_scene::session::Random;
use thenar_track::live::LivePose;

fn pressing() -> Rig {
    let mut rig = Rig::new(&blocked(), Rendering::Tendons);
    rig.pressing();
    rig
}

/// Goes on with frames for so long, while `say` puts the faults in; returns the force of each tick.
fn suffer(rig: &mut Rig, ms: u64, mut say: impl FnMut(&mut Rig, u64)) -> Vec<f64> {
    let mut forces = Vec::new();
    for k in 0..ms {
        rig.blocked_frame();
        say(rig, k);
        rig.tick();
        forces.push(rig.index_force());
    }
    check_outputs(&rig.wearer.shown.lock().unwrap().outputs);
    forces
}

fn returns(rig: &mut Rig) {
    rig.run(2000, |_| 0.0);
    rig.run(600, |ms| PRESS * (ms as f64 / 500.0).min(1.0));
    assert!(rig.index_force() > 0.2, "{}", rig.index_force());
    check_outputs(&rig.wearer.shown.lock().unwrap().outputs);
}

#[test]
fn poses_that_are_no_numbers_count_as_none() {
    let mut rig = pressing();
    let bad = LivePose::Angles { wrist: rig.wrist, angles: [f64::NAN; 20] };
    let forces = suffer(&mut rig, 300, |rig, _| rig.wearer.say(rig.now_ns, Some(bad.clone())));
    // Trusted for 100 ms, gone after another 50.
    assert!(forces[90] > 0.2 && forces[160..].iter().all(|f| *f == 0.0));
    returns(&mut rig);
}

#[test]
fn poses_that_stop_or_repeat_themselves_fade() {
    for repeat in [false, true] {
        let mut rig = pressing();
        let (pose, then) = (rig.pose(PRESS), rig.now_ns);
        let forces = suffer(&mut rig, 300, |rig, _| {
            if repeat {
                rig.wearer.say(then, Some(pose.clone()));
            }
        });
        assert!(forces[90] > 0.2 && forces[160..].iter().all(|f| *f == 0.0), "{repeat}");
        returns(&mut rig);
    }
}

#[test]
fn a_hand_that_is_said_to_be_lost_fades() {
    let mut rig = pressing();
    let forces = suffer(&mut rig, 300, |rig, _| rig.wearer.say(rig.now_ns, None));
    assert!(forces[160..].iter().all(|f| *f == 0.0));
    returns(&mut rig);
}

/// Seen at 90 Hz, the tracker says once that it does not see the hand: as if it had said nothing,
/// to the bit.
#[test]
fn a_hand_that_is_once_unseen_is_a_missing_sample() {
    let felt = |told: bool| {
        let mut rig = pressing();
        suffer(&mut rig, 400, |rig, k| match (k % 11, k / 11) {
            (0, 9) if told => rig.wearer.say(rig.now_ns, None),
            (0, 9) => (),
            (0, _) => rig.wearer.say(rig.now_ns, Some(rig.pose(PRESS + 1e-4 * k as f64))),
            _ => (),
        })
    };
    assert_eq!(felt(true), felt(false));
}

/// What a trip's file says of the tracker's age is how long the hand was not seen.
#[test]
fn records_tell_how_long_the_hand_was_not_tracked() {
    let mut rig = pressing();
    let last_ns = rig.now_ns - MS;
    for _ in 0..300 {
        rig.blocked_frame();
        rig.now_ns += MS;
        rig.wearer.alive(rig.now_ns);
        assert!(rig.clock.tick(rig.now_ns));
        let mut age = f32::NAN;
        while let Ok(record) = rig.clock.records.pop() {
            age = record.ages[0];
        }
        let want = (rig.now_ns - last_ns) as f64 * 1e-9;
        assert!((f64::from(age) - want).abs() < 1e-6, "{age} of {want} s");
    }
}

#[test]
fn a_teleport_becomes_a_journey_without_force() {
    let mut rig = pressing();
    let away = Pose::new(rig.wrist.position + Vec3::new(0.3, 0.2, -0.4), rig.wrist.rotation);
    let flipped =
        Pose::new(rig.wrist.position, Quat::from_scaled_axis(Vec3::z() * 3.0) * rig.wrist.rotation);
    for wrist in [away, flipped] {
        let forces = suffer(&mut rig, 700, |rig, _| {
            let LivePose::Angles { angles, .. } = rig.pose(PRESS) else { unreachable!() };
            rig.wearer.say(rig.now_ns, Some(LivePose::Angles { wrist, angles }));
        });
        // The second sample, which bears out the first, lets go, as fast as the slew lets it.
        assert!(forces.windows(2).all(|pair| pair[1] <= pair[0] + 1e-6), "{:?}", &forces[..200]);
        assert!(forces[20..].iter().all(|f| *f == 0.0));
        let home = rig.wrist;
        suffer(&mut rig, 1500, |rig, _| {
            let LivePose::Angles { angles, .. } = rig.pose(0.0) else { unreachable!() };
            rig.wearer.say(rig.now_ns, Some(LivePose::Angles { wrist: home, angles }));
        });
        returns(&mut rig);
    }
}

/// Seen at 90 Hz, the hand is 5 cm elsewhere for one sample, in any direction: half a newton at
/// most, gone at once.
#[test]
fn a_glitch_of_one_sample_is_not_felt() {
    let mut rig = pressing();
    let (home, before) = (rig.wrist, rig.index_force());
    for axis in 0..6 {
        let sign = if axis % 2 == 0 { 0.05 } else { -0.05 };
        let by = Vec3::from_fn(|k, _| if k == axis / 2 { sign } else { 0.0 });
        let forces = suffer(&mut rig, 330, |rig, k| {
            let off = if k == 11 { by } else { Vec3::zeros() };
            let LivePose::Angles { angles, .. } = rig.pose(PRESS) else { unreachable!() };
            let wrist = Pose::new(home.position + off, home.rotation);
            if k % 11 == 0 {
                rig.wearer.say(rig.now_ns, Some(LivePose::Angles { wrist, angles }));
            }
        });
        let most = forces.iter().fold(0.0_f64, |most, force| most.max((force - before).abs()));
        assert!(most < 0.5, "{by}: {most} N from {before} N");
    }
}

/// A tracker of which every sample contradicts the one before says nothing of where the hand is,
/// however often it says it: forces fade as if it were silent, 100 ms and the fade after the last
/// sample that was believed.
#[test]
fn samples_in_doubt_are_no_news() {
    let mut rig = pressing();
    let home = rig.wrist;
    let forces = suffer(&mut rig, 300, |rig, k| {
        let sign = if (k / 11) % 2 == 0 { 1.0 } else { -1.0 };
        let wrist = Pose::new(home.position + Vec3::x() * sign, home.rotation);
        let LivePose::Angles { angles, .. } = rig.pose(PRESS) else { unreachable!() };
        if k % 11 == 0 {
            rig.wearer.say(rig.now_ns, Some(LivePose::Angles { wrist, angles }));
        }
    });
    assert!(forces[80] > 0.2 && forces[160..].iter().all(|f| *f == 0.0), "{:?}", &forces[80..]);
    returns(&mut rig);
}

#[test]
fn a_device_that_falls_silent_is_let_go_and_taken_up_again() {
    let mut rig = pressing();
    let then = rig.now_ns;
    for _ in 0..200 {
        rig.blocked_frame();
        let pose = rig.pose(PRESS);
        rig.wearer.say(rig.now_ns, Some(pose));
        rig.now_ns += MS;
        rig.wearer.alive(then);
        assert!(rig.clock.tick(rig.now_ns));
    }
    assert_eq!(rig.index_force(), 0.0);
    returns(&mut rig);
}

#[test]
fn a_stop_is_zero_in_the_next_tick_and_stays() {
    let mut rig = pressing();
    rig.clock.remote().stop();
    rig.run(1, |_| PRESS);
    assert_eq!(rig.index_force(), 0.0);
    rig.run(3000, |ms| PRESS * (ms as f64 / 500.0 - 2.0).clamp(0.0, 1.0));
    assert_eq!(rig.index_force(), 0.0);
    let reason = rig.clock.core(|core| core.tripped().map(|reason| reason.to_string()));
    assert_eq!(reason.as_deref(), Some("stop was asked for"));
}

/// A dead-man switch that was let go for good: no jump of the force, then a stop like any other.
#[test]
fn forces_of_who_has_gone_fade_and_then_stop() {
    let mut rig = pressing();
    let (limits, before) = (limits(), rig.index_force());
    rig.clock.remote().abandon();
    let forces = suffer(&mut rig, 200, |rig, _| {
        let pose = rig.pose(PRESS);
        rig.wearer.say(rig.now_ns, Some(pose));
    });
    // As fast as the slew limit lets it, one tick of a millisecond after the other.
    let fading = (before / limits.change_max(1e-3)).ceil() as usize;
    assert!(fading > 1 && fading < 100, "{fading}");
    assert!(forces[0] > 0.0 && forces[..fading].is_sorted_by(|a, b| a > b), "{forces:?}");
    assert!(forces[fading..].iter().all(|force| *force == 0.0));
    let reason = rig.clock.core(|core| core.tripped().map(|reason| reason.to_string()));
    assert!(reason.is_some_and(|reason| reason.starts_with("whoever armed it has gone")));
    // Nothing but arming brings it back.
    rig.run(2000, |_| 0.0);
    rig.run(600, |ms| PRESS * (ms as f64 / 500.0).min(1.0));
    assert_eq!(rig.index_force(), 0.0);
    rig.engaged();
    rig.run(600, |ms| PRESS * (ms as f64 / 500.0).min(1.0));
    assert!(rig.index_force() > 0.2, "{}", rig.index_force());
    // A stop is no slower for it.
    rig.clock.remote().abandon();
    rig.clock.remote().stop();
    rig.run(1, |_| PRESS);
    assert_eq!(rig.index_force(), 0.0);
}

#[test]
fn nobody_can_have_left_what_nobody_armed() {
    let mut rig = Rig::new(&blocked(), Rendering::Tendons);
    rig.clock.remote().abandon();
    rig.run(100, |_| 0.0);
    assert_eq!(rig.clock.core(|core| core.tripped()), None);
    rig.pressing();
}

/// Neither a scene without a hand nor another hand lets through what was stopped.
#[test]
fn a_stop_outlives_the_hands() {
    let bare = crate::rig::session("version = 1\n");
    for before in [true, false] {
        let mut rig = pressing();
        if before {
            rig.clock.remote().stop();
            rig.run(1, |_| PRESS);
        }
        assert!(rig.port.attach(&bare).is_err(), "no hand");
        if !before {
            rig.clock.remote().stop();
        }
        rig.now_ns += MS;
        assert!(rig.clock.tick(rig.now_ns));
        rig.port.attach(&rig.session).expect("a hand");
        rig.run(1500, |_| 0.0);
        rig.run(600, |ms| PRESS * (ms as f64 / 500.0).min(1.0));
        assert_eq!(rig.index_force(), 0.0, "stopped {before}");
        // Arming it again is all it takes.
        rig.run(500, |_| 0.0);
        rig.engaged();
        rig.run(600, |ms| PRESS * (ms as f64 / 500.0).min(1.0));
        assert!(rig.index_force() > 0.2, "{}", rig.index_force());
    }
}

/// A short stall lets go, and force comes back by a ramp; a long one is a trip.
#[test]
fn a_clock_that_jumps_pauses_or_trips() {
    let mut rig = pressing();
    rig.now_ns += 50 * MS;
    rig.run(1, |_| PRESS);
    assert_eq!(rig.index_force(), 0.0);
    assert!(rig.clock.core(|core| core.tripped().is_none()));
    rig.run(300, |_| 0.0);
    rig.run(900, |ms| PRESS * (ms as f64 / 500.0).min(1.0));
    assert!(rig.index_force() > 0.2, "{}", rig.index_force());
    rig.now_ns += 600 * MS;
    rig.run(1, |_| PRESS);
    assert_eq!(rig.index_force(), 0.0);
    let reason = rig.clock.core(|core| core.tripped().unwrap().to_string());
    assert!(reason.contains("stood still"), "{reason}");
}

/// Whatever comes, in whatever order: no output is ever beyond limits, slew or numbers.
#[test]
fn no_output_is_ever_beyond_its_limits() {
    let limits = limits();
    for (seed, mode) in (0..6).zip([LoopMode::Multirate, LoopMode::Shared].iter().cycle()) {
        let mut random = Random::new(seed);
        let mut rig =
            Rig::new(&Settings { mode: *mode, ..Settings::default() }, Rendering::Tendons);
        rig.engaged();
        let mut wild = |low: f64, high: f64| random.range(low, high);
        for _ in 0..4000 {
            if wild(0.0, 1.0) < 0.3 {
                rig.blocked_frame();
            }
            let kind = wild(0.0, 1.0);
            if kind < 0.5 {
                let LivePose::Angles { mut wrist, mut angles } = rig.pose(wild(-0.2, 0.6)) else {
                    unreachable!()
                };
                if kind < 0.1 {
                    wrist.position += Vec3::new(wild(-0.1, 0.1), wild(-0.1, 0.1), wild(-9.0, 9.0));
                }
                if kind < 0.05 {
                    angles[(kind * 200.0) as usize] =
                        [f64::NAN, f64::INFINITY, 1e300][(kind * 60.0) as usize];
                }
                let stamp = rig.now_ns - (wild(0.0, 3.0) * MS as f64) as u64;
                rig.wearer.say(stamp, Some(LivePose::Angles { wrist, angles }));
            } else if kind < 0.52 {
                rig.wearer.say(rig.now_ns, None);
            }
            if wild(0.0, 1.0) < 0.002 {
                rig.clock.remote().arm();
            }
            rig.tick();
        }
        let outputs = rig.wearer.shown.lock().unwrap().outputs.clone();
        // A trip goes to zero at once; everything else is within the slew.
        for pair in outputs.windows(2) {
            let dt = (pair[1].time_ns - pair[0].time_ns) as f64 * 1e-9;
            let stopped = pair[1].digits.iter().all(|d| d.pad_force == 0.0);
            for (before, after) in pair[0].digits.iter().zip(&pair[1].digits) {
                let force = after.pad_force;
                assert!(force.is_finite() && (0.0..=limits.force_max()).contains(&force));
                let change = (force - before.pad_force).abs();
                assert!(stopped || change <= limits.change_max(dt) + 1e-12, "{seed}: {change}");
            }
        }
    }
}
