//! Building told: what takes long says so before and while it does, and Ctrl-C ends it.

use crate::error::CliError;
use crate::interrupt;
use crate::ticker::Ticker;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::{Arc, Mutex, PoisonError};
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

/// The same, whatever comes of it: what Ctrl-C ended has failed. Work that tells nothing, between stages or in
/// what has none, is told of each second, and where it does not end by itself within a second after Ctrl-C the
/// program ends.
pub fn heard<T>(work: impl FnOnce() -> T) -> T {
    let silence = Arc::new(Mutex::new(Silence { begun: Instant::now(), told: Instant::now() }));
    let shared = Arc::clone(&silence);
    let mut asked = None;
    let _ticker = Ticker::new(move || {
        if interrupt::asked() && asked.get_or_insert_with(Instant::now).elapsed() > PACE {
            interrupt::end();
        }
        lock(&shared).tell();
    });
    let mut teller =
        Teller { stage: "", last: Instant::now(), announced: false, bar: None, silence };
    let watch = move |progress| {
        teller.hear(&progress);
        !interrupt::asked()
    };
    watched(watch, work)
}

/// Since when nothing was told.
struct Silence {
    begun: Instant,
    told: Instant,
}

impl Silence {
    /// Breaks it when it has lasted.
    fn tell(&mut self) {
        if self.told.elapsed() > PACE {
            eprintln!("building: {:.0} s so far", self.begun.elapsed().as_secs_f64());
            self.told = Instant::now();
        }
    }
}

fn lock(silence: &Mutex<Silence>) -> std::sync::MutexGuard<'_, Silence> {
    silence.lock().unwrap_or_else(PoisonError::into_inner)
}

struct Teller {
    stage: &'static str,
    /// When the stage began, or was last told of.
    last: Instant,
    /// The stage was expected to be long, and said so.
    announced: bool,
    bar: Option<ProgressBar>,
    silence: Arc<Mutex<Silence>>,
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
                lock(&self.silence).told = self.last;
            }
        }
        if let Some(bar) = &self.bar {
            // A bar that stands still says enough.
            lock(&self.silence).told = Instant::now();
            bar.set_position((progress.done * 1000.0) as u64);
        }
    }

    fn begin(&mut self, terminal: bool, what: &str) {
        if !terminal {
            lock(&self.silence).told = Instant::now();
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
