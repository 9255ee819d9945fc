//! Times that the stages of a step take.

use std::time::Instant;
use thenar_core::histogram::Histogram;
use thenar_core::world::{Stage, StageTimer};

/// The stages in the order of a step, with their names in reports.
pub const STAGES: [(Stage, &str); 5] = [
    (Stage::Skeleton, "skeleton"),
    (Stage::Flesh, "flesh"),
    (Stage::Detect, "detect"),
    (Stage::Contact, "contact"),
    (Stage::Embed, "embed"),
];

/// Durations of the stages, and of whole steps, over a run.
#[derive(Clone, Debug, Default)]
pub struct StageTimes {
    /// In the order of [`STAGES`].
    pub stages: [Histogram; 5],
    /// Whole steps.
    pub total: Histogram,
}

/// Takes the times of a step.
#[derive(Clone, Debug, Default)]
pub struct StopWatch {
    /// All times so far.
    pub times: StageTimes,
    /// Starts of the step and of its present stage.
    step: Option<Instant>,
    stage: Option<(Stage, Instant)>,
    /// This step's times \[ns\]: a stage may come more than once.
    spent: [u64; 5],
}

impl StageTimer for StopWatch {
    fn begin(&mut self, stage: Option<Stage>) {
        let now = Instant::now();
        if let Some((stage, begun)) = self.stage.take() {
            let at = STAGES.iter().position(|(s, _)| *s == stage).unwrap_or(0);
            self.spent[at] += nanoseconds(begun, now);
        }
        match stage {
            Some(stage) => {
                self.step.get_or_insert(now);
                self.stage = Some((stage, now));
            }
            None => {
                if let Some(begun) = self.step.take() {
                    self.times.total.add(nanoseconds(begun, now));
                    for (histogram, ns) in self.times.stages.iter_mut().zip(&mut self.spent) {
                        histogram.add(std::mem::take(ns));
                    }
                }
            }
        }
    }
}

fn nanoseconds(from: Instant, to: Instant) -> u64 {
    u64::try_from((to - from).as_nanos()).unwrap_or(u64::MAX)
}
