//! Hand Tracking Streamer, an app for Quest headsets: 21 points per hand as text, over UDP
//! (port 9000) or TCP (port 8000).
//!
//! A hand is a wrist line and a landmark line of one frame. Landmarks are given in the wrist's
//! frame, or in the world: that is seen from whether the first of them, the wrist, is at the
//! origin. The headset says nothing while it does not see a hand.

mod driver;
mod line;
pub mod twin;

pub use driver::HandTrackingStreamerDriver;
pub use line::{Body, Line};

use crate::joints::{POINTS, rebuild};
use crate::lines::{LineResult, Lines};
use crate::{Event, HandSample, Protocol};
use thenar_core::{Pose, Vec3};
use thenar_track::source_clock::SourceClock;

/// UDP port that the app sends to.
pub const UDP_PORT: u16 = 9000;
/// TCP port, whoever listens.
pub const TCP_PORT: u16 = 8000;

/// Longest line: 63 numbers of any precision fit many times \[bytes\].
const LINE_BYTES_MAX: usize = 8 << 10;
/// Lines without frame numbers belong together if they came within this \[ns\].
const TOGETHER_NS: u64 = 5_000_000;
/// Landmarks whose first is nearer to the origin are in the wrist's frame \[m\].
const LOCAL: f64 = 1e-3;

/// The frame that landmarks are in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Points {
    /// Seen from the first landmark.
    #[default]
    Auto,
    /// In the wrist's.
    Local,
    /// In the world.
    World,
}

/// A part of a hand, waiting for the other.
#[derive(Clone, Debug)]
struct PendingPart<T> {
    value: T,
    frame: Option<i64>,
    time: Option<i64>,
    heard_ns: u64,
}

/// Lines of one hand that have come.
#[derive(Clone, Debug, Default)]
struct StreamedHand {
    wrist: Option<PendingPart<Pose>>,
    points: Option<PendingPart<[Vec3; POINTS]>>,
}

/// The protocol.
#[derive(Debug)]
pub struct HandTrackingStreamer {
    /// Each receive is one datagram.
    datagrams: bool,
    points: Points,
    lines: Lines,
    clock: SourceClock,
    /// Left, right.
    hands: [StreamedHand; 2],
}

impl HandTrackingStreamer {
    /// Over datagrams or a stream.
    pub fn new(datagrams: bool, points: Points) -> Self {
        Self {
            datagrams,
            points,
            lines: Lines::new(LINE_BYTES_MAX),
            clock: SourceClock::default(),
            hands: Default::default(),
        }
    }
}

impl Protocol for HandTrackingStreamer {
    fn start(&mut self, _: u64, _: &mut dyn FnMut(&[u8])) {
        self.lines.clear();
        self.clock.clear();
        self.hands = Default::default();
    }

    fn receive(
        &mut self,
        now_ns: u64,
        bytes: &[u8],
        event: &mut dyn FnMut(Event),
        _: &mut dyn FnMut(&[u8]),
    ) {
        let Self { datagrams, points, lines, clock, hands } = self;
        let mut show = |line: LineResult| {
            let read = line.map_err(|e| e.to_string()).and_then(Line::read);
            match read {
                Ok(line) => hear(*points, clock, hands, now_ns, line, event),
                Err(cause) => event(Event::Refused(cause)),
            }
        };
        lines.take(*datagrams, bytes, &mut show);
    }
}

/// Takes a line; with it, a hand may be whole.
fn hear(
    points: Points,
    clock: &mut SourceClock,
    hands: &mut [StreamedHand; 2],
    now_ns: u64,
    line: Line,
    event: &mut dyn FnMut(Event),
) {
    let Line { frame, time, body } = line;
    let (side, of_points) = match body {
        // It lives, though it may not see a hand.
        Body::Head => return event(Event::Alive),
        Body::Wrist(side, value) => {
            let part = PendingPart { value, frame, time, heard_ns: now_ns };
            hands[side as usize].wrist = Some(part);
            (side, false)
        }
        Body::Points(side, value) => {
            let part = PendingPart { value, frame, time, heard_ns: now_ns };
            hands[side as usize].points = Some(part);
            (side, true)
        }
    };
    let hand = &mut hands[side as usize];
    let Some(landmarks) = &hand.points else { return };
    let local = match points {
        Points::Auto => landmarks.value[0].norm() < LOCAL,
        Points::Local => true,
        Points::World => false,
    };
    let pose_WH = match &hand.wrist {
        _ if !local && of_points => Pose::identity(),
        Some(wrist) if local && together(wrist, landmarks) => wrist.value,
        _ => return,
    };
    let time = landmarks.time;
    let placed = landmarks.value.map(|point| pose_WH.point(&point));
    // Each part serves once.
    *hand = StreamedHand::default();
    let mut time_ns = now_ns;
    if let Some(time) = time {
        let carried = clock.carry(now_ns, time);
        if carried.jumped {
            event(Event::Note("the headset's clock has jumped".into()));
        }
        if carried.stands_still {
            let cause = "the headset's clock stands still, so nothing is new";
            return event(Event::Refused(cause.into()));
        }
        time_ns = carried.time_ns;
    }
    match rebuild(side, &placed) {
        Ok(pose) => event(Event::Sample(HandSample { side, time_ns, pose: Some(pose) })),
        Err(error) => event(Event::Refused(format!("landmarks of no hand: {error}"))),
    }
}

/// True if two lines are of one frame.
fn together<A, B>(a: &PendingPart<A>, b: &PendingPart<B>) -> bool {
    match (a.frame, b.frame) {
        (Some(a), Some(b)) => a == b,
        _ => a.heard_ns.abs_diff(b.heard_ns) <= TOGETHER_NS,
    }
}

#[cfg(test)]
mod tests;
