//! Building told: what takes long says so before and while it does, and Ctrl-C ends it.

mod stage_reporter;

use crate::error::CliError;
use crate::interrupt;
use crate::ticker::Ticker;
use stage_reporter::StageReporter;
use std::io::IsTerminal;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use thenar_rig::work::watched;

/// Work that looks at whether it is to end does so within this time after Ctrl-C.
const HEARD: Duration = Duration::from_secs(1);

/// Builds something; tells of long stages on the error output and ends with them on Ctrl-C.
///
/// # Errors
/// As `work`; or it was interrupted.
pub fn told<T>(work: impl FnOnce() -> Result<T, CliError>) -> Result<T, CliError> {
    match heard(work) {
        Err(_) if interrupt::pressed() => Err(CliError::Other("interrupted".into())),
        done => done,
    }
}

/// Runs `work`, whatever comes of it: what Ctrl-C ended has failed. Silent work is announced each
/// second, and where it does not end by itself after Ctrl-C the program ends.
pub fn heard<T>(work: impl FnOnce() -> T) -> T {
    let terminal = std::io::stderr().is_terminal();
    let stage_reporter = Arc::new(Mutex::new(StageReporter::new(terminal, Instant::now())));
    let shared = Arc::clone(&stage_reporter);
    let mut asked = None;
    let _ticker = Ticker::new(move || {
        if interrupt::pressed() && asked.get_or_insert_with(Instant::now).elapsed() > HEARD {
            interrupt::end();
        }
        with(&shared, |stage_reporter| stage_reporter.tick(Instant::now()));
    });
    let watch = move |progress| {
        with(&stage_reporter, |stage_reporter| stage_reporter.hear(&progress, Instant::now()));
        !interrupt::pressed()
    };
    watched(watch, work)
}

/// Builds in silence what another tells of; what Ctrl-C ended has failed.
pub fn unheard<T>(work: impl FnOnce() -> T) -> T {
    watched(|_| !interrupt::pressed(), work)
}

fn with(stage_reporter: &Mutex<StageReporter>, act: impl FnOnce(&mut StageReporter)) {
    act(&mut stage_reporter.lock().unwrap_or_else(PoisonError::into_inner));
}
