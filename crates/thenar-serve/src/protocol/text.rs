//! Text messages to clients.

use super::VERSION;
use crate::hub::{ClientId, SceneName};
use serde_json::json;

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

/// What was refused and why.
pub fn error(message: &str) -> String {
    json!({"type": "error", "message": message}).to_string()
}

/// The answer to a ping: the client's time and ours \[s\].
pub fn pong(t: f64, server: f64) -> String {
    json!({"type": "pong", "t": t, "server": server}).to_string()
}
