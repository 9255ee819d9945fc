//! Tells of forces that paused: they come back by themselves, so their state soon forgets why.

use super::record::TickRecord;
use thenar::haptic::safety::{Pause, Status};

/// Pauses told of between two looks of the monitor.
const MOST: usize = 4;

/// Which displays let forces through, and pauses not told of yet.
#[derive(Default)]
pub struct Pauses {
    passing: Vec<(u8, thenar::model::Side)>,
    untold: Vec<Pause>,
}

impl Pauses {
    /// Takes note of a tick.
    pub fn see(&mut self, record: &TickRecord) {
        let Some(display) = record.display else { return };
        let own = (display, record.side);
        let at = self.passing.iter().position(|other| *other == own);
        match (record.status, at) {
            (Status::Ramping { .. } | Status::Live, None) => self.passing.push(own),
            (Status::Ramping { .. } | Status::Live, Some(_)) | (_, None) => {}
            (status, Some(at)) => {
                self.passing.swap_remove(at);
                if let Status::Waiting { pause: Some(pause), .. } = status
                    && self.untold.len() < MOST
                {
                    self.untold.push(pause);
                }
            }
        }
    }

    /// What is to be told, once.
    pub fn tell(&mut self) -> impl Iterator<Item = String> + '_ {
        // What pauses one display mostly pauses all.
        self.untold.dedup();
        self.untold.drain(..).map(|pause| {
            format!("forces paused: {pause}; they begin anew once little force is wanted")
        })
    }
}
