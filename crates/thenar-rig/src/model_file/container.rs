//! Header and body of a model file.

use crate::RigError;
use thenar_input::{FNV_START, fnv1a};

const MAGIC: &[u8; 8] = b"THENARMD";
/// Version that is written; all from 1 on are read.
const VERSION: u32 = 5;
const HEADER_BYTES: usize = 32;

/// Kind of the body in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Hand = 1,
    Rigid = 2,
    Soft = 3,
    Figure = 4,
}

pub(super) fn encode(kind: Kind, model: &impl serde::Serialize) -> Result<Vec<u8>, RigError> {
    let body = postcard::to_stdvec(model)
        .map_err(|e| RigError::invalid(format!("the model cannot be encoded: {e}")))?;
    let mut bytes = Vec::with_capacity(HEADER_BYTES + body.len());
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((kind as u32).to_le_bytes());
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(fnv1a(FNV_START, &body).to_le_bytes());
    bytes.extend(body);
    Ok(bytes)
}

/// Version, kind and body of a whole, undamaged file.
pub(super) fn open(bytes: &[u8]) -> Result<(u32, Kind, &[u8]), RigError> {
    if bytes.get(..8) != Some(MAGIC) {
        return Err(RigError::byte(0, "not a Thenar model file"));
    }
    let word = |at: usize| bytes.get(at..at + 4).and_then(|b| b.try_into().ok());
    let long = |at: usize| bytes.get(at..at + 8).and_then(|b| b.try_into().ok());
    let (Some(version), Some(kind), Some(length), Some(checksum)) = (
        word(8).map(u32::from_le_bytes),
        word(12).map(u32::from_le_bytes),
        long(16).map(u64::from_le_bytes),
        long(24).map(u64::from_le_bytes),
    ) else {
        return Err(RigError::byte(bytes.len(), "the file ends inside its header"));
    };
    if !(1..=VERSION).contains(&version) {
        return Err(RigError::byte(8, format!("version {version}, this reads 1 to {VERSION}")));
    }
    let kind = match kind {
        1 => Kind::Hand,
        2 => Kind::Rigid,
        3 => Kind::Soft,
        4 => Kind::Figure,
        other => return Err(RigError::byte(12, format!("unknown kind of model {other}"))),
    };
    let body = &bytes[HEADER_BYTES..];
    if body.len() as u64 != length {
        return Err(RigError::byte(
            16,
            format!("the header says {length} bytes of model, there are {}", body.len()),
        ));
    }
    if fnv1a(FNV_START, body) != checksum {
        return Err(RigError::byte(24, "the checksum does not agree: the file is damaged"));
    }
    Ok((version, kind, body))
}

pub(super) fn decode<'a, T: serde::Deserialize<'a>>(body: &'a [u8]) -> Result<T, RigError> {
    let (model, rest) = postcard::take_from_bytes(body)
        .map_err(|e| RigError::invalid(format!("the model cannot be decoded: {e}")))?;
    if rest.is_empty() {
        Ok(model)
    } else {
        Err(RigError::invalid(format!("{} bytes are left over after the model", rest.len())))
    }
}
