//! Force that rises on one finger, step by step, until somebody stops it.

use super::UNFINISHED;
use crate::devices::feel::Trial;
use crate::devices::keys::{AnyKey, Key, Keys};
use crate::error::CliError;
use crate::interrupt;
use std::time::{Duration, Instant};
use thenar_link::{DIGITS, now_ns};
use thenar_touch::safety::{Pause, Status};

/// Steps to the most that is allowed: half a newton each for a CyberGrasp's 6 N.
pub const STEPS: u32 = 12;
/// Part of a step in which force rises; then it stays, to be felt.
const RISING: f64 = 0.5;
/// After its ramp the guard lets through what is wanted; a little later force begins \[s\].
const AFTER_RAMP: f64 = 0.2;
/// Between two ticks: some thousand a second.
const TICK: Duration = Duration::from_micros(900);

/// Way in which a ramp ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RampEnd {
    /// At the most that is allowed, after all of its last step.
    Top,
    /// By the person, when this was the last step that was not stopped \[N\].
    Stopped {
        /// Force of that step.
        comfortable: f64,
    },
    /// This program stood still too long.
    HeldUp,
    /// The device was not heard.
    Silent,
}

/// A finger's, or an arm's direction's, way from nothing to the most.
#[derive(Clone, Copy, Debug)]
pub struct ForceRamp {
    axis: usize,
    most: f64,
    step: f64,
    ramp: f64,
}

impl ForceRamp {
    /// A ramp to `most` \[N\] in steps of `step` \[s\], after the guard's ramp \[s\].
    pub fn new(axis: usize, most: f64, step: f64, ramp: f64) -> Self {
        Self { axis, most, step, ramp }
    }

    /// Force after so long \[N\], and that of the last step that is over; `None` when all are.
    pub fn at(&self, seconds: f64) -> Option<(f64, f64)> {
        let since = seconds - self.ramp - AFTER_RAMP;
        if since < 0.0 {
            return Some((0.0, 0.0));
        }
        let done = (since / self.step).floor();
        if done >= f64::from(STEPS) {
            return None;
        }
        let size = self.most / f64::from(STEPS);
        let rising = ((since / self.step - done) / RISING).min(1.0);
        let part = 0.5 - 0.5 * (std::f64::consts::PI * rising).cos();
        Some(((done + part) * size, done * size))
    }

    /// Plays it through the guard.
    ///
    /// # Errors
    /// The guard trips, the input ends, or the program is to: forces are released then.
    pub fn run(&self, trial: &mut Trial, keys: &Keys) -> Result<RampEnd, CliError> {
        let _any = AnyKey::counts();
        let start = Instant::now();
        while let Some((force, comfortable)) = self.at(start.elapsed().as_secs_f64()) {
            match keys.heard() {
                Some(Key::Pressed(_)) => {
                    trial.release();
                    return Ok(RampEnd::Stopped { comfortable });
                }
                Some(Key::Closed) => return Err(unfinished(trial)),
                None if interrupt::asked() => return Err(unfinished(trial)),
                None => {}
            }
            if let Some(ended) = self.tick(trial, now_ns(), force)? {
                return Ok(ended);
            }
            std::thread::sleep(TICK);
        }
        Ok(RampEnd::Top)
    }

    /// Shows this force; says what speaks against going on.
    pub fn tick(
        &self,
        trial: &mut Trial,
        now: u64,
        force: f64,
    ) -> Result<Option<RampEnd>, CliError> {
        let mut wanted = [0.0; DIGITS];
        wanted[self.axis] = force;
        trial.show(now, wanted)?;
        let ended = match trial.status() {
            Status::Waiting { pause: Some(Pause::Loop { .. }), .. } => RampEnd::HeldUp,
            // At the start nothing has been heard through this guard.
            Status::Waiting { pause: Some(_), .. } => RampEnd::Silent,
            _ => return Ok(None),
        };
        trial.release();
        Ok(Some(ended))
    }
}

fn unfinished(trial: &mut Trial) -> CliError {
    trial.release();
    CliError::Other(UNFINISHED.into())
}
