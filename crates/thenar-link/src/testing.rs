//! What tests of protocols share.

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

/// What a protocol makes of pieces that arrive at once.
pub fn collect(protocol: &mut dyn Protocol, now_ns: u64, pieces: &[&[u8]]) -> Vec<Event> {
    let mut events = Vec::new();
    for piece in pieces {
        protocol.receive(now_ns, piece, &mut |event| events.push(event), &mut |_| {});
    }
    events
}

/// What a protocol sends in a tick.
#[allow(dead_code)]
pub fn tick(protocol: &mut dyn Protocol, now_ns: u64, output: Option<&HandOutput>) -> Vec<Vec<u8>> {
    let mut sent = Vec::new();
    protocol.tick(now_ns, output, &mut |_| {}, &mut |bytes| sent.push(bytes.to_vec()));
    sent
}

/// Repeatable damage.
pub struct Mutator(pub u64);

impl Mutator {
    /// A number below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % n.max(1)
    }

    /// A copy with other digits, or with bytes or stretches changed, dropped, doubled or cut.
    pub fn damage(&mut self, bytes: &[u8]) -> Vec<u8> {
        const SPITE: &[u8] = b"0-e9.,:|=[]{}\"\n\r nNai\xff\x00\x7f\x80";
        let mut bytes = bytes.to_vec();
        if self.below(2) == 0 {
            for _ in 0..=self.below(4) {
                let at = self.below(bytes.len());
                if let Some(digit) = bytes.iter_mut().skip(at).find(|c| c.is_ascii_digit()) {
                    *digit = b'0' + self.below(10) as u8;
                }
            }
            return bytes;
        }
        for _ in 0..=self.below(4) {
            let (at, length) = (self.below(bytes.len()), 1 + self.below(30));
            let end = (at + length).min(bytes.len());
            match self.below(6) {
                0 if at < bytes.len() => bytes[at] = SPITE[self.below(SPITE.len())],
                1 => drop(bytes.drain(at..end)),
                2 => {
                    let copy = bytes[at..end].to_vec();
                    bytes.splice(at..at, copy);
                }
                3 => bytes.truncate(bytes.len() - self.below(bytes.len()) / 8),
                4 if at < bytes.len() => bytes[at] ^= 1 << self.below(8),
                _ => bytes.insert(at.min(bytes.len()), SPITE[self.below(SPITE.len())]),
            }
        }
        bytes
    }
}
