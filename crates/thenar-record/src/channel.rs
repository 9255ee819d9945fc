//! Channels: small records of fixed size beside the session, such as one per haptic tick.

use crate::frame::FrameKind;
use crate::frame_writer::{FrameWriter, Weight};
use serde::{Deserialize, Serialize};

/// A number of a record.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Field {
    /// Name, e.g. `index.force`.
    pub name: String,
    /// SI unit, `1` for a pure number.
    pub unit: String,
}

impl Field {
    /// A field.
    pub fn new(name: &str, unit: &str) -> Self {
        Self { name: name.into(), unit: unit.into() }
    }
}

/// Content of a channel frame, as JSON. It comes before the channel's first record.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChannelInfo {
    /// Number of the channel in this recording, from 1.
    pub id: u32,
    /// Name, e.g. `haptic`.
    pub name: String,
    /// The numbers of a record, in order; none for a channel of mere moments.
    pub fields: Vec<Field>,
}

/// Takes the records of one channel: 13 bytes and 8 for each field, little-endian f64.
#[derive(Debug)]
pub struct Channel {
    frame_writer: FrameWriter,
    id: u32,
    fields: usize,
}

impl Channel {
    pub(crate) fn new(frame_writer: FrameWriter, info: &ChannelInfo) -> Self {
        Self { frame_writer, id: info.id, fields: info.fields.len() }
    }

    /// Records these values, taken at `time_ns` of the recording's clock. Wait-free: no lock, no
    /// system call, nothing allocated. False when the record was dropped, as the disk is too slow.
    ///
    /// # Panics
    /// When there are not as many values as the channel has fields.
    pub fn record(&mut self, time_ns: u64, values: &[f64]) -> bool {
        assert_eq!(values.len(), self.fields, "one value for each field of the channel");
        let id = self.id;
        self.frame_writer.frame(FrameKind::Record, time_ns, Weight::Heavy, |body| {
            body.extend_from_slice(&id.to_le_bytes());
            values.iter().for_each(|x| body.extend_from_slice(&x.to_le_bytes()));
        })
    }

    /// Records dropped so far.
    pub fn dropped(&self) -> u64 {
        self.frame_writer.dropped()
    }
}

/// A record that was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record<'a> {
    /// Number of the channel.
    pub channel: u32,
    values: &'a [u8],
}

impl<'a> Record<'a> {
    /// From the body of a record frame.
    pub fn read(body: &'a [u8]) -> Option<Self> {
        let (channel, values) = body.split_first_chunk::<4>()?;
        values
            .len()
            .is_multiple_of(8)
            .then_some(Self { channel: u32::from_le_bytes(*channel), values })
    }

    /// Numbers of the record, in the order of the channel's fields.
    pub fn values(&self) -> impl Iterator<Item = f64> + 'a {
        let (numbers, _) = self.values.as_chunks::<8>();
        numbers.iter().map(|bytes| f64::from_le_bytes(*bytes))
    }
}
