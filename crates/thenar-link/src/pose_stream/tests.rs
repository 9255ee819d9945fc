//! Goal: what is sent arrives, recordings included, whatever is wrong is refused with its cause,
//! and a hostile peer costs no more than it may.

use super::*;
use crate::joints::WEBXR_OF_POINT;
use crate::testing::{collect, hands};
use thenar_core::Pose;
use thenar_core::model::Side;
use thenar_testing::Mutator;
use thenar_track::live::{LivePose, checked};

const MS: u64 = 1_000_000;

fn pose(side: Side) -> LivePose {
    let radii = std::array::from_fn(|joint| 0.005 + 0.0005 * joint as f64);
    LivePose::Joints { joints: hands(side)[0], radii }
}

fn joints(pose: &LivePose) -> &[Pose; 25] {
    let LivePose::Joints { joints, .. } = pose else { panic!("joints were sent") };
    joints
}

fn near(a: &LivePose, b: &LivePose) -> bool {
    joints(a).iter().zip(joints(b)).all(|(a, b)| {
        (a.position - b.position).norm() < 2e-6 && a.rotation.angle_to(&b.rotation) < 1e-5
    })
}

fn one(events: &[Event]) -> &HandSample {
    match events {
        [Event::Sample(sample)] => sample,
        _ => panic!("{events:?}"),
    }
}

fn cause(text: &str) -> String {
    match &collect(&mut PoseStream::new(true), MS, &[text.as_bytes()])[..] {
        [Event::Refused(cause)] => cause.clone(),
        events => panic!("{text}: {events:?}"),
    }
}

#[test]
fn what_is_written_is_read() {
    for side in [Side::Left, Side::Right] {
        let text = write(side, 12.5, Some(&pose(side)));
        let events = collect(&mut PoseStream::new(true), 3 * MS, &[text.as_bytes()]);
        let sample = one(&events);
        assert_eq!((sample.side, sample.time_ns), (side, 3 * MS));
        let got = sample.pose.as_ref().unwrap();
        assert!(near(got, &pose(side)));
        let (LivePose::Joints { radii: a, .. }, LivePose::Joints { radii: b, .. }) =
            (got, &pose(side))
        else {
            panic!()
        };
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6));
    }
    let lost = write(Side::Left, 1.0, None);
    let events = collect(&mut PoseStream::new(true), MS, &[lost.as_bytes()]);
    assert_eq!(one(&events).pose, None);
}

/// A recording sent as it is gives what reading it as a recording gives, however it is cut.
#[test]
fn recordings_are_streams() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hands.jsonl");
    let text = std::fs::read(file).unwrap();
    let whole = collect(&mut PoseStream::new(false), MS, &[&text]);
    let mut count = 0;
    for side in [Side::Left, Side::Right] {
        let got: Vec<_> = (whole.iter())
            .filter_map(|event| match event {
                Event::Sample(sample) if sample.side == side => Some(sample),
                _ => None,
            })
            .collect();
        let recording = thenar_track::Recording::open(std::path::Path::new(file)).unwrap();
        let want = recording.hand(side);
        assert_eq!(got.len(), want.len());
        count += got.len();
        for (got, want) in got.iter().zip(want) {
            assert_eq!(joints(got.pose.as_ref().unwrap()), &want.joints);
        }
    }
    assert_eq!(count, 4);
    for cut in (0..text.len()).step_by(37) {
        let (a, b) = text.split_at(cut);
        assert_eq!(collect(&mut PoseStream::new(false), MS, &[a, b]), whole, "{cut}");
    }
}

#[test]
fn the_order_of_joints_is_that_of_the_header() {
    let mut names = thenar_track::TRACKED_JOINTS;
    names.swap(0, 24);
    let header = serde_json::json!({
        "format": "hand-joints-jsonl", "version": 1, "quat": "x,y,z,w", "joints": names,
    });
    let text = format!("{header}\n{}", write(Side::Left, 0.0, Some(&pose(Side::Left))));
    let mut stream = PoseStream::new(true);
    let events = collect(&mut stream, MS, &[text.as_bytes()]);
    let got = joints(one(&events).pose.as_ref().unwrap());
    let sent = pose(Side::Left);
    let want = joints(&sent);
    assert!((got[0].position - want[24].position).norm() < 2e-6);
    assert!((got[24].position - want[0].position).norm() < 2e-6);
    assert!((got[7].position - want[7].position).norm() < 2e-6);
    // Whoever speaks next begins anew.
    stream.start(0, &mut |_| {});
    let again = write(Side::Left, 0.0, Some(&pose(Side::Left)));
    let events = collect(&mut stream, MS, &[again.as_bytes()]);
    assert!(near(one(&events).pose.as_ref().unwrap(), &pose(Side::Left)));
}

#[test]
fn other_numbers_of_joints_are_other_orders() {
    let hand = hands(Side::Left)[0];
    let line = |pos: &[Pose], quat: bool| {
        let places: Vec<_> = pos.iter().map(|p| p.position.as_slice().to_vec()).collect();
        let mut line = serde_json::json!({"hand": "left", "pos": places});
        if quat {
            let turns: Vec<_> = pos.iter().map(|p| p.rotation.coords.as_slice().to_vec()).collect();
            line["quat"] = serde_json::json!(turns);
        }
        line.to_string()
    };
    let read = |text: String| -> [Pose; 25] {
        let events = collect(&mut PoseStream::new(true), MS, &[text.as_bytes()]);
        *joints(one(&events).pose.as_ref().unwrap())
    };
    let palm = Pose::translation(9.0, 0.0, 0.0);
    let same = |a: &[Pose; 25]| {
        a.iter().zip(&hand).all(|(a, b)| {
            (a.position - b.position).norm() < 1e-12 && a.rotation.angle_to(&b.rotation) < 1e-6
        })
    };
    assert!(same(&read(line(&[&[palm][..], &hand].concat(), true))));
    assert!(same(&read(line(&[&hand[..], &[palm; 2]].concat(), true))));
    let points = WEBXR_OF_POINT.map(|joint| hand[joint]);
    let rebuilt = read(line(&points, false));
    assert!(WEBXR_OF_POINT.iter().all(|j| rebuilt[*j].position == hand[*j].position));
    for count in [0, 1, 20, 22, 24, 28] {
        let told = cause(&line(&vec![palm; count], true));
        assert!(told.contains(&format!("pos has {count} entries")), "{told}");
    }
    assert!(cause(&line(&hand, false)).contains("no quat"));
}

#[test]
fn what_is_wrong_is_named() {
    let good = write(Side::Left, 0.0, Some(&pose(Side::Left)));
    let with = |from: &str, to: &str| cause(&good.replacen(from, to, 1));
    assert!(cause("hello").contains("column 1: expected value"));
    assert!(cause("{}").contains("missing field `hand`"));
    assert!(cause("\u{feff}{}").contains("column 1"));
    assert!(with("left", "both").contains("unknown variant `both`"));
    assert!(with("\"t\":0.000000", "\"t\":1e30").contains("t is 1e30, expected at most"));
    assert!(with("\"t\":0.000000", "\"t\":NaN").contains("column 6"));
    assert!(with("\"pos\":[[", "\"pos\":[[1,2,3],[").contains("quat has 25 entries, pos 26"));
    assert!(with("\"pos\":[[-0.", "\"pos\":[[-90.").contains("out of reach"));
    assert!(with("\"quat\":[[", "\"quat\":[[9").contains("a quaternion of length 9"));
    assert!(with("\"radius\":[0.", "\"radius\":[3.").contains("a radius of 3.005 m"));
    assert!(with("\"radius\":[", "\"radius\":[0.1,").contains("radius has 26 entries"));
    assert!(cause("{\"format\":\"other\"}").starts_with("header: "));
    let long = format!("{{\"hand\":\"{}\"}}", "x".repeat(LINE_BYTES_MAX));
    assert!(cause(&long).contains("longer than 65536"));
    let deep = format!("{{\"hand\":\"left\",\"x\":{}", "[".repeat(60_000));
    assert!(cause(&deep).contains("EOF"));
}

/// Lines that pass the parser pass the simulation's own check, or are refused there without harm;
/// the next good line is understood.
#[test]
fn damaged_streams_do_no_harm() {
    let mut mutator = Mutator::new(5);
    let good = write(Side::Left, 0.0, Some(&pose(Side::Left)));
    let (mut read, mut refused) = (0, 0);
    for round in 0..3000u64 {
        let mut stream = PoseStream::new(round % 2 == 0);
        let bytes = mutator.damage(good.as_bytes());
        for event in collect(&mut stream, MS, &[&bytes]) {
            match event {
                Event::Sample(HandSample { pose: Some(pose), .. }) => {
                    assert!(checked(0.0, &pose).is_ok(), "{pose:?}");
                    read += 1;
                }
                Event::Refused(cause) => {
                    assert!(!cause.is_empty() && cause.len() < 200, "{cause}");
                    refused += 1;
                }
                _ => {}
            }
        }
        let next = format!("\n{good}");
        let events = collect(&mut stream, 100 * MS, &[next.as_bytes()]);
        let Some(Event::Sample(sample)) = events.last() else { panic!("{events:?}") };
        assert!(near(sample.pose.as_ref().unwrap(), &pose(Side::Left)));
    }
    assert!(read > 500 && refused > 500, "{read} {refused}");
}

/// A hundred times the rate: what is read is the rate, and it goes on when the flood ends.
#[test]
fn a_flood_is_bounded() {
    let mut stream = PoseStream::new(true);
    let line = b"{\"hand\":\"left\",\"tracked\":false}";
    let mut samples = 0;
    for k in 0..250_000u64 {
        let events = collect(&mut stream, k * 4_000, &[line]);
        samples += events.iter().filter(|e| matches!(e, Event::Sample(_))).count();
    }
    let most = LINES_PER_SECOND * 1.2 + 1.0;
    assert!((LINES_PER_SECOND..most).contains(&(samples as f64)), "{samples}");
    let events = collect(&mut stream, 1100 * MS, &[line]);
    assert!(matches!(events[..], [Event::Sample(_)]));
}

/// The sender's clock starts at 0 and the network delays by up to 20 ms.
#[test]
fn times_are_the_senders() {
    let mut stream = PoseStream::new(true);
    for k in 0..100u64 {
        let measured = 777 * MS + k * 10 * MS;
        let text = write(Side::Left, k as f64 * 0.01, Some(&pose(Side::Left)));
        let now = measured + (k % 5) * 5 * MS;
        let events = collect(&mut stream, now, &[text.as_bytes()]);
        assert!(one(&events).time_ns.abs_diff(measured) < MS);
    }
}
