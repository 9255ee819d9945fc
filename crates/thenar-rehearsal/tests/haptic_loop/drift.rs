//! Goal: what drifts slowly is felt as what it is: a tracker's place by the stiffness times its
//! way, a tracker's clock not at all. Method: a hand that presses, held still but for the drift.

use crate::rig::{MS, PRESS, Rig, blocked, small};
use thenar_core::{Pose, Vec3};
use thenar_link::Rendering;
use thenar_link::haptic_loop::{LoopMode, Settings};
use thenar_scene::session::Random;
use thenar_track::live::{LivePose, Mover};
use thenar_track::source_clock::SourceClock;

/// Fingers on a table.
const TABLE: &str = include_str!("../../../thenar-scene/scenes/table-press.toml");

/// The tracker drifts by 1 mm/s for 5 s, up, down and sideways: the force moves by no more than the
/// stiffness that is felt times the way, and a hundredth of a newton that a hand at rest is allowed
/// to waver by.
#[test]
fn a_place_that_drifts_is_felt_by_the_stiffness_times_its_way() {
    for mode in [LoopMode::Shared, LoopMode::Multirate] {
        for drift in [Vec3::z(), -Vec3::z(), Vec3::x()] {
            let settings = Settings { mode, ..Settings::default() };
            let mut rig = Rig::of(&small(TABLE), &settings, Rendering::Tendons);
            let mut live = rig.session.live_hand(0).unwrap();
            let bones = rig.session.hands()[0].handle.bones.clone();
            let bones = bones.start as usize..bones.end as usize;
            let mut targets = rig.session.input().targets[bones].to_vec();
            let mut motion = rig.session.hands()[0].motion.clone().unwrap();
            let mut before = [0.0; 5];
            let mut most = [0.0_f64; 2];
            for ms in 0..9_000 {
                if ms % 10 == 0 {
                    rig.simulated_frame();
                }
                if ms == 1000 {
                    rig.clock.remote().arm();
                }
                let t = 1e-3 * f64::from(ms);
                let way = 1e-3 * (t - 4.0).clamp(0.0, 5.0);
                if ms % 11 == 0 {
                    motion.sample((t - 1.5).clamp(0.0, 1.2), &mut targets);
                    let LivePose::Angles { wrist, mut angles } = live.pose_of(&targets) else {
                        unreachable!()
                    };
                    let press = 0.25 * (t - 2.5).clamp(0.0, 0.5) / 0.5;
                    (1..5).for_each(|finger| angles[4 * finger] += press);
                    let wrist = Pose::new(wrist.position + drift * way, wrist.rotation);
                    rig.wearer.say(rig.now_ns, Some(LivePose::Angles { wrist, angles }));
                }
                rig.tick();
                let forces = rig.wearer.last().digits.map(|digit| digit.pad_force);
                if ms == 3999 {
                    before = forces;
                    assert!(before[1] > 0.1 && before[2] > 0.1, "{mode:?}: {before:?}");
                }
                if ms >= 4000 {
                    let stiffness = rig.clock.core(|core| core.hands()[0].felt_stiffness());
                    for (force, before) in forces.iter().zip(before) {
                        let moved = (force - before).abs();
                        most[0] = most[0].max(moved);
                        most[1] = most[1].max(moved - stiffness * way);
                    }
                }
            }
            let stiffness = rig.clock.core(|core| core.hands()[0].felt_stiffness());
            println!("{mode:?} {drift:?}: {stiffness} N/m, {before:?} N, moved by {most:?} N");
            assert!(most[1] < 0.01, "{mode:?} {drift:?}: {most:?} N beyond {stiffness} N/m");
        }
    }
}

/// Stiffness that is felt each second of 150 s \[N/m\] behind a tracker whose clock runs off by
/// `rate`, seen through a network that takes 3 ms and up to 8 ms more; pressing all the while.
fn felt(rate: f64) -> Vec<f64> {
    let settings = Settings { grip: Some(1.0), ..blocked() };
    let mut rig = Rig::new(&settings, Rendering::Tendons);
    rig.pressing();
    let (mut clock, mut random, mut out) = (SourceClock::default(), Random::new(11), Vec::new());
    let pose = rig.pose(PRESS);
    let mut due = None;
    for ms in 0..150_000u64 {
        if ms % 5 == 0 {
            rig.blocked_frame();
        }
        if ms % 11 == 0 {
            let way = 3 + (4.0 * (random.symmetric() + 1.0)) as u64;
            due = Some((ms + way, (rig.now_ns as f64 * (1.0 + rate)) as i64));
        }
        if let Some((_, source)) = due.take_if(|(due, _)| *due <= ms) {
            let carried = clock.carry(rig.now_ns, source);
            assert!(!carried.jumped, "{rate}: a jump at {ms} ms");
            rig.wearer.say(carried.time_ns, Some(pose.clone()));
        }
        rig.tick();
        if ms % 1000 == 999 {
            let (mover, stiffness) = rig.clock.core(|core| {
                let hand = &core.hands()[0];
                (hand.mover(), hand.felt_stiffness())
            });
            let tracked = rig.clock.core(|core| core.hands()[0].tracked_ns());
            assert!(mover == Mover::Live && rig.now_ns - tracked < 40 * MS, "{rate} at {ms} ms");
            assert!(rig.index_force() > 0.1, "{rate}: {} N at {ms} ms", rig.index_force());
            out.push(stiffness);
        }
    }
    out
}

/// A clock that runs off by 1e-3 either way, which is 0.15 s in the end: what is felt is what a
/// true clock has felt, within a twentieth from the third second on, and the hand is never lost.
#[test]
fn a_clock_that_drifts_is_not_felt() {
    let truly = felt(0.0);
    for rate in [1e-3, -1e-3] {
        let drifting = felt(rate);
        for (second, (a, b)) in drifting.iter().zip(&truly).enumerate().skip(5) {
            assert!((a / b - 1.0).abs() < 0.05, "{rate}, {second} s: {a} N/m, truly {b} N/m");
        }
    }
}
