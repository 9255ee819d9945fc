//! One motion felt in several modes: how stiff, how late, and what energy comes back.

use super::{Rehearsal, TouchError, TouchMode, TouchSettings};
use crate::session::Session;
use std::f64::consts::TAU;
use thenar::world::Target;
use thenar::{Pose, Vec3};
use thenar_touch::{CouplingDesign, Prediction, RigidState};

/// A hand that is led to and fro along one direction, from where its motion begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Study {
    /// Direction, world, with its length: the hand moves between here and this far \[m\].
    pub way: Vec3,
    /// How often \[Hz\].
    pub frequency: f64,
    /// Before, while it comes to rest \[ms\].
    pub settle: u64,
    /// Then, measured \[ms\]: whole cycles.
    pub measured: u64,
}

/// What one mode made of it.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Mode of touch.
    pub mode: TouchMode,
    /// Simulation's period \[ms\].
    pub period: u64,
    /// Force against the way \[N\] every ms, all couplings together.
    pub force: Vec<f64>,
    /// Displacement along the way \[m\] likewise.
    pub displacement: Vec<f64>,
    /// Slope of force over displacement in the deeper half, going in \[N/m\].
    pub stiffness: f64,
    /// How much later than displacement force reaches half its span on the way in and out, on the
    /// mean \[ms\].
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

/// Leads the first hand of a scene through a study.
///
/// # Errors
/// The scene has no hand, or it cannot be felt.
pub fn compare(
    session: &Session,
    design: CouplingDesign,
    mode: TouchMode,
    period: u64,
    study: &Study,
) -> Result<Comparison, TouchError> {
    let prediction = Prediction::SIMULATION;
    let settings = TouchSettings { mode, design, period, latency: period, prediction, grip: None };
    lead(session, &settings, study)
}

/// Leads the first hand of a scene through a study.
///
/// # Errors
/// The scene has no hand, or it cannot be felt.
pub fn lead(
    session: &Session,
    settings: &TouchSettings,
    study: &Study,
) -> Result<Comparison, TouchError> {
    let (mode, period) = (settings.mode, settings.period);
    let mut chain = Rehearsal::new(session, 0, settings)?;
    let start = start_poses(session)?;
    let (unit, length) = (study.way.normalize(), study.way.norm());
    let mut force = Vec::new();
    let mut displacement = Vec::new();
    let (mut given, mut stored_max) = (0.0, 0.0_f64);
    for ms in 0..study.settle + study.measured {
        let t = 1e-3 * (ms + 1).saturating_sub(study.settle) as f64;
        let phase = TAU * study.frequency * t;
        let depth = 0.5 * length * (1.0 - phase.cos());
        let speed = 0.5 * length * phase.sin() * TAU * study.frequency;
        for (bone, state) in start.iter().enumerate() {
            let pose_WB = Pose::new(state.position + unit * depth, state.rotation);
            let velocity_W = unit * speed;
            chain.lead(bone, RigidState { velocity_W, ..RigidState::at_rest(pose_WB) });
        }
        chain.tick(false);
        if ms < study.settle {
            continue;
        }
        let pull: Vec3 = chain.touch().device_wrenches().iter().map(|[f, _]| *f).sum();
        force.push(-pull.dot(&unit));
        displacement.push(depth);
        given += chain.power() * 1e-3;
        stored_max = stored_max.max(-given);
    }
    let jumps = force.windows(2).map(|w| (w[1] - w[0]).abs());
    Ok(Comparison {
        mode,
        period,
        stiffness: slope_going_in(&force, &displacement),
        delay_ms: delay(&force, &displacement),
        given,
        stored_max,
        jump_max: jumps.fold(0.0, f64::max),
        force,
        displacement,
    })
}

/// Where the hand's motion begins, or where it is.
fn start_poses(session: &Session) -> Result<Vec<Pose>, TouchError> {
    let hand = session.hands().first().ok_or(TouchError::NoHand(0))?;
    let there = |b: u32| RigidState::of(session.world(), b).target();
    let mut targets: Vec<Option<Target>> =
        hand.handle.bones.clone().map(|b| Some(there(b))).collect();
    if let Some(motion) = &hand.motion {
        motion.clone().sample(0.0, &mut targets);
    }
    Ok(targets.iter().flatten().map(|target| target.pose_WB).collect())
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

/// The shift of force against displacement that correlates best \[ms\], to a parabola's top.
fn delay(force: &[f64], displacement: &[f64]) -> f64 {
    let n = force.len();
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let (f, d) = (mean(force), mean(displacement));
    // The motion repeats, so shifts wrap round.
    let at = |shift: i64| -> f64 {
        let later = |i: usize| (i as i64 + shift).rem_euclid(n as i64) as usize;
        (0..n).map(|i| (force[later(i)] - f) * (displacement[i] - d)).sum()
    };
    let best = (-100..=100_i64).max_by(|a, b| at(*a).total_cmp(&at(*b))).unwrap_or(0);
    let [left, top, right] = [best - 1, best, best + 1].map(at);
    let bend = left - 2.0 * top + right;
    best as f64 + if bend < 0.0 { 0.5 * (left - right) / bend } else { 0.0 }
}
