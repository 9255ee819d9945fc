//! The status that clients receive.

use serde::Serialize;
use thenar_scene::hands::Hands;
use thenar_scene::tuning::Setting;

/// The status message.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "status")]
pub struct Status<'a> {
    /// Number of the client that holds control.
    pub control: Option<u32>,
    /// Number of clients.
    pub viewers: usize,
    /// True while nothing is stepped.
    pub paused: bool,
    /// Simulated over real time, as wanted.
    pub speed: f64,
    /// The scene.
    pub scene: &'a str,
    /// The scene that is being made ready.
    pub loading: Option<&'a str>,
    /// The hands in the scene.
    pub hands: Hands,
    /// Failure of the simulation, if any.
    pub problem: Option<&'a str>,
    /// Settings that can be changed.
    pub settings: Vec<Setting>,
    /// The recording that is shown; absent when a scene is live.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recording: Option<Recorded<'a>>,
}

/// A recording that is shown.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Recorded<'a> {
    /// Name of the recording's file, without folder.
    pub file: &'a str,
    /// Place in it \[s\].
    pub time: f64,
    /// Length of the recording \[s\].
    pub end: f64,
}

impl Status<'_> {
    /// Returns the message as text.
    pub fn text(&self) -> String {
        // Texts and finite numbers always have a JSON form.
        serde_json::to_string(self).unwrap_or_default()
    }
}
