//! Goal: recorded motions are followed, late by the stated delay, and stay smooth, bounded and
//! finite through jitter, loss, teleports and sign flips. Method: a simulated tracker watches a
//! hand of another size move in a known way.

use super::*;
use crate::fixture::{hand, scaled};
use crate::retarget::size_ratio;
use crate::tracker::Tracker;
use std::path::Path;
use thenar_core::Vec3;
use thenar_core::kinematics::velocity_between;

/// All fingers closing and opening, the wrist on a tilted circle.
fn wave(time: f64) -> (Pose, Vec<[f64; 2]>) {
    let turn = Vec3::new(0.4 * (2.0 * time).sin(), 0.5 * (1.5 * time).cos(), 0.2 * time);
    let place = Vec3::new(0.2 * time.cos(), 1.0 + 0.1 * (2.0 * time).sin(), 0.2 * time.sin());
    let bend = |phase: f64| -0.6 + 0.5 * (3.0 * time + phase).sin();
    let angles = (0..15)
        .map(|j| match j % 3 {
            0 => [0.2 * (2.0 * time).sin(), bend(j as f64 * 0.1)],
            _ => [bend(0.5), 0.0],
        })
        .collect();
    (Pose::new(place, Quat::from_scaled_axis(turn)), angles)
}

fn motion(tracker: &Tracker, seconds: f64, hand: &HandModel) -> Recorded {
    Recorded::new(&RecordedDesc::of_file("test"), &tracker.recording(seconds), hand).unwrap()
}

fn sample(motion: &mut Recorded, time: f64) -> Vec<Target> {
    let mut out = vec![None; 16];
    motion.sample(time, &mut out);
    out.into_iter().flatten().collect()
}

/// Angles of the joints in these targets.
fn angles(motion: &Recorded, targets: &[Target]) -> Vec<[f64; 2]> {
    let poses: Vec<_> = targets.iter().map(|target| target.pose_WB).collect();
    let mut angles = vec![[0.0; 2]; 15];
    motion.articulation.tree.angles(&poses, &mut angles);
    angles
}

#[test]
fn a_hand_of_other_size_and_other_wrist_convention_is_followed_after_the_delay() {
    let (ours, person) = (hand(true), scaled(hand(false), 1.15));
    let tracker = Tracker {
        wrist_turn: Quat::from_scaled_axis(Vec3::new(0.2, -0.3, 0.1)),
        ..Tracker::new(&person, &wave)
    };
    let mut motion = motion(&tracker, 3.0, &ours);
    let delay = motion.delay();
    assert!((delay - 1.0 / (std::f64::consts::PI * 8.0)).abs() < 1e-12);
    for k in 0..40 {
        let time = 0.9 + 0.05 * f64::from(k);
        let targets = sample(&mut motion, time);
        // The filter's error beyond its delay is that of the curvature: its response to
        // sin(wt) is late by 2 atan(w/ω)/w and small by 1/(1 + w²/ω²), 0.4 % at w = 3.
        let (root, wanted) = wave(time - delay);
        let want_wrist = root * person.bones[0].pose_BT;
        let got_wrist = targets[0].pose_WB * ours.bones[0].pose_BT;
        assert!((want_wrist.position - got_wrist.position).norm() < 2e-3, "{time}");
        assert!(want_wrist.rotation.angle_to(&got_wrist.rotation) < 5e-3, "{time}");
        // Our hand's flexion counts the other way round.
        for (got, want) in angles(&motion, &targets).iter().zip(&wanted) {
            assert!((got[0] + want[0]).abs() < 5e-3, "{time} {got:?} {want:?}");
            assert!((got[1] + want[1]).abs() < 5e-3, "{time} {got:?} {want:?}");
        }
    }
    assert!(
        (size_ratio(&ours, tracker.recording(1.0).hand(Side::Right)).unwrap() - 1.15).abs() < 1e-9
    );
}

#[test]
fn the_delay_measured_on_a_steady_motion_is_the_stated_one() {
    let person = hand(false);
    let steady = |time: f64| {
        let turn = Quat::from_scaled_axis(Vec3::y() * 0.8 * time);
        (Pose::new(Vec3::new(0.5 * time, 1.0, 0.0), turn), vec![[0.0; 2]; 15])
    };
    let mut motion = motion(&Tracker::new(&person, &steady), 3.0, &person);
    let target = sample(&mut motion, 2.5)[0];
    let wrist = target.pose_WB * person.bones[0].pose_BT;
    // Turning carries the wrist about the root: only the rotation is a pure ramp of 0.8 rad/s.
    let late = 2.5 - wrist.rotation.scaled_axis().y / 0.8;
    assert!((late - motion.delay()).abs() < 1e-3, "{late}");
    assert!((target.angular_velocity_W - Vec3::y() * 0.8).norm() < 2e-3);
}

/// Jitter of 1 mm and 0.06°, a second without tracking, a teleport.
fn rough(person: &HandModel) -> Tracker<'_> {
    Tracker {
        rounding: [1e-3, 1e-3],
        lost: [1.0, 2.0],
        teleport: 3.0,
        ..Tracker::new(person, &wave)
    }
}

#[test]
fn velocities_are_the_derivative_of_poses_and_bounded_whatever_happens() {
    let (ours, person) = (hand(true), scaled(hand(false), 1.15));
    let mut motion = motion(&rough(&person), 4.0, &ours);
    let settings = motion.settings.clone();
    let h = 2e-5;
    let mut last: Option<Vec<Target>> = None;
    for k in 1..4500 {
        let time = f64::from(k) * 1e-3 + 0.4e-3;
        let (before, at, after) = (
            sample(&mut motion, time - h),
            sample(&mut motion, time),
            sample(&mut motion, time + h),
        );
        for b in 0..16 {
            let [linear, angular] =
                velocity_between(&before[b].pose_WB, &after[b].pose_WB, 2.0 * h);
            assert!((linear - at[b].velocity_W).norm() < 1e-5, "{time} {b}");
            assert!((angular - at[b].angular_velocity_W).norm() < 1e-4, "{time} {b}");
        }
        let wrist = at[0].pose_WB * ours.bones[0].pose_BT;
        let to_wrist = wrist.position - at[0].pose_WB.position;
        let speed = at[0].velocity_W + at[0].angular_velocity_W.cross(&to_wrist);
        assert!(speed.norm() <= settings.speed_max + 1e-9, "{time} {}", speed.norm());
        assert!(at[0].angular_velocity_W.norm() <= settings.spin_max * 1.1, "{time}");
        for (j, angles) in angles(&motion, &at).iter().enumerate() {
            let clamped = motion.articulation.tree.clamp(j, *angles);
            assert!((clamped[0] - angles[0]).abs() + (clamped[1] - angles[1]).abs() < 1e-9);
        }
        // Velocity is continuous: within a millisecond the filter changes it by at most
        // ω² × (way between input and output) × 1 ms, the way being at most speed × 2/ω.
        if let Some(last) = &last {
            let jump = (at[0].velocity_W - last[0].velocity_W).norm();
            assert!(jump < 2.0 * settings.omega * settings.speed_max * 1e-3, "{time} {jump}");
        }
        last = Some(at);
    }
}

#[test]
fn a_lost_hand_freezes_and_comes_back_softly() {
    let person = hand(false);
    let mut motion = motion(&rough(&person), 4.0, &person);
    let mut back = None;
    for k in 0..2900 {
        let time = f64::from(k) * 1e-3;
        let target = sample(&mut motion, time)[0];
        match motion.tracking() {
            Tracking::Lost => {
                assert!((1.0..2.0).contains(&time), "{time}");
                let still = target.velocity_W.norm() + target.angular_velocity_W.norm();
                assert!(time < 1.4 || still < 1e-3, "{time} {still}");
            }
            Tracking::Reacquiring if time > 1.0 => {
                let since = time - *back.get_or_insert(time);
                // The limit opens linearly to 3 m/s within 0.5 s.
                let speed = target.velocity_W.norm();
                assert!(speed <= 6.0 * since + 0.1 && time < 2.7, "{time} {speed}");
            }
            _ => assert!(!(1.15..=2.45).contains(&time), "{time}"),
        }
    }
    assert!(back.is_some_and(|back| (2.0..2.02).contains(&back)));
    // Then it is where it should be.
    let wrist = sample(&mut motion, 2.9)[0].pose_WB.position;
    assert!((wrist - wave(2.9 - motion.delay()).0.position).norm() < 3e-3);
}

#[test]
fn one_sample_a_metre_off_moves_the_hand_by_centimetres() {
    let person = hand(false);
    let mut motion = motion(&rough(&person), 4.0, &person);
    let mut worst: f64 = 0.0;
    for k in 2900..3400 {
        let time = f64::from(k) * 1e-3;
        let got = sample(&mut motion, time)[0].pose_WB.position;
        worst = worst.max((got - wave(time - motion.delay()).0.position).norm());
    }
    // Resampling makes the outlier a triangle 2/90 s wide; the input goes 3 m/s × 1/90 s = 33 mm
    // out and back, of which the filter lets half through.
    assert!((0.005..0.035).contains(&worst), "{worst}");
}

#[test]
fn a_still_hand_with_a_jittering_tracker_stands_still() {
    let person = hand(false);
    // A dither of a few tenths of a millimetre under the rounding makes it jump by whole steps.
    let still = |time: f64| {
        let dither = Vec3::new((time * 977.0).sin(), (time * 1409.0).sin(), (time * 523.0).sin());
        let turn = Quat::from_scaled_axis(Vec3::new(0.3, 0.2, 0.1) + dither * 5e-4);
        (Pose::new(Vec3::new(0.1, 1.0, 0.2) + dither * 4e-4, turn), vec![[0.0; 2]; 15])
    };
    let tracker = Tracker { rounding: [1e-3, 1e-3], ..Tracker::new(&person, &still) };
    let recording = tracker.recording(4.0);
    let raw: Vec<_> = recording.hand(Side::Right).iter().map(|s| s.joints[0].position).collect();
    let raw_speed = rms(raw.windows(2).map(|p| (p[1] - p[0]).norm() * 90.0));
    let mut motion = Recorded::new(&RecordedDesc::of_file("test"), &recording, &person).unwrap();
    let speed = rms((500..4000).map(|k| {
        let target = sample(&mut motion, f64::from(k) * 1e-3)[0];
        target.velocity_W.norm()
    }));
    assert!(raw_speed > 0.05, "the test must jitter: {raw_speed}");
    assert!(speed < raw_speed / 6.0, "{speed} of {raw_speed} m/s");
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += value * value;
        count += 1.0;
    }
    f64::sqrt(sum / count)
}

#[test]
fn targets_depend_on_time_alone() {
    let person = hand(false);
    let mut fine = motion(&rough(&person), 4.0, &person);
    let mut coarse = fine.clone();
    for k in 0..240 {
        let time = f64::from(k) / 60.0;
        for sub in 0..7 {
            sample(&mut fine, time - f64::from(6 - sub) * 1e-3 / 3.0);
        }
        assert_eq!(sample(&mut fine, time), sample(&mut coarse, time), "{time}");
    }
    // Also after going back.
    let again = sample(&mut fine, 1.0);
    assert_eq!(again, sample(&mut coarse, 1.0));
}

#[test]
fn a_left_recording_drives_a_right_hand_mirrored() {
    let person = hand(false);
    let right = Tracker::new(&person, &wave);
    let left = Tracker { mirror: true, side: Side::Left, ..Tracker::new(&person, &wave) };
    let mut straight = motion(&right, 1.0, &person);
    let desc = RecordedDesc { hand: Some(Side::Left), ..RecordedDesc::of_file("test") };
    let mut mirror = Recorded::new(&desc, &left.recording(1.0), &person).unwrap();
    for k in 0..100 {
        let time = f64::from(k) * 0.01;
        for (a, b) in sample(&mut straight, time).iter().zip(sample(&mut mirror, time)) {
            assert!((a.pose_WB.position - b.pose_WB.position).norm() < 1e-9, "{time}");
            assert!(a.pose_WB.rotation.angle_to(&b.pose_WB.rotation) < 1e-6, "{time}");
        }
    }
}

#[test]
fn the_start_placement_holds_a_hand_at_rest() {
    let person = hand(false);
    let desc = RecordedDesc {
        position: [0.0, -1.0, 0.3],
        heading_deg: 90.0,
        ..RecordedDesc::of_file("test")
    };
    let recording = Tracker::new(&person, &wave).recording(1.0);
    let mut motion = Recorded::new(&desc, &recording, &person).unwrap();
    let pose_WM = motion.start_placement();
    for (bone, target) in person.bones.iter().zip(sample(&mut motion, 0.0)) {
        let placed = pose_WM * bone.pose_MB;
        assert!((placed.position - target.pose_WB.position).norm() < 1e-9);
        assert!(placed.rotation.angle_to(&target.pose_WB.rotation) < 1e-7);
    }
    // The wave starts at (0.2, 1, 0): turned by 90° about y, (0, 1, -0.2).
    let wrist = sample(&mut motion, 0.0)[0].pose_WB.position;
    assert!((wrist - Vec3::new(0.0, 0.0, 0.1)).norm() < 1e-6, "{wrist}");
}

#[test]
fn wrong_settings_and_missing_hands_are_named() {
    let person = hand(false);
    let recording = Tracker::new(&person, &wave).recording(0.2);
    let fails = |desc: RecordedDesc, with: &str| {
        let error = Recorded::new(&desc, &recording, &person).unwrap_err().to_string();
        assert!(error.contains(with), "{error}");
    };
    let usual = || RecordedDesc::of_file("test");
    fails(RecordedDesc { hand: Some(Side::Left), ..usual() }, "no left hand");
    fails(RecordedDesc { start_s: 50.0, ..usual() }, "no right hand");
    fails(RecordedDesc { filter_hz: 0.0, ..usual() }, "filter_hz must be between 0.5");
    fails(RecordedDesc { speed_max: f64::NAN, ..usual() }, "speed_max must be");
    fails(RecordedDesc { position: [f64::INFINITY, 0.0, 0.0], ..usual() }, "position");
    let mut handless = hand(false);
    handless.bones[0].tracked_joint = None;
    let error = Recorded::new(&usual(), &recording, &handless).unwrap_err().to_string();
    assert!(error.contains("`wrist`"), "{error}");
}

#[test]
fn times_that_are_no_numbers_leave_the_targets_finite() {
    let person = hand(false);
    let mut motion = motion(&rough(&person), 2.5, &person);
    for time in [f64::NAN, -1e300, 0.3, f64::INFINITY, 1e300, f64::NAN, 0.1] {
        for target in sample(&mut motion, time) {
            assert!(target.pose_WB.is_finite());
            assert!(target.velocity_W.iter().all(|x| x.is_finite()));
        }
    }
}

/// A real capture of both hands, where `THENAR_MOTION_DIR` names the folder that holds one.
#[test]
fn a_real_capture_is_followed() {
    let Some(folder) = std::env::var_os("THENAR_MOTION_DIR") else {
        eprintln!("skipped: THENAR_MOTION_DIR is not set");
        return;
    };
    let file = Path::new(&folder).join("quest3-two-hands-8s.jsonl");
    let recording = Recording::open(&file).unwrap();
    assert_eq!(recording.hand(Side::Left).len(), 667);
    assert_eq!(recording.hand(Side::Right).len(), 756);
    let ours = hand(true);
    for side in [Side::Left, Side::Right] {
        let desc = RecordedDesc { hand: Some(side), ..RecordedDesc::of_file(&file) };
        let mut motion = Recorded::new(&desc, &recording, &ours).unwrap();
        let mut lost = 0;
        for k in 0..9000 {
            let time = f64::from(k) * 1e-3;
            for target in sample(&mut motion, time) {
                assert!(target.velocity_W.norm() < 5.0, "{time}");
                assert!(target.pose_WB.is_finite());
            }
            lost += u32::from(motion.tracking() == Tracking::Lost && time < motion.duration());
        }
        // The left hand is away for 1.01 s, of which the first 0.1 s is not yet a loss.
        let want = if side == Side::Left { 905..925 } else { 0..1 };
        assert!(want.contains(&lost), "{side:?} {lost}");
        let ratio = size_ratio(&ours, recording.hand(side)).unwrap();
        assert!((0.8..1.2).contains(&ratio), "{ratio}");
    }
}
