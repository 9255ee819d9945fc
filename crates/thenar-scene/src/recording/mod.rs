//! Recordings of sessions: what enters one, a hash of the state after every step, and now and then
//! the whole state; and how a session is made again from them.
//!
//! A session is made again from its source (the scene's text, the files it names, which hands) and
//! from all that entered it, before the same steps. On the same build and the same vector
//! instructions that gives the same bits, which the hashes show. Elsewhere it gives nearly the
//! same; keyframes put it right each time. Where a part of the file is damaged, the session goes on
//! from the next keyframe, or at once when the hashes show that nothing of it is missing.
//!
//! The bytes are described in `docs/recording.md`.

mod content;
mod entry;
mod replay;
mod scene;
mod session_writer;
mod snapshot;
mod state;
mod verdict;

pub use content::{Asset, Keyframe, KeyframeRest, SceneStart, StepMark};
pub use replay::{Event, Index, Replay, ReplayError};
pub use scene::{ASSET_BYTES_MAX, FILE_BYTES_MAX};
pub use session_writer::{SessionWriter, TimeOf};
pub use snapshot::{SnapshotError, go_on_from, snapshot};
pub use verdict::{Difference, Loss, ReplayDrift, Verdict};
