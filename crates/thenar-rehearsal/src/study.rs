//! One motion felt in several modes: how stiff, how late, and what energy comes back.

use crate::led::{Led, scripted};
use crate::{BEFORE, RehearsalError, check_all, check_tracker};
use std::f64::consts::TAU;
use thenar_core::{Pose, Vec3};
use thenar_scene::session::Session;
use thenar_touch::haptic_loop::{LoopMode, Settings};
use thenar_touch::{CouplingDesign, TrackerTiming};
use thenar_track::live::LivePose;

/// A hand that is led to and fro along one direction, from where its script begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Study {
    /// Direction, world, with its length: the hand moves between here and this far \[m\].
    pub way: Vec3,
    /// Frequency of the motion \[Hz\].
    pub frequency: f64,
    /// Cycles that are measured, after the hand has set out and come to rest.
    pub cycles: u32,
    /// Timing of the tracker, known to the loop.
    pub tracker: TrackerTiming,
    /// Couplings to the hand; those to the bones are the scene's drives.
    pub design: CouplingDesign,
    /// Damping of the loosest grip that the loop reckons with \[N s/m\]; `None` shows the couplings
    /// as they are.
    pub grip: Option<f64>,
}

/// Result of one mode in a study.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Mode of touch.
    pub mode: LoopMode,
    /// Period of the frames \[ms\]; in single-rate of the tick.
    pub period: u64,
    /// Force against the way \[N\] every ms, all couplings together.
    pub force: Vec<f64>,
    /// Displacement along the way \[m\] likewise, of the hand itself.
    pub displacement: Vec<f64>,
    /// Slope of force over displacement in the deeper half, going in \[N/m\].
    pub stiffness: f64,
    /// By how much later than displacement force correlates best \[ms\].
    pub delay_ms: f64,
    /// Energy given to the hand on balance over all cycles \[J\].
    pub given: f64,
    /// The most that the hand had put in at any time \[J\].
    pub stored_max: f64,
    /// Largest change of force from tick to tick \[N\].
    pub jump_max: f64,
}

impl Comparison {
    /// Root mean square of the difference in force from another run of the same study \[N\].
    pub fn rms_from(&self, other: &Self) -> f64 {
        let squares = self.force.iter().zip(&other.force).map(|(a, b)| (a - b).powi(2));
        (squares.sum::<f64>() / self.force.len().max(1) as f64).sqrt()
    }
}

impl Study {
    /// Looks whether the numbers make sense.
    ///
    /// # Errors
    /// The one that does not.
    pub fn check(&self) -> Result<(), RehearsalError> {
        let (way, cycles, grip) =
            (self.way.norm(), f64::from(self.cycles), self.grip.unwrap_or(1.0));
        check_all(&[
            ("the way", way, 1e-6..=1.0, "m", "longer than 0 and at most 1 m"),
            ("the frequency", self.frequency, 0.05..=20.0, "Hz", "0.05 to 20 Hz"),
            ("the number of cycles", cycles, 1.0..=1000.0, "", "1 to 1000"),
            ("the grip", grip, 1e-3..=1000.0, "N s/m", "0.001 to 1000 N s/m"),
        ])?;
        check_tracker(&self.tracker)
    }

    /// Leads the first hand of a scene through it.
    ///
    /// # Errors
    /// A number makes no sense, or the scene has no hand that could be felt.
    pub fn run(&self, session: Session, mode: LoopMode) -> Result<Comparison, RehearsalError> {
        self.check()?;
        let start = scripted(&session, 0.0)?;
        let Self { design, grip, .. } = *self;
        let settings = Settings { mode, design, grip, ..Settings::default() };
        let mut led = Led::new(session, &settings, self.tracker)?;
        let (unit, length) = (self.way.normalize(), self.way.norm());
        let (mut force, mut displacement) = (Vec::new(), Vec::new());
        let (mut given, mut stored_max) = (0.0, 0.0_f64);
        let cycle = (1e3 / self.frequency).round() as u64;
        let (mut pull, mut before) = (0.0, 0.0);
        for ms in 0..BEFORE + u64::from(self.cycles) * cycle {
            let phase = TAU * ms.saturating_sub(BEFORE) as f64 / cycle as f64;
            let depth = 0.5 * length * (1.0 - phase.cos());
            // The hand goes on against what the last tick shows it.
            given += pull * (depth - before);
            stored_max = stored_max.max(-given);
            led.tick(Some(&moved(&start, unit * depth)), false)?;
            (pull, before) = (led.force().dot(&unit), depth);
            if ms < BEFORE {
                given = 0.0;
                stored_max = 0.0;
                continue;
            }
            force.push(-pull);
            displacement.push(depth);
        }
        let jumps = force.windows(2).map(|w| (w[1] - w[0]).abs());
        let period = if mode == LoopMode::SingleRate { 1 } else { led.stage().period() };
        Ok(Comparison {
            mode,
            period,
            stiffness: slope_going_in(&force, &displacement),
            delay_ms: delay(&force, &displacement, cycle),
            given,
            stored_max,
            jump_max: jumps.fold(0.0, f64::max),
            force,
            displacement,
        })
    }
}

/// A hand as a whole somewhere else.
pub fn moved(pose: &LivePose, way: Vec3) -> LivePose {
    let there = |pose: &Pose| Pose::new(pose.position + way, pose.rotation);
    match pose {
        LivePose::Angles { wrist, angles } => {
            LivePose::Angles { wrist: there(wrist), angles: *angles }
        }
        LivePose::Joints { joints, radii } => {
            LivePose::Joints { joints: joints.each_ref().map(there), radii: *radii }
        }
    }
}

/// Least squares over what lies deeper than the middle while going in.
fn slope_going_in(force: &[f64], displacement: &[f64]) -> f64 {
    let middle = 0.5 * displacement.iter().fold(0.0_f64, |a, d| a.max(*d));
    let mut points = Vec::new();
    for i in 1..force.len() {
        if displacement[i] > middle && displacement[i] > displacement[i - 1] {
            points.push((displacement[i], force[i]));
        }
    }
    let count = points.len() as f64;
    let mean_x = points.iter().map(|p| p.0).sum::<f64>() / count;
    let mean_y = points.iter().map(|p| p.1).sum::<f64>() / count;
    let over: f64 = points.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum();
    over / points.iter().map(|p| (p.0 - mean_x).powi(2)).sum::<f64>()
}

/// The shift of force against displacement that correlates best \[ms\], of half a cycle at most, to
/// a parabola's top.
fn delay(force: &[f64], displacement: &[f64], cycle: u64) -> f64 {
    let n = force.len();
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let (f, d) = (mean(force), mean(displacement));
    // The motion repeats, so shifts wrap round.
    let at = |shift: i64| -> f64 {
        let later = |i: usize| (i as i64 + shift).rem_euclid(n as i64) as usize;
        (0..n).map(|i| (force[later(i)] - f) * (displacement[i] - d)).sum()
    };
    let half = cycle as i64 / 2;
    let all: Vec<f64> = (-half - 1..=half + 1).map(at).collect();
    let best = (1..all.len() - 1).max_by(|a, b| all[*a].total_cmp(&all[*b])).unwrap_or(1);
    let [left, top, right] = [all[best - 1], all[best], all[best + 1]];
    let bend = left - 2.0 * top + right;
    let between = if bend < 0.0 { 0.5 * (left - right) / bend } else { 0.0 };
    best as f64 - (half + 1) as f64 + between
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spring of 300 N/m that answers 37.5 ms late to a motion of 5 cm: its slope, and its delay
    /// though that is a third of a cycle.
    #[test]
    fn slope_and_delay_are_those_of_a_late_spring() {
        let depth = |ms: f64| 0.025 * (1.0 - (TAU * ms / 110.0).cos());
        let displacement: Vec<f64> = (0..220).map(|ms| depth(f64::from(ms))).collect();
        let force = |late: f64| -> Vec<f64> {
            (0..220).map(|ms| 300.0 * depth(f64::from(ms) - late)).collect()
        };
        assert!((slope_going_in(&force(0.0), &displacement) - 300.0).abs() < 1e-6);
        for late in [0.0, 37.5, -20.25] {
            let found = delay(&force(late), &displacement, 110);
            assert!((found - late).abs() < 0.02, "{found} of {late} ms");
        }
    }
}
