//! A recording on the live page.

use super::{Args, named};
use crate::building::told;
use crate::error::CliError;
use crate::interrupt;
use std::io::Write;
use std::path::Path;
use std::time::Duration;
use thenar_serve::playback::{Playback, PlaybackError};

/// Shows it until Ctrl-C.
///
/// # Errors
/// The recording cannot be replayed, or the port cannot be had.
pub fn run(args: &Args) -> Result<(), CliError> {
    interrupt::listen();
    let (playback, hub) = told(|| {
        Playback::start(&args.recording, args.from).map_err(|error| failed(&args.recording, error))
    })?;
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

fn failed(recording: &Path, error: PlaybackError) -> CliError {
    match error {
        PlaybackError::Replay(error) => named(recording, error),
        PlaybackError::Thread(_) => CliError::Other(error.to_string()),
        _ => CliError::Input(format!("{}: {error}", recording.display())),
    }
}
