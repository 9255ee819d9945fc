//! CyberGrasp: the force of each distal proxy's coupling along the pad normal, as pulls of tendons.
//!
//! Its control unit is closed and only its maker's library speaks to it. The boundary to that is a
//! program of your own, the *bridge*, which implements [`GraspUnit`] and calls [`serve_unit`]; we
//! reach it over TCP. Both directions are fixed in size, little-endian:
//!
//! ```text
//! to the unit   "TGRP" | sequence u32 | 5 forces f32 [N], thumb first    28 bytes, 1 kHz
//! from the unit "TGRA" | sequence u32                                     8 bytes, each answered
//! ```
//!
//! Forces are 0 to 12 N, pull only. The bridge releases all tendons when nothing came for 20 ms.

mod unit;

pub use unit::{GraspUnit, SimulatedUnit, UNIT_SILENCE, serve_unit};

use crate::profile::{Address, Check, Display, load};
use crate::transport::{StreamTransport, host_and_port, tcp};
use crate::worker::{Device, DisplayTraits};
use crate::{
    DIGITS, Driver, Event, FoundDevice, HandOutput, LinkError, Opened, Protocol, Rendering,
};
use serde::{Deserialize, Serialize};
use thenar_core::model::Side;
use thenar_touch::{CYBERGRASP_FORCE_MAX, tendon_pull};

/// Shipped profile.
pub const SHIPPED: &str = include_str!("../../profiles/cybergrasp.toml");
/// Bytes of a command, and of its answer.
pub const COMMAND: usize = 28;
/// Bytes of an answer.
pub const ANSWER: usize = 8;
const COMMAND_MARK: &[u8; 4] = b"TGRP";
const ANSWER_MARK: &[u8; 4] = b"TGRA";
/// Longest time between two messages to the unit, even when nothing changes \[ns\].
const PERIOD_NS: u64 = 1_000_000;

/// The profile's content.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// The tendons.
    pub display: Display,
}

impl Check for Profile {
    fn check(&self) -> Result<(), (String, String)> {
        self.display.check()?;
        if self.display.rated > CYBERGRASP_FORCE_MAX {
            let cause =
                format!("is {} N, expected at most {CYBERGRASP_FORCE_MAX}", self.display.rated);
            return Err(("display.rated".into(), cause));
        }
        Ok(())
    }

    fn set_side(&mut self, _: Side) {}
}

/// A command's bytes.
pub fn command(sequence: u32, forces: &[f64; DIGITS]) -> [u8; COMMAND] {
    let mut bytes = [0; COMMAND];
    bytes[..4].copy_from_slice(COMMAND_MARK);
    bytes[4..8].copy_from_slice(&sequence.to_le_bytes());
    for (slot, force) in bytes[8..].chunks_exact_mut(4).zip(forces) {
        slot.copy_from_slice(&(tendon_pull(*force, CYBERGRASP_FORCE_MAX) as f32).to_le_bytes());
    }
    bytes
}

/// The conversation with a bridge.
#[derive(Default)]
pub struct CyberGrasp {
    side: Option<Side>,
    forces: [f64; DIGITS],
    sequence: u32,
    sent_ns: u64,
    /// Bytes of an answer that has not come whole.
    answer: Vec<u8>,
}

impl CyberGrasp {
    /// For this hand; for the one that presses first if `None`.
    pub fn new(side: Option<Side>) -> Self {
        Self { side, ..Self::default() }
    }

    fn tell(&mut self, now_ns: u64, send: &mut dyn FnMut(&[u8])) {
        self.sequence = self.sequence.wrapping_add(1);
        self.sent_ns = now_ns;
        send(&command(self.sequence, &self.forces));
    }
}

impl Protocol for CyberGrasp {
    fn start(&mut self, now_ns: u64, send: &mut dyn FnMut(&[u8])) {
        self.answer.clear();
        self.forces = [0.0; DIGITS];
        self.tell(now_ns, send);
    }

    fn receive(
        &mut self,
        _: u64,
        bytes: &[u8],
        event: &mut dyn FnMut(Event),
        _: &mut dyn FnMut(&[u8]),
    ) {
        for byte in bytes {
            self.answer.push(*byte);
            let marked = self.answer.len().min(ANSWER_MARK.len());
            if self.answer[..marked] != ANSWER_MARK[..marked] {
                // It may be the first byte of the next.
                self.answer.clear();
                self.answer.extend(Some(*byte).filter(|byte| *byte == ANSWER_MARK[0]));
                event(Event::Refused("bytes that are not an answer of a CyberGrasp bridge".into()));
            } else if self.answer.len() == ANSWER {
                self.answer.clear();
                event(Event::Alive);
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
        let ours = |output: &&HandOutput| self.side.is_none_or(|side| side == output.side);
        let mut changed = false;
        if let Some(output) = output.filter(ours) {
            let forces = output.digits.map(|d| tendon_pull(d.pad_force, CYBERGRASP_FORCE_MAX));
            changed = forces != self.forces;
            self.forces = forces;
        }
        if changed || now_ns.saturating_sub(self.sent_ns) >= PERIOD_NS {
            self.tell(now_ns, send);
        }
    }

    fn holds_one_hand(&self) -> bool {
        self.side.is_none()
    }

    fn release(&self, send: &mut dyn FnMut(&[u8])) {
        send(&command(self.sequence.wrapping_add(1), &[0.0; DIGITS]));
    }

    fn stop(&mut self, send: &mut dyn FnMut(&[u8])) {
        self.forces = [0.0; DIGITS];
        self.tell(self.sent_ns, send);
    }
}

/// Driver of addresses `cybergrasp:HOST:PORT`.
pub struct CyberGraspDriver;

impl Driver for CyberGraspDriver {
    fn name(&self) -> &'static str {
        "cybergrasp"
    }

    fn about(&self) -> &'static str {
        "CyberGrasp through a bridge of yours to its maker's library; cybergrasp:127.0.0.1:7070"
    }

    fn enumerate(&self) -> Vec<FoundDevice> {
        Vec::new()
    }

    fn open(&self, address: &str) -> Result<Opened, LinkError> {
        let parsed = Address::parse(self.name(), address)?;
        let profile: Profile = load(self.name(), SHIPPED, &parsed)?;
        let name = format!("cybergrasp:{}", parsed.place);
        let peer = host_and_port(&parsed.place, None).map_err(|cause| {
            let cause = format!("{cause} of a bridge");
            LinkError::Setting { what: format!("device `{name}`"), cause }
        })?;
        let device = Device {
            name,
            connect: Box::new(move || Ok(Box::new(StreamTransport::new(tcp::call(&peer)?)?))),
            protocol: Box::new(CyberGrasp::new(parsed.side)),
            tracks: None,
            display: Some(DisplayTraits {
                rendering: Rendering::Tendons,
                limits: profile.display.limits(true),
                torque_limits: None,
                loop_profile: profile.display.loop_profile(),
            }),
            speaks: true,
        };
        device.open()
    }
}
