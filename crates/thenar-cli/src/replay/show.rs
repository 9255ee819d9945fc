//! A recording on the live page.

use super::Args;
use crate::error::CliError;
use crate::interrupt;
use std::io::Write;
use std::time::Duration;
use thenar_serve::playback::{Playback, PlaybackError};

/// Shows it until Ctrl-C.
///
/// # Errors
/// The recording cannot be replayed, or the port cannot be had.
pub fn run(args: &Args) -> Result<(), CliError> {
    interrupt::listen();
    let (playback, hub) = Playback::start(&args.recording, args.from)?;
    let server = args.page.serve(hub)?;
    args.page.announce(&format!("{} is shown", args.recording.display()), &server);
    while !interrupt::asked() {
        std::thread::sleep(Duration::from_millis(50));
    }
    server.stop();
    drop(playback);
    // Whoever read the address may have stopped reading.
    let _ = writeln!(std::io::stdout(), "ended");
    Ok(())
}

impl From<PlaybackError> for CliError {
    fn from(error: PlaybackError) -> Self {
        match error {
            PlaybackError::Replay(error) => error.into(),
            PlaybackError::Thread(_) => Self::Other(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}
