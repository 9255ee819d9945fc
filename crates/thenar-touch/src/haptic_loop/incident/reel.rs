//! The monitor's part: the last seconds of what entered.

use super::tape::{Input, SampleIn};
use super::{Frames, Incident, KEPT_NS};
use crate::haptic_loop::{Ability, TickRecord};
use rtrb::{Consumer, Producer};
use std::collections::{HashSet, VecDeque};

/// Inputs and states of the last seconds, oldest first. Begins with a state, or is empty.
pub struct Reel {
    inputs: Consumer<Input>,
    samples: Consumer<SampleIn>,
    filled: Consumer<Vec<u8>>,
    empty: Producer<Vec<u8>>,
    kept: VecDeque<Input>,
    kept_samples: VecDeque<SampleIn>,
    states: VecDeque<Vec<u8>>,
}

impl Reel {
    pub(super) fn new(
        inputs: Consumer<Input>,
        samples: Consumer<SampleIn>,
        filled: Consumer<Vec<u8>>,
        empty: Producer<Vec<u8>>,
    ) -> Self {
        let (kept, kept_samples, states) = Default::default();
        Self { inputs, samples, filled, empty, kept, kept_samples, states }
    }

    /// Takes in what has come.
    pub fn wind(&mut self) {
        while let Ok(input) = self.inputs.pop() {
            match input {
                Input::Begin => self.clear(),
                Input::State(time_ns) => {
                    let Ok(state) = self.filled.pop() else { continue };
                    if state.is_empty() {
                        // None could be taken, and nothing is kept.
                        let _ = self.empty.push(state);
                        self.clear();
                        continue;
                    }
                    self.states.push_back(state);
                    self.kept.push_back(input);
                    self.forget(time_ns);
                    continue;
                }
                Input::Sample(..) => match self.samples.pop() {
                    Ok(sample) if !self.states.is_empty() => self.kept_samples.push_back(sample),
                    _ => {}
                },
                _ => {}
            }
            if !self.states.is_empty() {
                self.kept.push_back(input);
            }
        }
    }

    /// Nothing of before counts.
    fn clear(&mut self) {
        self.kept.clear();
        self.kept_samples.clear();
        for state in self.states.drain(..) {
            // There is room for all that there are.
            let _ = self.empty.push(state);
        }
    }

    /// Drops what is before the newest state that is old enough.
    fn forget(&mut self, now_ns: u64) {
        let old = |input: &Input| match input {
            Input::State(time_ns) => now_ns.saturating_sub(*time_ns) >= KEPT_NS,
            _ => false,
        };
        let Some(from) = self.kept.iter().rposition(old) else { return };
        for input in self.kept.drain(..from) {
            match input {
                Input::State(_) => {
                    let state = self.states.pop_front();
                    state.map(|state| self.empty.push(state));
                }
                Input::Sample(..) => _ = self.kept_samples.pop_front(),
                _ => {}
            }
        }
    }

    /// All that is kept, with these frames and records of the same time, from the oldest state on whose frames are still
    /// there; `None` if there is none.
    pub fn incident(
        &self,
        reason: &str,
        displays: &[Ability],
        frames: &Frames,
        records: &[TickRecord],
    ) -> Option<Incident> {
        let frames = frames.kept();
        let there: HashSet<(u8, u64)> =
            frames.iter().map(|(hand, step, _)| (*hand, *step)).collect();
        // Behind the last input that calls for a frame which is gone.
        let gone = self.kept.iter().rposition(|input| match input {
            Input::Frame(hand, step) => !there.contains(&(*hand, *step)),
            _ => false,
        });
        let from = gone.map_or(0, |gone| gone + 1);
        let of_before = |what: fn(&Input) -> bool| {
            self.kept.iter().take(from).filter(|input| what(input)).count()
        };
        let (states, samples) = (of_before(is_state), of_before(is_sample));
        let began = self.kept.iter().skip(from).position(is_state)? + from;
        let Input::State(began_ns) = self.kept[began] else { return None };
        let inputs: Vec<Input> = self.kept.iter().skip(began + 1).copied().collect();
        let passed = self.kept.range(from..began).filter(|input| is_sample(input)).count();
        // The records of ticks of which all is there that entered.
        let ended_ns = inputs.iter().rev().find_map(|input| match input {
            Input::Tick(time_ns, _) => Some(*time_ns),
            _ => None,
        })?;
        let kept = began_ns + 1..=ended_ns;
        Some(Incident {
            reason: reason.into(),
            program: env!("CARGO_PKG_VERSION").into(),
            instructions: thenar::vector_instructions(),
            displays: displays.to_vec(),
            state: self.states.get(states)?.clone(),
            inputs,
            samples: self.kept_samples.iter().skip(samples + passed).cloned().collect(),
            frames,
            records: records.iter().filter(|r| kept.contains(&r.time_ns)).copied().collect(),
        })
    }
}

fn is_state(input: &Input) -> bool {
    matches!(input, Input::State(_))
}

fn is_sample(input: &Input) -> bool {
    matches!(input, Input::Sample(..))
}
