//! Helpers that tests of protocols share.

use crate::{Event, HandOutput, Protocol};
use std::path::Path;
use thenar_core::Pose;
use thenar_core::model::Side;
use thenar_track::Recording;

/// Hands at rest, of several shapes (tests/data).
pub fn hands(side: Side) -> Vec<[Pose; 25]> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hands.jsonl");
    let recording = Recording::open(&file).unwrap();
    let mut hands: Vec<_> = recording.hand(side).iter().map(|sample| sample.joints).collect();
    if side == Side::Right {
        let mirrored = |pose| thenar_track::mirrored(pose);
        hands.insert(0, recording.hand(Side::Left)[0].joints.each_ref().map(mirrored));
    }
    hands
}

/// Events that a protocol makes of pieces that arrive at once.
pub fn collect(protocol: &mut dyn Protocol, now_ns: u64, pieces: &[&[u8]]) -> Vec<Event> {
    let mut events = Vec::new();
    for piece in pieces {
        protocol.receive(now_ns, piece, &mut |event| events.push(event), &mut |_| {});
    }
    events
}

/// Messages that a protocol sends in a tick.
#[allow(dead_code)]
pub fn tick(protocol: &mut dyn Protocol, now_ns: u64, output: Option<&HandOutput>) -> Vec<Vec<u8>> {
    let mut sent = Vec::new();
    protocol.tick(now_ns, output, &mut |_| {}, &mut |bytes| sent.push(bytes.to_vec()));
    sent
}
