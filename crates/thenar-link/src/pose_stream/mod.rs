//! The project's own pose stream: one JSON object per line, over UDP, WebSocket or a file.
//!
//! ```text
//! {"t":0.0112,"hand":"left","pos":[[x,y,z], ...],"quat":[[x,y,z,w], ...],"radius":[ ... ]}
//! {"t":0.0112,"hand":"right","tracked":false}
//! ```
//!
//! The format of recordings, so that a recording can be sent as it is. Besides: `t` (the sender's
//! clock \[s\]) and `radius` \[m\] may be missing, a header is not needed, and how many joints
//! there are tells whose they are: 25 (ours), 26 (OpenXR), 27 (Apple), or 21 points without `quat`
//! (MediaPipe's order), whose frames are rebuilt. Positions are metres in the world, +y up.

mod driver;
mod line;

pub use driver::PoseStreamDriver;
pub use line::{Line, Order, natural_order, write};

use crate::lines::{LineResult, Lines};
use crate::rate::Rate;
use crate::{Event, HandSample, Protocol};
use thenar_track::source_clock::SourceClock;

/// UDP port unless another is chosen.
pub const UDP_PORT: u16 = 9010;
/// Longest line, as of recordings, which have the same lines \[bytes\].
pub const LINE_BYTES_MAX: usize = thenar_track::LINE_BYTES_MAX as usize;
/// Lines per second that are read; two hands at 1 kHz are 2000.
pub const LINES_PER_SECOND: f64 = 2500.0;
/// Bytes per second that are read; two hands at 1 kHz are some 5 MB.
pub const BYTES_PER_SECOND: f64 = 16e6;

/// The protocol.
#[derive(Debug)]
pub struct PoseStream {
    /// Each receive is one message.
    messages: bool,
    lines: Lines,
    order: Order,
    clock: SourceClock,
    line_rate: Rate,
    byte_rate: Rate,
}

impl PoseStream {
    /// Over messages (datagrams, WebSocket) or a stream (file).
    pub fn new(messages: bool) -> Self {
        Self {
            messages,
            lines: Lines::new(LINE_BYTES_MAX),
            order: natural_order(),
            clock: SourceClock::default(),
            line_rate: Rate::new(LINES_PER_SECOND, LINES_PER_SECOND / 5.0),
            byte_rate: Rate::new(BYTES_PER_SECOND, BYTES_PER_SECOND / 5.0),
        }
    }
}

impl Protocol for PoseStream {
    fn start(&mut self, _: u64, _: &mut dyn FnMut(&[u8])) {
        self.lines.clear();
        self.clock.clear();
        self.order = natural_order();
    }

    fn receive(
        &mut self,
        now_ns: u64,
        bytes: &[u8],
        event: &mut dyn FnMut(Event),
        _: &mut dyn FnMut(&[u8]),
    ) {
        let Self { messages, lines, order, clock, line_rate, byte_rate } = self;
        let mut show = |line: LineResult| {
            let read = line.map_err(|e| e.to_string()).and_then(|bytes| {
                // What is too much is not even looked at.
                let length = bytes.len() as f64;
                let bytes_left = byte_rate.take(now_ns, length);
                if !bytes_left || !line_rate.take(now_ns, 1.0) {
                    return Err("more than 2500 lines or 16 MB per second".into());
                }
                Line::read(bytes, order)
            });
            match read {
                Err(cause) => event(Event::Refused(cause)),
                Ok(Line::Header(new)) => *order = new,
                Ok(Line::Hand { side, time, pose }) => {
                    let mut time_ns = now_ns;
                    if let Some(time) = time {
                        let carried = clock.carry(now_ns, (time * 1e9) as i64);
                        if carried.jumped {
                            event(Event::Note("the sender's clock has jumped".into()));
                        }
                        if carried.stands_still {
                            let cause =
                                "t stands still, so nothing is new: let it run or leave it out";
                            return event(Event::Refused(cause.into()));
                        }
                        time_ns = carried.time_ns;
                    }
                    event(Event::Sample(HandSample { side, time_ns, pose }));
                }
            }
        };
        lines.take(*messages, bytes, &mut show);
    }
}

#[cfg(test)]
mod tests;
