//! Desktop haptic arms, through a small bridge: one UDP datagram each way, a thousand times per
//! second. The bridge owns the maker's library and has a watchdog of its own: it lets the arm go
//! when no command came for 20 ms. See [`wire`] for the datagrams.
//!
//! As a tracker it is a hand that holds the handle; the first button closes the fingers. As a
//! display it shows the force and torque of the palm's coupling at the handle.

mod driver;
pub mod profile;
pub mod twin;
pub mod wire;

pub use driver::{ForceDeviceDriver, PORT};

use crate::{Event, HandOutput, HandSample, Protocol};
use thenar_core::model::Side;
use thenar_core::{Pose, Vec3};
use thenar_track::ANGLES;
use thenar_track::live::LivePose;
use thenar_track::source_clock::SourceClock;
use wire::{Command, State};

/// Commands follow each other after so long at most \[ns\] ...
const PERIOD_NS: u64 = 1_000_000;
/// ... and at least; a new output goes out at once otherwise \[ns\].
const GAP_NS: u64 = 400_000;
/// Without an output or a state for so long no force is commanded \[ns\].
const SILENCE_NS: u64 = 20_000_000;
/// A device that was silent for so long may number its states anew \[ns\].
const RESTART_NS: u64 = 100_000_000;
/// A release is numbered so far ahead: a keeper has the number of 5 ms ago, and a command goes out
/// every 0.4 ms at most.
const RELEASE_AHEAD: u32 = 64;
/// Time that the fingers take to close when the button is pressed \[s\].
const CLOSING: f64 = 0.15;
/// Time between reports of lost states \[ns\], made if more than one in a hundred was lost.
const REPORT_NS: u64 = 10_000_000_000;

/// Placement of the device and the grip on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// The hand that holds it.
    pub side: Side,
    /// The device's frame in the world.
    pub pose_WD: Pose,
    /// The wrist in the frame of the handle.
    pub pose_TH: Pose,
    /// Joint angles of the hand, button up, and down \[rad\].
    pub grips: [[f64; ANGLES]; 2],
    /// No larger torque is commanded \[N m\]; the guards before it allow part of it.
    pub torque_max: f64,
}

/// The protocol.
#[derive(Clone, Debug)]
pub struct ForceDevice {
    setup: Setup,
    /// Number of the next command.
    seq: u32,
    sent_ns: Option<u64>,
    /// Time and value of the wanted force and torque, device frame.
    wanted: Option<(u64, [Vec3; 2])>,
    /// Newest state: number and arrival.
    state: Option<(u32, u64)>,
    clock: SourceClock,
    /// 0 open to 1 closed.
    grip: f64,
    /// States that came and that did not, since when.
    counted: [u64; 2],
    counted_since_ns: Option<u64>,
}

impl ForceDevice {
    /// A device that stands there.
    pub fn new(setup: Setup) -> Self {
        Self {
            setup,
            seq: 0,
            sent_ns: None,
            wanted: None,
            state: None,
            clock: SourceClock::default(),
            grip: 0.0,
            counted: [0; 2],
            counted_since_ns: None,
        }
    }

    fn command(&mut self, now_ns: u64, [force, torque]: [Vec3; 2], send: &mut dyn FnMut(&[u8])) {
        let command = Command { seq: self.seq, time_ns: now_ns, force, torque };
        self.seq = self.seq.wrapping_add(1);
        self.sent_ns = Some(now_ns);
        send(&command.write());
    }

    /// True for a state that is newer than all before. Numbers wrap; datagrams overtake each other.
    fn is_news(&mut self, now_ns: u64, seq: u32) -> bool {
        let ahead = match self.state {
            Some((last, at)) if now_ns.saturating_sub(at) < RESTART_NS => {
                seq.wrapping_sub(last) as i32
            }
            _ => 1,
        };
        if ahead > 0 {
            self.state = Some((seq, now_ns));
            self.counted[0] += 1;
            self.counted[1] += u64::from(ahead.unsigned_abs() - 1).min(1000);
        }
        ahead > 0
    }

    fn sample(&mut self, now_ns: u64, before_ns: u64, state: &State, event: &mut dyn FnMut(Event)) {
        let dt = now_ns.saturating_sub(before_ns) as f64 * 1e-9;
        let step = (dt / CLOSING).min(1.0);
        let goal = f64::from(state.buttons & 1);
        self.grip += (goal - self.grip).clamp(-step, step);
        let [open, closed] = &self.setup.grips;
        let angles = std::array::from_fn(|k| open[k] + self.grip * (closed[k] - open[k]));
        let wrist = self.setup.pose_WD * state.pose * self.setup.pose_TH;
        // A device's clock counts nanoseconds from anywhere; beyond 292 years it is none.
        let source = i64::try_from(state.time_ns).unwrap_or(i64::MAX);
        let carried = self.clock.carry(now_ns, source);
        if carried.jumped {
            event(Event::Note("the arm's clock has jumped".into()));
        }
        if carried.stands_still {
            let cause = "the arm's clock stands still, so nothing is new";
            return event(Event::Refused(cause.into()));
        }
        let pose = Some(LivePose::Angles { wrist, angles });
        let (side, time_ns) = (self.setup.side, carried.time_ns);
        event(Event::Sample(HandSample { side, time_ns, pose }));
    }

    fn report(&mut self, now_ns: u64, event: &mut dyn FnMut(Event)) {
        let since = *self.counted_since_ns.get_or_insert(now_ns);
        if now_ns.saturating_sub(since) < REPORT_NS {
            return;
        }
        let [came, lost] = std::mem::take(&mut self.counted);
        self.counted_since_ns = Some(now_ns);
        if lost * 100 > came {
            event(Event::Note(format!("{lost} states were lost, {came} came, in the last 10 s")));
        }
    }
}

impl Protocol for ForceDevice {
    fn start(&mut self, now_ns: u64, send: &mut dyn FnMut(&[u8])) {
        // Beyond what a keeper may have sent.
        let seq = self.seq.wrapping_add(2 * RELEASE_AHEAD);
        *self = Self { seq, ..Self::new(self.setup.clone()) };
        // The device learns where its host is, and that nothing shall be felt.
        self.command(now_ns, [Vec3::zeros(); 2], send);
    }

    fn receive(
        &mut self,
        now_ns: u64,
        bytes: &[u8],
        event: &mut dyn FnMut(Event),
        _: &mut dyn FnMut(&[u8]),
    ) {
        match State::read(bytes) {
            Err(error) => event(Event::Refused(error.to_string())),
            Ok(state) => {
                let before = self.state.map_or(now_ns, |(_, at)| at);
                if self.is_news(now_ns, state.seq) {
                    self.sample(now_ns, before, &state, event);
                }
                self.report(now_ns, event);
            }
        }
    }

    fn tick(
        &mut self,
        now_ns: u64,
        output: Option<&HandOutput>,
        _: &mut dyn FnMut(Event),
        send: &mut dyn FnMut(&[u8]),
    ) {
        let passed = |since: u64| now_ns.saturating_sub(since);
        let output = output.filter(|output| output.side == self.setup.side);
        if let Some(output) = output {
            let forces = [output.force_W, output.torque_W];
            let finite = forces.iter().all(|v| v.norm().is_finite());
            let forces = if finite { forces } else { [Vec3::zeros(); 2] };
            let pose_WD = &self.setup.pose_WD;
            let [force, torque] = forces.map(|v_W| pose_WD.inverse_vector(&v_W));
            self.wanted = Some((now_ns, [force, torque.cap_magnitude(self.setup.torque_max)]));
        }
        let due = if output.is_some() { GAP_NS } else { PERIOD_NS };
        if self.sent_ns.is_some_and(|sent| passed(sent) < due) {
            return;
        }
        // A device that says nothing of its handle pushes blindly.
        let seen = self.state.is_some_and(|(_, at)| passed(at) <= SILENCE_NS);
        let forces = match self.wanted {
            Some((since, forces)) if seen && passed(since) <= SILENCE_NS => forces,
            _ => [Vec3::zeros(); 2],
        };
        self.command(now_ns, forces, send);
    }

    /// Ahead of all commands that may have gone out since: bridges leave out older ones.
    fn release(&self, send: &mut dyn FnMut(&[u8])) {
        let seq = self.seq.wrapping_add(RELEASE_AHEAD);
        let time_ns = self.sent_ns.unwrap_or(0);
        send(&Command { seq, time_ns, force: Vec3::zeros(), torque: Vec3::zeros() }.write());
    }

    fn stop(&mut self, send: &mut dyn FnMut(&[u8])) {
        self.wanted = None;
        let time_ns = self.sent_ns.unwrap_or(0);
        // Datagrams get lost.
        (0..3).for_each(|_| self.command(time_ns, [Vec3::zeros(); 2], send));
    }
}

#[cfg(test)]
mod tests;
