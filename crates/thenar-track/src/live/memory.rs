//! Memory of a hand that poses move: with it, another that was made from the same scene goes on
//! with the same bits.

use super::clock::{Clock, Timing};
use super::kinematic_state::KinematicState;
use super::observer::{Observed, ObservedRotation};
use super::{JOINT_RATE_MAX, LiveError, LiveHand, SPEED_MAX, SPIN_MAX};
use serde::{Deserialize, Serialize};
use thenar_core::{Pose, Quat, Vec3};

/// A sample this far from what was expected is a teleport: \[m\] and \[m/s\] times the gap.
const TELEPORT: [f64; 2] = [0.05, SPEED_MAX];
/// Limits of a teleport for rotations \[rad, rad/s\].
const TELEPORT_TURN: [f64; 2] = [0.5, 25.0];

/// Poses that refine the calibration.
pub const CALIBRATION: usize = 90;

/// Source of a hand's targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PoseSource {
    /// The scene's script, as it is.
    Script,
    /// On the way back to the script.
    Returning,
    /// Poses move the hand.
    Live,
}

/// All that changes in a hand from pose to pose and from step to step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Size of the tracked hand over ours, of the first poses: [`CALIBRATION`] of them.
    pub ratios: Vec<f64>,
    /// Number of these that are known.
    pub calibrated: usize,
    /// Source of the targets.
    pub way: PoseSource,
    /// The tracker said that it has lost the hand.
    pub lost: bool,
    /// Time stepped \[s\]; goes on when the scene starts over.
    pub now: f64,
    /// Joins the tracker's time to ours.
    pub clock: Clock,
    /// Time at which the newest pose came \[s\].
    pub arrived: f64,
    /// Age of that pose when it came \[s\].
    pub late: f64,
    /// Time at which the hand set out for another place \[s\].
    pub set_out: f64,
    /// The tracked wrist.
    pub position: Observed<Vec3>,
    /// Observed rotation of the wrist.
    pub rotation: ObservedRotation,
    /// The tracked joints.
    pub joints: Vec<[Observed<f64>; 2]>,
    /// Stance of the targets.
    pub kinematic_state: KinematicState,
    /// Stance that the script wants, or the tracked pose.
    pub script: KinematicState,
    /// The script's place in the step before is known.
    pub script_known: bool,
}

impl Memory {
    /// Nothing is known of a tracker.
    pub fn new(kinematic_state: KinematicState, joints: usize) -> Self {
        Self {
            ratios: vec![1.0; CALIBRATION],
            calibrated: 0,
            way: PoseSource::Script,
            lost: false,
            now: 0.0,
            clock: Clock::default(),
            arrived: f64::NEG_INFINITY,
            late: 0.0,
            set_out: 0.0,
            position: Observed::at(Vec3::zeros()),
            rotation: ObservedRotation::at(Quat::identity()),
            joints: vec![[Observed::at(0.0); 2]; joints],
            script: kinematic_state.clone(),
            kinematic_state,
            script_known: false,
        }
    }

    /// Takes a pose that was carried over into the observers, which remember noise for `longest`
    /// \[s\] at most; sets out anew where it does not continue the ones before.
    pub fn observe(
        &mut self,
        wrist: &Pose,
        angles: &[[f64; 2]],
        timing: &Timing,
        was_lost: bool,
        longest: f64,
    ) {
        let gap = timing.gap.unwrap_or(0.0);
        let far = |[base, rate]: [f64; 2]| base + rate * gap;
        let teleported = self.position.surprise(wrist.position, timing.gap) > far(TELEPORT)
            || self.rotation.surprise(&wrist.rotation, timing.gap) > far(TELEPORT_TURN);
        if was_lost || timing.fresh || teleported {
            self.position = Observed::at(wrist.position);
            self.rotation = ObservedRotation::at(wrist.rotation);
            for (joint, angles) in self.joints.iter_mut().zip(angles) {
                *joint = angles.map(Observed::at);
            }
            self.set_out = self.now;
            return;
        }
        self.position.take(wrist.position, timing.gap, SPEED_MAX, longest);
        self.rotation.take(&wrist.rotation, timing.gap, SPIN_MAX, longest);
        for (joint, angles) in self.joints.iter_mut().zip(angles) {
            for k in 0..2 {
                joint[k].take(angles[k], timing.gap, JOINT_RATE_MAX, longest);
            }
        }
    }

    /// True when it is of a hand with as many joints.
    fn fits(&self, other: &Self) -> bool {
        let joints = |memory: &Self| {
            let (kinematic_state, script) = (&memory.kinematic_state, &memory.script);
            let lists =
                [&kinematic_state.angles, &kinematic_state.rates, &script.angles, &script.rates];
            (memory.joints.len(), lists.map(Vec::len))
        };
        joints(self) == joints(other)
            && self.ratios.len() == other.ratios.len()
            && self.calibrated <= self.ratios.len()
    }
}

/// Memory of a [`LiveHand`], apart from it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LiveMemory {
    memory: Memory,
    wrist_offset: Option<Quat>,
    knuckles: [Vec3; 4],
}

/// A borrowed [`LiveMemory`].
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LiveMemoryRef<'a> {
    memory: &'a Memory,
    wrist_offset: Option<Quat>,
    knuckles: [Vec3; 4],
}

impl LiveHand {
    /// All that the next step depends on besides the scene and what enters.
    pub fn memory(&self) -> LiveMemoryRef<'_> {
        LiveMemoryRef {
            memory: &self.memory,
            wrist_offset: self.retarget.as_ref().map(|retarget| retarget.wrist_offset()),
            knuckles: self.knuckles.sums(),
        }
    }

    /// True when [`LiveHand::recall`] takes this.
    pub fn fits(&self, kept: &LiveMemory) -> bool {
        kept.memory.fits(&self.memory) && kept.wrist_offset.is_some() == self.retarget.is_some()
    }

    /// Goes on from what a hand of the same scene remembered.
    ///
    /// # Errors
    /// It was another hand. Nothing has changed then.
    pub fn recall(&mut self, kept: &LiveMemory) -> Result<(), LiveError> {
        if !self.fits(kept) {
            let cause = "what it is to remember is of a hand with other joints".into();
            return Err(LiveError::Unfit { hand: self.name.clone(), cause });
        }
        self.memory.clone_from(&kept.memory);
        if let (Some(retarget), Some(offset)) = (&mut self.retarget, kept.wrist_offset) {
            retarget.set_wrist_offset(offset);
        }
        self.knuckles.set_sums(kept.knuckles);
        Ok(())
    }
}
