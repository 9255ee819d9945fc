//! Tells of forces that paused: they come back by themselves, so their state soon forgets why.

use super::record::TickRecord;
use crate::safety::{Pause, Status};
use std::mem::{Discriminant, discriminant};
use thenar_core::model::Side;

/// Least time between two reports of one kind of pause \[ns\].
const AGAIN_NS: u64 = 1_000_000_000;

/// The displays that let forces through, and pauses not yet reported.
#[derive(Default)]
pub struct Pauses {
    passing: Vec<(u8, Side)>,
    untold: Vec<Pause>,
    /// Time at which each kind was last reported \[ns\].
    told: Vec<(Discriminant<Pause>, u64)>,
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
                    && self.is_news(&pause, record.time_ns)
                {
                    self.untold.push(pause);
                }
            }
        }
    }

    fn is_news(&mut self, pause: &Pause, now_ns: u64) -> bool {
        let kind = discriminant(pause);
        match self.told.iter_mut().find(|(other, _)| *other == kind) {
            Some((_, told_ns)) if now_ns.saturating_sub(*told_ns) < AGAIN_NS => return false,
            Some((_, told_ns)) => *told_ns = now_ns,
            None => self.told.push((kind, now_ns)),
        }
        true
    }

    /// Reports each new pause, once.
    pub fn tell(&mut self) -> impl Iterator<Item = String> + '_ {
        self.untold.drain(..).map(|pause| {
            let again = match pause {
                Pause::DeadMan => "they begin anew once it is held and little force is wanted",
                _ => "they come back once that is over",
            };
            format!("forces paused: {pause}; {again}")
        })
    }
}
