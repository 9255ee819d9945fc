//! A tracker that is late and a glove that pulls at once, in memory.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use thenar_core::model::Side;
use thenar_link::worker::Door;
use thenar_link::{ForceDisplay, HandOutput, HandSample, Rendering, Tracker};
use thenar_touch::safety::Limits;
use thenar_touch::{LoopProfile, TrackerTiming};

/// State that both ends share.
struct SharedLine {
    next: Option<HandSample>,
    seen_ns: Option<u64>,
    shown: HandOutput,
    heard_ns: Option<u64>,
}

/// The wearer's ends.
pub struct WearerEndpoint(Arc<Mutex<SharedLine>>);

/// The loop's ends.
struct LoopEndpoint {
    line: Arc<Mutex<SharedLine>>,
    timing: TrackerTiming,
    sample: Option<HandSample>,
}

struct Glove {
    line: Arc<Mutex<SharedLine>>,
    limits: Limits,
    door: Door,
}

/// A tracker and a glove, and the wearer's ends of both.
pub fn pair(
    timing: TrackerTiming,
    limits: Limits,
) -> (WearerEndpoint, Box<dyn Tracker>, Box<dyn ForceDisplay>) {
    let shown = HandOutput::released(Side::Right, 0);
    let line =
        Arc::new(Mutex::new(SharedLine { next: None, seen_ns: None, shown, heard_ns: None }));
    let tracker = LoopEndpoint { line: line.clone(), timing, sample: None };
    (
        WearerEndpoint(line.clone()),
        Box::new(tracker),
        Box::new(Glove { line, limits, door: Door::new(limits, None, true) }),
    )
}

fn open(line: &Mutex<SharedLine>) -> MutexGuard<'_, SharedLine> {
    line.lock().unwrap_or_else(PoisonError::into_inner)
}

impl WearerEndpoint {
    /// Returns the glove's present pull.
    pub fn shown(&self) -> HandOutput {
        open(&self.0).shown
    }

    /// A sample arrives.
    pub fn tell(&self, sample: HandSample, now_ns: u64) {
        let mut line = open(&self.0);
        (line.next, line.seen_ns) = (Some(sample), Some(now_ns));
    }

    /// The glove answers.
    pub fn hear(&self, now_ns: u64) {
        open(&self.0).heard_ns = Some(now_ns);
    }
}

impl Tracker for LoopEndpoint {
    fn latest(&mut self, side: Side) -> Option<&HandSample> {
        let mut line = open(&self.line);
        let next = line.next.take_if(|sample| sample.side == side)?;
        self.sample = Some(next);
        self.sample.as_ref()
    }

    fn timing(&self) -> Option<TrackerTiming> {
        Some(self.timing)
    }

    fn heard_ns(&mut self) -> Option<u64> {
        open(&self.line).seen_ns
    }

    fn messages(&mut self) -> Vec<String> {
        Vec::new()
    }
}

impl ForceDisplay for Glove {
    fn rendering(&self) -> Rendering {
        Rendering::Tendons
    }

    fn limits(&self) -> Limits {
        self.limits
    }

    fn loop_profile(&self) -> LoopProfile {
        let [delay, damping, friction, resolution] = [0.0; 4];
        let rated_stiffness = f64::INFINITY;
        LoopProfile { period: 1e-3, delay, damping, friction, resolution, rated_stiffness }
    }

    fn show(&mut self, output: &HandOutput) {
        // As before a device: what is refused, or is nothing new, leaves it as it is.
        if !self.door.bind(output, output.time_ns)
            && let Some(sent) = self.door.pass(output.side, Some(output), output.time_ns)
        {
            open(&self.line).shown = sent;
        }
    }

    fn heard_ns(&mut self) -> Option<u64> {
        open(&self.line).heard_ns
    }

    fn messages(&mut self) -> Vec<String> {
        Vec::new()
    }
}

/// Sees the hand at its rate, and tells of it later.
pub struct LateTracker {
    timing: TrackerTiming,
    seen: u64,
    way: VecDeque<(u64, HandSample)>,
}

impl LateTracker {
    pub fn new(timing: TrackerTiming) -> Self {
        Self { timing, seen: 0, way: VecDeque::new() }
    }

    /// True if it looks in this millisecond.
    pub fn is_due(&self, ms: u64) -> bool {
        1e-3 * ms as f64 * self.timing.rate >= self.seen as f64
    }

    /// Takes in what it sees.
    pub fn see(&mut self, sample: HandSample) {
        let late = (1e9 * self.timing.latency) as u64;
        self.seen += 1;
        self.way.push_back((sample.time_ns + late, sample));
    }

    /// The newest of what has arrived by now.
    pub fn arrived(&mut self, now_ns: u64) -> Option<HandSample> {
        let mut newest = None;
        while self.way.front().is_some_and(|(due, _)| *due <= now_ns) {
            newest = self.way.pop_front().map(|(_, sample)| sample);
        }
        newest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever the loop shows, the glove pulls what a device would: finite, within its rating and
    /// its slew.
    #[test]
    fn the_glove_stands_behind_a_door() {
        let (ends, _, mut display) = pair(TrackerTiming::GLOVE, Limits::cybergrasp());
        let mut before = 0.0;
        for ms in 1..200u64 {
            let mut output = HandOutput::released(Side::Right, ms * 1_000_000);
            output.digits[1].pad_force = [5.0, f64::NAN, 1e9, -3.0][ms as usize / 8 % 4];
            display.show(&output);
            let force = ends.shown().digits[1].pad_force;
            assert!((0.0..=12.0).contains(&force), "{ms} ms: {force} N");
            assert!(force == 0.0 || force - before <= 0.6 + 1e-9, "{ms} ms: {force} N");
            before = force;
        }
    }
}
