//! Text messages to clients.

use super::VERSION;
use crate::hub::{ClientId, SceneName};
use serde_json::json;
use thenar_core::model::Side;
use thenar_link::Rendering;
use thenar_link::haptic_loop::{STATEMENT, Status};

/// The first message to a client.
pub fn welcome(client: ClientId, scenes: &[SceneName]) -> String {
    json!({
        "type": "welcome",
        "protocol": VERSION,
        "server": concat!("thenar ", env!("CARGO_PKG_VERSION")),
        "client": client.0,
        "scenes": scenes,
    })
    .to_string()
}

/// Most messages of devices and loop that are sent.
const MESSAGES: usize = 5;

/// Message on the state of the devices. `armed_by` must stay for forces to last.
pub fn touch(status: &Status, armed_by: Option<ClientId>) -> String {
    let us = |ns: u64| ns as f64 * 1e-3;
    let devices = status.devices.iter().map(|device| {
        json!({
            "name": device.name,
            "connected": device.connected,
            "silent_s": device.silence,
            "tracks": device.tracks,
            "shows": device.shows,
        })
    });
    let hands = status.hands.iter().map(|hand| {
        let side = match hand.side {
            Side::Left => "left",
            Side::Right => "right",
        };
        json!({
            "side": side,
            "tracked": hand.tracked,
            "renders": hand.display.map(|(_, rendering)| match rendering {
                Rendering::Tendons => "tendons",
                Rendering::Stops => "stops",
                Rendering::Vibration => "vibration",
                Rendering::Wrench => "wrench",
            }),
            "force_max": hand.force_max,
            "wanted": hand.forces.map(|[wanted, _]| wanted),
            "sent": hand.forces.map(|[_, sent]| sent),
        })
    });
    json!({
        "type": "touch",
        "state": status.state.word(),
        "reason": status.state.reason(),
        "armed_by": armed_by.map(|client| client.0),
        "rate": status.rate_hz,
        "ticks": status.ticks,
        "missed": status.missed,
        "period_p999_us": us(status.period.quantile(0.999)),
        "late_p999_us": us(status.late.quantile(0.999)),
        "tick_us": us(status.cost.quantile(0.5)),
        "devices": devices.collect::<Vec<_>>(),
        "hands": hands.collect::<Vec<_>>(),
        "warnings": status.warnings,
        "messages": status.messages[status.messages.len().saturating_sub(MESSAGES)..],
        "statement": STATEMENT,
    })
    .to_string()
}

/// Message of what was refused and why.
pub fn error(message: &str) -> String {
    json!({"type": "error", "message": message}).to_string()
}

/// The answer to a ping: the client's time and ours \[s\].
pub fn pong(t: f64, server: f64) -> String {
    json!({"type": "pong", "t": t, "server": server}).to_string()
}
