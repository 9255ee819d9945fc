//! CyberGlove III: packets of 61 bytes, found by the time in front of them.
//!
//! ```text
//! hh:mm:ss:ff:dS | 22 sensors, 16 bits, high byte first | 3 bytes
//! 14 bytes       | 44 bytes                              |
//! ```

use super::profile::Profile;
use super::{Handshake, SENSORS, sample};
use crate::{Event, HandOutput, Protocol};
use std::sync::Arc;

/// Bytes of a packet.
pub const PACKET: usize = 61;
/// Largest word of a sensor: the converter has 12 bits.
const CONVERTER_MAX: f64 = 4095.0;
/// Bytes of the time.
const TIME: usize = 14;
const START: [&[u8]; 2] = [b"1E4010111\0", b"1S\0"];
/// Two losses of the packet's beginning within this time mean that the stream is broken \[ns\].
const RESYNC_NS: u64 = 2_000_000_000;

/// The protocol.
pub struct Third {
    profile: Arc<Profile>,
    /// Bytes not yet understood: less than two packets.
    bytes: Vec<u8>,
    /// The beginning of packets is known.
    in_step: bool,
    /// Time of the last loss of the beginning \[ns\].
    lost_ns: Option<u64>,
    handshake: Handshake,
}

impl Third {
    /// A conversation that has not begun.
    pub fn new(profile: Arc<Profile>) -> Self {
        let handshake = Handshake::new(&START);
        Self {
            profile,
            bytes: Vec::with_capacity(2 * PACKET),
            in_step: false,
            lost_ns: None,
            handshake,
        }
    }

    /// Takes whole packets off the front, or looks for the next beginning.
    fn digest(&mut self, now_ns: u64, event: &mut dyn FnMut(Event), send: &mut dyn FnMut(&[u8])) {
        while self.bytes.len() >= PACKET {
            if is_time(&self.bytes) && self.is_whole() {
                self.in_step = true;
                self.handshake.heard(now_ns);
                event(self.read(now_ns));
                self.bytes.drain(..PACKET);
                continue;
            }
            if std::mem::take(&mut self.in_step) {
                event(Event::Refused("a packet is damaged; looking for the next".into()));
                let again = |lost: u64| now_ns.saturating_sub(lost) < RESYNC_NS;
                if self.lost_ns.replace(now_ns).is_some_and(again) {
                    event(Event::Note("the stream keeps breaking; it is started anew".into()));
                    send(b"\x03");
                    self.lost_ns = None;
                    self.handshake.begin(now_ns);
                }
            }
            let begins = (1..=self.bytes.len() - TIME).find(|at| is_time(&self.bytes[*at..]));
            let skipped = begins.unwrap_or(self.bytes.len() - TIME + 1);
            self.bytes.drain(..skipped);
        }
    }

    /// True if the packet in front is one, and not the beginning of one and what came after bytes
    /// were lost: every sensor is within its range, and no other packet begins within it.
    fn is_whole(&self) -> bool {
        let most = self.profile.glove.full_scale.max(CONVERTER_MAX);
        let packet = &self.bytes[..PACKET];
        let words = packet[TIME..TIME + 2 * SENSORS].chunks_exact(2);
        let mut values = words.map(|word| f64::from(u16::from_be_bytes([word[0], word[1]])));
        values.all(|value| value <= most) && !(1..PACKET - 2).any(|at| may_be_time(&packet[at..]))
    }

    fn read(&self, now_ns: u64) -> Event {
        let full = self.profile.glove.full_scale;
        let values: [f64; SENSORS] = std::array::from_fn(|k| {
            let at = TIME + 2 * k;
            f64::from(u16::from_be_bytes([self.bytes[at], self.bytes[at + 1]])) / full
        });
        sample(&self.profile, now_ns, &values)
    }
}

/// `..:..:..:..:.S`, with digits for dots.
fn is_time(bytes: &[u8]) -> bool {
    bytes.len() >= TIME && may_be_time(bytes)
}

/// True if the bytes that are there can begin a time.
fn may_be_time(bytes: &[u8]) -> bool {
    let fits = |(k, byte): (usize, &u8)| match k {
        2 | 5 | 8 | 11 => *byte == b':',
        13 => *byte == b'S',
        _ => byte.is_ascii_digit() || *byte == b' ',
    };
    bytes.iter().take(TIME).enumerate().all(fits)
}

impl Protocol for Third {
    fn start(&mut self, now_ns: u64, _: &mut dyn FnMut(&[u8])) {
        self.bytes.clear();
        (self.in_step, self.lost_ns) = (false, None);
        // A glove that streams already is not started again.
        self.handshake.listen(now_ns);
    }

    fn receive(
        &mut self,
        now_ns: u64,
        bytes: &[u8],
        event: &mut dyn FnMut(Event),
        send: &mut dyn FnMut(&[u8]),
    ) {
        for part in bytes.chunks(PACKET) {
            self.bytes.extend_from_slice(part);
            self.digest(now_ns, event, send);
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

#[cfg(test)]
mod tests {
    use super::super::{SHIPPED_3, ThirdTwin};
    use super::*;
    use crate::profile::{Address, load};
    use crate::twin::Twin;

    /// Packets of a hand that closes, cut short anywhere: what is left of one never becomes a pose,
    /// and those that come whole all do, but the one behind a cut that hides its beginning.
    #[test]
    fn spliced_packets_are_refused() {
        let address = Address::parse("cyberglove3", "x").unwrap();
        let profile = Arc::new(load::<Profile>("cyberglove3", SHIPPED_3, &address).unwrap());
        for kept in 1..PACKET {
            let mut glove = Third::new(profile.clone());
            glove.start(0, &mut |_| ());
            let (mut poses, mut refused) = (Vec::new(), 0);
            let mut twin = ThirdTwin::default();
            twin.set_curls([0.5; 5]);
            let mut want = Vec::new();
            for k in 0..20u64 {
                let now_ns = k * 10_000_000;
                let packet = twin.packet(now_ns);
                let part = if k == 10 { &packet[..kept] } else { &packet[..] };
                let mut take = |event| match event {
                    Event::Sample(sample) => poses.push(sample.pose),
                    Event::Refused(_) => refused += 1,
                    _ => {}
                };
                glove.receive(now_ns, part, &mut take, &mut |_| ());
                if k == 0 {
                    want = poses.clone();
                }
            }
            assert!(poses.iter().all(|pose| *pose == want[0]), "cut to {kept} bytes");
            assert!(poses.len() >= 17, "cut to {kept} bytes: {} of 19", poses.len());
            assert!(refused >= 1, "cut to {kept} bytes");
        }
    }

    /// A word of 12594 of 4095 is believed by nobody.
    #[test]
    fn sensors_out_of_range_are_refused() {
        let address = Address::parse("cyberglove3", "x").unwrap();
        let profile = Arc::new(load::<Profile>("cyberglove3", SHIPPED_3, &address).unwrap());
        let mut glove = Third::new(profile);
        let mut packet = ThirdTwin::default().packet(0);
        packet[TIME + 8..TIME + 10].copy_from_slice(&12594_u16.to_be_bytes());
        let mut events = Vec::new();
        glove.receive(0, &packet, &mut |event| events.push(event), &mut |_| ());
        assert!(events.iter().all(|event| !matches!(event, Event::Sample(_))), "{events:?}");
    }
}
