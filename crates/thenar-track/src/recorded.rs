//! Motions recorded from a tracked hand, made fit to drive a simulated one.
//!
//! Samples are first carried over to our hand (wrist pose and joint angles), then, at every
//! millisecond of the motion:
//!
//! 1. *resampled*: straight between two neighbouring samples; held while tracking is lost, that is
//!    between samples further apart than `loss_s`, and after the last;
//! 2. *limited* in speed, so that teleports become walks; after a loss the limit starts at zero
//!    and opens within `reacquire_s`, so that the hand returns softly from where it froze;
//! 3. *filtered* (see the filter's page): critically damped at `filter_hz`, which follows steady
//!    motion 1/(π `filter_hz`) seconds late: 40 ms at 8 Hz. The output depends on past input only.
//!
//! The result is a function of time alone, whatever times it is asked at.

use super::articulation::Articulation;
use super::filter;
use super::recording::{Recording, TrackedSample};
use super::retarget::Retarget;
use crate::FitError;
use desc::Settings;
use thenar_core::model::{HandModel, Side};
use thenar_core::world::Target;
use thenar_core::{Pose, Quat};

mod desc;

pub use desc::RecordedDesc;

/// Inner time step \[s\].
const STEP: f64 = 1e-3;
/// Time for which the filter runs on after the last sample, until nothing moves any more \[s\].
const SETTLE: f64 = 120.0;

/// State of tracking at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tracking {
    /// Samples come in.
    Tracked,
    /// Samples are missing, and the hand stands still.
    Lost,
    /// Samples come in again, and the hand is on its way to them.
    Reacquiring,
}

/// One sample carried over: the wrist in the world, and the joint angles.
#[derive(Clone, Debug)]
struct Knot {
    time: f64,
    wrist: Pose,
    angles: Vec<[f64; 2]>,
}

/// A recorded motion made ready for one hand.
#[derive(Clone, Debug)]
pub struct Recorded {
    articulation: Articulation,
    settings: Settings,
    knots: Vec<Knot>,
    /// Number of inner steps behind the filter's state.
    steps: u64,
    /// The knot in force.
    at: usize,
    position: filter::FilteredPoint,
    rotation: filter::Rotation,
    joints: Vec<[filter::Scalar; 2]>,
    tracking: Tracking,
    /// Time at which tracking last came back \[s\].
    acquired: f64,
    angles: Vec<[f64; 2]>,
    rates: Vec<[f64; 2]>,
    time: f64,
}

impl Recorded {
    /// Fits one hand of `recording` to `hand`. Time 0 is the recording's first sample of any
    /// hand, plus `desc.start_s`.
    pub fn new(
        desc: &RecordedDesc,
        recording: &Recording,
        hand: &HandModel,
    ) -> Result<Self, FitError> {
        let settings = desc.settings()?;
        let articulation = Articulation::new(hand)?;
        let side = desc.hand.or(hand.side).unwrap_or(Side::Right);
        let samples = recording.hand(side);
        let origin = recording.span().map_or(0.0, |span| span[0]) + desc.start_s;
        let used = &samples[samples.partition_point(|s| s.time < origin)..];
        if used.is_empty() {
            let side = if side == Side::Left { "left" } else { "right" };
            return Err(FitError::NoHand { side });
        }
        let mirror = hand.side.is_some_and(|ours| ours != side);
        let retarget = Retarget::new(hand, samples, mirror)?;
        let knots = carry_over(&retarget, &articulation, used, &settings.placement, origin);

        let still = vec![[0.0; 2]; articulation.tree.joints()];
        let first = knots[0].wrist;
        let mut motion = Self {
            joints: vec![[filter::Scalar::default(); 2]; still.len()],
            articulation,
            settings,
            knots,
            steps: 0,
            at: 0,
            position: filter::FilteredPoint::still(first.position),
            rotation: filter::Rotation::still(first.rotation),
            tracking: Tracking::Reacquiring,
            acquired: 0.0,
            angles: still.clone(),
            rates: still,
            time: 0.0,
        };
        motion.restart();
        Ok(motion)
    }

    /// Time of the last sample \[s\].
    pub fn duration(&self) -> f64 {
        self.knots.last().map_or(0.0, |knot| knot.time)
    }

    /// Returns the lag of the targets behind steady motion \[s\].
    pub fn delay(&self) -> f64 {
        2.0 / self.settings.omega
    }

    /// Returns the state of tracking at the time last sampled.
    pub fn tracking(&self) -> Tracking {
        self.tracking
    }

    /// Returns the pose of the model frame that puts the wrist of the hand at rest where the motion
    /// starts. The motion starts with the fingers at rest too.
    pub fn start_placement(&self) -> Pose {
        self.articulation.placement(&self.knots[0].wrist)
    }

    /// Targets of all bones at `time` \[s\]. Times should not decrease from call to call: going
    /// back starts over, which takes as long as the motion has steps.
    pub fn sample(&mut self, time: f64, out: &mut [Option<Target>]) {
        if time.is_finite() {
            self.time = time.clamp(0.0, self.duration() + SETTLE);
        }
        let steps = (self.time / STEP).floor() as u64;
        if steps < self.steps {
            self.restart();
        }
        while self.steps < steps {
            self.advance();
        }
        self.emit(self.time - self.steps as f64 * STEP, out);
    }

    /// Back to time 0: at the first sample's place, fingers at rest, on the way to the first pose.
    fn restart(&mut self) {
        let first = self.knots[0].wrist;
        self.position = filter::FilteredPoint::still(first.position);
        self.rotation = filter::Rotation::still(first.rotation);
        for (joint, rest) in self.joints.iter_mut().zip(&self.articulation.rest_angles) {
            *joint = rest.map(filter::Scalar::still);
        }
        (self.steps, self.at) = (0, 0);
        (self.tracking, self.acquired) = (Tracking::Reacquiring, 0.0);
        self.aim();
    }

    /// Moves the filters to the end of the running step and aims them for the next.
    fn advance(&mut self) {
        let omega = self.settings.omega;
        self.position.advance(omega, STEP);
        self.rotation.advance(omega, STEP);
        self.joints.iter_mut().flatten().for_each(|joint| joint.advance(omega, STEP));
        self.steps += 1;
        self.aim();
    }

    /// Gives the filters their input for the step that begins at `steps`.
    fn aim(&mut self) {
        let now = self.steps as f64 * STEP;
        let part = self.find(now);
        let opening = ((now - self.acquired) / self.settings.reacquire).clamp(0.0, 1.0);
        let held = self.tracking == Tracking::Reacquiring;
        let share = if held { opening } else { 1.0 } * STEP;

        let from = &self.knots[self.at];
        let to = self.knots.get(self.at + 1).unwrap_or(from);
        let position = from.wrist.position.lerp(&to.wrist.position, part);
        let turn = (to.wrist.rotation * from.wrist.rotation.inverse()).scaled_axis();
        let rotation = Quat::from_scaled_axis(turn * part) * from.wrist.rotation;
        let mut left = self.position.aim(position, self.settings.speed_max * share);
        left += self.rotation.aim(rotation, self.settings.spin_max * share);
        for ((joint, from), to) in self.joints.iter_mut().zip(&from.angles).zip(&to.angles) {
            for k in 0..2 {
                let raw = from[k] + (to[k] - from[k]) * part;
                left += joint[k].aim(raw, self.settings.joint_rate_max * share);
            }
        }
        if held && left == 0.0 && opening >= 1.0 {
            self.tracking = Tracking::Tracked;
        }
    }

    /// Finds the knot in force and how far the next one is on; notes loss and return of tracking.
    fn find(&mut self, now: f64) -> f64 {
        let before = self.at;
        while self.knots.get(self.at + 1).is_some_and(|next| next.time <= now) {
            self.at += 1;
        }
        let gap = |k: usize| match self.knots.get(k + 1) {
            Some(next) => next.time - self.knots[k].time,
            None => f64::INFINITY,
        };
        if (before..self.at).any(|k| gap(k) > self.settings.loss) {
            (self.tracking, self.acquired) = (Tracking::Reacquiring, now);
        }
        let since = now - self.knots[self.at].time;
        if gap(self.at) > self.settings.loss {
            if since > self.settings.loss {
                self.tracking = Tracking::Lost;
            }
            return 0.0;
        }
        (since / gap(self.at)).clamp(0.0, 1.0)
    }

    fn emit(&mut self, ahead: f64, out: &mut [Option<Target>]) {
        let omega = self.settings.omega;
        let [position, velocity] = self.position.after(omega, ahead);
        let (rotation, spin) = self.rotation.after(omega, ahead);
        for (j, joint) in self.joints.iter().enumerate() {
            for k in 0..2 {
                [self.angles[j][k], self.rates[j][k]] = joint[k].after(omega, ahead);
            }
        }
        let wrist = Pose::new(position, rotation);
        self.articulation.targets(&wrist, [velocity, spin], &self.angles, &self.rates, out);
    }
}

fn carry_over(
    retarget: &Retarget,
    articulation: &Articulation,
    samples: &[TrackedSample],
    placement: &Pose,
    origin: f64,
) -> Vec<Knot> {
    let bones = articulation.tree.bones();
    let (mut wanted, mut poses) = (vec![Pose::identity(); bones], vec![Pose::identity(); bones]);
    let carry = |sample: &TrackedSample| {
        let mut angles = vec![[0.0; 2]; articulation.tree.joints()];
        let wrist =
            retarget.apply(articulation, &sample.joints, &mut angles, &mut wanted, &mut poses);
        Knot { time: sample.time - origin, wrist: *placement * wrist, angles }
    };
    samples.iter().map(carry).collect()
}

#[cfg(test)]
mod tests;
