//! The chain's state: what an incident begins with.

use super::Core;
use crate::haptic_loop::actuators::{Actuators, Capability};
use crate::haptic_loop::exchange::{Frame, slots};
use crate::haptic_loop::hand::{HandState, LoopHand};
use crate::haptic_loop::record::TickRecord;
use crate::safety::Trip;
use crate::{HandOutput, Tracker};
use rtrb::Producer;
use serde::ser::{Error, SerializeSeq};
use serde::{Deserialize, Serialize, Serializer};
use triple_buffer::Input;

/// The state, borrowed.
#[derive(Serialize)]
struct CoreStateRef<'a> {
    #[serde(serialize_with = "hands")]
    hands: &'a [LoopHand],
    actuators: &'a [Actuators],
    heard: &'a [u64],
    armed: bool,
    stopped: Option<Trip>,
    fading: Option<Trip>,
}

/// One after the other, so that nothing is allocated.
fn hands<S: Serializer>(hands: &[LoopHand], serializer: S) -> Result<S::Ok, S::Error> {
    let mut list = serializer.serialize_seq(Some(hands.len()))?;
    for hand in hands {
        let state = hand.state().ok_or_else(|| S::Error::custom("a simulation is within"))?;
        list.serialize_element(&state)?;
    }
    list.end()
}

/// The state, read.
#[derive(Deserialize)]
pub struct CoreState {
    hands: Vec<HandState>,
    actuators: Vec<Actuators>,
    heard: Vec<u64>,
    armed: bool,
    stopped: Option<Trip>,
    fading: Option<Trip>,
}

impl CoreState {
    /// The step of the frame that each hand was on.
    pub fn frames(&self) -> impl Iterator<Item = u64> + '_ {
        self.hands.iter().map(|hand| hand.frame)
    }
}

impl Core {
    /// Writes the state into `room`; its length, if it fits and there is one. Allocates nothing.
    pub(super) fn write_state(&self, room: &mut [u8]) -> Option<usize> {
        let state = CoreStateRef {
            hands: &self.hands,
            actuators: &self.actuators,
            heard: &self.heard,
            armed: self.armed,
            stopped: self.stopped,
            fading: self.fading,
        };
        postcard::to_slice(&state, room).ok().map(|written| written.len())
    }

    /// Goes on from a state, on these frames; and the slots by which each hand gets further ones.
    /// `None` if hands, frames and displays do not fit.
    pub fn recall(
        state: CoreState,
        frames: Vec<Frame>,
        trackers: Vec<Box<dyn Tracker>>,
        displays: &[Capability],
        records: Producer<TickRecord>,
    ) -> Option<(Self, Vec<Input<Frame>>)> {
        let mut core = Self::new(trackers, displays.to_vec(), records).ok()?;
        let hands = state.hands.len();
        let fits = state.actuators.len() == displays.len() * hands
            && state.heard.len() == displays.len()
            && frames.len() == hands;
        if !fits {
            return None;
        }
        let mut inputs = Vec::with_capacity(hands);
        for (hand, frame) in state.hands.into_iter().zip(&frames) {
            let (slow, fast) = slots(frame, None);
            inputs.push(slow.frame);
            core.hands.push(LoopHand::recall(hand, fast));
        }
        core.outputs = (0..state.actuators.len())
            .map(|i| HandOutput::released(core.hands[i % hands].side(), 0))
            .collect();
        core.actuators = state.actuators;
        core.heard = state.heard;
        (core.armed, core.stopped, core.fading) = (state.armed, state.stopped, state.fading);
        Some((core, inputs))
    }
}
