//! The file of an incident: a mark, the version, a checksum, and the content as postcard has it.

use super::writer::{Input, RecordedSample};
use crate::haptic_loop::{Capability, TickRecord};
use serde::{Deserialize, Serialize};
use std::io::{self, Write};
use std::path::Path;

/// Version of the format.
pub const VERSION: u32 = 9;
const MARK: &[u8; 8] = b"THNTOUCH";
/// Bytes before the content: mark, version, CRC-32 of the content.
const HEAD: usize = 16;
/// Largest file that is read \[B\]: four times the room of frames.
const LARGEST: u64 = 256 << 20;

/// All that is needed to make the chain's last seconds again.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Incident {
    /// Why forces stopped.
    pub reason: String,
    /// Version of the program that recorded it.
    pub program: String,
    /// Vector instructions of its processor: other ones give other bits.
    pub instructions: String,
    /// The displays.
    pub displays: Vec<Capability>,
    /// State of the chain when this begins.
    pub state: Vec<u8>,
    /// Inputs that entered after that.
    pub inputs: Vec<Input>,
    /// Samples of trackers, as inputs call for them.
    pub samples: Vec<RecordedSample>,
    /// Frames of the simulation: hand, step, bytes.
    pub frames: Vec<(u8, u64, Vec<u8>)>,
    /// Records that the chain made.
    pub records: Vec<TickRecord>,
}

/// Why an incident cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum IncidentError {
    /// The file cannot be read.
    #[error("cannot read it: {0}")]
    Read(#[from] io::Error),
    /// Another file, or a damaged one.
    #[error("{0}")]
    Damaged(&'static str),
    /// A version that this program does not know.
    #[error("it is of version {found}; this program reads {VERSION}")]
    Version {
        /// Version of the file.
        found: u32,
    },
    /// Parts of the file do not fit together.
    #[error("its {0} do not fit together")]
    Unfit(&'static str),
}

impl Incident {
    /// Writes it into a new file.
    ///
    /// # Errors
    /// The file exists or cannot be written.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        let content = postcard::to_allocvec(self).map_err(io::Error::other)?;
        let mut file = std::fs::File::create_new(path)?;
        let mut head = Vec::with_capacity(HEAD);
        head.extend_from_slice(MARK);
        head.extend_from_slice(&VERSION.to_le_bytes());
        head.extend_from_slice(&crc32fast::hash(&content).to_le_bytes());
        file.write_all(&head)?;
        file.write_all(&content)?;
        file.flush()
    }

    /// Reads a file.
    ///
    /// # Errors
    /// The file is no incident, is damaged, or is of another version.
    pub fn read(path: &Path) -> Result<Self, IncidentError> {
        if std::fs::metadata(path)?.len() > LARGEST {
            return Err(IncidentError::Damaged("it is larger than an incident can be"));
        }
        Self::parse(&std::fs::read(path)?)
    }

    /// Reads bytes of a file.
    ///
    /// # Errors
    /// As [`Incident::read`].
    pub fn parse(bytes: &[u8]) -> Result<Self, IncidentError> {
        let (head, content) = bytes
            .split_at_checked(HEAD)
            .filter(|(head, _)| head.starts_with(MARK))
            .ok_or(IncidentError::Damaged("it is no incident of touch"))?;
        let number = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|k| head[at + k]));
        if number(8) != VERSION {
            return Err(IncidentError::Version { found: number(8) });
        }
        if number(12) != crc32fast::hash(content) {
            return Err(IncidentError::Damaged("it is damaged: its checksum does not fit"));
        }
        postcard::from_bytes(content)
            .map_err(|_| IncidentError::Damaged("its content cannot be read"))
    }

    /// The newest frame of this hand and step.
    pub(super) fn frame(&self, hand: u8, step: u64) -> Option<&[u8]> {
        let found = self.frames.iter().rev().find(|(h, s, _)| (*h, *s) == (hand, step));
        found.map(|(_, _, bytes)| bytes.as_slice())
    }
}
