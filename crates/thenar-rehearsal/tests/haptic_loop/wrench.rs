//! A display of one point: force and torque, each behind its guard, and no weight of the hand.

use crate::rig::{MS, Rig, SCENE, blocked, limits, torque_limits};
use thenar_core::{Pose, Quat, Vec3};
use thenar_link::haptic_loop::{LoopMode, Settings};
use thenar_link::{HandOutput, Rendering};
use thenar_scene::session::Random;
use thenar_touch::safety::{Limits, Status};
use thenar_track::live::LivePose;

fn say(rig: &Rig, wrist: Pose) {
    let LivePose::Angles { angles, .. } = rig.pose(0.0) else { unreachable!() };
    rig.wearer.say(rig.now_ns, Some(LivePose::Angles { wrist, angles }));
}

/// Each within its limits, and within its slew unless all was stopped at once; the largest of each.
fn check(outputs: &[HandOutput]) -> [f64; 2] {
    let all = [limits(), torque_limits()];
    let mut largest = [0.0_f64; 2];
    for pair in outputs.windows(2) {
        let dt = (pair[1].time_ns - pair[0].time_ns) as f64 * 1e-9;
        let [before, after] = [0, 1].map(|k| [pair[k].force_W, pair[k].torque_W]);
        let stopped = after == [Vec3::zeros(); 2];
        for k in 0..2 {
            let (size, change) = (after[k].norm(), (after[k] - before[k]).norm());
            assert!(size.is_finite() && size <= all[k].force_max() * (1.0 + 1e-9), "{k}: {size}");
            assert!(stopped || change <= all[k].change_max(dt) + 1e-9, "{k}: {change} in {dt} s");
            largest[k] = largest[k].max(size);
        }
    }
    largest
}

/// The palm of a hand that is held turned by 0.2 rad is turned back: angular springs in series, up
/// to what the arm may do.
#[test]
fn a_blocked_palm_is_twisted_back_within_the_torque_limits() {
    let mut rig = Rig::new(&blocked(), Rendering::Wrench);
    rig.engaged();
    let home = rig.wrist;
    for ms in 0..900 {
        rig.blocked_frame();
        let angle = 0.2 * (f64::from(ms) / 500.0).min(1.0);
        let turn = Quat::from_scaled_axis(Vec3::y() * angle);
        say(&rig, Pose::new(home.position, turn * home.rotation));
        rig.tick();
    }
    let wanted = rig.clock.core(|core| core.hands()[0].touch().device_wrenches()[0][1]);
    let drive = rig.session.world().desc().drives[0].unwrap();
    let design = Settings::default().design;
    let device = design.device_stiffness * design.lever * design.lever;
    let series = thenar_touch::series_stiffness(device, drive.angular_stiffness);
    assert!((wanted.y / (-0.2 * series) - 1.0).abs() < 0.02, "{wanted} N m, {series} N m/rad");
    let sent = rig.wearer.last().torque_W;
    let most = torque_limits().force_max();
    let want = wanted * (most / wanted.norm()).min(1.0);
    assert!((sent - want).norm() < 1e-3 * want.norm(), "{sent} for {wanted}");
    let [_, torque] = check(&rig.wearer.shown.lock().unwrap().outputs);
    assert!(torque > 0.5 * most, "{torque} N m");
}

/// Spun faster than a wrist turns: force and torque are both stopped, and the reason says which it
/// was.
#[test]
fn a_palm_that_spins_stops_everything() {
    let mut rig = Rig::new(&blocked(), Rendering::Wrench);
    rig.engaged();
    let home = rig.wrist;
    let mut tripped = None;
    for ms in 0..1000 {
        rig.blocked_frame();
        let s = f64::from(ms) * 1e-3;
        let turn = Quat::from_scaled_axis(Vec3::y() * (40.0 * s * s));
        say(&rig, Pose::new(home.position + Vec3::x() * (0.02 * s), turn * home.rotation));
        rig.tick();
        if let Some(reason) = rig.clock.core(|core| core.tripped()) {
            tripped = Some(reason.to_string());
            break;
        }
    }
    let reason = tripped.expect("a trip");
    assert!(reason.starts_with("turning at ") && reason.contains("rad/s"), "{reason}");
    let last = rig.wearer.last();
    assert_eq!([last.force_W, last.torque_W], [Vec3::zeros(); 2]);
    check(&rig.wearer.shown.lock().unwrap().outputs);
}

/// Wrists that turn over, jump, tremble and are no numbers.
#[test]
fn no_wrench_is_ever_beyond_its_limits() {
    let mut largest = [0.0_f64; 2];
    for (seed, mode) in (0..2).zip(&[LoopMode::Multirate, LoopMode::Shared]) {
        let mut random = Random::new(seed);
        // On the couplings as they are: there must be something to guard.
        let settings = Settings { mode: *mode, grip: None, ..Settings::default() };
        let mut rig = Rig::new(&settings, Rendering::Wrench);
        rig.engaged();
        let mut wild = |size: f64| random.vector(size);
        for tick in 0..3000u64 {
            if tick % 16 == 0 {
                rig.blocked_frame();
            }
            if tick % 11 == 0 {
                let kind = wild(1.0).x;
                // Slow sways, with noise; seldom anything at all.
                let sway = (tick as f64 * 3e-3).sin();
                let (by, turn) =
                    (Vec3::new(0.0, 0.01 * sway, 0.0), Vec3::new(0.3 * sway, 0.0, 0.0));
                let (by, turn) = match kind {
                    k if k > 0.98 => (wild(0.5), wild(3.0)),
                    k if k < -0.98 => (wild(1.0) * f64::NAN, turn),
                    _ => (by + wild(5e-4), turn + wild(0.01)),
                };
                let rotation = Quat::from_scaled_axis(turn) * rig.wrist.rotation;
                say(&rig, Pose::new(rig.wrist.position + by, rotation));
            }
            if tick % 700 == 0 {
                rig.clock.remote().arm();
            }
            rig.tick();
        }
        let most = check(&rig.wearer.shown.lock().unwrap().outputs);
        largest = [0, 1].map(|k| largest[k].max(most[k]));
    }
    assert!(largest[0] > 0.5 && largest[1] > 0.005, "{largest:?}");
}

/// The simulated hand has a weight of its own, which its wearer's hand carries already: held still
/// over nothing it is not felt, or forces would never begin to be small.
#[test]
fn the_weight_of_the_simulated_hand_is_not_felt() {
    for mode in [LoopMode::Multirate, LoopMode::Shared, LoopMode::SingleRate] {
        let settings = Settings { mode, ..Settings::default() };
        let mut rig = Rig::new(&settings, Rendering::Wrench);
        let world = rig.session.world();
        let bones = rig.session.hands()[0].handle.bones.clone();
        let mass: f64 = bones.map(|b| world.model().rigids[b as usize].mass).sum();
        let weight = mass * world.desc().gravity.norm();
        assert!(weight > 0.3, "{weight} N");
        rig.clock.remote().arm();
        let every = (world.time_step() * 1e3).round().max(1.0) as u64;
        for ms in 0..2500u64 {
            if ms % every == 0 {
                rig.simulated_frame();
            }
            say(&rig, rig.wrist);
            rig.tick();
        }
        let forces = rig.clock.core(|core| {
            core.hands()[0].touch().device_wrenches().iter().map(|[f, _]| *f).sum::<Vec3>()
        });
        assert!(forces.norm() < 0.05 * weight, "{mode:?}: {forces} N of {weight} N");
        let status = rig.clock.core(|core| core.tripped());
        assert_eq!(status, None);
        let live = rig.clock.core(|core| core.actuators()[0].status());
        assert_eq!(live, Status::Live, "{mode:?}: forces began");
        assert!(rig.now_ns > 2000 * MS && rig.wearer.last().force_W.norm() < 0.05);
        // They began: a push of a hand that is held by hand is answered (these limits let through
        // what points upwards).
        if mode != LoopMode::Multirate {
            continue;
        }
        let home = rig.wrist;
        let mut felt = 0.0_f64;
        for ms in 0..300u64 {
            if ms % every == 0 {
                rig.blocked_frame();
            }
            say(&rig, Pose::new(home.position - Vec3::y() * 1e-4 * ms as f64, home.rotation));
            rig.tick();
            felt = felt.max(rig.wearer.last().force_W.norm());
        }
        assert!(felt > 0.5, "{felt} N");
    }
}

/// Armed before it is found, a metre from where the scene has it: it sets out by itself, faster
/// than a wearer may move, and that is nobody's speed. Nothing stops.
#[test]
fn the_way_to_where_a_hand_is_found_is_not_the_wearers_speed() {
    let limits = Limits { speed_max: 1.2, ..limits() };
    let mut rig = Rig::within(limits, SCENE, &Settings::default(), Rendering::Wrench);
    rig.clock.remote().arm();
    let found = Pose::new(rig.wrist.position + Vec3::x(), rig.wrist.rotation);
    let (mut fastest, mut before) = (0.0_f64, None);
    for _ in 0..1500 {
        rig.blocked_frame();
        say(&rig, found);
        rig.tick();
        let (tripped, tracked) = rig
            .clock
            .core(|core| (core.tripped(), core.hands()[0].touch().tracked()[0].pose_WB.position));
        assert!(tripped.is_none(), "{tripped:?}");
        let last = before.replace(tracked).unwrap_or(tracked);
        fastest = fastest.max((tracked - last).norm() / 1e-3);
    }
    assert!(fastest > limits.speed_max, "{fastest} m/s would not have stopped it anyway");
}
