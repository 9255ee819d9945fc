//! The conversation with a glove.
//!
//! The firmware has five traps. It takes a finger that a line leaves out for released: every line
//! names all five. It ignores lines of less than five characters, and reads at most a hundred: ours
//! have 11 to 26. With force feedback it reads after each line of its own, and waits up to a second
//! for one of ours: each of its lines is answered at once, with a newline when nothing changed, and
//! a glove that fell silent is nudged. It takes one line per line it says: more would pile up in
//! front of it and delay every later one, so at most one is sent ahead, and after a silence, when
//! nobody knows what it has yet to read, answers are held back until it stops speaking without
//! them. It has no watchdog, servos hold what they were told: stops are released at start and at
//! the end.

use super::encoding::{Line, State, parse, stops};
use super::profile::Profile;
use crate::lines::Lines;
use crate::{Event, HandOutput, HandSample, Protocol};
use std::sync::Arc;
use thenar_core::model::Side;
use thenar_track::live::LivePose;

/// Longest line of any firmware seen is 75 bytes; per-joint curls may double that.
const LINE_MAX: usize = 300;
/// A glove that says nothing for so long waits for a line that got lost \[ns\].
const NUDGE_NS: u64 = 50_000_000;
/// A glove that has lines to read speaks again within this time without an answer \[ns\].
const HOLD_NS: u64 = 20_000_000;
/// Most lines that may lie before a glove when it speaks again, besides those that it was nudged
/// with: far more than its port holds.
const UNREAD_MAX: u32 = 64;
/// Number of nudges after which a silent glove is asked to start its stream.
const NUDGES_PER_START: u32 = 20;
/// Most lines sent before the glove asked for them, except to release.
const AHEAD_MAX: u32 = 1;

/// The protocol.
pub struct LucidGloves {
    profile: Arc<Profile>,
    lines: Lines,
    /// Last value that the glove sent of each sensor.
    state: State,
    /// Stops wanted of the fingers, and stops last sent to the glove.
    wanted: [u16; 5],
    told: [u16; 5],
    /// Lines sent that answer none of the glove's.
    ahead: u32,
    /// Lines may lie in front of the glove: answers are held back.
    draining: bool,
    /// Most lines that may lie before the glove. One that has spoken as often waits for no answers:
    /// not every firmware does.
    unread: u32,
    /// Due time of the answer held back \[ns\].
    held_ns: Option<u64>,
    heard_ns: u64,
    nudged_ns: u64,
    nudges: u32,
    /// True once the glove has said which hand it is.
    known: bool,
}

impl LucidGloves {
    /// A conversation that has not begun.
    pub fn new(profile: Arc<Profile>) -> Self {
        Self {
            profile,
            lines: Lines::new(LINE_MAX),
            state: State::default(),
            wanted: [0; 5],
            told: [0; 5],
            ahead: 0,
            draining: true,
            unread: UNREAD_MAX,
            held_ns: None,
            heard_ns: 0,
            nudged_ns: 0,
            nudges: 0,
            known: false,
        }
    }

    fn tell(&mut self, send: &mut dyn FnMut(&[u8])) {
        self.told = self.wanted;
        send(stops(&self.told, self.state.legacy).as_bytes());
    }

    /// A line came: the glove now reads one of ours.
    fn answer(&mut self, now_ns: u64, send: &mut dyn FnMut(&[u8])) {
        self.unread = self.unread.saturating_sub(1);
        if self.draining && self.unread > 0 {
            self.held_ns = Some(now_ns + HOLD_NS);
            return;
        }
        if std::mem::take(&mut self.draining) {
            (self.held_ns, self.ahead) = (None, 0);
        }
        if self.wanted != self.told {
            self.tell(send);
        } else if self.ahead > 0 {
            // It has one to read already.
            self.ahead -= 1;
        } else {
            send(b"\n");
        }
    }

    fn understand(&mut self, line: Line, now_ns: u64, event: &mut dyn FnMut(Event)) {
        match line {
            Line::State(state) => {
                self.state.take(&state);
                let angles = self.profile.angles(&self.state);
                let pose = LivePose::Angles { wrist: self.profile.wrist.pose(), angles };
                let side = self.profile.hand.side;
                event(Event::Sample(HandSample { side, time_ns: now_ns, pose: Some(pose) }));
            }
            Line::Info(info) => {
                let side = match info.hand {
                    Some(0) => Some(Side::Left),
                    Some(1) => Some(Side::Right),
                    _ => None,
                };
                if std::mem::replace(&mut self.known, true) {
                    return event(Event::Alive);
                }
                event(Event::Note(info.to_string()));
                if side.is_some_and(|side| side != self.profile.hand.side) {
                    let text = "the glove is of the other hand than the profile says (hand.side)";
                    event(Event::Note(text.into()));
                }
            }
        }
    }
}

impl Protocol for LucidGloves {
    fn start(&mut self, now_ns: u64, send: &mut dyn FnMut(&[u8])) {
        let fresh = Self::new(self.profile.clone());
        *self = Self { state: State { legacy: self.state.legacy, ..State::default() }, ..fresh };
        (self.heard_ns, self.nudged_ns) = (now_ns, now_ns);
        self.tell(send);
    }

    fn receive(
        &mut self,
        now_ns: u64,
        bytes: &[u8],
        event: &mut dyn FnMut(Event),
        send: &mut dyn FnMut(&[u8]),
    ) {
        let mut lines = std::mem::replace(&mut self.lines, Lines::new(0));
        lines.push(bytes, &mut |line| {
            let understood =
                line.ok().and_then(|line| parse(line, self.profile.sensors.analog_max));
            match understood {
                Some(line) => {
                    (self.heard_ns, self.nudges) = (now_ns, 0);
                    self.understand(line, now_ns, event);
                }
                None => event(Event::Refused(
                    "a line is not from a glove: noise, another speed or another device".into(),
                )),
            }
            // Whatever the line was, the glove now waits.
            self.answer(now_ns, send);
        });
        self.lines = lines;
    }

    fn tick(
        &mut self,
        now_ns: u64,
        output: Option<&HandOutput>,
        _: &mut dyn FnMut(Event),
        send: &mut dyn FnMut(&[u8]),
    ) {
        if let Some(output) = output.filter(|output| output.side == self.profile.hand.side) {
            self.wanted = self.profile.stops(output.digits.map(|digit| digit.curl_at_contact));
        }
        if self.held_ns.is_some_and(|due| now_ns >= due) {
            // It waits: all that was sent is read.
            (self.held_ns, self.draining, self.ahead) = (None, false, 0);
            self.tell(send);
        }
        let release = (0..5).any(|k| self.wanted[k] == 0 && self.told[k] > 0);
        if release || (self.wanted != self.told && self.ahead < AHEAD_MAX && !self.draining) {
            self.ahead += 1;
            self.tell(send);
        }
        let silent = now_ns.saturating_sub(self.heard_ns.max(self.nudged_ns)) > NUDGE_NS;
        if silent {
            if !std::mem::replace(&mut self.draining, true) {
                self.unread = UNREAD_MAX;
            }
            (self.nudged_ns, self.ahead) = (now_ns, 0);
            self.unread = self.unread.saturating_add(1);
            self.nudges += 1;
            // For the firmware seen, this line releases all fingers: not while one is stopped.
            if self.nudges.is_multiple_of(NUDGES_PER_START) && self.wanted == [0; 5] {
                send(b"(ZA)\n");
            } else {
                self.tell(send);
            }
        }
    }

    fn release(&self, send: &mut dyn FnMut(&[u8])) {
        send(stops(&[0; 5], self.state.legacy).as_bytes());
    }

    fn stop(&mut self, send: &mut dyn FnMut(&[u8])) {
        self.wanted = [0; 5];
        self.tell(send);
        send(b"(ZZ)\n");
    }
}
