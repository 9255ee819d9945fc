//! Goal: the arm shows what it shall, and nothing when anything is amiss.

use super::twin::SimulatedArm;
use super::*;
use crate::testing::{collect, tick};
use thenar_core::Quat;
use thenar_testing::Mutator;

const MS: u64 = 1_000_000;

/// On a table, turned a quarter about y; the wrist is 0.1 m behind the handle.
fn setup() -> Setup {
    let turn = Quat::from_scaled_axis(Vec3::y() * std::f64::consts::FRAC_PI_2);
    Setup {
        side: Side::Right,
        pose_WD: Pose::new(Vec3::new(0.0, 1.0, 0.0), turn),
        pose_TH: Pose::translation(0.0, 0.0, 0.1),
        grips: [[0.0; ANGLES], [0.5; ANGLES]],
        torque_max: 0.2,
    }
}

fn push(x: f64) -> HandOutput {
    let force_W = Vec3::new(x, 0.0, 0.0);
    HandOutput { force_W, ..HandOutput::released(Side::Right, 0) }
}

fn state(seq: u32, at_ns: u64) -> [u8; wire::STATE_BYTES] {
    let (pose, velocity) = (Pose::identity(), Vec3::zeros());
    State { seq, time_ns: at_ns, pose, velocity, buttons: 0 }.write()
}

fn commands(sent: &[Vec<u8>]) -> Vec<Command> {
    sent.iter().map(|bytes| Command::read(bytes).unwrap()).collect()
}

#[test]
fn the_handle_moves_the_hand_and_the_force_comes_back() {
    let (mut device, mut arm) = (ForceDevice::new(setup()), SimulatedArm::new());
    arm.pose = Pose::translation(0.3, 0.0, 0.0);
    arm.buttons = 1;
    device.start(MS, &mut |bytes| arm.receive(MS, bytes).unwrap());
    let mut newest = None;
    for ms in 2..400u64 {
        let events = collect(&mut device, ms * MS, &[&arm.state(ms * MS)]);
        let [Event::Sample(sample)] = &events[..] else { panic!("{events:?}") };
        newest = Some(sample.clone());
        for bytes in tick(&mut device, ms * MS, Some(&push(2.0))) {
            arm.receive(ms * MS, &bytes).unwrap();
        }
    }
    let Some(LivePose::Angles { wrist, angles }) = newest.unwrap().pose else { panic!() };
    // The device's x is the world's -z, its z the world's x.
    assert!((wrist.position - Vec3::new(0.1, 1.0, -0.3)).norm() < 1e-6, "{wrist:?}");
    assert!((angles[0] - 0.5).abs() < 1e-9, "the button closes the hand");
    assert!((arm.force(399 * MS) - Vec3::new(0.0, 0.0, 2.0)).norm() < 1e-6);
    // The host says nothing more: the bridge's own watchdog lets go.
    assert_ne!(arm.force(419 * MS), Vec3::zeros());
    assert_eq!(arm.force(420 * MS), Vec3::zeros());
}

#[test]
fn commands_come_a_thousand_times_a_second_and_new_outputs_at_once() {
    let mut device = ForceDevice::new(setup());
    let count = (0..100_000u64).map(|k| tick(&mut device, k * 10_000, None).len()).sum::<usize>();
    assert_eq!(count, 1000);
    let mut device = ForceDevice::new(setup());
    let count = (0..10_000u64)
        .map(|k| tick(&mut device, k * 100_000, Some(&push(1.0))).len())
        .sum::<usize>();
    assert_eq!(count, 2500, "never faster than 2.5 kHz");
    let sent = tick(&mut device, 2000 * MS, Some(&push(1.0)));
    assert_eq!(sent.len(), 1);
    assert_eq!(tick(&mut device, 2000 * MS + 1000, None).len(), 0);
}

/// A silent device, a silent loop, a force that is none, the other hand: nothing is felt.
#[test]
fn nothing_is_felt_when_anything_is_amiss() {
    let felt = |seen_ns: u64, shown_ns: u64, now: u64, output: HandOutput| {
        let mut device = ForceDevice::new(setup());
        collect(&mut device, seen_ns, &[&state(1, seen_ns)]);
        tick(&mut device, shown_ns, Some(&output));
        commands(&tick(&mut device, now, None))[0].force.norm()
    };
    let (at, later) = (100 * MS, 110 * MS);
    assert!((felt(at, at, later, push(3.0)) - 3.0).abs() < 1e-6);
    assert_eq!(felt(89 * MS, at, later, push(3.0)), 0.0, "silent device");
    assert_eq!(felt(later, 89 * MS, later, push(3.0)), 0.0, "silent loop");
    assert_eq!(felt(at, at, later, push(f64::NAN)), 0.0);
    assert_eq!(felt(at, at, later, push(f64::INFINITY)), 0.0);
    let left = HandOutput { side: Side::Left, ..push(3.0) };
    assert_eq!(felt(at, at, later, left), 0.0);

    let mut device = ForceDevice::new(setup());
    collect(&mut device, at, &[&state(1, at)]);
    tick(&mut device, at, Some(&push(3.0)));
    let mut last = Vec::new();
    device.stop(&mut |bytes| last.push(bytes.to_vec()));
    let last = commands(&last);
    assert_eq!(last.len(), 3);
    assert!(last.iter().all(|command| command.force == Vec3::zeros()));
    // The device takes them: their numbers go on.
    assert!(last.windows(2).all(|two| two[1].seq == two[0].seq + 1));
}

#[test]
fn old_states_are_left_out_and_numbers_wrap() {
    let mut device = ForceDevice::new(setup());
    let mut now = 0;
    let mut seen = |seq: u32, wait_ms: u64| {
        now += wait_ms * MS;
        !collect(&mut device, now, &[&state(seq, now)]).is_empty()
    };
    assert!(seen(u32::MAX - 1, 1));
    assert!(!seen(u32::MAX - 1, 1), "twice");
    assert!(!seen(u32::MAX - 2, 1), "overtaken");
    assert!(seen(u32::MAX, 1) && seen(0, 1) && seen(5, 1));
    assert!(!seen(3, 1));
    // Another sender far ahead does not lock the device out for good, nor does a restart.
    assert!(seen(1 << 30, 1));
    assert!(!seen(6, 1));
    assert!(seen(7, 150) && seen(8, 1));
}

#[test]
fn torque_is_bounded() {
    let mut device = ForceDevice::new(setup());
    collect(&mut device, MS, &[&state(1, MS)]);
    let twist = HandOutput { torque_W: Vec3::new(3.0, 4.0, 0.0), ..push(1.0) };
    let torque = commands(&tick(&mut device, MS, Some(&twist)))[0].torque;
    assert!((torque - Vec3::new(0.0, 0.16, 0.12)).norm() < 1e-6, "{torque:?}");
}

#[test]
fn shipped_arms_are_sound_and_a_wrong_one_is_named() {
    use super::profile::{Profile, SHIPPED};
    use crate::profile::Check;
    let mut profile: Profile = toml::from_str(SHIPPED).unwrap();
    let names: Vec<_> = profile.arms.keys().cloned().collect();
    let rated = [("touch", 3.3, 700.0), ("desktop", 7.9, 1000.0), ("premium-6dof", 8.5, 800.0)];
    for (name, force, stiffness) in rated {
        let arm = &profile.arms[name];
        assert_eq!((arm.force_max, arm.stiffness_max), (force, stiffness));
    }
    assert_eq!(names.len(), 6);
    for name in names {
        profile.arm = name;
        profile.check().unwrap();
        assert!(profile.chosen().unwrap().limits().check().is_ok());
        assert!(profile.setup().is_some());
    }
    profile.arm = "hammer".into();
    assert!(
        profile.check().unwrap_err().1.starts_with("`hammer` is not an arm; there are desktop,")
    );
    let told = |address: &str| crate::open(address).map(|_| ()).unwrap_err().to_string();
    assert!(told("force-device:hammer@").contains("`hammer` is not an arm"));
    assert!(told("force-device:host:port").contains("has no port from 1 to 65535"));
    assert!(told("force-device:x?speed=1").contains("`speed=1` is not an option"));
}

#[test]
fn losses_are_told() {
    let mut device = ForceDevice::new(setup());
    let mut notes = Vec::new();
    for k in 0..11_000u64 {
        // Every tenth is lost.
        let seq = (k + k / 9) as u32;
        for event in collect(&mut device, k * MS, &[&state(seq, k * MS)]) {
            notes.extend(match event {
                Event::Note(note) => Some(note),
                _ => None,
            });
        }
    }
    assert_eq!(notes, ["1111 states were lost, 10001 came, in the last 10 s"]);
}

/// Damaged datagrams give states that are finite and near, or refusals; good ones still count.
#[test]
fn damaged_datagrams_do_no_harm() {
    let (mut mutator, mut arm) = (Mutator::new(3), SimulatedArm::new());
    let mut device = ForceDevice::new(setup());
    let (mut read, mut refused) = (0, 0);
    for k in 0..20_000u64 {
        let now = k * 200 * MS;
        let bytes = mutator.damage(&state(k as u32, now));
        for event in collect(&mut device, now, &[&bytes]) {
            match event {
                Event::Sample(sample) => {
                    let Some(LivePose::Angles { wrist, .. }) = sample.pose else { panic!() };
                    assert!(wrist.is_finite() && wrist.position.norm() < 12.0);
                    assert!(sample.time_ns <= now);
                    read += 1;
                }
                Event::Refused(_) => refused += 1,
                _ => {}
            }
        }
        let _ = arm.receive(now, &bytes);
        assert!(arm.force(now).iter().all(|x| x.is_finite()));
        for bytes in tick(&mut device, now, Some(&push(1.0))) {
            assert!(Command::read(&bytes).is_ok());
        }
    }
    assert!(read > 3000 && refused > 3000, "{read} {refused}");
    let now = 20_001 * 200 * MS;
    assert_eq!(collect(&mut device, now, &[&state(1, now)]).len(), 1);
}

/// A keeper has the release of 5 ms ago. The bridge takes it for newer than all that was commanded
/// since, and what is commanded when the program is back for newer again.
#[test]
fn a_release_is_newer_than_what_it_releases() {
    let (mut device, mut arm) = (ForceDevice::new(setup()), SimulatedArm::new());
    device.start(MS, &mut |bytes| arm.receive(MS, bytes).unwrap());
    let mut release = Vec::new();
    let mut now = MS;
    // As fast as commands can follow each other.
    for k in 0..2000_u64 {
        now += GAP_NS;
        collect(&mut device, now, &[&arm.state(now)]);
        for bytes in tick(&mut device, now, Some(&push(1.0 + 1e-4 * k as f64))) {
            arm.receive(now, &bytes).unwrap();
        }
        if k == 2000 - crate::keeper::BEAT_NS / GAP_NS {
            device.release(&mut |bytes| release.extend_from_slice(bytes));
        }
    }
    assert!(arm.force(now).norm() > 1.0);
    arm.receive(now, &release).unwrap();
    assert_eq!(arm.force(now), Vec3::zeros());
    // Again and again, while the program stands still; then it is back.
    arm.receive(now, &release).unwrap();
    device.start(now, &mut |bytes| arm.receive(now, bytes).unwrap());
    now += GAP_NS;
    collect(&mut device, now, &[&arm.state(now)]);
    for bytes in tick(&mut device, now, Some(&push(1.5))) {
        arm.receive(now, &bytes).unwrap();
    }
    assert!((arm.force(now).norm() - 1.5).abs() < 1e-6);
}
