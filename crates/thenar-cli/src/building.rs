//! Building told: what takes long says so before and while it does, and Ctrl-C ends it.

use crate::error::CliError;
use crate::interrupt;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};
use thenar_rig::work::{Progress, watched};

/// Seconds that one comparison takes, roughly: 15 ns on a core of 3 GHz.
const COMPARISON: f64 = 15e-9;
/// Work expected to be shorter is not announced \[s\].
const SHORT: f64 = 1.0;
/// Time between lines where the error output is no terminal.
const PACE: Duration = Duration::from_secs(1);

/// Builds something; tells of long stages on the error output and ends with them on Ctrl-C.
///
/// # Errors
/// As `work`; or it was interrupted.
pub fn told<T>(work: impl FnOnce() -> Result<T, CliError>) -> Result<T, CliError> {
    match heard(work) {
        Err(_) if interrupt::asked() => Err(CliError::Other("interrupted".into())),
        done => done,
    }
}

/// The same, whatever comes of it: what Ctrl-C ended has failed.
pub fn heard<T>(work: impl FnOnce() -> T) -> T {
    let mut teller = Teller { stage: "", last: Instant::now(), announced: false, bar: None };
    let watch = move |progress| {
        teller.hear(&progress);
        !interrupt::asked()
    };
    watched(watch, work)
}

struct Teller {
    stage: &'static str,
    /// When the stage began, or was last told of.
    last: Instant,
    /// The stage was expected to be long, and said so.
    announced: bool,
    bar: Option<ProgressBar>,
}

impl Teller {
    fn hear(&mut self, progress: &Progress) {
        let seconds = progress.work * COMPARISON;
        let begins = progress.done == 0.0 || progress.stage != self.stage;
        if begins {
            (self.stage, self.last, self.bar) = (progress.stage, Instant::now(), None);
            self.announced = seconds > SHORT;
        }
        let terminal = std::io::stderr().is_terminal();
        if begins && self.announced {
            self.begin(terminal, &format!("{}: about {seconds:.0} s", progress.stage));
        } else if self.last.elapsed() > PACE && progress.done < 1.0 {
            if self.bar.is_none() && terminal {
                self.begin(terminal, progress.stage);
            } else if !terminal {
                eprintln!("{}: {:.0} %", progress.stage, progress.done * 100.0);
                self.last = Instant::now();
            }
        }
        if let Some(bar) = &self.bar {
            bar.set_position((progress.done * 1000.0) as u64);
        }
    }

    fn begin(&mut self, terminal: bool, what: &str) {
        if !terminal {
            return eprintln!("{what}");
        }
        let bar = ProgressBar::new(1000).with_message(what.to_owned());
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {percent} %") {
            bar.set_style(style);
        }
        self.bar = Some(bar);
    }
}

impl Drop for Teller {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
