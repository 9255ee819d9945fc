//! What is felt is contact: nothing in empty air, whatever the hand does and whatever the mode; and
//! of what is met, the same in every mode.

use crate::rig::{MS, Rig, limits};
use std::f64::consts::FRAC_PI_2;
use thenar_core::{Pose, Vec3};
use thenar_link::Rendering;
use thenar_link::haptic_loop::{LoopMode, Settings};
use thenar_scene::tuning::SettingValue;
use thenar_track::live::LivePose;

const MODES: [LoopMode; 3] = [LoopMode::Shared, LoopMode::SingleRate, LoopMode::Multirate];

/// The default hand, with nothing else; steps of 16 ms, and in single-rate of 8 ms, to be quick.
fn empty(mode: LoopMode) -> String {
    let step = if mode == LoopMode::SingleRate { 0.008 } else { 0.016 };
    format!("version = 1\ntime_step = {step}\n[[hand]]\nname = \"hand\"\nmodel = \"right\"\n")
}

/// Goes on for so many milliseconds: ticks of a millisecond (in single-rate as long as its step),
/// frames as the scene steps, a sample in each tick. `each` sees the rig after a tick.
fn go(
    rig: &mut Rig,
    ms: u64,
    mut pose: impl FnMut(&Rig, f64) -> LivePose,
    mut each: impl FnMut(&Rig, u64),
) {
    let step = (1e3 * rig.session.world().time_step()).round() as u64;
    let tick =
        if rig.clock.core(|core| core.hands()[0].touch().world().is_some()) { step } else { 1 };
    for k in (0..ms).step_by(tick as usize) {
        if k % step == 0 {
            rig.simulated_frame();
        }
        let said = pose(rig, k as f64 * 1e-3);
        rig.wearer.say(rig.now_ns, Some(said));
        rig.now_ns += (tick - 1) * MS;
        rig.tick();
        each(rig, k);
    }
}

/// Largest force that any pad, and any coupling, wanted in a tick \[N\].
fn felt(rig: &Rig) -> [f64; 2] {
    rig.clock.core(|core| {
        let hand = &core.hands()[0];
        let pads = hand.readings().iter().flatten().map(|r| r.pad_force.abs());
        let couplings = hand.touch().device_wrenches().iter().map(|[f, _]| f.norm());
        [pads.fold(0.0, f64::max), couplings.fold(0.0, f64::max)]
    })
}

fn moved(rig: &Rig, flexion: f64, way: Vec3) -> LivePose {
    let LivePose::Angles { wrist, angles } = rig.pose(flexion) else { unreachable!() };
    LivePose::Angles { wrist: Pose::new(wrist.position + way, wrist.rotation), angles }
}

/// The index finger bends by a quarter turn in a second and stays; then the hand swings at 0.1 m/s,
/// and at last at 1 m/s. It touches nothing: 20 mN, a tenth of what lets forces engage and a
/// fifteenth of what closes a stop.
#[test]
fn empty_air_is_not_felt() {
    for mode in MODES {
        let settings = Settings { mode, grip: None, ..Settings::default() };
        let mut rig = Rig::of(&empty(mode), &settings, Rendering::Stops);
        rig.wearer.alive(rig.now_ns);
        go(&mut rig, 400, |rig, _| rig.pose(0.0), |_, _| ());
        rig.clock.remote().arm();
        let mut most = [[0.0_f64; 2]; 3];
        let mut note = |phase: usize, rig: &Rig| {
            let now = felt(rig);
            (0..2).for_each(|k| most[phase][k] = most[phase][k].max(now[k]));
            assert!(
                rig.wearer.last().digits.iter().all(|d| d.curl_at_contact.is_none()),
                "{mode:?}"
            );
        };
        let bend = |rig: &Rig, t: f64| rig.pose(FRAC_PI_2 * t.min(1.0));
        go(&mut rig, 1500, bend, |rig, _| note(0, rig));
        // Peak speeds of 0.1 and 1 m/s, at 1 Hz.
        for (phase, speed) in [(1, 0.1), (2, 1.0)] {
            let rate = std::f64::consts::TAU;
            let swing = |rig: &Rig, t: f64| {
                moved(rig, FRAC_PI_2, Vec3::y() * (speed / rate * (1.0 - (rate * t).cos())))
            };
            go(&mut rig, 1000, swing, |rig, _| note(phase, rig));
        }
        println!("{mode:?}: {most:?} N");
        assert!(most[0][0] < 0.02 && most[1][0] < 0.02, "{mode:?}: {most:?} N");
        assert!(most[2][0] < 0.05, "{mode:?}: {most:?} N at 1 m/s");
    }
}

/// Flesh that becomes ten times as stiff while it is felt, on a bent finger, and springs of joints
/// with it: still nothing in empty air, in any mode, once forces are let through again.
#[test]
fn settings_that_act_at_once_are_not_felt_in_empty_air() {
    for mode in [LoopMode::Multirate, LoopMode::Shared] {
        let settings = Settings { mode, grip: None, ..Settings::default() };
        let mut rig = Rig::of(&empty(mode), &settings, Rendering::Tendons);
        rig.wearer.alive(rig.now_ns);
        let bent = |rig: &Rig, _: f64| rig.pose(FRAC_PI_2);
        go(&mut rig, 1500, bent, |_, _| ());
        rig.session.set("hand_young", &SettingValue::Number(3e5)).unwrap();
        let mut most = 0.0_f64;
        go(&mut rig, 1500, bent, |rig, ms| {
            most = most.max(if ms > 500 { felt(rig)[0] } else { 0.0 })
        });
        println!("{mode:?}: {most} N");
        assert!(most < 0.02, "{mode:?}: {most} N");
    }
}

/// What the pads want once all is at rest, thumb first, and the force of all couplings \[N\].
fn at_rest(scene: &str, mode: LoopMode, pose: impl Fn(&Rig, f64) -> LivePose) -> ([f64; 5], Vec3) {
    let settings = Settings { mode, grip: None, ..Settings::default() };
    let mut rig = Rig::within(limits(), scene, &settings, Rendering::Tendons);
    let (mut pads, mut all, mut count) = ([0.0; 5], Vec3::zeros(), 0.0);
    go(&mut rig, 1900, pose, |rig, ms| {
        if ms < 1600 {
            return;
        }
        count += 1.0;
        rig.clock.core(|core| {
            let hand = &core.hands()[0];
            for (sum, reading) in pads.iter_mut().zip(hand.readings()) {
                *sum += reading.map_or(0.0, |r| r.pad_force);
            }
            all += hand.touch().device_wrenches().iter().map(|[f, _]| *f).sum::<Vec3>();
        });
    });
    (pads.map(|sum| sum / count), all / count)
}

/// A weight of 1 N on the last bone of the index finger is felt as 1 N in all; a hand pressed on a
/// table without friction, which would remember the way there, is felt alike. In single-rate and
/// multirate as in shared constraints, within 2 %.
#[test]
fn modes_agree_on_loads_and_on_what_is_pressed() {
    let load = "[[load]]\nkind = \"force\"\nbody = \"hand/index-distal\"\nforce = [0, -1, 0]\npoint = [0, 0, 0]\n";
    let table = "[[rigid]]\nname = \"table\"\nshape = { kind = \"plane\" }\nmotion = \"fixed\"\nfriction = 0\n";
    let pressed = |hand: &str| hand.replace("[[hand]]", &format!("{table}[[hand]]"));
    let still = |rig: &Rig, _: f64| rig.pose(0.0);
    let mut told: Vec<[([f64; 5], Vec3); 2]> = Vec::new();
    for mode in MODES {
        let hand = empty(mode);
        let loaded = at_rest(&format!("{hand}{load}"), mode, still);
        assert!((loaded.1 + Vec3::y()).norm() < 0.02, "{mode:?}: 1 N is felt as {} N", loaded.1);
        // Lowered until its lowest finger is in the table by some millimetres.
        let lower = |rig: &Rig, t: f64| {
            let lowest = lowest(rig);
            moved(rig, 0.0, Vec3::y() * (-lowest - 0.006) * (t / 0.7).min(1.0))
        };
        let scene = pressed(&hand);
        told.push([loaded, at_rest(&scene, mode, lower)]);
        println!("{mode:?}: {:?}", told.last());
    }
    for one in &told[1..] {
        for (one, shared) in one.iter().zip(&told[0]) {
            let size = shared.1.norm();
            assert!(size > 0.5, "{size} N are felt");
            assert!((one.1 - shared.1).norm() < 0.02 * size, "{} beside {}", one.1, shared.1);
            for (a, b) in one.0.iter().zip(&shared.0) {
                assert!((a - b).abs() < 0.02 * size, "{:?} beside {:?}", one.0, shared.0);
            }
        }
    }
}

/// Height of the lowest skin of the hand as the scene puts it \[m\].
fn lowest(rig: &Rig) -> f64 {
    let desc = rig.session.world().desc();
    let soft = &desc.softs[0];
    let nodes = soft.flesh.nodes.iter().map(|n| soft.pose_WM.point(n).y);
    nodes.fold(f64::INFINITY, f64::min)
}
