//! A session at an instant, as bytes: another session of the same scene goes on from them with the
//! same bits.
//!
//! The bytes are eight of [`MAGIC`], a CRC-32 (little-endian) of what follows, and a keyframe as in
//! `docs/recording.md`.

use super::content::{Keyframe, KeyframeRef, append};
use crate::session::Session;

/// The first bytes of a snapshot: what it is, and the version of its form.
const MAGIC: &[u8; 8] = b"THNSTAT1";
/// Offset of the keyframe \[bytes\].
const BODY: usize = 12;

/// Reason why a session does not go on from some bytes. The session is unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SnapshotError {
    /// The bytes are something else, or cut short.
    #[error("the bytes are no state of a session")]
    NoSnapshot,
    /// The bytes are damaged.
    #[error("the bytes are damaged: their CRC-32 is {found:08x}, expected {told:08x}")]
    Damaged {
        /// Checksum of the bytes as they are.
        found: u32,
        /// Checksum that they carry.
        told: u32,
    },
    /// The bytes are of a scene that starts otherwise.
    #[error(
        "the state is of another scene: that one starts as {theirs:016x}, this one as {own:016x}"
    )]
    OtherScene {
        /// Hash of the state in which their scene starts.
        theirs: u64,
        /// Hash of the state in which this one starts.
        own: u64,
    },
    /// Bodies, joints or settings are others, or a number is not finite.
    #[error("the state does not fit the scene")]
    Unfit,
}

/// Snapshot of a session: everything that its next step depends on besides its source and what
/// enters. `start`: hash of the state that its scene starts in.
pub fn snapshot(session: &Session, start: u64) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend_from_slice(&[0; 4]);
    append(&mut bytes, &KeyframeRef::of(session, session.steps(), start));
    let sum = crc32fast::hash(&bytes[BODY..]);
    bytes[MAGIC.len()..BODY].copy_from_slice(&sum.to_le_bytes());
    bytes
}

/// Goes on from a [`snapshot`] of a session whose scene starts in a state of hash `start`, as this
/// one's. Contacts and reports are those of the next step. A witness is not told: a session that is
/// recorded is not to be moved this way.
///
/// # Errors
/// The bytes are none of this scene. Nothing has changed then.
pub fn go_on_from(session: &mut Session, start: u64, bytes: &[u8]) -> Result<(), SnapshotError> {
    let keyframe = read(bytes)?;
    let kept = keyframe.kept.ok_or(SnapshotError::NoSnapshot)?;
    if kept.start != start {
        return Err(SnapshotError::OtherScene { theirs: kept.start, own: start });
    }
    match session.recall(&keyframe.state, &kept.memory) {
        true => Ok(()),
        false => Err(SnapshotError::Unfit),
    }
}

fn read(bytes: &[u8]) -> Result<Keyframe, SnapshotError> {
    let rest = bytes.strip_prefix(MAGIC).ok_or(SnapshotError::NoSnapshot)?;
    let (told, body) = rest.split_first_chunk::<4>().ok_or(SnapshotError::NoSnapshot)?;
    let (told, found) = (u32::from_le_bytes(*told), crc32fast::hash(body));
    if told != found {
        return Err(SnapshotError::Damaged { found, told });
    }
    Keyframe::read(body).ok_or(SnapshotError::NoSnapshot)
}
