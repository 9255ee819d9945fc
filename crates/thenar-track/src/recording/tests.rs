//! Goal: recordings come back as written, and whatever is wrong is refused with line and cause.

use super::*;
use crate::fixture::hand;
use crate::tracker::Tracker;
use crate::{Recorded, RecordedDesc};
use thenar_testing::Mutator;

fn text() -> String {
    let hand = hand(false);
    let motion = |time: f64| (Pose::translation(time, 1.0, 0.0), vec![[0.1 * time; 2]; 15]);
    Tracker::new(&hand, &motion).text(0.1)
}

fn read(text: &[u8]) -> Result<Recording, RecordingError> {
    Recording::read(text, Path::new("some.jsonl"))
}

fn fails(text: &str, with: &str) {
    let error = read(text.as_bytes()).unwrap_err().to_string();
    assert!(error.starts_with("some.jsonl") && error.contains(with), "{error}");
}

#[test]
fn samples_come_back_as_written_whatever_the_order_of_joints() {
    let hand = hand(false);
    let motion = |time: f64| (Pose::translation(time, 1.0, 0.0), vec![[0.1 * time; 2]; 15]);
    let tracker = Tracker::new(&hand, &motion);
    let recording = tracker.recording(0.1);
    assert_eq!((recording.hand(Side::Right).len(), recording.hand(Side::Left).len()), (9, 0));
    assert_eq!(recording.span(), Some([0.0, 8.0 / 90.0]));
    for sample in recording.hand(Side::Right) {
        for (read, made) in sample.joints.iter().zip(tracker.joints(sample.time)) {
            assert!((read.position - made.position).norm() < 1e-12);
            assert!(read.rotation.angle_to(&made.rotation) < 1e-7);
        }
    }

    // Swapping two joints in the header swaps them in the samples.
    let swapped =
        text().replacen("\"wrist\",\"thumb-metacarpal\"", "\"thumb-metacarpal\",\"wrist\"", 1);
    let swapped = read(swapped.as_bytes()).unwrap();
    let (a, b) = (&swapped.hand(Side::Right)[3], &recording.hand(Side::Right)[3]);
    assert_eq!((a.joints[0], a.joints[1], a.joints[2]), (b.joints[1], b.joints[0], b.joints[2]));
}

#[test]
fn what_is_wrong_is_named_with_its_line() {
    let good = text();
    let lines: Vec<&str> = good.lines().collect();
    let with = |k: usize, line: &str| {
        let mut lines = lines.clone();
        lines[k] = line;
        lines.join("\n")
    };
    fails("", "some.jsonl:1: empty");
    fails("\n\n", "empty");
    fails("{}", "some.jsonl:1: header: column 2: missing field `format`");
    fails(&good.replacen("\"version\":1", "\"version\":2", 1), "version 2");
    fails(&good.replacen("x,y,z,w", "w,x,y,z", 1), "quat must be");
    fails(&good.replacen("\"wrist\"", "\"elbow\"", 1), "joint `wrist` is missing");
    fails(&good.replacen("\"wrist\",", "", 1), "expected 25 joints, got 24");
    fails(&with(2, "{\"t\":"), "some.jsonl:3: column 5: EOF");
    fails(&good[..good.len() - 100], "some.jsonl:10: column");
    fails(&with(4, &lines[4].replacen("\"right\"", "\"both\"", 1)), "some.jsonl:5: ");
    fails(&with(3, lines[5]), "some.jsonl:5: time goes back");
    fails(&with(1, &lines[1].replacen("\"pos\":[", "\"pos\":[[0,0,0],", 1)), "26 entries");
    fails(&with(1, &lines[1].replacen("\"quat\":[", "\"quat\":[[0,0,0,1],", 1)), "quat has 26");
    fails(&with(1, &lines[1].replacen("\"t\":0.0", "\"t\":1e999", 1)), "out of range");
    fails(&with(1, &lines[1].replacen("\"t\":0.0", "\"t\":1e99", 1)), "at most 10000000 s");
    fails(&with(1, &lines[1].replacen("\"t\":0.0", "\"t\":NaN", 1)), "some.jsonl:2: column");
    fails(&with(1, "{\"t\":0,\"hand\":\"left\",\"pos\":[[1]],\"quat\":[]}"), "some.jsonl:2");
    let long = "x".repeat(LINE_BYTES_MAX as usize + 5);
    fails(&with(1, &long), "some.jsonl:2: line longer than 65536");

    let far = "{\"t\":0,\"hand\":\"left\",\"pos\":[".to_string() + &["[0,1e300,0]"; 25].join(",");
    let zero = "],\"quat\":[".to_string() + &["[0,0,0,0]"; 25].join(",") + "]}";
    fails(&with(1, &(far.clone() + &zero)), "joint `wrist`: position");
    fails(&with(1, &(far.replace("1e300", "1") + &zero)), "quaternion of length 0");
    assert!(read(&[0xff, 0xfe, 0x00, b'\n']).is_err());
}

#[test]
fn an_endless_file_is_refused() {
    // 64 KiB blank lines repeated without end.
    struct Endless;
    impl std::io::Read for Endless {
        fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
            into.fill(b' ');
            let last = into.len() - 1;
            into[last] = b'\n';
            Ok(into.len())
        }
    }
    let reader = BufReader::with_capacity(60_000, Endless);
    let error = Recording::read(reader, Path::new("endless")).unwrap_err();
    assert!(matches!(error, RecordingError::TooLong { .. }), "{error}");
}

#[test]
fn mirroring_keeps_the_bone_axis_and_the_back() {
    let pose =
        Pose::new(Vec3::new(1.0, 2.0, 3.0), Quat::from_scaled_axis(Vec3::new(0.3, -0.8, 0.5)));
    let reflect = |v: Vec3| Vec3::new(-v.x, v.y, v.z);
    let mirror = mirrored(&pose);
    assert!((mirror.position - reflect(pose.position)).norm() < 1e-15);
    assert!((mirror.vector(&Vec3::z()) - reflect(pose.vector(&Vec3::z()))).norm() < 1e-14);
    assert!((mirror.vector(&Vec3::y()) - reflect(pose.vector(&Vec3::y()))).norm() < 1e-14);
    assert!((mirror.vector(&Vec3::x()) + reflect(pose.vector(&Vec3::x()))).norm() < 1e-14);
}

#[test]
fn damaged_files_are_read_or_refused_but_never_harm() {
    let (good, hand) = (text(), hand(false));
    let mut mutator = Mutator::new(5);
    let (mut read_well, mut refused) = (0, 0);
    for _ in 0..3000 {
        let Ok(recording) = read(&mutator.damage(good.as_bytes())) else {
            refused += 1;
            continue;
        };
        read_well += 1;
        let Ok(mut motion) = Recorded::new(&RecordedDesc::of_file("x"), &recording, &hand) else {
            continue;
        };
        let mut out = vec![None; 16];
        for k in 0..10 {
            motion.sample(f64::from(k) * 0.02, &mut out);
            assert!(out.iter().flatten().all(|target| target.pose_WB.is_finite()));
        }
    }
    assert!(read_well > 100 && refused > 1000, "{read_well} {refused}");
}
