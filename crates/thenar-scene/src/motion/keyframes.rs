//! Motions written by hand: the wrist and the fingers at a few instants.
//!
//! ```toml
//! [[key]]
//! time = 0.0                                  # s
//! pose = "open"                               # a preset for the whole hand
//! wrist = { position = [0.0, 0.12, 0.0], fingers = [0, 0, -1], back = [0, 1, 0] }
//!
//! [[key]]
//! time = 0.8
//! curl = { index = 0.6, thumb = 0.3 }         # 0 open .. 1 fist, per finger
//! joints = { index-proximal = { flexion_deg = 40, spread_deg = 5 } }
//!
//! [[key]]
//! time = 1.5
//! tips = { index = [0.02, 0.0, -0.1] }        # m, world: where the middle of its pad is
//! ```
//!
//! Within a key, `pose` is refined by `curl`, that by `joints`, and that by `tips`. What a key does
//! not name keeps moving between the keys that do name it.

mod compile;
mod desc;

pub use desc::{JointKey, Key, KeyframesDesc, LimitPolicy, WristKey};

use super::error::MotionError;
use super::interpolate::{RotationTrack, ScalarTrack, VectorTrack};
use compile::{check_times, joint_tracks, wrist_tracks};
use thenar_core::model::HandModel;
use thenar_core::world::Target;
use thenar_core::{Pose, Vec3};
use thenar_track::{Anatomy, Articulation};

/// A keyframed motion made ready for one hand.
#[derive(Clone, Debug)]
pub struct Keyframes {
    articulation: Articulation,
    position: VectorTrack,
    rotation: RotationTrack,
    joints: Vec<[ScalarTrack; 2]>,
    angles: Vec<[f64; 2]>,
    rates: Vec<[f64; 2]>,
    duration: f64,
    time: f64,
    warnings: Vec<String>,
}

impl Keyframes {
    /// Fits `desc` to `hand`. Where no key tells, the wrist stays where `pose_WM` (the pose of
    /// the model frame) puts it, and joints stay at rest.
    pub fn new(
        desc: &KeyframesDesc,
        hand: &HandModel,
        pose_WM: &Pose,
    ) -> Result<Self, MotionError> {
        let articulation = Articulation::new(hand)?;
        let anatomy = Anatomy::of(hand);
        let duration = check_times(&desc.key)?;
        let home = articulation.wrist_at_rest(pose_WM);
        let (position, rotation) = wrist_tracks(&desc.key, &home)?;
        let wrist = |time| Pose::new(position.at(time)[0], rotation.at(time).0);
        let (joints, warnings) = joint_tracks(desc, hand, &articulation, &anatomy, &wrist)?;
        let still = vec![[0.0; 2]; joints.len()];
        Ok(Self {
            articulation,
            position,
            rotation,
            joints,
            angles: still.clone(),
            rates: still,
            duration,
            time: 0.0,
            warnings,
        })
    }

    /// Angles that were clamped, one line each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Time of the last key \[s\].
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Returns the pose of the model frame of the hand at rest that puts its wrist where the motion
    /// starts.
    pub fn start_placement(&self) -> Pose {
        self.articulation.placement(&self.wrist(f64::NEG_INFINITY).0)
    }

    /// Targets of all bones at `time` \[s\].
    pub fn sample(&mut self, time: f64, out: &mut [Option<Target>]) {
        if time.is_finite() {
            self.time = time;
        }
        let (wrist, velocity) = self.wrist(self.time);
        for (j, tracks) in self.joints.iter().enumerate() {
            for (k, track) in tracks.iter().enumerate() {
                [self.angles[j][k], self.rates[j][k]] = track.at(self.time);
            }
        }
        self.articulation.targets(&wrist, velocity, &self.angles, &self.rates, out);
    }

    fn wrist(&self, time: f64) -> (Pose, [Vec3; 2]) {
        let [position, velocity] = self.position.at(time);
        let (rotation, angular) = self.rotation.at(time);
        (Pose::new(position, rotation), [velocity, angular])
    }
}

#[cfg(test)]
mod tests;
