//! A recorded session in the place of a live one: made again at its own pace, with the same
//! messages to clients.
//!
//! Clients pause, go step by step, choose speed and place. Whatever else they send is refused: what
//! moves a recorded session is in the recording. Nobody watching, it waits.

mod commands;
mod playback_clock;
mod player;
mod run;

use crate::hub::{Hub, pair};
use crate::protocol;
use player::Player;
use run::Loop;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use thenar_scene::recording::ReplayError;

/// Why a recording cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum PlaybackError {
    /// The recording cannot be replayed.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// Nothing in it can be shown.
    #[error("there is no scene in the recording")]
    Empty,
    /// Too large for a page.
    #[error(transparent)]
    Model(#[from] protocol::ModelError),
    /// The thread of the replay cannot be started.
    #[error("cannot start the replay: {0}")]
    Thread(#[from] std::io::Error),
}

/// A recording that is shown; it ends when this is dropped.
#[derive(Debug)]
pub struct Playback {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Playback {
    /// Reads a recording through, makes its first scene, or that at `from` \[s\], and starts the
    /// thread.
    ///
    /// # Errors
    /// It cannot be replayed, or no thread can be started.
    pub fn start(file: &Path, from: f64) -> Result<(Self, Hub), PlaybackError> {
        let player = Player::open(file, from)?;
        let (hub, endpoint) = pair();
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let stop = Arc::new(AtomicBool::new(false));
        let told = stop.clone();
        let running = Loop::new(endpoint, player, name)?;
        let named = std::thread::Builder::new().name("replay".into());
        let thread = named.spawn(move || running.run(&told))?;
        Ok((Self { stop, thread: Some(thread) }, hub))
    }
}

impl Drop for Playback {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // There is nothing to learn from its end.
            let _ = thread.join();
        }
    }
}
