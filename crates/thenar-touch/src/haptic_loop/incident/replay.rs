//! An incident made again by the chain that felt it.

use super::writer::{Input, RecordedSample};
use super::{Incident, IncidentError, decided};
use crate::haptic_loop::core::CoreState;
use crate::haptic_loop::{Core, Frame, TickRecord, TickTime};
use crate::{HandSample, Tracker, TrackerTiming};
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use thenar_core::model::Side;
use triple_buffer::Input as Slot;

/// Records that a tick may make: hands times displays.
const RECORDS: usize = 4096;
/// Trackers and displays at most.
const DEVICES: usize = 256;

/// Result of a replay.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// Ticks made again.
    pub ticks: u64,
    /// Records of ticks, displays and hands that were compared.
    pub compared: u64,
    /// Records that differ.
    pub different: u64,
    /// The first of those.
    pub first: Option<Difference>,
    /// All that the chain made.
    pub records: Vec<TickRecord>,
}

/// A record that came out otherwise.
#[derive(Clone, Debug)]
pub struct Difference {
    /// Record as it was.
    pub recorded: TickRecord,
    /// Record as it is now, if there is any.
    pub replayed: Option<TickRecord>,
}

/// Runs the chain over an incident, and compares each record bit for bit.
///
/// # Errors
/// What is in it does not fit together.
pub fn replay(incident: &Incident) -> Result<Replayed, IncidentError> {
    // States are taken as they are. One that was made up may be of lists that do not fit each
    // other, and the chain, which relies on them, stops at that.
    let run = AssertUnwindSafe(|| run(incident));
    catch_unwind(run).unwrap_or(Err(IncidentError::Unfit("lists")))
}

fn run(incident: &Incident) -> Result<Replayed, IncidentError> {
    let trackers = incident.inputs.iter().filter_map(|input| match input {
        Input::Sample(tracker, _) => Some(usize::from(*tracker) + 1),
        _ => None,
    });
    let trackers = trackers.max().unwrap_or(0);
    if trackers > DEVICES || incident.displays.len() > DEVICES {
        return Err(IncidentError::Unfit("devices"));
    }
    let recorded: Vec<RecordedTracker> =
        (0..trackers).map(|_| RecordedTracker::default()).collect();
    let replay_tracker =
        |recorded: &RecordedTracker| ReplayTracker { recorded: recorded.clone(), given: None };
    let boxed = recorded
        .iter()
        .map(|recorded| Box::new(replay_tracker(recorded)) as Box<dyn Tracker>)
        .collect();
    let (records, mut made) = rtrb::RingBuffer::new(RECORDS);
    let state: CoreState = postcard::from_bytes(&incident.state)
        .map_err(|_| IncidentError::Damaged("its state cannot be read"))?;
    let frames = frames(incident, &state)?;
    let (mut core, mut slots) = Core::recall(state, frames, boxed, &incident.displays, records)
        .ok_or(IncidentError::Unfit("state and displays"))?;
    let mut samples = incident.samples.iter();
    let mut all = Vec::new();
    let mut ticks = 0;
    for input in &incident.inputs {
        match *input {
            Input::Begin | Input::State(_) => {}
            Input::Arm => core.arm(),
            Input::Stop(reason) => core.trip(reason),
            Input::Fade(reason) => core.fade_out(reason),
            Input::Heard(display, ns) => {
                core.hear_at(usize::from(display), ns).ok_or(IncidentError::Unfit("displays"))?;
            }
            Input::Frame(hand, step) => {
                let slot: &mut Slot<Frame> =
                    slots.get_mut(usize::from(hand)).ok_or(IncidentError::Unfit("hands"))?;
                slot.write(frame(incident, hand, step)?);
            }
            Input::Sample(tracker, stated) => {
                let sample = samples.next().ok_or(IncidentError::Unfit("samples"))?;
                recorded[usize::from(tracker)].push(sample.clone(), stated);
            }
            Input::Tick(now_ns, enabled) => {
                core.tick(&TickTime { now_ns, ..TickTime::default() }, enabled);
                ticks += 1;
                while let Ok(record) = made.pop() {
                    all.push(record);
                }
            }
        }
    }
    Ok(compare(incident, all, ticks))
}

/// The frame on which each hand of the state was.
fn frames(incident: &Incident, state: &CoreState) -> Result<Vec<Frame>, IncidentError> {
    let steps = state.frames();
    steps.enumerate().map(|(hand, step)| frame(incident, hand as u8, step)).collect()
}

fn frame(incident: &Incident, hand: u8, step: u64) -> Result<Frame, IncidentError> {
    let bytes = incident.frame(hand, step).ok_or(IncidentError::Unfit("frames"))?;
    postcard::from_bytes(bytes).map_err(|_| IncidentError::Damaged("a frame cannot be read"))
}

fn compare(incident: &Incident, all: Vec<TickRecord>, ticks: u64) -> Replayed {
    let (mut compared, mut different, mut first) = (0, 0, None);
    // Some may be missing of what was recorded: the ring to the monitor was full.
    let mut next = all.iter().peekable();
    for recorded in &incident.records {
        while next.next_if(|record| record.time_ns < recorded.time_ns).is_some() {}
        let same = |record: &&TickRecord| {
            (record.time_ns, record.side, record.display)
                == (recorded.time_ns, recorded.side, recorded.display)
        };
        let replayed = all_of_tick(next.clone(), recorded.time_ns).find(same).copied();
        compared += 1;
        if replayed.as_ref().map(decided) != Some(decided(recorded)) {
            different += 1;
            first.get_or_insert(Difference { recorded: *recorded, replayed });
        }
    }
    Replayed { ticks, compared, different, first, records: all }
}

/// Records from here on that are of this time.
fn all_of_tick<'a>(
    from: impl Iterator<Item = &'a TickRecord>,
    time_ns: u64,
) -> impl Iterator<Item = &'a TickRecord> {
    from.take_while(move |record| record.time_ns == time_ns)
}

/// A tracker that tells what was recorded of it.
#[derive(Clone, Default)]
struct RecordedTracker(Arc<Mutex<TrackerQueue>>);

#[derive(Default)]
struct TrackerQueue {
    waiting: VecDeque<RecordedSample>,
    timing: Option<TrackerTiming>,
}

impl RecordedTracker {
    fn queue(&self) -> MutexGuard<'_, TrackerQueue> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push(&self, sample: RecordedSample, stated: Option<TrackerTiming>) {
        let mut queue = self.queue();
        queue.waiting.push_back(sample);
        queue.timing = stated;
    }
}

/// A tracker as the chain sees it, with room for the sample that it was given last.
struct ReplayTracker {
    recorded: RecordedTracker,
    given: Option<HandSample>,
}

impl Tracker for ReplayTracker {
    fn latest(&mut self, side: Side) -> Option<&HandSample> {
        let mut queue = self.recorded.queue();
        let at = queue.waiting.iter().position(|sample| sample.side == side)?;
        self.given = queue.waiting.remove(at);
        drop(queue);
        self.given.as_ref()
    }

    fn heard_ns(&mut self) -> Option<u64> {
        None
    }

    fn timing(&self) -> Option<TrackerTiming> {
        self.recorded.queue().timing
    }

    fn messages(&mut self) -> Vec<String> {
        Vec::new()
    }
}
