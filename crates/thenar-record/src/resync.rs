//! Finding the way again after damage.
//!
//! A frame's checksum continues that of the frame before, which stands in its head. So where two
//! frames follow each other, the second can be trusted as soon as its checksum continues what the
//! head of the first says; whatever the first holds, it stays unused. What was moved or repeated
//! also has such pairs: it shows by its time, which rises within a source.

use crate::FrameKind;
use crate::frame::{
    FRAME_BYTES_MAX, Frame, HEAD_BYTES, PAYLOAD_BYTES_MIN, PROLOGUE_BYTES, checksum,
};
use crate::reader::read_up_to;
use std::collections::BTreeMap;
use std::io::{self, Read, Seek, SeekFrom};

/// Bytes looked at together.
const WINDOW: usize = 1 << 14;
/// Bytes of the smallest frame.
const FRAME_BYTES_MIN: usize = HEAD_BYTES + PAYLOAD_BYTES_MIN;

/// Times of the newest frame of each source \[ns\].
#[derive(Clone, Debug, Default)]
pub struct NewestTimes(BTreeMap<u32, u64>);

/// Source whose time a frame carries: 0 the session, else a channel. `None` where times say
/// nothing.
fn source(frame: &Frame) -> Option<u32> {
    match frame.kind? {
        FrameKind::Scene | FrameKind::Input | FrameKind::Step | FrameKind::Keyframe => Some(0),
        FrameKind::Record => frame.body.first_chunk().map(|id| u32::from_le_bytes(*id)),
        FrameKind::Header | FrameKind::Channel | FrameKind::Gap | FrameKind::End => None,
    }
}

impl NewestTimes {
    /// Takes in a frame that is trusted.
    pub fn note(&mut self, frame: &Frame) {
        if let Some(source) = source(frame) {
            self.0.insert(source, frame.time_ns);
        }
    }

    /// True unless a later frame of its source is known.
    pub fn is_in_order(&self, frame: &Frame) -> bool {
        let newest = source(frame).and_then(|source| self.0.get(&source));
        newest.is_none_or(|newest| frame.time_ns >= *newest)
    }

    /// True when its time says that it comes after all known ones of its source.
    fn is_later(&self, frame: &Frame) -> bool {
        source(frame).is_some_and(|source| self.0.get(&source).is_none_or(|t| frame.time_ns > *t))
    }
}

/// The head of a frame.
#[derive(Clone, Copy, Debug)]
struct FrameHead {
    length: [u8; 4],
    sum: u32,
    kind: u8,
}

impl FrameHead {
    fn of(bytes: &[u8]) -> Option<Self> {
        let (length, rest) = bytes.split_first_chunk::<4>()?;
        let (sum, rest) = rest.split_first_chunk::<4>()?;
        Some(Self { length: *length, sum: u32::from_le_bytes(*sum), kind: *rest.first()? })
    }

    /// End of a frame at `at`, when its length is possible.
    fn end(&self, at: u64) -> Option<u64> {
        let length = u32::from_le_bytes(self.length);
        let possible = length as usize >= PAYLOAD_BYTES_MIN && length <= FRAME_BYTES_MAX;
        possible.then(|| at + HEAD_BYTES as u64 + u64::from(length))
    }
}

/// Searches a file of `size` bytes.
pub struct Search<'a, R> {
    pub input: &'a mut R,
    pub size: u64,
    pub newest: &'a NewestTimes,
    /// The mark of the end has been read.
    pub ended: bool,
    /// Bytes that may still be read: a file made up of traps must not take for ever.
    pub budget: &'a mut u64,
}

impl<R: Read + Seek> Search<'_, R> {
    /// The first frame after `from` that can be trusted, and the checksum before it.
    pub fn run(&mut self, from: u64) -> io::Result<Option<(u64, u32)>> {
        let mut window = vec![0; WINDOW + FRAME_BYTES_MIN];
        let mut payload = Vec::new();
        let mut start = from.max(PROLOGUE_BYTES as u64);
        while start < self.size && self.spend(WINDOW as u64) {
            self.input.seek(SeekFrom::Start(start))?;
            let got = read_up_to(self.input, &mut window)?;
            for k in 0..got.min(WINDOW) {
                let at = start + k as u64;
                let Some(head) = FrameHead::of(&window[k..got]) else { break };
                // Where the damage begins the head may be whole, and the kind not.
                let is_frame = at == from || FrameKind::of(head.kind).is_some();
                let next = head.end(at).filter(|next| is_frame && *next < self.size);
                if let Some(next) = next
                    && self.is_good(next, head.sum, &mut payload)?
                {
                    return Ok(Some((next, head.sum)));
                }
            }
            start += WINDOW as u64;
        }
        Ok(None)
    }

    fn spend(&mut self, bytes: u64) -> bool {
        let enough = *self.budget >= bytes;
        *self.budget = self.budget.saturating_sub(bytes);
        enough
    }

    /// True when there is a frame whose checksum continues `before`, and whose time is a later one.
    fn is_good(&mut self, at: u64, before: u32, payload: &mut Vec<u8>) -> io::Result<bool> {
        let mut bytes = [0; HEAD_BYTES + 1];
        self.input.seek(SeekFrom::Start(at))?;
        if read_up_to(self.input, &mut bytes)? < bytes.len() {
            return Ok(false);
        }
        let Some(head) = FrameHead::of(&bytes) else { return Ok(false) };
        let end =
            head.end(at).filter(|end| *end <= self.size && FrameKind::of(head.kind).is_some());
        let Some(end) = end.filter(|end| self.spend(end - at)) else { return Ok(false) };
        payload.clear();
        payload.push(head.kind);
        payload.resize((end - at) as usize - HEAD_BYTES, 0);
        if read_up_to(self.input, &mut payload[1..])? < payload.len() - 1 {
            return Ok(false);
        }
        if checksum(before, head.length, payload) != head.sum {
            return Ok(false);
        }
        // The mark of the end has its place at the end.
        let is_end =
            |frame: &Frame| !self.ended && frame.kind == Some(FrameKind::End) && end == self.size;
        Ok(Frame::of(payload).is_some_and(|frame| self.newest.is_later(&frame) || is_end(&frame)))
    }
}
