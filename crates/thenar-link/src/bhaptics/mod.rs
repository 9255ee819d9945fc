//! Vibrating gloves through the bHaptics player: JSON over its WebSocket (version 2).
//!
//! Each glove gets a frame of 100 ms while anything vibrates, and one of zeros when that ends; the
//! first frame of a touch goes out at once. A frame shows the largest intensity since the one
//! before it, so that a tap between frames is felt. The player needs to run on this computer.

mod driver;
pub mod twin;

pub use driver::BhapticsDriver;

use crate::{DIGITS, DigitOutput, Event, HandOutput, Protocol};
use serde::Deserialize;
use std::fmt::Write;
use thenar_core::model::Side;

/// TCP port of the player, on this computer.
pub const PORT: u16 = 15881;
/// Path requested of the player, which shows name and id.
pub const PATH: &str = "/v2/feedbacks?app_id=thenar&app_name=Thenar";

/// Duration of a frame's vibration, and the time between frames \[ns\].
const FRAME_NS: u64 = 100_000_000;
/// Without an output for so long nothing is felt \[ns\].
const SILENCE_NS: u64 = 20_000_000;
/// The player's largest intensity for one point.
const INTENSITY_MAX: f64 = 100.0;

/// Map from pads' readings to intensities: linear in force and in slip, together at most 100.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntensityMap {
    /// Pad force below which nothing is felt \[N\].
    pub force_min: f64,
    /// Pad force of the largest intensity from force \[N\].
    pub force_full: f64,
    /// That intensity, 0 to 100.
    pub force_share: f64,
    /// Slip speed of the largest intensity from slip \[m/s\].
    pub slip_full: f64,
    /// That intensity, 0 to 100.
    pub slip_share: f64,
}

impl Default for IntensityMap {
    fn default() -> Self {
        Self {
            force_min: 0.05,
            force_full: 5.0,
            force_share: 60.0,
            slip_full: 0.2,
            slip_share: 40.0,
        }
    }
}

impl IntensityMap {
    /// Intensity for one finger, 0 to 100. Numbers that are none give nothing.
    pub fn intensity(&self, digit: &DigitOutput) -> u8 {
        let part = |value: f64, full: f64| {
            if value.is_finite() { (value / full).clamp(0.0, 1.0) } else { 0.0 }
        };
        if !(digit.pad_force.is_finite() && digit.pad_force >= self.force_min) {
            return 0;
        }
        let force = self.force_share * part(digit.pad_force, self.force_full);
        let slip = self.slip_share * part(digit.slip_speed, self.slip_full);
        (force + slip).clamp(0.0, INTENSITY_MAX).round() as u8
    }
}

/// One glove.
#[derive(Clone, Copy, Debug, Default)]
struct Glove {
    /// Newest intensities, and when they came.
    now: [u8; DIGITS],
    shown_ns: u64,
    /// Largest since the last frame.
    peak: [u8; DIGITS],
    /// Time of the last frame sent.
    sent_ns: Option<u64>,
    /// The last frame vibrates.
    vibrates: bool,
}

/// The protocol.
#[derive(Clone, Debug, Default)]
pub struct Bhaptics {
    feel: IntensityMap,
    /// Left, right.
    gloves: [Glove; 2],
    /// Connected gloves, by the player's last status.
    connected: Option<Vec<String>>,
}

/// Part of the player's statuses that is read; the rest is ignored.
#[derive(Deserialize)]
struct Status {
    #[serde(default, rename = "ConnectedPositions")]
    connected: Option<Vec<String>>,
}

impl Bhaptics {
    /// With this feel.
    pub fn new(feel: IntensityMap) -> Self {
        Self { feel, ..Self::default() }
    }
}

impl Protocol for Bhaptics {
    fn start(&mut self, _: u64, send: &mut dyn FnMut(&[u8])) {
        *self = Self::new(self.feel);
        // A player that vibrates from before stops.
        self.stop(send);
    }

    fn receive(
        &mut self,
        _: u64,
        bytes: &[u8],
        event: &mut dyn FnMut(Event),
        _: &mut dyn FnMut(&[u8]),
    ) {
        let Ok(status) = serde_json::from_slice::<Status>(bytes) else {
            return event(Event::Refused("the player sent something that is not a status".into()));
        };
        event(Event::Alive);
        let Some(mut gloves) = status.connected else { return };
        gloves.retain(|position| ["GloveL", "GloveR"].contains(&position.as_str()));
        gloves.sort();
        gloves.dedup();
        if self.connected.as_ref() != Some(&gloves) {
            event(Event::Note(match gloves.is_empty() {
                true => "the player has no glove".into(),
                false => format!("the player has {}", gloves.join(" and ")),
            }));
            self.connected = Some(gloves);
        }
    }

    fn tick(
        &mut self,
        now_ns: u64,
        output: Option<&HandOutput>,
        _: &mut dyn FnMut(Event),
        send: &mut dyn FnMut(&[u8]),
    ) {
        if let Some(output) = output {
            let glove = &mut self.gloves[output.side as usize];
            glove.now = output.digits.each_ref().map(|digit| self.feel.intensity(digit));
            glove.shown_ns = now_ns;
            glove.peak = std::array::from_fn(|k| glove.peak[k].max(glove.now[k]));
        }
        for (glove, side) in self.gloves.iter_mut().zip([Side::Left, Side::Right]) {
            if now_ns.saturating_sub(glove.shown_ns) > SILENCE_NS {
                (glove.now, glove.peak) = ([0; DIGITS], [0; DIGITS]);
            }
            let vibrates = glove.peak.iter().any(|intensity| *intensity > 0);
            let due = glove.sent_ns.is_none_or(|sent| now_ns.saturating_sub(sent) >= FRAME_NS);
            // Letting go waits for nothing; but it is no reason for a flood either.
            let released = glove.vibrates && glove.now == [0; DIGITS] && !vibrates;
            if (due && vibrates) || released {
                send(frame(side, &glove.peak).as_bytes());
                glove.sent_ns = Some(now_ns);
                glove.vibrates = vibrates;
                glove.peak = glove.now;
            }
        }
    }

    fn stop(&mut self, send: &mut dyn FnMut(&[u8])) {
        for side in [Side::Left, Side::Right] {
            send(frame(side, &[0; DIGITS]).as_bytes());
        }
        self.gloves = Default::default();
    }
}

/// A frame for one glove: its tips are points 0 to 4, thumb first.
fn frame(side: Side, intensities: &[u8; DIGITS]) -> String {
    let (key, position) = match side {
        Side::Left => ("thenar-left", "GloveL"),
        Side::Right => ("thenar-right", "GloveR"),
    };
    let mut text = format!(
        "{{\"Register\":[],\"Submit\":[{{\"type\":\"frame\",\"key\":\"{key}\",\"Frame\":\
         {{\"durationMillis\":100,\"position\":\"{position}\",\"dotPoints\":["
    );
    for (index, intensity) in intensities.iter().enumerate() {
        let comma = if index > 0 { "," } else { "" };
        // Writing to a string cannot fail.
        let _ = write!(text, "{comma}{{\"index\":{index},\"intensity\":{intensity}}}");
    }
    text.push_str("],\"pathPoints\":[]}}]}");
    text
}

#[cfg(test)]
mod tests;
