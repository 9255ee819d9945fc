//! CyberGlove I and II: commands in text, records of one byte per sensor.
//!
//! A record is `S`, a byte from 1 to 255 per sensor, and a zero. Only the zero is never data, so
//! records end at zeros and are taken when just the right number of bytes lies between two. What
//! looks like the first record of a stream may be noise: it waits until another follows it.

use super::profile::Profile;
use super::{Handshake, sample};
use crate::{Event, HandOutput, Protocol};
use std::sync::Arc;

/// Commands that make the glove stream at 100 Hz: stop, is it there, light on, no filter, period of
/// 1152 / 115200 s, no status byte, go.
const START: [&[u8]; 7] = [b"\x03", b"l ?\r", b"l 1\r", b"f 0\r", b"t 1152 1\r", b"u 0\r", b"S"];

/// The protocol.
pub struct Classic {
    profile: Arc<Profile>,
    /// Bytes since the last zero, no more than a record has.
    record: Vec<u8>,
    /// More came than a record has.
    too_long: bool,
    /// Candidate for the stream's first record, and the number of bytes since.
    first: Option<(Event, usize)>,
    handshake: Handshake,
}

impl Classic {
    /// A conversation that has not begun.
    pub fn new(profile: Arc<Profile>) -> Self {
        let handshake = Handshake::new(&START);
        Self { profile, record: Vec::with_capacity(64), too_long: false, first: None, handshake }
    }

    /// A zero came.
    fn finish(&mut self, now_ns: u64, event: &mut dyn FnMut(Event)) {
        let bytes = std::mem::take(&mut self.record);
        let too_long = std::mem::take(&mut self.too_long);
        let sensors = self.profile.glove.sensors;
        match bytes.as_slice() {
            [b'S', values @ ..] if values.len() == sensors && !too_long => {
                let full = self.profile.glove.full_scale;
                let mut scaled = [0.0; super::SENSORS];
                for (scaled, byte) in scaled.iter_mut().zip(values) {
                    *scaled = f64::from(byte - 1) / full;
                }
                let sample = sample(&self.profile, now_ns, &scaled[..sensors]);
                match self.first.take() {
                    Some((first, since)) if since == sensors + 2 => event(first),
                    _ if !self.handshake.streams() => {
                        self.first = Some((sample, 0));
                        self.clear(bytes);
                        return;
                    }
                    _ => {}
                }
                self.handshake.heard(now_ns);
                event(sample);
            }
            [b'S', values @ ..] if [18, 22].contains(&values.len()) && !too_long => {
                event(Event::Refused(format!(
                    "the glove has {} sensors, the profile says {sensors} (glove.sensors)",
                    values.len()
                )));
            }
            _ => {
                event(Event::Refused("bytes that are not a record: noise or another speed".into()))
            }
        }
        self.clear(bytes);
    }

    /// Begins the next record in the memory of the last.
    fn clear(&mut self, mut bytes: Vec<u8>) {
        bytes.clear();
        self.record = bytes;
    }
}

impl Protocol for Classic {
    fn start(&mut self, now_ns: u64, _: &mut dyn FnMut(&[u8])) {
        self.record.clear();
        (self.too_long, self.first) = (false, None);
        self.handshake.begin(now_ns);
    }

    fn receive(
        &mut self,
        now_ns: u64,
        bytes: &[u8],
        event: &mut dyn FnMut(Event),
        _: &mut dyn FnMut(&[u8]),
    ) {
        for byte in bytes {
            if let Some((_, since)) = &mut self.first {
                *since += 1;
            }
            match byte {
                0 => self.finish(now_ns, event),
                // Before the first record the glove echoes our commands.
                byte if !self.handshake.streams() => {
                    if self.record.len() > self.profile.glove.sensors {
                        self.record.remove(0);
                    }
                    self.record.push(*byte);
                }
                byte if self.record.len() <= super::SENSORS => self.record.push(*byte),
                _ => self.too_long = true,
            }
        }
    }

    fn tick(
        &mut self,
        now_ns: u64,
        _: Option<&HandOutput>,
        _: &mut dyn FnMut(Event),
        send: &mut dyn FnMut(&[u8]),
    ) {
        self.handshake.tick(now_ns, send);
    }

    fn stop(&mut self, send: &mut dyn FnMut(&[u8])) {
        send(b"\x03");
    }
}
