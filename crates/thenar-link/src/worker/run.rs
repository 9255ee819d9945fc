//! Work of the thread.

use super::door::Door;
use super::handles::slot;
use super::kept::KeeperLink;
use super::notice::{LossNotice, OthersNotice, SilenceNotice};
use super::{BACK_OFF, Device, OUTPUT_SILENCE_NS, POLL, Shared};
use crate::realtime::{PriorityClass, raise_priority, touch_stack};
use crate::{Event, HandOutput, HandSample, Rendering, Transport, now_ns};
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use thenar_core::model::Side;
use thenar_touch::safety::Limits;
use thenar_track::live::checked;
use triple_buffer::{Input, Output};

/// The thread's ends of the slots: left, right.
pub struct WorkerEndpoints {
    pub samples: [Input<Option<HandSample>>; 2],
    pub outputs: [Output<HandOutput>; 2],
}

/// Why a session with an open transport ended.
enum SessionEnd {
    /// The worker was asked to end.
    Stopped,
    /// The transport failed.
    Lost(io::Error),
    /// The protocol panicked.
    Panicked,
}

/// The thread.
pub struct Worker {
    device: Device,
    shared: Arc<Shared>,
    ends: WorkerEndpoints,
    /// Time of each side's newest sample \[ns\].
    sample_ns: [u64; 2],
    /// Arrival of the output shown for each side \[ns\]; `None` when released.
    shown_ns: [Option<u64>; 2],
    /// Guard before the wire.
    door: Door,
}

impl Worker {
    pub fn new(device: Device, shared: Arc<Shared>, ends: WorkerEndpoints) -> Self {
        let one_hand = device.protocol.holds_one_hand();
        // What shows no force has nothing to pass.
        let (limits, torque) = device
            .display
            .map_or((Limits::rated(1.0), None), |traits| (traits.limits, traits.torque_limits));
        let rendering = device.display.map_or(Rendering::Tendons, |traits| traits.rendering);
        let door = Door::new(rendering.limits(limits), torque, one_hand);
        Self { device, shared, ends, sample_ns: [0; 2], shown_ns: [None; 2], door }
    }

    /// Until it is asked to stop.
    pub fn run(mut self) {
        // Whoever only tracks need not be above the loop. What the system refuses the loop reports,
        // and `thenar devices check`.
        if self.device.display.is_some() {
            let _ = raise_priority(PriorityClass::Device);
            touch_stack();
        }
        let mut pause = BACK_OFF[0];
        let mut away = LossNotice::default();
        while !self.stopping() {
            match (self.device.connect)() {
                Err(error) => away.failed(&self.shared, &error),
                Ok(mut transport) => {
                    away.reached(&self.shared);
                    self.shared.connected.store(true, Ordering::Relaxed);
                    let heard = self.shared.heard();
                    let mut kept = KeeperLink::default();
                    let end = self.session(&mut *transport, &mut kept, &mut away);
                    self.shared.connected.store(false, Ordering::Relaxed);
                    // Kept until it is free.
                    let free = self.last_words(&mut *transport);
                    kept.end(free);
                    let spoke = self.shared.heard() != heard;
                    if spoke {
                        pause = BACK_OFF[0];
                    }
                    match end {
                        SessionEnd::Stopped => break,
                        SessionEnd::Lost(error) => {
                            away.lost(&self.shared, &error, spoke || !self.device.speaks);
                        }
                        SessionEnd::Panicked => {
                            let text = "closed after an internal error; forces are released";
                            self.shared.messages().tell(text);
                            break;
                        }
                    }
                }
            }
            self.wait(pause);
            pause = (pause * 2).min(BACK_OFF[1]);
        }
        self.shared.ended.store(true, Ordering::Release);
    }

    fn stopping(&self) -> bool {
        self.shared.stop.load(Ordering::Acquire)
    }

    /// Waits, unless asked to stop.
    fn wait(&self, pause: Duration) {
        let start = Instant::now();
        while !self.stopping() && start.elapsed() < pause {
            std::thread::park_timeout(Duration::from_millis(10).min(pause));
        }
    }

    /// Talks with the device until something ends it.
    fn session(
        &mut self,
        transport: &mut dyn Transport,
        kept: &mut KeeperLink,
        away: &mut LossNotice,
    ) -> SessionEnd {
        let talk = AssertUnwindSafe(|| self.talk(transport, kept, away));
        catch_unwind(talk).unwrap_or(SessionEnd::Panicked)
    }

    fn talk(
        &mut self,
        transport: &mut dyn Transport,
        kept: &mut KeeperLink,
        away: &mut LossNotice,
    ) -> SessionEnd {
        let mut buffer = vec![0; 1 << 16];
        let opened_ns = now_ns();
        let mut silence = SilenceNotice::new(opened_ns);
        let mut others = OthersNotice::default();
        self.shown_ns = [None; 2];
        self.door.open(opened_ns);
        // What waited for a device that was away is not shown late.
        self.ends.outputs.iter_mut().for_each(|output| _ = output.update());
        let mut link = FailFastSender { transport, lost: None };
        self.device.protocol.start(opened_ns, &mut |bytes| link.send(bytes));
        while link.lost.is_none() {
            if self.stopping() {
                return SessionEnd::Stopped;
            }
            let received = match link.transport.receive(&mut buffer, POLL) {
                Ok(received) => received,
                Err(error) => return SessionEnd::Lost(error),
            };
            let now = now_ns();
            if kept.beat(now, &*self.device.protocol, &mut *link.transport, &self.shared) {
                // As at the start: it holds nothing, whatever it was told before.
                self.shown_ns = [None; 2];
                self.door.open(now);
                self.device.protocol.start(now, &mut |bytes| link.send(bytes));
            }
            let wanted = newest(&self.shared, &mut self.ends.outputs, &mut self.shown_ns, now);
            let outputs = through(&mut self.door, &wanted, &self.shown_ns, &self.shared, now);
            let samples = &mut self.ends.samples;
            let mut take = |event| take(event, now, &self.shared, samples, &mut self.sample_ns);
            let protocol = &mut *self.device.protocol;
            if received > 0 {
                protocol.receive(now, &buffer[..received], &mut take, &mut |b| link.send(b));
            }
            let [left, right] = outputs.each_ref().map(Option::as_ref);
            protocol.tick(now, left.or(right), &mut take, &mut |b| link.send(b));
            if let (Some(_), Some(_)) = (left, right) {
                protocol.tick(now, right, &mut take, &mut |b| link.send(b));
            }
            others.look(now, link.transport.refused(), &self.shared);
            if self.device.speaks {
                silence.look(now, received > 0, &self.shared, away);
            }
        }
        link.lost.map_or(SessionEnd::Stopped, SessionEnd::Lost)
    }

    /// Sets the device free, as far as it still can be reached; true if it took that.
    fn last_words(&mut self, transport: &mut dyn Transport) -> bool {
        let protocol = &mut self.device.protocol;
        let said = catch_unwind(AssertUnwindSafe(|| {
            let mut link = FailFastSender { transport, lost: None };
            protocol.stop(&mut |bytes| link.send(bytes));
            link.lost.is_none()
        }));
        said.unwrap_or(false)
    }
}

/// Sends until the first failure, and keeps that.
struct FailFastSender<'a> {
    transport: &'a mut dyn Transport,
    lost: Option<io::Error>,
}

impl FailFastSender<'_> {
    fn send(&mut self, bytes: &[u8]) {
        if self.lost.is_none() {
            self.lost = self.transport.send(bytes).err();
        }
    }
}

/// Handles an event.
fn take(
    event: Event,
    now: u64,
    shared: &Shared,
    samples: &mut [Input<Option<HandSample>>; 2],
    newest: &mut [u64; 2],
) {
    match event {
        Event::Sample(mut sample) => {
            let k = slot(sample.side);
            sample.time_ns = sample.time_ns.min(now);
            // Older than what is known, or the same again: datagrams overtake each other.
            if sample.time_ns <= newest[k] {
                return;
            }
            match sample.pose.as_ref().map(|pose| checked(0.0, pose)).transpose() {
                Ok(pose) => sample.pose = pose,
                Err(error) => {
                    shared.messages().refuse(now, &format!("a pose is refused: {error}"));
                    return;
                }
            }
            newest[k] = sample.time_ns;
            samples[k].write(Some(sample));
        }
        Event::Alive => {}
        Event::Note(text) => shared.messages().note(now, &text),
        Event::Refused(why) => return shared.messages().refuse(now, &why),
    }
    shared.heard_ns.store(now, Ordering::Relaxed);
}

/// Per side, what leaves for the device of what shall be shown.
fn through(
    door: &mut Door,
    wanted: &[Option<HandOutput>; 2],
    shown_ns: &[Option<u64>; 2],
    shared: &Shared,
    now: u64,
) -> [Option<HandOutput>; 2] {
    for output in wanted.iter().flatten() {
        if door.bind(output, now) {
            let text = "it holds one hand, and shows the one that pressed first; \
                        `?side=left` or `?side=right` in its address says which it holds";
            shared.messages().note(now, text);
        }
    }
    let sides = [Side::Left, Side::Right];
    let passed = sides.map(|side| door.pass(side, wanted[slot(side)].as_ref(), now));
    for side in sides.into_iter().filter(|side| shown_ns[slot(*side)].is_none()) {
        door.leave(side);
    }
    passed
}

/// Per side, what shall be shown from now on if that changed: a new output, or none because none
/// came for too long or nobody holds the display any more.
fn newest(
    shared: &Shared,
    outputs: &mut [Output<HandOutput>; 2],
    shown_ns: &mut [Option<u64>; 2],
    now: u64,
) -> [Option<HandOutput>; 2] {
    let closed = shared.display_closed.load(Ordering::Acquire);
    [Side::Left, Side::Right].map(|side| {
        let (output, shown) = (&mut outputs[slot(side)], &mut shown_ns[slot(side)]);
        if !closed && output.update() {
            *shown = Some(now);
            return Some(*output.output_buffer());
        }
        let since = (*shown)?;
        if !closed && now.saturating_sub(since) <= OUTPUT_SILENCE_NS {
            return None;
        }
        *shown = None;
        Some(HandOutput::released(side, now))
    })
}
