//! A recording and the place in it.

use super::PlaybackError;
use std::path::Path;
use std::time::{Duration, Instant};
use thenar_scene::recording::{Event, Index, Replay, ReplayError};
use thenar_scene::session::Session;

/// Time for which damage is shown after it \[s\].
const DAMAGE_SHOWN: f64 = 3.0;
/// So much early is there: times are rounded to nanoseconds \[s\].
const EARLY: f64 = 5e-7;

/// A recording, with all of its beginnings known.
#[derive(Debug)]
pub struct Player {
    replay: Replay,
    index: Index,
    /// Time in the recording of what the session shows \[s\].
    at: f64,
    /// Cost of the last step when it was recorded.
    cost: Duration,
    /// Time to go to \[s\]; it may take many steps.
    goal: Option<f64>,
    failed: Option<String>,
}

impl Player {
    /// At the first scene, or where it is at `from` \[s\].
    ///
    /// # Errors
    /// The recording cannot be replayed, has no scene, or ends before `from`.
    pub fn open(file: &Path, from: f64) -> Result<Self, PlaybackError> {
        let (index, replay) = (Index::of(file)?, Replay::open(file)?);
        index.reach(from)?;
        let mut player =
            Self { replay, index, at: 0.0, cost: Duration::ZERO, goal: None, failed: None };
        player.at = player.replay.go_to(&player.index, from - EARLY)?;
        player.session().ok_or(PlaybackError::Empty)?;
        player.goal = Some(from);
        Ok(player)
    }

    /// The session as it is now; `None` when its scene cannot be made.
    pub fn session(&self) -> Option<&Session> {
        self.replay.session()
    }

    /// Counts scenes from 1.
    pub fn scene(&self) -> u32 {
        self.replay.verdict().scenes
    }

    /// Place in the recording \[s\].
    pub fn at(&self) -> f64 {
        self.at
    }

    /// Length of the recording \[s\].
    pub fn end(&self) -> f64 {
        self.index.end()
    }

    /// Cost of the last step when it was recorded.
    pub fn cost(&self) -> Duration {
        self.cost
    }

    /// True while it is on its way to another place.
    pub fn is_seeking(&self) -> bool {
        self.goal.is_some()
    }

    /// Makes the next step; its time \[s\], or `None` at the end of what can be replayed.
    pub fn step(&mut self) -> Option<f64> {
        loop {
            match self.replay.next() {
                Ok(Some(Event::Stepped { time_ns, cost_ns })) => {
                    self.at = time_ns as f64 * 1e-9;
                    self.cost = Duration::from_nanos(cost_ns.unwrap_or(0).into());
                    return Some(self.at);
                }
                Ok(Some(_)) => {}
                Ok(None) => return None,
                Err(error) => {
                    self.failed = Some(error.to_string());
                    return None;
                }
            }
        }
    }

    /// Sets out for the step at `seconds`: from the present place if it lies ahead and no keyframe
    /// is nearer, else from the last keyframe before it. One step at least is made, so that there
    /// are contacts to be seen.
    ///
    /// # Errors
    /// The recording cannot be read.
    pub fn seek(&mut self, seconds: f64) -> Result<(), ReplayError> {
        let seconds = seconds.clamp(0.0, self.end());
        let before = seconds - EARLY;
        let nearer = |time: &f64| *time > self.at && *time <= before;
        if before < self.at || self.failed.is_some() || self.index.beginnings().iter().any(nearer) {
            self.failed = None;
            self.at = self.replay.go_to(&self.index, before)?;
        }
        self.goal = Some(seconds);
        Ok(())
    }

    /// Goes on towards the place set out for, for as long as this. True when it is there.
    pub fn approach(&mut self, longest: Duration) -> bool {
        let Some(goal) = self.goal else { return true };
        let begun = Instant::now();
        while begun.elapsed() < longest {
            if self.step().is_none_or(|at| at >= goal - EARLY) {
                self.goal = None;
                return true;
            }
        }
        false
    }

    /// Problem with what is shown, if any.
    pub fn problem(&self) -> Option<String> {
        if let Some(failed) = &self.failed {
            return Some(failed.clone());
        }
        let verdict = self.replay.verdict();
        let near = |until: Option<f64>| until.is_none_or(|until| self.at - until < DAMAGE_SHOWN);
        let loss = verdict.losses.iter().rev().find(|loss| near(loss.until));
        let differs = verdict.first.map(|first| {
            let step = first.step;
            format!("this differs from what was recorded, from step {step} on; see `thenar replay`")
        });
        loss.map(ToString::to_string).or(differs)
    }
}
