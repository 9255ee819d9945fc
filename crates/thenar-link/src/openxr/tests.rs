//! Goal: what a runtime tells becomes hands. Method: a runtime that says what a test wants.

use super::*;
use crate::testing::{collect, hands};
use std::collections::VecDeque;
use thenar_testing::Mutator;

/// Answers, one after the other; then the session has ended.
struct Mock(VecDeque<Option<HandJoints>>);

impl Runtime for Mock {
    fn hands(&mut self) -> io::Result<Option<HandJoints>> {
        self.0.pop_front().ok_or_else(|| io::ErrorKind::NotConnected.into())
    }
}

/// A hand as a runtime tells it: the palm, then our joints.
fn told(side: Side) -> [Joint; OPENXR_JOINTS] {
    let hand = hands(side)[0];
    std::array::from_fn(|i| {
        let pose = hand[i.saturating_sub(1)];
        Joint {
            valid: true,
            position: pose.position.map(|x| x as f32).into(),
            rotation: pose.rotation.coords.map(|x| x as f32).into(),
            radius: 0.001 * i as f32,
        }
    })
}

/// All events of a runtime until its session ends.
fn events(answers: Vec<HandJoints>) -> Vec<Event> {
    events_with_pauses(answers.into_iter().map(Some).collect())
}

fn events_with_pauses(answers: Vec<Option<HandJoints>>) -> Vec<Event> {
    let mut transport = RuntimeTransport::new(Mock(answers.into()));
    let (mut protocol, mut events) = (OpenXrHands::default(), Vec::new());
    let mut buffer = vec![0; 1 << 16];
    while let Ok(length) = transport.receive(&mut buffer, Duration::from_millis(1)) {
        events.extend(collect(&mut protocol, 9, &[&buffer[..length]]));
    }
    events
}

#[test]
fn joints_come_out_in_our_order() {
    let events = events(vec![[Some(told(Side::Left)), Some(told(Side::Right))]]);
    let [Event::Sample(left), Event::Sample(right)] = &events[..] else { panic!("{events:?}") };
    for (sample, side) in [(left, Side::Left), (right, Side::Right)] {
        assert_eq!((sample.side, sample.time_ns), (side, 9));
        let Some(LivePose::Joints { joints, radii }) = &sample.pose else { panic!() };
        for (k, want) in hands(side)[0].iter().enumerate() {
            assert!((joints[k].position - want.position).norm() < 1e-6);
            assert!(joints[k].rotation.angle_to(&want.rotation) < 1e-3);
            assert!((radii[k] - 0.001 * (k + 1) as f64).abs() < 1e-8);
        }
    }
}

#[test]
fn a_hand_with_a_joint_missing_is_not_seen() {
    let seen = Some(told(Side::Left));
    let mut half = told(Side::Left);
    half[7].valid = false;
    // Joints that are not known may hold anything.
    half[7].position = [f32::NAN; 3];
    let mut palmless = told(Side::Left);
    palmless[0].valid = false;
    let answers = [seen, Some(half), None, None, Some(palmless)];
    let events = events(answers.map(|left| [left, None]).to_vec());
    let left: Vec<_> = (events.iter())
        .filter_map(|event| match event {
            Event::Sample(sample) => Some((sample.side, sample.pose.is_some())),
            _ => None,
        })
        .collect();
    // The loss is told once; our joints need no palm.
    assert_eq!(left, [true, false, true].map(|seen| (Side::Left, seen)));
    assert_eq!(events.iter().filter(|e| **e == Event::Alive).count(), 7);
}

/// Hands are lost when the session stops, and then nothing is said until it runs again.
#[test]
fn a_session_that_does_not_run_is_silent() {
    let seen = Some([Some(told(Side::Left)), None]);
    let events = events_with_pauses(vec![None, None, seen, None, None, None, seen]);
    let left: Vec<_> = events
        .iter()
        .map(|event| match event {
            Event::Sample(HandSample { side: Side::Left, pose, .. }) => Some(pose.is_some()),
            Event::Alive => None,
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(left, [Some(true), None, Some(false), None, Some(true), None]);
}

/// A message is reported, and what comes after it is read.
#[test]
fn notes_are_told() {
    struct Noting(Option<&'static str>);
    impl Runtime for Noting {
        fn hands(&mut self) -> io::Result<Option<HandJoints>> {
            Ok(Some([Some(told(Side::Left)), None]))
        }
        fn note(&mut self) -> Option<&'static str> {
            self.0.take()
        }
    }
    let mut transport = RuntimeTransport::new(Noting(Some("no stage")));
    let (mut protocol, mut buffer) = (OpenXrHands::default(), vec![0; 1 << 16]);
    let mut receive = || {
        let length = transport.receive(&mut buffer, Duration::from_millis(9)).unwrap();
        collect(&mut protocol, 9, &[&buffer[..length]])
    };
    assert_eq!(receive(), [Event::Note("no stage".into())]);
    assert!(matches!(receive()[..], [Event::Sample(_), Event::Alive]));
}

#[test]
fn numbers_that_are_none_are_refused() {
    for (place, bad) in [(0, f32::NAN), (0, 1e9), (3, 9.0), (7, -1.0), (7, f32::NAN)] {
        let mut hand = told(Side::Right);
        match place {
            0 => hand[3].position[0] = bad,
            3 => hand[3].rotation = [bad; 4],
            _ => hand[3].radius = bad,
        }
        let events = events(vec![[None, Some(hand)]]);
        assert!(matches!(events[..], [Event::Alive, Event::Refused(_)]), "{events:?}");
    }
    let mut good = vec![0; HAND_BYTES];
    write(&mut good, 0, Some(&told(Side::Left)));
    let (mut mutator, mut protocol) = (Mutator::new(2), OpenXrHands::default());
    let mut refused = 0;
    for _ in 0..3000 {
        for event in collect(&mut protocol, 1, &[&mutator.damage(&good)]) {
            refused += u32::from(matches!(event, Event::Refused(_)));
            if let Event::Sample(HandSample { pose: Some(pose), .. }) = event {
                assert!(thenar_track::live::checked(0.0, &pose).is_ok());
            }
        }
    }
    assert!(refused > 300, "{refused}");
}

/// Without a runtime the device opens, says so and waits. Where one is installed this opens it.
#[test]
fn without_a_runtime_it_waits() {
    let told = crate::open("openxr:7").map(|_| ()).unwrap_err().to_string();
    assert!(told.contains("expected nothing or the loader's full path"), "{told}");
    assert!(crate::open("openxr:").unwrap().tracker.is_some());
}
