//! The tracked hand in one tick, as every mode takes it: samples in, one target per bone out that
//! never leaps.
//!
//! A bone that is found for the first time, or that the tracker puts somewhere else, is led there: its
//! target **glides** from where it was, or from its simulated bone where that is nearer: in a scene that
//! began anew the bones are at their start. Until it has all but arrived the wearer feels nothing of it,
//! because the way there is the tracker's doing and not the wearer's.

use super::{Sample, Track};
use crate::{Prediction, RigidState, seconds_between};
use thenar::math::{Pose, Quat, Vec3, rotation_vector};

/// Within this distance of its tracked pose the force of a gliding bone grows from nothing to all \[m\].
const ARRIVING: f64 = 0.01;
/// A turn counts as its arc at this distance \[m\]: half a phalanx.
const LEVER: f64 = 0.02;

/// All tracked bones of a hand.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct TrackedHand {
    prediction: Prediction,
    /// Time constant of a glide \[s\]; zero leaps.
    glide: f64,
    tracks: Vec<Track>,
    /// Tracked at least once, by the last tick.
    known: Vec<bool>,
    jumped: Vec<bool>,
    /// Set out from its simulated bone in the last tick.
    from_bone: Vec<bool>,
    /// What is left of jumps (linear, angular): targets are the tracked poses plus this.
    left: Vec<[Vec3; 2]>,
    tracked: Vec<RigidState>,
    targets: Vec<RigidState>,
    last_ns: Option<u64>,
}

impl TrackedHand {
    /// A hand that nobody has seen yet, with its bones here.
    pub fn new(prediction: Prediction, glide: f64, bones: &[RigidState]) -> Self {
        let n = bones.len();
        Self {
            prediction,
            glide,
            tracks: vec![Track::default(); n],
            known: vec![false; n],
            jumped: vec![false; n],
            from_bone: vec![false; n],
            left: vec![[Vec3::zeros(); 2]; n],
            tracked: bones.to_vec(),
            targets: bones.to_vec(),
            last_ns: None,
        }
    }

    /// See [`Track::push`].
    pub fn push(
        &mut self,
        bone: usize,
        time_ns: u64,
        pose_WB: Pose,
        velocity: Option<[Vec3; 2]>,
    ) -> Sample {
        self.tracks[bone].push(time_ns, pose_WB, velocity, &self.prediction)
    }

    /// Begins a tick: time since the one before \[s\], not negative and at most `most`.
    pub fn passed(&mut self, now_ns: u64, most: f64) -> f64 {
        let passed = seconds_between(self.last_ns.unwrap_or(now_ns), now_ns);
        self.last_ns = Some(now_ns);
        passed.clamp(0.0, most)
    }

    /// Places tracked poses and targets `h` \[s\] after the tick before; the age of the oldest \[s\],
    /// infinite when a bone was never tracked. Such a bone goes where its simulated one is.
    pub fn place(&mut self, now_ns: u64, h: f64, bones: &[RigidState]) -> f64 {
        let mut oldest = 0.0_f64;
        let decay = if self.glide > 0.0 { (-h / self.glide).exp() } else { 0.0 };
        for (i, track) in self.tracks.iter_mut().enumerate() {
            let Some(told) = track.at(now_ns, &self.prediction) else {
                (self.tracked[i], self.targets[i]) = (bones[i], bones[i]);
                oldest = f64::INFINITY;
                continue;
            };
            let begins = !std::mem::replace(&mut self.known[i], true);
            self.jumped[i] = told.jumped;
            self.tracked[i] = told.state;
            let left = &mut self.left[i];
            self.from_bone[i] = false;
            if told.jumped || begins {
                let to = &told.state.pose_WB;
                let ways = [&self.targets[i], &bones[i]]
                    .map(|from| (from.pose_WB.position - to.position).norm());
                self.from_bone[i] = ways[1] < ways[0] - ARRIVING;
                let from = if self.from_bone[i] { &bones[i] } else { &self.targets[i] };
                let from = &from.pose_WB;
                let turn = rotation_vector(&(from.rotation * to.rotation.inverse()));
                *left = [from.position - to.position, turn];
            } else {
                left.iter_mut().for_each(|part| *part *= decay);
            }
            self.targets[i] = shifted(&told.state, left, self.glide);
            oldest = oldest.max(told.age);
        }
        oldest
    }

    /// Where the hand is.
    pub fn tracked(&self) -> &[RigidState] {
        &self.tracked
    }

    /// Where its bones are led.
    pub fn targets(&self) -> &[RigidState] {
        &self.targets
    }

    /// True for a bone that was ever tracked.
    pub fn is_known(&self, bone: usize) -> bool {
        self.known[bone]
    }

    /// True for a bone that jumped in the last tick.
    pub fn jumped(&self, bone: usize) -> bool {
        self.jumped[bone]
    }

    /// True for a bone that was led from its simulated bone in the last tick, and not from where it was.
    pub fn set_out_from_bone(&self, bone: usize) -> bool {
        self.from_bone[bone]
    }

    /// Part of a bone's force that the wearer feels, 0 to 1: 1 but during a glide.
    pub fn share(&self, bone: usize) -> f64 {
        let [linear, angular] = &self.left[bone];
        (1.0 - (linear.norm() + LEVER * angular.norm()) / ARRIVING).max(0.0)
    }
}

/// `state` away by a glide that decays with this time constant \[s\].
fn shifted(state: &RigidState, [linear, angular]: &[Vec3; 2], time: f64) -> RigidState {
    let rate = if time > 0.0 { 1.0 / time } else { 0.0 };
    let part = if time > 0.0 { 1.0 } else { 0.0 };
    let turned = Quat::from_scaled_axis(*angular * part) * state.pose_WB.rotation;
    RigidState {
        pose_WB: Pose::new(state.pose_WB.position + linear * part, turned),
        velocity_W: state.velocity_W - linear * rate,
        angular_velocity_W: state.angular_velocity_W - angular * rate,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    const MS: u64 = 1_000_000;

    /// A scene begins anew: the bones are at their start, and so is the hand that is told of. Nothing
    /// is led from where it was.
    #[test]
    fn a_hand_sets_out_from_bones_that_are_nearer() {
        let [here, there] = [0.0, 0.5].map(|x| RigidState::at_rest(Pose::translation(x, 0.0, 0.0)));
        let mut hand = TrackedHand::new(Prediction::TRACKER, 0.15, &[here]);
        let mut tick = |ms: u64, seen: RigidState, bone: RigidState| {
            hand.push(0, ms * MS, seen.pose_WB, None);
            let h = hand.passed(ms * MS, 0.02);
            hand.place(ms * MS, h, &[bone]);
            (hand.targets()[0].pose_WB.position.x, hand.set_out_from_bone(0))
        };
        for ms in 1..3000 {
            assert!(!tick(ms, there, there).1 || ms == 1);
        }
        let (x, from_bone) = tick(3000, here, here);
        assert!(from_bone && x.abs() < 1e-6, "{x} m");
        // Pressing: the bone is behind, the hand is told of where it was.
        let deep = RigidState::at_rest(Pose::translation(0.02, 0.0, 0.0));
        for ms in 3001..5000 {
            tick(ms, deep, here);
        }
        let (x, from_bone) = tick(5500, deep, here);
        assert!(!from_bone && (x - 0.02).abs() < 1e-4, "{x} m");
    }

    /// Found somewhere, thrown about and turned over at random: targets never move faster than a
    /// glide may, they arrive, and no force is felt on the way.
    #[test]
    fn targets_never_leap_and_arrive() {
        let glide = 0.15;
        for seed in 1..=20 {
            let mut random = Random::new(seed);
            let start = [RigidState::at_rest(Pose::identity())];
            let mut hand = TrackedHand::new(Prediction::TRACKER, glide, &start);
            let mut seen = Pose::new(random.vec3(0.5), random.rotation(3.0));
            let mut before = start[0].pose_WB;
            let mut jumps = 0;
            for ms in 1..=6000u64 {
                if ms % 2000 == 0 {
                    seen = Pose::new(random.vec3(0.5), random.rotation(3.1));
                }
                if ms % 10 == 0 {
                    hand.push(0, ms * MS, seen, None);
                }
                let h = hand.passed(ms * MS, 0.02);
                // A simulation that follows at once.
                let bones = [hand.targets()[0]];
                hand.place(ms * MS, h, &bones);
                jumps += u32::from(hand.jumped(0));
                let now = hand.targets()[0].pose_WB;
                // At most a metre and a turn of π, each within a time constant.
                let moved = (now.position - before.position).norm();
                let turned = now.rotation.angle_to(&before.rotation);
                let context = format!("seed {seed}, {ms} ms: {moved} m, {turned} rad");
                assert!(moved <= 3.0_f64.sqrt() * 1e-3 / glide, "{context}");
                assert!(turned <= std::f64::consts::PI * 1e-3 / glide + 1e-6, "{context}");
                let away = (now.position - seen.position).norm()
                    + LEVER * now.rotation.angle_to(&seen.rotation);
                let share = hand.share(0);
                // Between two samples the tracked pose is the one before.
                if hand.is_known(0) && hand.tracked()[0].pose_WB == seen {
                    assert!((share - (1.0 - away / ARRIVING).max(0.0)).abs() < 1e-6, "{context}");
                }
                if ms % 2000 == 1999 {
                    assert!(share > 0.99 && away < 1e-4, "{context}: {away} m, {share}");
                }
                before = now;
            }
            assert_eq!(jumps, 3, "seed {seed}");
        }
    }
}
