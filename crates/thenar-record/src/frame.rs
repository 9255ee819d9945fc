//! The bytes of a file: a prologue, then frames.
//!
//! ```text
//!   prologue   0  magic    8 bytes, "THENARRC"
//!              8  version  u32
//!             12  checksum u32, CRC-32 of the 12 bytes before
//!   frame      0  length   u32, bytes of the payload, at least 9
//!              4  checksum u32, CRC-32 of length and payload, continued from the checksum before
//!              8  payload  kind u8, time u64 [ns], body
//! ```
//!
//! All numbers are little-endian. As each checksum continues the one before, a frame that is
//! moved, left out or repeated is found like one that is damaged.

/// The version that this reads and writes.
pub const VERSION: u32 = 1;
/// Longest payload \[bytes\].
pub const FRAME_BYTES_MAX: u32 = 1 << 30;

pub(crate) const MAGIC: &[u8; 8] = b"THENARRC";
pub(crate) const PROLOGUE_BYTES: usize = 16;
/// Before a payload.
pub(crate) const HEAD_BYTES: usize = 8;
/// Kind and time.
pub(crate) const PAYLOAD_BYTES_MIN: usize = 9;

/// Content of a frame. Readers skip kinds that they do not know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum FrameKind {
    /// [`Header`](crate::Header), JSON. The first frame.
    Header = 1,
    /// A scene begins.
    Scene = 2,
    /// Something entered the session.
    Input = 3,
    /// A step was made.
    Step = 4,
    /// The whole state.
    Keyframe = 5,
    /// [`ChannelInfo`](crate::ChannelInfo), JSON.
    Channel = 6,
    /// A record of a channel.
    Record = 7,
    /// [`Gap`](crate::Gap): frames were dropped before this one.
    Gap = 8,
    /// The recording was ended as it should be.
    End = 9,
}

impl FrameKind {
    const ALL: [Self; 9] = [
        Self::Header,
        Self::Scene,
        Self::Input,
        Self::Step,
        Self::Keyframe,
        Self::Channel,
        Self::Record,
        Self::Gap,
        Self::End,
    ];

    pub(crate) fn of(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u8 == number)
    }
}

/// A frame that was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Kind of its content; `None` for one that this version does not know.
    pub kind: Option<FrameKind>,
    /// Time of writing \[ns since the recording began\]; rises within one source.
    pub time_ns: u64,
    /// The rest.
    pub body: &'a [u8],
}

impl<'a> Frame<'a> {
    /// From a payload of sufficient length.
    pub(crate) fn of(payload: &'a [u8]) -> Option<Self> {
        let (kind, rest) = payload.split_first()?;
        let (time, body) = rest.split_first_chunk::<8>()?;
        Some(Self { kind: FrameKind::of(*kind), time_ns: u64::from_le_bytes(*time), body })
    }
}

/// Starts a payload.
pub(crate) fn begin_payload(out: &mut Vec<u8>, kind: FrameKind, time_ns: u64) {
    out.push(kind as u8);
    out.extend_from_slice(&time_ns.to_le_bytes());
}

/// The beginning of a file, and its checksum.
pub(crate) fn prologue() -> ([u8; PROLOGUE_BYTES], u32) {
    let mut bytes = [0; PROLOGUE_BYTES];
    bytes[..8].copy_from_slice(MAGIC);
    bytes[8..12].copy_from_slice(&VERSION.to_le_bytes());
    let sum = crc32fast::hash(&bytes[..12]);
    bytes[12..].copy_from_slice(&sum.to_le_bytes());
    (bytes, sum)
}

/// The checksum of a frame after one with the checksum `before`.
pub(crate) fn checksum(before: u32, length: [u8; 4], payload: &[u8]) -> u32 {
    let mut sum = crc32fast::Hasher::new_with_initial(before);
    sum.update(&length);
    sum.update(payload);
    sum.finalize()
}

/// Appends a frame, and moves the checksum on.
pub(crate) fn append(out: &mut Vec<u8>, sum: &mut u32, payload: &[u8]) {
    let length = (payload.len() as u32).to_le_bytes();
    *sum = checksum(*sum, length, payload);
    out.extend_from_slice(&length);
    out.extend_from_slice(&sum.to_le_bytes());
    out.extend_from_slice(payload);
}
