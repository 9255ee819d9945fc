//! Messages that go out: models, and snapshots at a rate that eyes can use.

use crate::hub::HubEndpoint;
use crate::protocol::{Pace, Snapshots, set_epoch};
use bytes::Bytes;
use std::time::Duration;
use thenar_scene::session::Session;

/// Snapshots a second, at most.
const RATE_MAX: f64 = 120.0;

/// Counts and writes.
#[derive(Debug, Default)]
pub struct Publisher {
    epoch: u32,
    number: u32,
    /// Steps since the last snapshot.
    steps: u32,
    snapshots: Snapshots,
}

impl Publisher {
    /// Sends a new model, in a new epoch.
    pub fn model(&mut self, mut message: Vec<u8>, endpoint: &HubEndpoint) {
        self.epoch += 1;
        set_epoch(&mut message, self.epoch);
        endpoint.model.send_replace(Bytes::from(message));
    }

    /// True when the step just done, one `period` after the last, is to be shown.
    pub fn is_due(&mut self, period: Duration) -> bool {
        self.steps += 1;
        f64::from(self.steps) * period.as_secs_f64() * RATE_MAX > 0.999
    }

    /// Sends a snapshot.
    pub fn snapshot(&mut self, session: &Session, pace: Pace, endpoint: &HubEndpoint) {
        self.number = self.number.wrapping_add(1);
        self.steps = 0;
        let energy = session.world().energy(session.input());
        let pace = Pace { epoch: self.epoch, number: self.number, energy, ..pace };
        let message = self.snapshots.write(session, &pace);
        endpoint.snapshot.send_replace(Bytes::copy_from_slice(message));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_than_120_snapshots_a_second_and_none_left_out_below() {
        for (h, every) in [(1.0 / 60.0, 1), (0.01, 1), (1.0 / 120.0, 1), (5e-3, 2), (1e-3, 9)] {
            let mut publisher = Publisher::default();
            let period = Duration::from_secs_f64(h);
            let due = (1..).find(|_| publisher.is_due(period));
            assert_eq!(due, Some(every), "{h}");
        }
    }
}
