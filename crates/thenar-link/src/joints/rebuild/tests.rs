//! Goal: joint frames come back from points alone, on hands that differ in shape and pose.
//! Method: hands of which everything is known lose all but 21 points.

use super::*;
use std::path::Path;
use thenar_core::random::Random;
use thenar_track::{Recording, TrackedSample};

/// Errors of the rebuilt joints: worst and mean angle of finger bones, of thumb bones and of the
/// wrist \[degrees\], mean distance of metacarpal bases \[m\].
#[derive(Debug, Default)]
struct Errors {
    fingers: Vec<f64>,
    thumb: Vec<f64>,
    wrist: Vec<f64>,
    bases: Vec<f64>,
}

impl Errors {
    fn add(&mut self, side: Side, sample: &TrackedSample) {
        let points = WEBXR_OF_POINT.map(|joint| sample.joints[joint].position);
        let LivePose::Joints { joints, .. } = rebuild(side, &points).unwrap() else {
            panic!("joints were asked for");
        };
        for (joint, (ours, theirs)) in joints.iter().zip(&sample.joints).enumerate() {
            let angle = ours.rotation.angle_to(&theirs.rotation).to_degrees();
            match joint {
                0 => self.wrist.push(angle),
                1..=4 => self.thumb.push(angle),
                // Headsets turn metacarpals like the wrist, not along the bone as the standard has
                // it: only their place is compared.
                5 | 10 | 15 | 20 => self.bases.push((ours.position - theirs.position).norm()),
                _ => self.fingers.push(angle),
            }
            if ![5, 10, 15, 20].contains(&joint) {
                assert_eq!(ours.position, theirs.position);
            }
        }
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn worst(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

fn hands() -> Recording {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hands.jsonl");
    Recording::open(&file).unwrap()
}

/// The wearer of the capture, at rest.
#[test]
fn frames_come_back_on_hands_of_a_headset() {
    let hands = hands();
    let mut errors = Errors::default();
    (hands.hand(Side::Left)[..2].iter()).for_each(|sample| errors.add(Side::Left, sample));
    assert!(mean(&errors.fingers) < 5.0 && worst(&errors.fingers) < 12.0, "{errors:?}");
    assert!(mean(&errors.thumb) < 10.0 && worst(&errors.wrist) < 3.0, "{errors:?}");
    assert!(worst(&errors.bases) < 0.006, "{errors:?}");
}

/// A hand that an artist made, whose proportions nothing was fitted to.
#[test]
fn frames_come_back_roughly_on_another_hand() {
    let hands = hands();
    let mut errors = Errors::default();
    for side in [Side::Left, Side::Right] {
        let last = hands.hand(side).last().unwrap();
        errors.add(side, last);
    }
    assert!(mean(&errors.fingers) < 15.0, "{errors:?}");
    assert!(mean(&errors.bases) < 0.02, "{errors:?}");
}

/// All of a real capture, where `THENAR_MOTION_DIR` names the folder that holds one.
#[test]
fn frames_come_back_on_a_real_capture() {
    let Some(folder) = std::env::var_os("THENAR_MOTION_DIR") else {
        eprintln!("skipped: THENAR_MOTION_DIR is not set");
        return;
    };
    let file = Path::new(&folder).join("quest3-two-hands-8s.jsonl");
    let recording = Recording::open(&file).unwrap();
    for side in [Side::Left, Side::Right] {
        let mut errors = Errors::default();
        recording.hand(side).iter().for_each(|sample| errors.add(side, sample));
        let all = [&errors.fingers, &errors.thumb, &errors.wrist, &errors.bases];
        eprintln!("{side:?} mean {:?} worst {:?}", all.map(|e| mean(e)), all.map(|e| worst(e)));
        assert!(mean(&errors.fingers) < 4.5 && worst(&errors.fingers) < 18.0);
        assert!(mean(&errors.thumb) < 8.0 && worst(&errors.thumb) < 22.0);
        assert!(worst(&errors.wrist) < 1.5 && mean(&errors.bases) < 0.0015);
    }
}

/// A mirrored hand gives mirrored frames, a moved one moved frames, and a larger one thicker.
#[test]
fn hands_may_be_anywhere_and_on_either_side() {
    use thenar_track::mirrored;
    let sample = &hands().hand(Side::Left)[0].joints.map(|joint| joint);
    let points = WEBXR_OF_POINT.map(|joint| sample[joint].position);
    let joints = |side, points: &[Vec3; POINTS]| match rebuild(side, points).unwrap() {
        LivePose::Joints { joints, radii } => (joints, radii),
        LivePose::Angles { .. } => panic!("joints were asked for"),
    };
    let (here, radii) = joints(Side::Left, &points);
    let reflected = points.map(|p| Vec3::new(-p.x, p.y, p.z));
    let move_ = Pose::new(Vec3::new(1.0, -2.0, 3.0), Quat::from_euler_angles(0.4, -2.0, 1.0));
    let (there, _) = joints(Side::Left, &points.map(|p| move_.point(&p)));
    let (other, _) = joints(Side::Right, &reflected);
    for joint in 0..25 {
        for (got, want) in
            [(other[joint], mirrored(&here[joint])), (there[joint], move_ * here[joint])]
        {
            assert!((got.position - want.position).norm() < 1e-12);
            assert!(got.rotation.angle_to(&want.rotation) < 1e-7);
        }
    }
    let (_, thick) = joints(Side::Left, &points.map(|p| p * 1.3));
    assert!(thick.iter().zip(radii).all(|(a, b)| (a / b - 1.3).abs() < 1e-9));
}

#[test]
fn what_is_no_hand_is_refused() {
    let points = WEBXR_OF_POINT.map(|joint| hands().hand(Side::Left)[0].joints[joint].position);
    let with = |point: usize, at: Vec3| {
        let mut points = points;
        points[point] = at;
        rebuild(Side::Left, &points)
    };
    assert_eq!(rebuild(Side::Left, &[Vec3::zeros(); POINTS]), Err(RebuildError::NoPalm));
    let line = std::array::from_fn(|i| Vec3::x() * (0.01 * i as f64));
    assert_eq!(rebuild(Side::Left, &line), Err(RebuildError::NoPalm));
    for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e300] {
        assert_eq!(with(7, Vec3::new(0.0, bad, 0.0)), Err(RebuildError::Unreachable(7)));
    }
    let far = with(20, points[0] + Vec3::x() * 0.6);
    assert!(matches!(far, Err(RebuildError::TooLarge { point: 20, .. })), "{far:?}");
}

/// Fingers without length and points on each other leave frames that are rotations.
#[test]
fn frames_are_rotations_whatever_the_points() {
    let mut random = Random::new(7);
    let mut random = || 0.5 * random.symmetric();
    let points = WEBXR_OF_POINT.map(|joint| hands().hand(Side::Left)[0].joints[joint].position);
    let mut made = 0;
    for round in 0..2000 {
        let spread = [0.0, 1e-9, 0.01, 0.1, 0.4][round % 5];
        let mut points = points.map(|p| p + Vec3::new(random(), random(), random()) * spread);
        points[1 + round % 20] = points[round % 20];
        let Ok(LivePose::Joints { joints, .. }) = rebuild(Side::Right, &points) else { continue };
        made += 1;
        for joint in joints {
            let turn = joint.rotation.to_rotation_matrix();
            let off = (turn.matrix() * turn.matrix().transpose() - Mat3::identity()).norm();
            assert!(joint.is_finite() && off < 1e-9 && turn.matrix().determinant() > 0.0);
        }
    }
    assert!(made > 1000, "{made}");
}
