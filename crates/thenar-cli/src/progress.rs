//! Progress of a command: a bar on a terminal; elsewhere lines on the error output, ever more
//! rarely.

use crate::ticker::Ticker;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// After so long the first line comes, and after twice the time of each the next: an hour has
/// twelve.
const FIRST_LINE: Duration = Duration::from_secs(1);

/// Tells how much of a work is done.
pub struct Meter {
    unit: Unit,
    bar: Option<ProgressBar>,
    /// Work done and steps made, for the lines that a ticker prints: one step may take long.
    now: Arc<[AtomicU64; 2]>,
    _lines: Option<Ticker>,
}

/// Units of work. A file's bytes say nothing of its number of steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    Steps,
    Cases,
    Bytes,
}

impl Unit {
    /// Template of the bar.
    fn bar(self) -> &'static str {
        match self {
            Self::Steps => "{bar:40} {percent:>3} %  step {pos} of {len}  {per_sec}  {eta} left",
            Self::Cases => "{bar:40} {percent:>3} %  case {pos} of {len}  {eta} left",
            Self::Bytes => "{bar:40} {percent:>3} %  {msg}",
        }
    }

    /// Line of work where no bar can be.
    fn line(self, done: u64, steps: u64, total: u64) -> String {
        let share = share(done, total);
        match self {
            Self::Steps => format!("step {steps} of {total}: {share:.0} %"),
            Self::Cases => format!("{done} of {total} cases: {share:.0} %"),
            Self::Bytes => format!("step {steps}: {share:.0} %"),
        }
    }
}

struct Lines {
    begun: Instant,
    /// Time of the next line, from the beginning.
    due: Duration,
}

impl Lines {
    /// True when a line is due, which is then taken for told.
    fn are_due(&mut self, since: Duration) -> bool {
        let due = since >= self.due;
        while self.due <= since {
            self.due *= 2;
        }
        due
    }
}

impl Meter {
    /// Meter of a number of steps.
    pub fn of_steps(total: u64, quiet: bool) -> Self {
        Self::new(total, Unit::Steps, quiet)
    }

    /// Meter of a number of cases.
    pub fn of_cases(total: u64, quiet: bool) -> Self {
        Self::new(total, Unit::Cases, quiet)
    }

    /// Meter of a file, by its bytes, from which steps are made.
    pub fn of_bytes(total: u64, quiet: bool) -> Self {
        Self::new(total, Unit::Bytes, quiet)
    }

    fn new(total: u64, unit: Unit, quiet: bool) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let bar = || {
            let style = ProgressStyle::with_template(unit.bar());
            ProgressBar::new(total)
                .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        };
        let now = Arc::new([AtomicU64::new(0), AtomicU64::new(0)]);
        let shared = Arc::clone(&now);
        let lines = || {
            let mut lines = Lines { begun: Instant::now(), due: FIRST_LINE };
            Ticker::new(move || {
                if lines.are_due(lines.begun.elapsed()) {
                    let [done, steps] = [0, 1].map(|i| shared[i].load(Relaxed));
                    eprintln!("{}", unit.line(done, steps, total));
                }
            })
        };
        Self {
            unit,
            bar: (terminal && !quiet).then(bar),
            now,
            _lines: (!terminal && !quiet).then(lines),
        }
    }

    /// Shows how much is done, and how many steps are made.
    pub fn at(&self, done: u64, steps: u64) {
        if let Some(bar) = &self.bar {
            bar.set_position(done);
            if self.unit == Unit::Bytes {
                bar.set_message(format!("step {steps}"));
            }
        }
        self.now[0].store(done, Relaxed);
        self.now[1].store(steps, Relaxed);
    }

    /// Does something that writes to the error output.
    pub fn suspend(&self, tell: impl FnOnce()) {
        match &self.bar {
            Some(bar) => bar.suspend(tell),
            None => tell(),
        }
    }
}

/// Percent of a whole; of nothing all is done.
fn share(done: u64, total: u64) -> f64 {
    if total > 0 { 100.0 * done.min(total) as f64 / total as f64 } else { 100.0 }
}

impl Drop for Meter {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_at_one_two_four_seconds_and_so_on() {
        let mut lines = Lines { begun: Instant::now(), due: FIRST_LINE };
        let seconds = (0..36_000).map(|tenth| f64::from(tenth) * 0.1);
        let told: Vec<f64> =
            seconds.filter(|s| lines.are_due(Duration::from_secs_f64(*s))).collect();
        let expected: Vec<f64> = (0..12).map(|k| f64::from(1 << k)).collect();
        assert_eq!(told, expected);
        // What was missed is not caught up.
        let mut late = Lines { begun: Instant::now(), due: FIRST_LINE };
        let times = [0.5, 100.0, 100.1, 127.0, 128.0];
        let due = times.map(|s| late.are_due(Duration::from_secs_f64(s)));
        assert_eq!(due, [false, true, false, false, true]);
    }

    #[test]
    fn a_share_is_of_a_hundred() {
        assert_eq!(
            [share(0, 0), share(1, 4), share(9, 4), share(4, 4)],
            [100.0, 25.0, 100.0, 100.0]
        );
    }

    /// A file's bytes are known, 63 of 100 here, and not how many steps they hold.
    #[test]
    fn lines_name_the_whole_where_it_is_known() {
        let line = |unit: Unit, done, steps, total| unit.line(done, steps, total);
        assert_eq!(line(Unit::Steps, 113, 113, 180), "step 113 of 180: 63 %");
        assert_eq!(line(Unit::Cases, 3, 0, 12), "3 of 12 cases: 25 %");
        assert_eq!(line(Unit::Bytes, 63, 113, 100), "step 113: 63 %");
    }
}
