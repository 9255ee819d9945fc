//! Goal: no bytes harm a protocol. Method: good streams, cut at every byte or mutated at random
//! (seeded), straight into the protocols.

use std::sync::Arc;
use thenar_link::cyberglove::{self, Classic, ClassicTwin, Third, ThirdTwin};
use thenar_link::cybergrasp::CyberGrasp;
use thenar_link::lucidgloves::{self, LucidGloves, LucidGlovesTwin};
use thenar_link::profile::{Address, load};
use thenar_link::twin::Twin;
use thenar_link::{Event, Protocol};
use thenar_scene::live::LivePose;
use thenar_scene::motion::ANGLES;

/// A protocol and a stream of ten good packets, the first of them another hand's than the others.
struct Case {
    name: &'static str,
    protocol: Box<dyn Protocol>,
    packets: Vec<Vec<u8>>,
}

const CURLS: [f64; 5] = [0.2, 0.4, 0.6, 0.8, 0.3];

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
    vec![
        Case {
            name: "alpha",
            protocol: Box::new(LucidGloves::new(lucid.clone())),
            packets: lines(false),
        },
        Case { name: "legacy", protocol: Box::new(LucidGloves::new(lucid)), packets: lines(true) },
        Case { name: "classic", protocol: Box::new(Classic::new(classic)), packets: records },
        Case { name: "third", protocol: Box::new(Third::new(third)), packets },
        Case {
            name: "cybergrasp",
            protocol: Box::new(CyberGrasp::new(None)),
            packets: vec![b"TGRA\x01\0\0\0".to_vec(); 10],
        },
    ]
}

/// What came of some bytes.
#[derive(Default)]
struct Outcome {
    samples: Vec<[f64; ANGLES]>,
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
                let Some(LivePose::Angles { angles, wrist }) = sample.pose else { return };
                assert!(wrist.is_finite() && angles.iter().all(|a| a.is_finite()));
                out.samples.push(angles);
            }
            Event::Alive => out.alive += 1,
            Event::Note(text) | Event::Refused(text) => assert!(text.len() < 300),
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
        assert_eq!(clean.samples.len() + clean.alive, 10, "{}", case.name);
        for cut in 0..2 * case.packets[0].len() {
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
        assert!(end.samples.len() + end.alive >= 7, "{}: {} good", case.name, end.samples.len());
        let mut fresh = Outcome::default();
        case.protocol.start(now, &mut |_| {});
        feed(&mut *case.protocol, &mut now, &case.packets[9], &mut fresh);
        assert_eq!(end.samples.last(), fresh.samples.last(), "{}", case.name);
    }
}
