//! The loop on a made-up clock: arming, a slow and a stalled simulation.

use crate::rig::{MS, PRESS, Rig, check_outputs};
use thenar_link::Rendering;
use thenar_link::haptic_loop::{LoopMode, Settings};
use thenar_touch::safety::Limits;

fn settings(mode: LoopMode) -> Settings {
    Settings { mode, grip: None, ..Settings::default() }
}

#[test]
fn nothing_is_felt_until_the_device_is_armed() {
    let mut rig = Rig::new(&settings(LoopMode::Multirate), Rendering::Tendons);
    rig.run(1500, |_| 0.0);
    rig.run(600, |ms| PRESS * (ms as f64 / 500.0).min(1.0));
    let outputs = rig.wearer.shown.lock().unwrap().outputs.clone();
    assert_eq!(outputs.len(), 2100, "a display is told every tick, dry or not");
    let zero = |o: &thenar_link::HandOutput| {
        o.digits.iter().all(|d| *d == thenar_link::DigitOutput::default())
    };
    assert!(outputs.iter().all(zero));
    // What would be sent is known all the same.
    let wanted = rig.clock.core(|core| core.hands()[0].readings()[1].unwrap().pad_force);
    assert!(wanted > 0.3, "{wanted}");

    // Armed while pressing: it waits until the wanted force has been small.
    rig.clock.remote().arm();
    rig.run(500, |_| PRESS);
    assert_eq!(rig.index_force(), 0.0);
    rig.run(500, |ms| PRESS * (1.0 - ms as f64 / 400.0).max(0.0));
    rig.run(600, |_| 0.0);
    rig.run(600, |ms| PRESS * (ms as f64 / 500.0).min(1.0));
    assert!((rig.index_force() - wanted).abs() < 0.05 * wanted, "{}", rig.index_force());
    check_outputs(&rig.wearer.shown.lock().unwrap().outputs);
}

/// The blocked finger is felt as the two couplings in series: device and bone.
#[test]
fn a_blocked_finger_is_felt_as_the_springs_in_series() {
    let mut rig = Rig::new(&settings(LoopMode::Multirate), Rendering::Tendons);
    rig.pressing();
    rig.run(1000, |_| PRESS);
    let (tip, blocked) = rig.clock.core(|core| {
        let touch = core.hands()[0].touch();
        let hand = &rig.session.hands()[0].model;
        let bone =
            hand.bones.iter().rposition(|b| b.digit == thenar_core::model::Digit::Index).unwrap();
        (touch.tracked()[bone].pose_WB, touch.bones()[bone].pose_WB)
    });
    let drive = rig.session.world().desc().drives[7].unwrap();
    let device = Settings::default().design.device_stiffness;
    let series = thenar_touch::series_stiffness(device, drive.stiffness);
    let way = blocked.position - tip.position;
    let want = series * way.dot(&tip.vector(&thenar_core::Vec3::y()));
    let got = rig.index_force();
    assert!((got - want).abs() < 0.02 * want, "{got} N, springs in series {want} N");
}

#[test]
fn a_simulation_at_20_hz_that_stalls_is_continuous_fades_and_returns() {
    let mut rig = Rig::new(&settings(LoopMode::Multirate), Rendering::Tendons);
    rig.pressing();
    let full = rig.index_force();
    let begin = rig.wearer.shown.lock().unwrap().outputs.len();
    // Frames every 50 ms, at 1 kHz ticks with a sample in each.
    let mut least = full;
    for ms in 0..1000 {
        if ms % 50 == 0 {
            rig.blocked_frame();
        }
        let pose = rig.pose(PRESS);
        rig.wearer.say(rig.now_ns, Some(pose));
        rig.tick();
        least = least.min(rig.index_force());
    }
    // 50 ms is the oldest frame that is fully trusted.
    assert!(least > 0.9 * full, "{least} of {full} N at 20 Hz");
    // Half a second without any. The last is 50 ms old: not trusted any more, gone 50 ms later.
    let mut at = Vec::new();
    for _ in 0..500 {
        let pose = rig.pose(PRESS);
        rig.wearer.say(rig.now_ns, Some(pose));
        rig.tick();
        at.push(rig.index_force());
    }
    assert!((at[25] / full - 0.5).abs() < 0.1, "{} of {full} N", at[25]);
    assert!(at[55..].iter().all(|force| *force == 0.0), "{:?}", &at[50..60]);
    // Frames again: the finger opens, and presses again, and is felt again.
    rig.run(900, |_| 0.0);
    rig.run(600, |ms| PRESS * (ms as f64 / 500.0).min(1.0));
    assert!(rig.index_force() > 0.9 * full, "{} of {full}", rig.index_force());
    let outputs = &rig.wearer.shown.lock().unwrap().outputs;
    assert_eq!(outputs.len() - begin, 1000 + 500 + 1500, "no tick was left out");
    check_outputs(outputs);
}

/// A stop is where the finger was when it began to press, and lets go when it opens.
#[test]
fn stops_stand_where_contact_began() {
    let mut rig = Rig::new(&settings(LoopMode::Multirate), Rendering::Stops);
    rig.pressing();
    let stop = rig.wearer.last().digits[1].curl_at_contact.expect("a stop");
    let curl = rig.clock.core(|core| core.hands()[0].curl(1));
    assert!(stop < curl && stop > 0.0, "{stop} {curl}");
    rig.run(300, |_| 2.0 * PRESS);
    assert_eq!(rig.wearer.last().digits[1].curl_at_contact, Some(stop));
    assert_eq!(rig.wearer.last().digits[3].curl_at_contact, None, "the ring finger is free");
    rig.run(600, |_| -0.1);
    assert_eq!(rig.wearer.last().digits[1].curl_at_contact, None);
}

/// Single-rate: the simulation is within; its hand follows, and what is felt is its drives.
#[test]
fn the_simulation_can_be_within_the_loop() {
    let mut rig = Rig::new(&settings(LoopMode::SingleRate), Rendering::Tendons);
    for _ in 0..300 {
        rig.port.before_step(&mut rig.session, rig.now_ns).unwrap();
        rig.session.step(&mut ());
        rig.port.after_step(&mut rig.session, rig.now_ns);
        for _ in 0..5 {
            let pose = rig.pose(PRESS);
            rig.wearer.say(rig.now_ns, Some(pose));
            rig.tick();
        }
    }
    let inside = rig.clock.core(|core| {
        let bones = core.hands()[0].touch().bones();
        bones.iter().map(|bone| bone.pose_WB.position).collect::<Vec<_>>()
    });
    rig.port.before_step(&mut rig.session, rig.now_ns).unwrap();
    for (bone, inside) in inside.iter().enumerate() {
        let outside = rig.session.world().rigid_pose(bone as u32).position;
        // Handed over every eight ticks; the hand stands still by now.
        assert!((outside - inside).norm() < 1e-4, "bone {bone}: {outside} {inside}");
    }
    assert!(Limits::cybergrasp().force_max() > rig.index_force());
    assert!(rig.now_ns > 1500 * MS);
}

/// Single-rate: a stage on its script and a ball under a constant force move in the loop's
/// simulation as in the scene's, though the loop alone steps it: x = x₀ + v t and z = z₀ + F t² / 2
/// m.
#[test]
fn what_else_moves_goes_on_within_the_loop() {
    const OTHERS: &str = "version = 1
time_step = 0.005
gravity = [0, 0, 0]
[[hand]]
preset = \"paper\"
name = \"hand\"
flesh = false
[[rigid]]
name = \"stage\"
shape = { kind = \"box\", size = [0.1, 0.02, 0.1] }
motion = \"scripted\"
position = [0.5, 0, 0.5]
interpolation = \"linear\"
keyframes = [{ time = 0 }, { time = 10, position = [1.5, 0, 0.5] }]
[[rigid]]
name = \"ball\"
shape = { kind = \"sphere\", radius = 0.01 }
mass = 0.1
position = [1, 1, 1]
[[load]]
kind = \"force\"
body = \"ball\"
force = [0, 0, 0.05]
";
    let mut rig = Rig::of(OTHERS, &settings(LoopMode::SingleRate), Rendering::Tendons);
    for ms in 0..1200u64 {
        if ms % 5 == 0 {
            rig.simulated_frame();
        }
        let pose = rig.pose(0.0);
        rig.wearer.say(rig.now_ns, Some(pose));
        rig.tick();
    }
    rig.clock.core(|core| {
        let world = core.hands()[0].touch().world().expect("within the loop");
        let body = |name: &str| {
            let index = world.desc().rigids.iter().position(|body| body.name == name).unwrap();
            world.rigid_pose(index as u32).position
        };
        let t = world.time();
        assert!((t - 1.2).abs() < 0.01, "{t} s");
        // A step of the scene of delay: 0.5 mm of the stage's way, 5 ms of the ball's.
        let (stage, ball) = (body("stage"), body("ball"));
        assert!((stage.x - (0.5 + 0.1 * t)).abs() < 1e-3, "{stage} at {t} s");
        let [late, most] = [t - 0.012, t].map(|t| 1.0 + 0.5 * 0.5 * t * t);
        assert!((late..most + 1e-3).contains(&ball.z), "{ball}: {late} to {most} m");
    });
}

/// Until a tracker finds it, a hand is where its scene has it, with its own weight: what is led at
/// the first pose sets out from there.
#[test]
fn a_hand_that_nobody_tracks_stays_with_its_simulation() {
    for mode in [LoopMode::Shared, LoopMode::Multirate] {
        let mut rig = Rig::new(&settings(mode), Rendering::Tendons);
        for ms in 0..600 {
            if ms % 16 == 0 {
                rig.simulated_frame();
            }
            rig.tick();
        }
        let first = rig.session.hands()[0].handle.bones.start;
        let bones = rig.clock.core(|core| core.hands()[0].touch().bones().to_vec());
        for (b, bone) in bones.iter().enumerate() {
            let there = rig.session.world().rigid_pose(first + b as u32);
            let off = (bone.pose_WB.position - there.position).norm();
            assert!(off < 1e-3, "{mode:?}, bone {b}: {off} m");
        }
        // And the first pose does not throw it.
        for ms in 0..300 {
            if ms % 16 == 0 {
                rig.simulated_frame();
            }
            rig.wearer.say(rig.now_ns, Some(rig.pose(0.0)));
            rig.tick();
            let world = rig.session.world();
            let speed = (0..bones.len() as u32).map(|b| world.rigid_velocity(first + b)[0].norm());
            let fastest = speed.fold(0.0, f64::max);
            assert!(fastest < 1.0, "{mode:?}, {ms} ms: {fastest} m/s");
        }
    }
}
