//! The monitor's part: the last seconds of what entered.

use super::writer::{Input, RecordedSample, STATE_ROOM};
use super::{Frames, Incident, KEPT_NS};
use crate::haptic_loop::{Capability, TickRecord};
use rtrb::{Consumer, Producer};
use std::collections::{HashSet, VecDeque};

/// Inputs and states of the last seconds, oldest first. Begins with a state, or is empty.
pub struct IncidentReader {
    inputs: Consumer<Input>,
    samples: Consumer<RecordedSample>,
    filled: Consumer<Vec<u8>>,
    empty: Producer<Vec<u8>>,
    kept: VecDeque<Input>,
    kept_samples: VecDeque<RecordedSample>,
    states: VecDeque<Vec<u8>>,
}

impl IncidentReader {
    pub(super) fn new(
        inputs: Consumer<Input>,
        samples: Consumer<RecordedSample>,
        filled: Consumer<Vec<u8>>,
        empty: Producer<Vec<u8>>,
    ) -> Self {
        let (kept, kept_samples, states) = Default::default();
        Self { inputs, samples, filled, empty, kept, kept_samples, states }
    }

    /// Takes in what has come.
    pub fn drain(&mut self) {
        while let Ok(input) = self.inputs.pop() {
            match input {
                Input::Begin => self.clear(),
                Input::State(time_ns) => {
                    let Ok(state) = self.filled.pop() else { continue };
                    if state.is_empty() {
                        // None could be taken, and nothing is kept.
                        give_back(&mut self.empty, state);
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
            give_back(&mut self.empty, state);
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
                    let Some(state) = self.states.pop_front() else { continue };
                    give_back(&mut self.empty, state);
                }
                Input::Sample(..) => _ = self.kept_samples.pop_front(),
                _ => {}
            }
        }
    }

    /// All that is kept, with these frames and records of the same time, from the oldest state on
    /// whose frames are still there; `None` if there is none.
    pub fn incident(
        &self,
        reason: &str,
        displays: &[Capability],
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
            instructions: thenar_core::vector_instructions(),
            displays: displays.to_vec(),
            state: self.states.get(states)?.clone(),
            inputs,
            samples: self.kept_samples.iter().skip(samples + passed).cloned().collect(),
            frames,
            records: records.iter().filter(|r| kept.contains(&r.time_ns)).copied().collect(),
        })
    }
}

/// Gives the loop the room of a state at its full length, which it need not write then within a
/// tick.
fn give_back(empty: &mut Producer<Vec<u8>>, mut room: Vec<u8>) {
    room.resize(STATE_ROOM, 0);
    // There is room for all that there are.
    let _ = empty.push(room);
}

fn is_state(input: &Input) -> bool {
    matches!(input, Input::State(_))
}

fn is_sample(input: &Input) -> bool {
    matches!(input, Input::Sample(..))
}

#[cfg(test)]
mod tests {
    use super::super::writer::IncidentWriter;
    use super::*;
    use crate::{HandSample, TrackerTiming};
    use thenar_core::model::Side;
    use thenar_core::random::Random;

    /// Ticks this far apart make a state every few of them \[ns\].
    const TICK_NS: u64 = 130_000_000;

    impl IncidentReader {
        /// Each input that names a state or a sample has the one that it names, and none between
        /// the first and the last sample is missing.
        fn is_in_step(&self) -> bool {
            let (mut states, mut samples) = (self.states.iter(), self.kept_samples.iter());
            let mut before = None;
            let each = self.kept.iter().all(|input| match input {
                Input::State(time_ns) => {
                    states.next().is_some_and(|state| state[..] == time_ns.to_le_bytes())
                }
                Input::Sample(_, Some(stated)) => {
                    let number = stated.latency as u64;
                    let follows = before.replace(number).is_none_or(|before| number == before + 1);
                    follows && samples.next().is_some_and(|sample| sample.time_ns == number)
                }
                _ => true,
            });
            let begins = self.kept.front().is_none_or(is_state);
            each && begins && states.next().is_none() && samples.next().is_none()
        }
    }

    /// One tick of a loop with up to three samples, each with its number for a time and for what
    /// its tracker states.
    fn tick(
        incident_writer: &mut IncidentWriter,
        random: &mut Random,
        now_ns: u64,
        number: &mut u64,
    ) {
        for _ in 0..random.bits() % 4 {
            *number += 1;
            let sample = HandSample { side: Side::Right, time_ns: *number, pose: None };
            let stated = TrackerTiming { rate: 90.0, latency: *number as f64, noise: 0.0 };
            incident_writer.sample(0, &sample, Some(stated));
        }
        incident_writer.input(Input::Tick(now_ns, true));
        incident_writer.state(now_ns, |room| {
            room[..8].copy_from_slice(&now_ns.to_le_bytes());
            Some(8)
        });
    }

    /// Rings of odd sizes, filled beyond their ends by a loop whose monitor looks at random: what
    /// is kept begins with a state and stays in step, through every overflow of inputs, of samples
    /// and of states; and looked at in time it is there again.
    #[test]
    fn rings_that_overflow_stay_in_step() {
        let mut lost = 0;
        for seed in 1..=60 {
            let mut random = Random::new(seed);
            let room = [20, 8].map(|least| least + (random.bits() % 40) as usize);
            let (mut incident_writer, mut incident_reader) =
                IncidentWriter::with_room(room[0], room[1]);
            let (mut now_ns, mut number) = (0, 0);
            for _ in 0..400 {
                now_ns += TICK_NS;
                tick(&mut incident_writer, &mut random, now_ns, &mut number);
                if random.range(0.0, 1.0) < 0.08 {
                    incident_reader.drain();
                    assert!(incident_reader.is_in_step(), "seed {seed}, {now_ns} ns");
                    let newest = incident_reader.kept.iter().rev().find_map(|input| match input {
                        Input::Tick(time_ns, _) => Some(*time_ns),
                        _ => None,
                    });
                    lost += u32::from(newest != Some(now_ns));
                }
            }
            for _ in 0..40 {
                now_ns += TICK_NS;
                tick(&mut incident_writer, &mut random, now_ns, &mut number);
                incident_reader.drain();
                assert!(incident_reader.is_in_step(), "seed {seed}, {now_ns} ns");
            }
            assert!(!incident_reader.states.is_empty(), "seed {seed}: nothing is kept again");
        }
        assert!(lost > 100, "rings overflowed {lost} times");
    }
}
