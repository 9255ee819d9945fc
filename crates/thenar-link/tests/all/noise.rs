//! Goal: no bytes harm a protocol. Method: good streams, cut at every byte, read at another speed
//! or mutated at random (seeded), straight into the protocols.

// The fuzz target of all protocols is built here as well, and run on seeded damage.
#[allow(unused_attributes)] // it has no main of its own
#[path = "../../../../fuzz/fuzz_targets/gloves.rs"]
mod target;

/// What the fuzzer calls.
#[macro_export]
macro_rules! fuzz_target {
    (|$bytes:ident: &[u8]| $body:block) => {
        pub fn run($bytes: &[u8]) $body
    };
}

use std::sync::Arc;
use thenar_core::Pose;
use thenar_core::model::Side;
use thenar_core::random::Random;
use thenar_link::cyberglove::{self, Classic, ClassicTwin, Third, ThirdTwin};
use thenar_link::cybergrasp::CyberGrasp;
use thenar_link::force_device::{self, ForceDevice};
use thenar_link::hand_tracking_streamer::{HandTrackingStreamer, Points, twin};
use thenar_link::lucidgloves::{self, LucidGloves, LucidGlovesTwin};
use thenar_link::profile::{Address, load};
use thenar_link::twin::Twin;
use thenar_link::{Event, Protocol, pose_stream};
use thenar_track::Recording;
use thenar_track::live::LivePose;

/// A protocol and a stream of good packets, ten or, of the long ones, three, the first of them
/// another hand's than the others.
struct Case {
    name: &'static str,
    protocol: Box<dyn Protocol>,
    packets: Vec<Vec<u8>>,
    /// Over a serial line.
    serial: bool,
}

const CURLS: [f64; 5] = [0.2, 0.4, 0.6, 0.8, 0.3];

/// A hand, and the same elsewhere.
fn hands() -> [[Pose; 25]; 2] {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hands.jsonl");
    let joints = Recording::open(std::path::Path::new(file)).unwrap().hand(Side::Left)[0].joints;
    [joints, joints.map(|pose| Pose::translation(0.1, 0.0, 0.0) * pose)]
}

fn cases() -> Vec<Case> {
    let none = Address::default();
    let lucid: Arc<lucidgloves::Profile> =
        Arc::new(load("lucidgloves", lucidgloves::SHIPPED, &none).unwrap());
    let classic: Arc<cyberglove::Profile> =
        Arc::new(load("cyberglove", cyberglove::SHIPPED, &none).unwrap());
    let third: Arc<cyberglove::Profile> =
        Arc::new(load("cyberglove3", cyberglove::SHIPPED_3, &none).unwrap());
    let ten = |first: Vec<u8>, others: Vec<u8>| {
        std::iter::once(first).chain(vec![others; 9]).collect::<Vec<_>>()
    };
    let lines = |legacy| {
        let mut twin = LucidGlovesTwin::new(legacy, !legacy);
        let first = twin.line().into_bytes();
        twin.set_curls(CURLS);
        ten(first, twin.line().into_bytes())
    };
    let mut glove = ClassicTwin::new(22);
    let first = glove.record();
    glove.set_curls(CURLS);
    let records = ten(first, glove.record());
    let mut glove = ThirdTwin::default();
    let first = glove.packet(0);
    glove.set_curls(CURLS);
    let packets = ten(first, glove.packet(123_456_789_000));
    // Each has a time of its own, 11 ms after the one before.
    let of_hands = |line: &dyn Fn(&[Pose; 25], i64) -> String| {
        let [first, others] = hands();
        let in_turn = [first, others, others].into_iter().zip(0..);
        in_turn.map(|(hand, k)| line(&hand, k * 11_000_000).into_bytes()).collect::<Vec<_>>()
    };
    let streamed = of_hands(&|hand, t| twin::lines(Side::Left, hand, Points::Local, Some((7, t))));
    let posed = of_hands(&|joints, t| {
        let pose = LivePose::Joints { joints: *joints, radii: [0.01; 25] };
        pose_stream::write(Side::Left, 0.5 + t as f64 * 1e-9, Some(&pose))
    });
    let case = |name, serial, protocol, packets| Case { name, protocol, packets, serial };
    vec![
        case("alpha", true, Box::new(LucidGloves::new(lucid.clone())), lines(false)),
        case("legacy", true, Box::new(LucidGloves::new(lucid)), lines(true)),
        case("classic", true, Box::new(Classic::new(classic)), records),
        case("third", true, Box::new(Third::new(third)), packets),
        case(
            "cybergrasp",
            false,
            Box::new(CyberGrasp::new(None)),
            vec![b"TGRA\x01\0\0\0".to_vec(); 10],
        ),
        case("hts", false, Box::new(HandTrackingStreamer::new(false, Points::Auto)), streamed),
        case("poses", false, Box::new(pose_stream::PoseStream::new(false)), posed),
    ]
}

/// What came of some bytes.
#[derive(Default)]
struct Outcome {
    samples: Vec<LivePose>,
    refused: usize,
    events: usize,
    alive: usize,
    sent: usize,
}

fn feed(protocol: &mut dyn Protocol, now_ns: &mut u64, bytes: &[u8], out: &mut Outcome) {
    *now_ns += 1_000_000;
    let mut sent = 0;
    let mut event = |event: Event| {
        out.events += 1;
        match event {
            Event::Sample(sample) => {
                let Some(pose) = sample.pose else { return };
                assert!(match &pose {
                    LivePose::Angles { wrist, angles } => {
                        wrist.is_finite() && angles.iter().all(|a| a.is_finite())
                    }
                    LivePose::Joints { joints, .. } => joints.iter().all(Pose::is_finite),
                });
                out.samples.push(pose);
            }
            Event::Alive => out.alive += 1,
            Event::Note(text) => assert!(text.len() < 300),
            Event::Refused(text) => {
                assert!(text.len() < 300);
                out.refused += 1;
            }
        }
    };
    protocol.receive(*now_ns, bytes, &mut event, &mut |b| sent += b.len());
    protocol.tick(*now_ns, None, &mut event, &mut |b| sent += b.len());
    out.sent += sent;
}

/// Unplugged after every byte: what was begun is forgotten, and the next stream is read from its
/// first packet.
#[test]
fn a_stream_cut_at_every_byte_is_read_again_from_its_start() {
    for mut case in cases() {
        let stream = case.packets.concat();
        let mut clean = Outcome::default();
        let mut now = 1_000_000_000;
        case.protocol.start(now, &mut |_| {});
        feed(&mut *case.protocol, &mut now, &stream, &mut clean);
        assert_eq!(clean.samples.len() + clean.alive, case.packets.len(), "{}", case.name);
        let packets = if case.packets.len() < 10 { 1 } else { 2 };
        for cut in 0..packets * case.packets[0].len() + 2 {
            let mut ignored = Outcome::default();
            case.protocol.start(now, &mut |_| {});
            feed(&mut *case.protocol, &mut now, &stream[..cut], &mut ignored);
            case.protocol.stop(&mut |_| {});
            case.protocol.start(now, &mut |_| {});
            let mut again = Outcome::default();
            // In pieces of that length too.
            for piece in stream.chunks(cut.max(1)) {
                feed(&mut *case.protocol, &mut now, piece, &mut again);
            }
            assert_eq!(again.samples, clean.samples, "{} cut at {cut}", case.name);
            assert_eq!(again.alive, clean.alive, "{} cut at {cut}", case.name);
        }
    }
}

/// Flipped, lost, repeated and inserted bytes, packets halved and doubled: poses stay finite, what
/// is said and sent stays in proportion, and good packets afterwards are understood.
#[test]
fn mutated_streams_do_no_harm() {
    for mut case in cases() {
        let mut seed = 0x5eed_u64;
        let mut random = move |below: usize| {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            seed as usize % below
        };
        let mut now = 1_000_000_000;
        case.protocol.start(now, &mut |_| {});
        for round in 0..400 {
            let mut bytes = case.packets.concat();
            for _ in 0..=random(12) {
                if bytes.is_empty() {
                    break;
                }
                let at = random(bytes.len());
                match random(6) {
                    0 => bytes[at] ^= 1 << random(8),
                    1 => bytes[at] = random(256) as u8,
                    2 => _ = bytes.remove(at),
                    3 => bytes.insert(at, random(256) as u8),
                    4 => bytes.truncate(at + 1),
                    _ => {
                        let part = bytes[at..].to_vec();
                        bytes.extend_from_slice(&part);
                    }
                }
            }
            bytes.truncate(20_000);
            let mut out = Outcome::default();
            let piece = 1 + random(90);
            for piece in bytes.chunks(piece) {
                feed(&mut *case.protocol, &mut now, piece, &mut out);
            }
            assert!(out.events <= bytes.len() + 1, "{} round {round}", case.name);
            assert!(out.sent <= 40 * (bytes.len() + 10), "{} round {round}", case.name);
        }
        // Far beyond any time limit, then the truth.
        now += 10_000_000_000;
        let mut end = Outcome::default();
        feed(&mut *case.protocol, &mut now, &case.packets.concat(), &mut end);
        let (good, sent) = (end.samples.len() + end.alive, case.packets.len());
        assert!(good >= sent - sent.div_ceil(4), "{}: {good} of {sent} good", case.name);
        let mut fresh = Outcome::default();
        case.protocol.start(now, &mut |_| {});
        // What looks like a first record may wait for the next.
        let last = case.packets[case.packets.len() - 2..].concat();
        feed(&mut *case.protocol, &mut now, &last, &mut fresh);
        assert_eq!(end.samples.last(), fresh.samples.last(), "{}", case.name);
    }
}

/// What a line at 8N1 gives when it is read at another speed than it is written: the level at the
/// middle of each bit that the reader believes in, and zero where its stop bit is none, as
/// terminals have it.
fn at_another_speed(bytes: &[u8], written: f64, read: f64) -> Vec<u8> {
    let level = |bits: f64| {
        let (byte, place) = (bits as usize / 10, bits as usize % 10);
        match (bytes.get(byte), place) {
            (Some(_), 0) => false,
            (None, _) | (_, 9) => true,
            (Some(byte), place) => byte >> (place - 1) & 1 == 1,
        }
    };
    let (step, mut at, mut out) = (written / read, 0.0, Vec::new());
    while at < 10.0 * bytes.len() as f64 {
        if level(at) {
            at += step / 16.0;
            continue;
        }
        let bit = |k: f64| level(at + (k + 0.5) * step);
        let value = (0..8).filter(|k| bit(f64::from(1 + k))).map(|k| 1u8 << k).sum();
        out.push(if bit(9.0) { value } else { 0 });
        at += 9.5 * step;
    }
    out
}

/// Nothing moves, something is told where there is something to tell, and the right speed is
/// understood at once.
#[test]
fn a_wrong_speed_moves_nothing() {
    let good: Vec<u8> = (0..=255).collect();
    assert_eq!(at_another_speed(&good, 115_200.0, 115_200.0), good, "the reader reads");
    for mut case in cases().into_iter().filter(|case| case.serial) {
        for speed in [9600.0, 38_400.0, 57_600.0, 76_800.0, 230_400.0, 250_000.0] {
            let mut now = 1_000_000_000;
            case.protocol.start(now, &mut |_| {});
            let mut out = Outcome::default();
            let stream = case.packets.concat().repeat(100);
            for piece in at_another_speed(&stream, 115_200.0, speed).chunks(13) {
                feed(&mut *case.protocol, &mut now, piece, &mut out);
            }
            let what = format!("{} at {speed}", case.name);
            assert!(out.samples.is_empty() && out.alive == 0, "{what}");
            now += 10_000_000_000;
            let mut end = Outcome::default();
            feed(&mut *case.protocol, &mut now, &case.packets.concat(), &mut end);
            assert!(end.samples.len() >= 9, "{what}: {} good", end.samples.len());
        }
    }
}

/// Datagrams and messages are whole or refused, whatever of them is missing.
#[test]
fn a_part_of_a_datagram_is_refused() {
    let profile: force_device::profile::Profile =
        load("force-device", force_device::profile::SHIPPED, &Address::default()).unwrap();
    let mut arm = force_device::twin::SimulatedArm::new();
    let status = br#"{"ConnectedPositions":["GloveR"]}"#.to_vec();
    let bhaptics = thenar_link::bhaptics::Bhaptics::default();
    let cases: [(&str, Box<dyn Protocol>, Vec<u8>); 2] = [
        ("arm", Box::new(ForceDevice::new(profile.setup().unwrap())), arm.state(1).to_vec()),
        ("bhaptics", Box::new(bhaptics), status),
    ];
    for (name, mut protocol, whole) in cases {
        let mut now = 1_000_000_000;
        protocol.start(now, &mut |_| {});
        for cut in 0..whole.len() {
            let mut out = Outcome::default();
            feed(&mut *protocol, &mut now, &whole[..cut], &mut out);
            feed(&mut *protocol, &mut now, &[&whole[..], &whole[..=cut]].concat(), &mut out);
            assert_eq!((out.samples.len(), out.alive, out.refused), (0, 0, 2), "{name} {cut}");
        }
        let mut out = Outcome::default();
        feed(&mut *protocol, &mut now, &whole, &mut out);
        assert_eq!(out.samples.len() + out.alive, 1, "{name}");
    }
}

/// A sender's clock jumps by a day, forward and back: each hand is still taken once, as fresh as it
/// is, and each jump is told once.
#[test]
fn clocks_that_jump_by_a_day_are_followed() {
    const DAY: i64 = 86_400_000_000_000;
    let profile: force_device::profile::Profile =
        load("force-device", force_device::profile::SHIPPED, &Address::default()).unwrap();
    let mut arm = force_device::twin::SimulatedArm::new();
    let [hand, _] = hands();
    let pose = LivePose::Joints { joints: hand, radii: [0.01; 25] };
    let mut frame = 0;
    type Say<'a> = Box<dyn FnMut(i64) -> Vec<u8> + 'a>;
    let cases: [(&str, Box<dyn Protocol>, Say); 3] = [
        (
            "hts",
            Box::new(HandTrackingStreamer::new(true, Points::Auto)),
            Box::new(move |t| {
                frame += 1;
                twin::lines(Side::Left, &hand, Points::Local, Some((frame, t))).into_bytes()
            }),
        ),
        (
            "poses",
            Box::new(pose_stream::PoseStream::new(true)),
            Box::new(|t| pose_stream::write(Side::Left, t as f64 * 1e-9, Some(&pose)).into_bytes()),
        ),
        (
            "arm",
            Box::new(ForceDevice::new(profile.setup().unwrap())),
            Box::new(|t| arm.state(t as u64).to_vec()),
        ),
    ];
    for (name, mut protocol, mut say) in cases {
        let (mut now, mut last, mut jumps) = (1_000_000_000, 0, 0);
        protocol.start(now, &mut |_| {});
        for shift in [0, DAY, 0, -DAY, 2 * DAY, 2 * DAY, 0] {
            for _ in 0..50 {
                now += 10_000_000;
                let mut samples = 0;
                let mut event = |event| match event {
                    Event::Sample(sample) => {
                        samples += 1;
                        // Microseconds are what a line of text keeps of a time.
                        assert!(sample.time_ns.abs_diff(now) <= 2_000, "{name}");
                        assert!(sample.time_ns > last && sample.time_ns <= now, "{name}");
                        last = sample.time_ns;
                    }
                    Event::Note(text) => {
                        assert!(text.contains("clock has jumped"), "{name}: {text}");
                        jumps += 1;
                    }
                    other => panic!("{name}: {other:?}"),
                };
                let bytes = say(10 * DAY + now as i64 + shift);
                protocol.receive(now, &bytes, &mut event, &mut |_| {});
                assert_eq!(samples, 1, "{name}");
            }
        }
        assert_eq!(jumps, 5, "{name}: changes of the clock");
    }
}

/// Every protocol, by the fuzz target's own choice: good streams, damaged a few hundred times each.
#[test]
fn the_fuzz_target_survives_seeded_damage() {
    let mut arm = force_device::twin::SimulatedArm::new();
    let touch = br#"{"ConnectedPositions":["GloveL","GloveR"]}"#.to_vec();
    let mut streams: Vec<(u8, Vec<u8>)> = vec![(8, arm.state(7).to_vec()), (9, touch)];
    for case in cases() {
        let stream = case.packets.concat();
        match case.name {
            "alpha" | "legacy" => streams.push((0, stream)),
            "classic" => streams.push((1, stream)),
            "third" => streams.push((2, stream)),
            "cybergrasp" => streams.push((3, stream)),
            "hts" => streams.extend([(4, stream.clone()), (5, stream)]),
            "poses" => streams.extend([(6, stream.clone()), (7, stream)]),
            other => panic!("{other} has no number in the target"),
        }
    }
    let mut random = Random::new(0x7007);
    let mut random = move |below: usize| random.below(below);
    for (which, good) in streams {
        for round in 0..200 {
            let mut bytes = vec![which, random(256) as u8];
            bytes.extend_from_slice(&good);
            for _ in 0..round % 8 {
                let at = 2 + random(bytes.len() - 2);
                match random(4) {
                    0 => bytes[at] = random(256) as u8,
                    1 => bytes[at] ^= 1 << random(8),
                    2 => _ = bytes.drain(at..(at + random(40)).min(bytes.len())),
                    _ => bytes.insert(at, b"0-9eE.,:[]{}\"\n\0\xff"[random(16)]),
                }
                if bytes.len() < 4 {
                    break;
                }
            }
            target::run(&bytes);
        }
    }
}
