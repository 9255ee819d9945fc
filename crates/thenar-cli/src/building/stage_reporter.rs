//! Lines of progress: when one is due, and what it says.

use indicatif::{ProgressBar, ProgressStyle};
use std::time::{Duration, Instant};
use thenar_rig::work::Progress;

/// Seconds that one comparison takes, roughly: 15 ns on a core of 3 GHz.
const COMPARISON: f64 = 15e-9;
/// Work expected to be shorter is not announced \[s\].
const SHORT: f64 = 1.0;
/// Least time between lines where the error output is no terminal: a line that is due waits for the
/// next tick, and is still no more than a second late.
const PACE: Duration = Duration::from_millis(900);

/// Tells of one stage after the other.
pub(super) struct StageReporter {
    now: Progress,
    /// Start of the first stage.
    begun: Instant,
    /// Time of the last report.
    last: Instant,
    terminal: bool,
    bar: Option<ProgressBar>,
}

impl StageReporter {
    pub fn new(terminal: bool, now: Instant) -> Self {
        let nothing = Progress { stage: "building", work: 0.0, done: 0.0, steps: 0 };
        Self { now: nothing, begun: now, last: now, terminal, bar: None }
    }

    /// Takes note of how far the work is, and tells of it when a line is due.
    pub fn hear(&mut self, progress: &Progress, now: Instant) {
        if let Some(line) = self.heard(progress, now) {
            self.tell(&line);
        }
        if let Some(bar) = &self.bar {
            bar.set_position((progress.done * 1000.0) as u64);
        }
    }

    /// Tells how far the work was when it was last heard of, when a line is due.
    pub fn tick(&mut self, now: Instant) {
        if let Some(line) = self.due(now) {
            self.tell(&line);
        }
    }

    fn heard(&mut self, progress: &Progress, now: Instant) -> Option<String> {
        // A stage may say more than once that it begins.
        let again = progress.done == 0.0 && self.now.done > 0.0;
        let begins = progress.stage != self.now.stage || again;
        self.now = *progress;
        if begins {
            self.clear();
            let seconds = progress.work * COMPARISON;
            if seconds > SHORT {
                self.last = now;
                return Some(format!("{}: about {seconds:.0} s", progress.stage));
            }
        }
        self.due(now)
    }

    fn due(&mut self, now: Instant) -> Option<String> {
        if now.saturating_duration_since(self.last) < PACE {
            return None;
        }
        self.last = now;
        let Progress { stage, work, done, steps } = self.now;
        let percent = done * 100.0;
        Some(match (work, steps) {
            // Nobody knows how much there is to do.
            (0.0, _) => {
                let seconds = now.saturating_duration_since(self.begun).as_secs_f64();
                format!("{stage}: building for {seconds:.0} s so far")
            }
            (_, 0 | 1) => format!("{stage}: {percent:.0} %"),
            _ => {
                let step = (done * steps as f64).round();
                format!("{stage}: step {step} of {steps}: {percent:.0} %")
            }
        })
    }

    fn tell(&mut self, line: &str) {
        if !self.terminal {
            return eprintln!("{line}");
        }
        if self.bar.is_none() {
            let bar = ProgressBar::new(1000).with_message(line.to_owned());
            if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {percent} %") {
                bar.set_style(style);
            }
            self.bar = Some(bar);
        } else if let Some(bar) = &self.bar {
            bar.set_message(line.to_owned());
        }
    }

    fn clear(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

impl Drop for StageReporter {
    fn drop(&mut self) {
        self.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(work: f64, done: f64) -> Progress {
        Progress { stage: "laying", work, done, steps: 0 }
    }

    /// Lines told in a number of tenths of a second, and in which of them.
    fn told(tenths: u64, hear: impl Fn(u64) -> Option<Progress>) -> Vec<(u64, String)> {
        let begin = Instant::now();
        let mut stage_reporter = StageReporter::new(false, begin);
        let mut told = Vec::new();
        for tenth in 0..tenths {
            let now = begin + Duration::from_millis(100 * tenth);
            let heard = hear(tenth).and_then(|progress| stage_reporter.heard(&progress, now));
            told.extend(heard.or_else(|| stage_reporter.due(now)).map(|line| (tenth, line)));
        }
        told
    }

    #[test]
    fn work_that_says_nothing_more_is_told_of_every_second() {
        let told = told(30, |tenth| (tenth == 0).then_some(at(0.0, 0.0)));
        let expected = [(9, 1), (18, 2), (27, 3)]
            .map(|(tenth, s)| (tenth, format!("laying: building for {s} s so far")));
        assert_eq!(told, expected);
    }

    /// Stages of half a second, each of which would always be 0 s old, are part of one work that
    /// lasts.
    #[test]
    fn work_that_nobody_measures_is_as_old_as_all_of_it() {
        let stages = ["reading", "welding"];
        let stage = |tenth: u64| Progress { stage: stages[tenth as usize / 5 % 2], ..at(0.0, 0.0) };
        let told = told(20, |tenth| (tenth % 5 == 0).then(|| stage(tenth)));
        let expected =
            [(9, "welding: building for 1 s so far"), (18, "welding: building for 2 s so far")];
        assert_eq!(told, expected.map(|(tenth, line)| (tenth, line.to_owned())));
    }

    #[test]
    fn steps_are_counted_where_there_are_several() {
        for (steps, line) in
            [(20, "laying: step 12 of 20: 60 %"), (1, "laying: 60 %"), (0, "laying: 60 %")]
        {
            let told = told(10, |tenth| (tenth == 0).then_some(Progress { steps, ..at(1.0, 0.6) }));
            assert_eq!(told, [(9, line.to_owned())]);
        }
    }

    /// 2e8 comparisons of 15 ns each are 3 s.
    #[test]
    fn long_work_is_announced_once_however_often_it_begins() {
        let told = told(20, |tenth| Some(at(2e8, if tenth < 10 { 0.0 } else { 0.5 })));
        let expected = [(0, "laying: about 3 s"), (9, "laying: 0 %"), (18, "laying: 50 %")];
        assert_eq!(told, expected.map(|(tenth, line)| (tenth, line.to_owned())));
    }

    #[test]
    fn short_work_of_many_stages_is_told_of_every_second_too() {
        let names = ["reading", "welding", "turning"];
        let stage = |tenth: u64| Progress { stage: names[tenth as usize / 4 % 3], ..at(0.0, 0.0) };
        let told = told(20, |tenth| (tenth % 4 == 0).then(|| stage(tenth)));
        assert_eq!(told.iter().map(|line| line.0).collect::<Vec<_>>(), [9, 18]);
    }
}
