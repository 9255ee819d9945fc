//! One source's end of a recording.

use crate::frame::{FrameKind, begin_payload};
use rtrb::Producer;
use std::sync::mpsc::Sender;

/// Length that stands for a payload that comes by the other way.
pub(crate) const BIG: u32 = u32::MAX;

/// Weight of a frame: light ones are dropped first when the ring fills.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// Dropped when half the ring is full: keyframes, from which others are only sooner reached.
    Light,
    /// Dropped when seven eighths are full: steps' hashes.
    Usual,
    /// Dropped when nothing fits any more: inputs, without which nothing can be replayed.
    Heavy,
}

/// Frames that were dropped, as a gap frame tells: 20 bytes, little-endian.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gap {
    /// Source of the dropped frames: 0 is the session, others are channels.
    pub source: u32,
    /// Number of frames, heavy ones among them.
    pub frames: u64,
    /// Number of heavy frames.
    pub heavy: u64,
}

impl Gap {
    /// From the body of a gap frame.
    pub fn read(body: &[u8]) -> Option<Self> {
        let (source, rest) = body.split_first_chunk::<4>()?;
        let (frames, rest) = rest.split_first_chunk::<8>()?;
        let heavy = rest.first_chunk::<8>()?;
        Some(Self {
            source: u32::from_le_bytes(*source),
            frames: u64::from_le_bytes(*frames),
            heavy: u64::from_le_bytes(*heavy),
        })
    }

    fn write(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.source.to_le_bytes());
        out.extend_from_slice(&self.frames.to_le_bytes());
        out.extend_from_slice(&self.heavy.to_le_bytes());
    }
}

/// Takes frames of one source. Allocates nothing once frames as long as this have been written,
/// and never waits.
#[derive(Debug)]
pub struct FrameWriter {
    ring: Producer<u8>,
    big: Sender<Vec<u8>>,
    /// Length and payload of the frame being written.
    buffer: Vec<u8>,
    gap: Gap,
    dropped: u64,
    /// Time of the newest frame \[ns\].
    time_ns: u64,
}

impl Drop for FrameWriter {
    fn drop(&mut self) {
        if let Some(payload) = self.last_word() {
            // Whoever would write it may have ended.
            let _ = self.big.send(payload);
        }
    }
}

impl FrameWriter {
    pub(crate) fn new(
        ring: Producer<u8>,
        big: Sender<Vec<u8>>,
        source: u32,
        longest: usize,
    ) -> Self {
        let gap = Gap { source, ..Gap::default() };
        Self { ring, big, buffer: Vec::with_capacity(longest + 64), gap, dropped: 0, time_ns: 0 }
    }

    /// Records a frame, whose body `write` appends. False when it had to be dropped.
    pub fn frame(
        &mut self,
        kind: FrameKind,
        time_ns: u64,
        weight: Weight,
        write: impl FnOnce(&mut Vec<u8>),
    ) -> bool {
        self.tell_gap(time_ns);
        self.buffer.clear();
        self.buffer.extend_from_slice(&[0; 4]);
        begin_payload(&mut self.buffer, kind, time_ns);
        write(&mut self.buffer);
        self.push(weight)
    }

    /// Records a frame of any length, for the beginning of things: it allocates.
    pub fn big_frame(
        &mut self,
        kind: FrameKind,
        time_ns: u64,
        write: impl FnOnce(&mut Vec<u8>),
    ) -> bool {
        self.tell_gap(time_ns);
        let mut payload = Vec::new();
        begin_payload(&mut payload, kind, time_ns);
        write(&mut payload);
        if self.ring.slots() < 4 || self.big.send(payload).is_err() {
            return self.drop_one(Weight::Heavy);
        }
        // There was room, and nobody else writes.
        let _ = self.ring.push_entire_slice(&BIG.to_le_bytes());
        true
    }

    /// Frames dropped so far.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Pushes the frame, whole or not at all.
    fn push(&mut self, weight: Weight) -> bool {
        let length = (self.buffer.len() - 4) as u32;
        self.buffer[..4].copy_from_slice(&length.to_le_bytes());
        let spare = match weight {
            Weight::Light => self.ring.buffer().capacity() / 2,
            Weight::Usual => self.ring.buffer().capacity() / 8,
            Weight::Heavy => 0,
        };
        if self.ring.slots() < self.buffer.len() + spare {
            return self.drop_one(weight);
        }
        self.ring.push_entire_slice(&self.buffer).is_ok()
    }

    /// Gap left to report when nothing will be pushed any more.
    fn last_word(&self) -> Option<Vec<u8>> {
        (self.gap.frames > 0).then(|| {
            let mut payload = Vec::new();
            begin_payload(&mut payload, FrameKind::Gap, self.time_ns);
            self.gap.write(&mut payload);
            payload
        })
    }

    fn drop_one(&mut self, weight: Weight) -> bool {
        self.gap.frames += 1;
        self.gap.heavy += u64::from(weight == Weight::Heavy);
        self.dropped += 1;
        false
    }

    /// Says what is missing, as soon as that fits.
    fn tell_gap(&mut self, time_ns: u64) {
        self.time_ns = time_ns;
        if self.gap.frames == 0 {
            return;
        }
        let gap = self.gap;
        self.buffer.clear();
        self.buffer.extend_from_slice(&[0; 4]);
        begin_payload(&mut self.buffer, FrameKind::Gap, time_ns);
        gap.write(&mut self.buffer);
        // A gap frame that is told while the ring is nearly full would be followed by another.
        if self.ring.slots() >= self.buffer.len() + self.ring.buffer().capacity() / 4 {
            let length = (self.buffer.len() - 4) as u32;
            self.buffer[..4].copy_from_slice(&length.to_le_bytes());
            if self.ring.push_entire_slice(&self.buffer).is_ok() {
                self.gap = Gap { source: gap.source, ..Gap::default() };
            }
        }
    }
}
