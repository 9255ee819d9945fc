//! Records a session.

use super::content::{KeyframeRef, StepMark, append};
use super::{entry, scene};
use crate::session::{Entry, Session, Witness};
use thenar_record::{Clock, FrameKind, FrameWriter, Weight};

/// The clock whose time frames carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeOf {
    /// The recording's clock: for sessions that run in real time.
    Clock,
    /// The simulation, going on through restarts: for runs as fast as they can be.
    Simulation,
}

/// Writes all that enters a session, a mark after each step, and keyframes. Per step it costs a
/// hash of the state and a copy of 50 bytes; nothing waits and, keyframes' first aside, nothing is
/// allocated.
#[derive(Debug)]
pub struct SessionWriter {
    frames: FrameWriter,
    clock: Clock,
    time_of: TimeOf,
    /// Simulated time between keyframes \[s\].
    keyframe_every: f64,
    /// Simulated time since the last.
    since_keyframe: f64,
    /// Simulated time of all steps so far \[s\].
    simulated: f64,
    /// Steps since the scene frame.
    number: u64,
    /// Hash of the state at that frame.
    start: u64,
    step_began: u64,
}

impl SessionWriter {
    /// Nothing yet. `keyframe_every` is simulated time \[s\]; infinite for none.
    pub fn new(frames: FrameWriter, clock: Clock, time_of: TimeOf, keyframe_every: f64) -> Self {
        Self {
            frames,
            clock,
            time_of,
            keyframe_every,
            since_keyframe: 0.0,
            simulated: 0.0,
            number: 0,
            start: 0,
            step_began: 0,
        }
    }

    fn now(&self) -> u64 {
        match self.time_of {
            TimeOf::Clock => self.clock.now_ns(),
            TimeOf::Simulation => (self.simulated * 1e9).round() as u64,
        }
    }
}

impl Witness for SessionWriter {
    fn begins(&mut self, session: &Session) {
        (self.number, self.since_keyframe) = (0, 0.0);
        // A scene that a program has changed leaves no frame: replay says that there is none.
        if let Some(start) = scene::start(session) {
            self.start = start.hash;
            let now = self.now();
            self.frames.big_frame(FrameKind::Scene, now, |body| start.write(body));
        }
    }

    fn entered(&mut self, entry: Entry<'_>) {
        let (now, number) = (self.now(), self.number);
        self.frames.frame(FrameKind::Input, now, Weight::Heavy, |body| {
            entry::with_ref(number, entry, |input| append(body, input));
        });
    }

    fn stepping(&mut self) {
        self.step_began = self.clock.now_ns();
    }

    fn stepped(&mut self, session: &Session) {
        let cost = self.clock.now_ns() - self.step_began;
        let world = session.world();
        self.number += 1;
        self.simulated += world.time_step();
        self.since_keyframe += world.time_step();
        let now = self.now();
        let mark = StepMark {
            number: self.number,
            hash: world.state_hash(),
            cost_ns: u32::try_from(cost).unwrap_or(u32::MAX),
            taken_back: session.report().taken_back,
        };
        self.frames.frame(FrameKind::Step, now, Weight::Usual, |body| mark.write(body));
        // Half a step early is not late.
        if self.since_keyframe >= self.keyframe_every - 0.5 * world.time_step() {
            self.since_keyframe = 0.0;
            let keyframe = KeyframeRef::of(session, self.number, self.start);
            self.frames
                .frame(FrameKind::Keyframe, now, Weight::Light, |body| append(body, &keyframe));
        }
    }
}
