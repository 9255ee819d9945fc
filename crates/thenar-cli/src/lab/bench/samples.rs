//! Times of each stage of each step.

use std::time::Instant;
use thenar_core::world::{Stage, StageTimer};
use thenar_scene::session::Session;

/// Samples of one quantity; of a stage's duration \[µs\], one for each step.
#[derive(Clone, Debug, Default)]
pub struct Samples(Vec<f64>);

impl Samples {
    /// One more.
    pub fn push(&mut self, sample: f64) {
        self.0.push(sample);
    }

    /// The value that this part of the samples stays below.
    pub fn quantile(&mut self, part: f64) -> f64 {
        self.0.sort_unstable_by(f64::total_cmp);
        let last = self.0.len().saturating_sub(1);
        self.0.get((last as f64 * part).round() as usize).copied().unwrap_or(f64::NAN)
    }
}

/// A stopwatch over the stages of a step.
#[derive(Debug)]
pub struct Stopwatch {
    running: Option<(Stage, Instant)>,
    /// The present step, by stage \[µs\].
    now: [f64; 5],
    /// All steps, by stage.
    pub stages: [Samples; 5],
    /// All steps, whole.
    pub total: Samples,
}

impl Stopwatch {
    /// Room for a number of steps.
    pub fn new(steps: usize) -> Self {
        let room = || Samples(Vec::with_capacity(steps));
        Self {
            running: None,
            now: [0.0; 5],
            stages: std::array::from_fn(|_| room()),
            total: room(),
        }
    }

    /// Steps the session and takes its times.
    pub fn step(&mut self, session: &mut Session) {
        session.step(self);
        for (samples, time) in self.stages.iter_mut().zip(self.now) {
            samples.0.push(time);
        }
        self.total.0.push(self.now.iter().sum());
        self.now = [0.0; 5];
    }
}

impl Stopwatch {
    /// Copies the last step of another watch.
    pub fn take_last(&mut self, other: &Self) {
        for (to, from) in self.stages.iter_mut().zip(&other.stages) {
            to.0.extend(from.0.last());
        }
        self.total.0.extend(other.total.0.last());
    }
}

impl StageTimer for Stopwatch {
    fn begin(&mut self, stage: Option<Stage>) {
        let now = Instant::now();
        if let Some((stage, start)) = self.running.take() {
            self.now[stage as usize] += (now - start).as_secs_f64() * 1e6;
        }
        self.running = stage.map(|stage| (stage, now));
    }
}
