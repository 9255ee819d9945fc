//! A LucidGlove as its firmware behaves, traps and all.

use super::encoding::State;
use crate::twin::Twin;

/// Longest that the firmware waits for a line of the host \[ns\].
pub const FORCE_FEEDBACK_WAIT_NS: u64 = 1_000_000_000;
/// Pause of its loop \[ns\].
const LOOP_NS: u64 = 1_000_000;
/// A byte on the wire at 115200 bit/s \[ns\].
const BYTE_NS: u64 = 86_806;
/// The firmware's buffer for a line \[bytes\].
const BUFFER: usize = 100;
/// Capacity of its serial port \[bytes\]; more is lost.
const PORT_BUFFER: usize = 256;

/// The glove.
pub struct LucidGlovesTwin {
    /// Readings of its sensors.
    pub sensors: State,
    /// The servos: 0 free to 1000 blocked open.
    pub servos: [u16; 5],
    /// True if the firmware is compiled to speak the older encoding.
    pub legacy: bool,
    /// Lines that it said.
    pub lines_said: u64,
    /// Lines that reached its serial port, read or not.
    pub lines_heard: u64,
    received: Vec<u8>,
    /// Time of its next line; `None` while it waits for one.
    next_ns: Option<u64>,
    /// Start of its wait for a line, or arrival of the last byte in it.
    waiting_ns: u64,
}

impl LucidGlovesTwin {
    /// A glove with five curl sensors, and splay sensors if wanted; all in the middle.
    pub fn new(legacy: bool, splay: bool) -> Self {
        let sensors = State {
            curl: [Some(0); 5],
            splay: [splay.then_some(2048); 5],
            legacy,
            ..State::default()
        };
        Self {
            sensors,
            servos: [0; 5],
            legacy,
            lines_said: 0,
            lines_heard: 0,
            received: Vec::new(),
            next_ns: None,
            waiting_ns: 0,
        }
    }

    /// The line that its sensors make.
    pub fn line(&self) -> String {
        let curl = self.sensors.curl.map(|curl| curl.unwrap_or(0));
        let [a, b, c, d, e] = curl;
        if self.legacy {
            return format!("{a}&{b}&{c}&{d}&{e}&2047&2047&0&0&0&0&0&0\n");
        }
        let trigger = u32::from(b).saturating_sub(2047) * 2;
        let mut line = format!("A{a}B{b}C{c}D{d}E{e}F2047G2047P{trigger}");
        for (letter, splay) in ('A'..).zip(self.sensors.splay) {
            if let Some(splay) = splay {
                line += &format!("({letter}B){splay}");
            }
        }
        for (letter, joints) in ('A'..).zip(self.sensors.joints) {
            for (joint, value) in ('A'..).zip(joints) {
                if let Some(value) = value {
                    line += &format!("({letter}A{joint}){value}");
                }
            }
        }
        line + "\n"
    }

    /// The firmware's reading of a line from the host: up to its newline, a full buffer, or a
    /// second of silence.
    fn read(&mut self, now_ns: u64) -> Option<Vec<u8>> {
        let end = self.received.iter().take(BUFFER).position(|byte| *byte == b'\n');
        let (taken, kept) = match end {
            Some(end) => (end + 1, end),
            None if self.received.len() >= BUFFER => (BUFFER, BUFFER),
            None if now_ns.saturating_sub(self.waiting_ns) >= FORCE_FEEDBACK_WAIT_NS => {
                (self.received.len(), self.received.len())
            }
            None => return None,
        };
        let line = self.received[..kept].to_vec();
        self.received.drain(..taken);
        Some(line)
    }

    /// Decodes a line as the firmware does: a finger that is not named goes to 0.
    fn obey(&mut self, line: &[u8]) {
        let line = line.split(|byte| *byte == 0).next().unwrap_or_default();
        if line.len() < 5 {
            return;
        }
        let value = |text: &[u8]| {
            let digits = text.iter().take_while(|byte| byte.is_ascii_digit());
            digits.fold(0u32, |n, b| n.saturating_mul(10).saturating_add(u32::from(b - b'0')))
        };
        self.servos = if self.legacy {
            let mut parts = line.split(|byte| *byte == b'&').filter(|part| !part.is_empty());
            std::array::from_fn(|_| parts.next().map_or(0, value).min(1000) as u16)
        } else {
            std::array::from_fn(|finger| {
                let letter = b'A' + finger as u8;
                let at = line.iter().position(|byte| *byte == letter);
                at.map_or(0, |at| value(&line[at + 1..])).min(1000) as u16
            })
        };
    }
}

impl Twin for LucidGlovesTwin {
    fn power_on(&mut self, now_ns: u64) {
        self.received.clear();
        self.next_ns = Some(now_ns);
    }

    fn step(&mut self, now_ns: u64, received: &[u8], send: &mut dyn FnMut(&[u8])) {
        self.lines_heard += received.iter().filter(|byte| **byte == b'\n').count() as u64;
        let room = PORT_BUFFER - self.received.len();
        self.received.extend_from_slice(&received[..received.len().min(room)]);
        if !received.is_empty() {
            self.waiting_ns = now_ns;
        }
        if self.next_ns.is_some_and(|next| now_ns >= next) {
            send(self.line().as_bytes());
            self.lines_said += 1;
            (self.next_ns, self.waiting_ns) = (None, now_ns);
        }
        if self.next_ns.is_none()
            && let Some(line) = self.read(now_ns)
        {
            self.obey(&line);
            self.next_ns = Some(now_ns + LOOP_NS + BYTE_NS * self.line().len() as u64);
        }
    }

    fn set_curls(&mut self, curls: [f64; 5]) {
        self.sensors.curl = curls.map(|curl| Some((curl.clamp(0.0, 1.0) * 4095.0).round() as u16));
    }

    fn felt(&self) -> [f64; 5] {
        self.servos.map(|servo| f64::from(servo) / 1000.0)
    }
}
