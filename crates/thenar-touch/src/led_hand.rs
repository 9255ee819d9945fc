//! The wearer's hand in one tick, as it was observed upstream: one state per bone, taken as it is.
//!
//! Nothing here estimates a velocity, predicts, smooths or doubts: that was done once, before
//! (`thenar_track::live`), and whoever leads a hand says when it is somewhere else.

use crate::{RigidState, seconds_between};

/// All bones of a hand that is led.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct LedHand {
    states: Vec<RigidState>,
    /// Led since the last tick.
    fresh: Vec<bool>,
    /// The hand is somewhere else: since the last tick, and in the last tick.
    sets_out: Vec<bool>,
    set_out: Vec<bool>,
    /// Led before.
    known: Vec<bool>,
    last_ns: Option<u64>,
}

impl LedHand {
    /// A hand that nobody has led yet, with its bones here.
    pub(crate) fn new(bones: &[RigidState]) -> Self {
        let n = bones.len();
        Self {
            states: bones.to_vec(),
            fresh: vec![false; n],
            sets_out: vec![false; n],
            set_out: vec![false; n],
            known: vec![false; n],
            last_ns: None,
        }
    }

    /// Leads a bone; what is not finite leads nowhere.
    pub fn lead(&mut self, bone: usize, state: RigidState) {
        if state.is_finite() {
            (self.states[bone], self.fresh[bone]) = (state, true);
        }
    }

    /// A bone is somewhere else from the next tick on.
    pub fn set_out(&mut self, bone: usize) {
        self.sets_out[bone] = true;
    }

    /// Begins a tick: time since the one before \[s\], not negative and at most `most`.
    pub(crate) fn passed(&mut self, now_ns: u64, most: f64) -> f64 {
        let passed = seconds_between(self.last_ns.unwrap_or(now_ns), now_ns);
        self.last_ns = Some(now_ns);
        passed.clamp(0.0, most)
    }

    /// Places the hand in this tick. A bone that was never led is where its simulated one is; one
    /// that is led no more stands still.
    pub(crate) fn place(&mut self, bones: &[RigidState]) {
        for (i, state) in self.states.iter_mut().enumerate() {
            self.set_out[i] = std::mem::take(&mut self.sets_out[i]);
            if std::mem::take(&mut self.fresh[i]) {
                self.known[i] = true;
            } else if self.known[i] {
                *state = RigidState::at_rest(state.pose_WB);
            } else {
                *state = bones[i];
            }
        }
    }

    /// Returns the states of the hand's bones.
    pub fn states(&self) -> &[RigidState] {
        &self.states
    }

    /// True for a bone that was ever led.
    pub fn is_known(&self, bone: usize) -> bool {
        self.fresh[bone] || self.known[bone]
    }

    /// True for a bone that was somewhere else in the last tick.
    pub fn has_set_out(&self, bone: usize) -> bool {
        self.set_out[bone]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_core::{Pose, Vec3};

    /// A bone that is led is taken to the bit, in the very tick; one led no more stands still
    /// there.
    #[test]
    fn a_led_hand_is_where_it_is_led() {
        let at = |x: f64| RigidState::at_rest(Pose::translation(x, 0.0, 0.0));
        let bones = [at(0.0), at(0.1)];
        let mut hand = LedHand::new(&bones);
        hand.place(&bones);
        assert_eq!(hand.states(), bones);
        let moves = RigidState { velocity_W: Vec3::y(), ..at(0.3) };
        hand.lead(0, moves);
        hand.lead(1, RigidState { velocity_W: Vec3::x() * f64::NAN, ..at(0.5) });
        hand.place(&bones);
        assert_eq!(hand.states(), [moves, at(0.1)]);
        assert!(hand.is_known(0) && !hand.is_known(1));
        hand.lead(1, at(0.2));
        hand.place(&bones);
        assert_eq!(hand.states(), [at(0.3), at(0.2)]);
    }

    /// Somewhere else for one tick.
    #[test]
    fn setting_out_is_told_once() {
        let bones = [RigidState::at_rest(Pose::identity())];
        let mut hand = LedHand::new(&bones);
        hand.set_out(0);
        assert!(!hand.has_set_out(0));
        for told in [true, false] {
            hand.lead(0, bones[0]);
            hand.place(&bones);
            assert_eq!(hand.has_set_out(0), told);
        }
    }
}
