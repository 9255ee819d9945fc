//! Presence of devices: which there are, and whether they are reached.

use super::control::DeviceStatus;
use crate::{ForceDisplay, PresenceCheck, Tracker};

/// Asks all devices whether they are there, while the loop has them.
pub struct PresenceChecks {
    trackers: Vec<PresenceCheck>,
    displays: Vec<PresenceCheck>,
}

impl PresenceChecks {
    /// Presence checks of these trackers and displays.
    pub fn of(trackers: &[Box<dyn Tracker>], displays: &[Box<dyn ForceDisplay>]) -> Self {
        Self {
            trackers: trackers.iter().map(|tracker| tracker.presence_check()).collect(),
            displays: displays.iter().map(|display| display.presence_check()).collect(),
        }
    }

    /// All that have a name, each once: a glove is often both.
    pub fn look(&mut self, now_ns: u64) -> Vec<DeviceStatus> {
        let mut all: Vec<DeviceStatus> = Vec::new();
        let tracks = self.trackers.iter_mut().map(|look| (look, true));
        let shows = self.displays.iter_mut().map(|look| (look, false));
        for (look, tracks) in tracks.chain(shows) {
            for found in look() {
                let known = all.iter().position(|device| device.name == found.name);
                let device = match known {
                    Some(k) => &mut all[k],
                    None => {
                        let since = |ns: u64| now_ns.saturating_sub(ns) as f64 * 1e-9;
                        all.push(DeviceStatus {
                            name: found.name,
                            connected: found.connected,
                            silence: found.heard_ns.map(since),
                            tracks: false,
                            shows: false,
                        });
                        all.last_mut().expect("just pushed")
                    }
                };
                device.tracks |= tracks;
                device.shows |= !tracks;
            }
        }
        all
    }
}
