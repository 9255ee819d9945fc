//! Goal: what the app sends becomes the hand that it saw, however it is cut, mixed or damaged.

use super::*;
use crate::joints::WEBXR_OF_POINT;
use crate::testing::{collect, hands};
use thenar_core::model::Side;
use thenar_testing::Mutator;
use thenar_track::live::LivePose;

const MS: u64 = 1_000_000;

fn protocol() -> HandTrackingStreamer {
    HandTrackingStreamer::new(false, Points::Auto)
}

/// The relaxed left hand, somewhere.
fn hand() -> [Pose; 25] {
    hands(Side::Left)[0]
}

fn samples(events: &[Event]) -> Vec<&HandSample> {
    (events.iter())
        .filter_map(|event| if let Event::Sample(sample) = event { Some(sample) } else { None })
        .collect()
}

fn is_hand(sample: &HandSample, want: &[Pose; 25]) -> bool {
    let Some(LivePose::Joints { joints, .. }) = &sample.pose else { return false };
    // Six decimals were sent.
    WEBXR_OF_POINT.iter().all(|j| (joints[*j].position - want[*j].position).norm() < 3e-6)
}

#[test]
fn hands_arrive_in_either_frame() {
    for points in [Points::Local, Points::World] {
        for setting in [Points::Auto, points] {
            let text = twin::lines(Side::Left, &hand(), points, Some((1, 5)));
            let mut protocol = HandTrackingStreamer::new(true, setting);
            let events = collect(&mut protocol, 7 * MS, &[text.as_bytes()]);
            let [sample] = samples(&events)[..] else { panic!("{events:?}") };
            assert_eq!((sample.side, sample.time_ns), (Side::Left, 7 * MS));
            assert!(is_hand(sample, &hand()), "{points:?} {setting:?}");
        }
    }
}

#[test]
fn a_stream_may_be_cut_anywhere() {
    let text: String = [Side::Left, Side::Right]
        .map(|side| twin::lines(side, &hands(side)[0], Points::Local, Some((1, 1))))
        .concat();
    let whole = collect(&mut protocol(), MS, &[text.as_bytes()]);
    assert_eq!(samples(&whole).len(), 2);
    for cut in 0..text.len() {
        let (a, b) = text.as_bytes().split_at(cut);
        assert_eq!(collect(&mut protocol(), MS, &[a, b]), whole, "{cut}");
    }
}

/// A wrist of one frame and landmarks of another are no hand.
#[test]
fn parts_of_different_frames_are_not_joined() {
    let moved = hand().map(|p| Pose::translation(0.1, 0.0, 0.0) * p);
    let frame = |joints, n| twin::lines(Side::Left, joints, Points::Local, Some((n, n * 11)));
    let (one, two) = (frame(&hand(), 1), frame(&moved, 2));
    let half = |text: &str, k: usize| text.lines().nth(k).unwrap().to_owned() + "\n";
    let mut protocol = protocol();
    // The wrist of frame 1, the landmarks of frame 2, then its wrist: that completes it.
    let mixed = [half(&one, 0), half(&two, 1), half(&two, 0)];
    let pieces: Vec<&[u8]> = mixed.iter().map(|s| s.as_bytes()).collect();
    let events = collect(&mut protocol, MS, &pieces);
    let [sample] = samples(&events)[..] else { panic!("{events:?}") };
    assert!(is_hand(sample, &moved));

    // Without numbers time tells: a lost line does not shift all that follow.
    let bare = |joints| twin::lines(Side::Left, joints, Points::Local, None);
    let (one, two) = (bare(&hand()), bare(&moved));
    let mut protocol = HandTrackingStreamer::new(true, Points::Auto);
    let late = half(&one, 1);
    assert!(samples(&collect(&mut protocol, 20 * MS, &[late.as_bytes()])).is_empty());
    let events = collect(&mut protocol, 31 * MS, &[half(&two, 0).as_bytes()]);
    assert!(samples(&events).is_empty());
    let events = collect(&mut protocol, 32 * MS, &[half(&two, 1).as_bytes()]);
    assert!(is_hand(samples(&events)[0], &moved));
}

/// The headset's clock is behind by 3 s; frames take between 1 ms and 6 ms.
#[test]
fn samples_have_the_time_of_the_headset() {
    let mut protocol = protocol();
    for k in 0..50u64 {
        let measured = 5000 * MS + k * 14 * MS;
        let time = measured as i64 - 3_000_000_000;
        let text = twin::lines(Side::Left, &hand(), Points::Local, Some((k as i64, time)));
        let now = measured + MS + (k * 3 % 6) * MS;
        let events = collect(&mut protocol, now, &[text.as_bytes()]);
        let [sample] = samples(&events)[..] else { panic!("{events:?}") };
        // The first datagram took the shortest way, 1 ms.
        assert!(sample.time_ns.abs_diff(measured + MS) < MS / 10);
    }
}

/// Damaged text gives samples, refusals or nothing, the rest is understood again, and every sample
/// is a hand within reach.
#[test]
fn damaged_streams_do_no_harm() {
    let mut mutator = Mutator::new(11);
    let (mut hands_seen, mut refused) = (0, 0);
    let good = twin::lines(Side::Left, &hand(), Points::Local, Some((3, 4)));
    for round in 0..3000 {
        let mut protocol = HandTrackingStreamer::new(round % 2 == 0, Points::Auto);
        let text = mutator.damage(good.as_bytes());
        for event in collect(&mut protocol, MS, &[&text]) {
            match event {
                Event::Sample(sample) => {
                    let Some(LivePose::Joints { joints, .. }) = sample.pose else { panic!() };
                    assert!(joints.iter().all(|j| j.is_finite() && j.position.norm() < 21.0));
                    hands_seen += 1;
                }
                Event::Refused(cause) => {
                    assert!(!cause.is_empty() && cause.len() < 200, "{cause}");
                    refused += 1;
                }
                _ => {}
            }
        }
        let after = format!("\n{}", good.replace("f=3", "f=12345"));
        let events = collect(&mut protocol, 500 * MS, &[after.as_bytes()]);
        assert!(is_hand(samples(&events).last().expect("a hand"), &hand()));
    }
    assert!(hands_seen > 500 && refused > 500, "{hands_seen} {refused}");
}
