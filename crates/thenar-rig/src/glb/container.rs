//! The outer shell of a GLB file: header, JSON chunk, binary chunk.

use crate::RigError;

/// A parsed file whose JSON has passed the `gltf` crate's validation.
pub(super) struct Container {
    pub document: gltf::Document,
    pub blob: Vec<u8>,
}

const HEADER_BYTES: usize = 12;

impl Container {
    pub fn new(bytes: &[u8]) -> Result<Self, RigError> {
        check_header(bytes)?;
        let parsed = gltf::Gltf::from_slice(bytes)
            .map_err(|e| RigError::invalid(format!("not a valid GLB file: {e}")))?;
        if let Some(name) = parsed.extensions_required().next() {
            return Err(RigError::invalid(format!(
                "the file requires the glTF extension {name}, which is not supported"
            )));
        }
        Ok(Self { document: parsed.document, blob: parsed.blob.unwrap_or_default() })
    }
}

/// Checks magic, version and length, which the parser trusts.
fn check_header(bytes: &[u8]) -> Result<(), RigError> {
    let word = |at: usize| {
        let four: Option<[u8; 4]> = bytes.get(at..at + 4).and_then(|b| b.try_into().ok());
        four.map(u32::from_le_bytes)
    };
    let (Some(magic), Some(version), Some(length)) = (word(0), word(4), word(8)) else {
        return Err(RigError::byte(bytes.len(), "the file ends inside the GLB header"));
    };
    if magic != u32::from_le_bytes(*b"glTF") {
        return Err(RigError::byte(0, "not a GLB file: it does not start with `glTF`"));
    }
    if version != 2 {
        return Err(RigError::byte(4, format!("glTF version {version}, expected 2")));
    }
    if (length as usize) < HEADER_BYTES || length as usize > bytes.len() {
        return Err(RigError::byte(
            8,
            format!("the header says {length} bytes, the file has {}", bytes.len()),
        ));
    }
    Ok(())
}
