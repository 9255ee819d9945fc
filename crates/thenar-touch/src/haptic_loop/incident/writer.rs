//! The loop's part: what enters a tick, handed on without waiting.

use super::STATE_EVERY_NS;
use super::reader::IncidentReader;
use crate::safety::Trip;
use crate::{HandSample, TrackerTiming};
use rtrb::{Consumer, Producer, RingBuffer};
use serde::{Deserialize, Serialize};

/// Inputs that may wait for the monitor: some four seconds of one display.
const INPUTS: usize = 16_384;
/// Samples that may wait: seconds of a tracker of 120 Hz that tells of two hands.
const SAMPLES: usize = 512;
/// States in all: those of the time that is kept, one that is filled, one that is on its way.
const STATES: usize = 6;
/// Room for one \[B\]; that of a hand of 16 bones before one display takes some 100 KiB.
pub(super) const STATE_ROOM: usize = 512 * 1024;

/// Inputs of the chain, in the order in which they enter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Input {
    /// The hands were put in place of others: nothing of before counts.
    Begin,
    /// A state was taken here, after the tick of this time \[ns\]; it comes by another way.
    State(u64),
    /// Forces are let through.
    Arm,
    /// Forces are stopped.
    Stop(Trip),
    /// Forces fade, and are stopped then.
    Fade(Trip),
    /// A display was last heard then \[ns\].
    Heard(u8, u64),
    /// A hand takes up the frame of this step.
    Frame(u8, u64),
    /// A tracker, which states this of itself, has a sample; it comes by another way.
    Sample(u8, Option<TrackerTiming>),
    /// A tick at this time \[ns\], with the dead-man switch held or not.
    Tick(u64, bool),
}

/// A sample, by another way than the rest since it is large.
pub type RecordedSample = HandSample;

/// The loop's ends.
pub struct IncidentWriter {
    inputs: Producer<Input>,
    samples: Producer<RecordedSample>,
    filled: Producer<Vec<u8>>,
    empty: Consumer<Vec<u8>>,
    /// Something found no room: nothing is kept until the next state.
    broken: bool,
    /// Time at which the next state is due \[ns\].
    state_ns: u64,
}

impl IncidentWriter {
    /// Both ends. Allocates all that they need.
    pub fn new() -> (Self, IncidentReader) {
        Self::with_room(INPUTS, SAMPLES)
    }

    /// Both ends, with room for this many inputs and samples.
    pub(super) fn with_room(inputs: usize, samples: usize) -> (Self, IncidentReader) {
        let (inputs, inputs_out) = RingBuffer::new(inputs);
        let (samples, samples_out) = RingBuffer::new(samples);
        let (filled, filled_out) = RingBuffer::new(STATES);
        let (mut empty_in, empty) = RingBuffer::new(STATES);
        for _ in 0..STATES {
            // The ring has room for all of them.
            let _ = empty_in.push(vec![0; STATE_ROOM]);
        }
        let incident_writer = Self { inputs, samples, filled, empty, broken: true, state_ns: 0 };
        (incident_writer, IncidentReader::new(inputs_out, samples_out, filled_out, empty_in))
    }

    /// Takes down an input.
    pub fn input(&mut self, input: Input) {
        if !self.broken {
            self.broken = self.inputs.push(input).is_err();
        }
    }

    /// Takes down a sample.
    pub fn sample(&mut self, tracker: usize, sample: &HandSample, stated: Option<TrackerTiming>) {
        // Both or neither: the reader takes the next sample for each input that names one.
        if !self.broken {
            self.broken = self.inputs.slots() == 0 || self.samples.push(sample.clone()).is_err();
        }
        self.input(Input::Sample(tracker as u8, stated));
    }

    /// Other hands are in place: what was kept is of no use.
    pub fn begin(&mut self) {
        (self.broken, self.state_ns) = (true, 0);
    }

    /// After a tick: takes down the state, by `write` into the room that is given, when that is
    /// due. `write` gives the length, or none if there is no such state or too little room.
    pub fn state(&mut self, now_ns: u64, write: impl FnOnce(&mut [u8]) -> Option<usize>) {
        if now_ns < self.state_ns {
            return;
        }
        self.state_ns = now_ns.saturating_add(STATE_EVERY_NS);
        // Room for both inputs below or for none, as the reader takes the next state for each input
        // that names one.
        if self.inputs.slots() < 2 {
            self.broken = true;
            return;
        }
        let Ok(mut room) = self.empty.pop() else {
            self.broken = true;
            return;
        };
        debug_assert_eq!(
            room.len(),
            STATE_ROOM,
            "the reader gives rooms back at their full length"
        );
        let length = write(&mut room);
        room.truncate(length.unwrap_or(0));
        let begins = std::mem::replace(&mut self.broken, length.is_none());
        // An empty one goes back the same way.
        let sent = self.filled.push(room).is_ok();
        if begins && !self.broken {
            self.broken = self.inputs.push(Input::Begin).is_err();
        }
        if sent {
            // Also while nothing is kept: the reader gives the room back.
            self.broken |= self.inputs.push(Input::State(now_ns)).is_err();
        }
    }
}
