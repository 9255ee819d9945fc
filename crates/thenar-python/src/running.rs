//! A session with all that Python asks of it.

use crate::quantity::Quantity;
use crate::record::ActiveRecording;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::time::{Duration, Instant};
use thenar_core::readout::ContactReadout;
use thenar_scene::recording::snapshot;
use thenar_scene::session::{Session, Source};

/// A session that is stepped, and what was read of it.
#[derive(Debug)]
pub struct Running {
    /// The session.
    pub session: Session,
    /// Hash of the state it started in, and of the scene's text and overrides.
    pub start: u64,
    /// Snapshot of the session as it was opened.
    beginning: Vec<u8>,
    /// Counts changes: what was read before one is stale.
    pub generation: u64,
    /// Steps so far that gave a number that is not finite: taken back, in whole or in part.
    pub taken_back: u64,
    /// The recording under way.
    pub writing: Option<ActiveRecording>,
    /// Contact in other forms, and the generation it is of.
    readout: (ContactReadout, Option<u64>),
}

impl Running {
    /// A session that was just opened from this source.
    pub fn new(session: Session, source: &Source) -> Self {
        let readout = (ContactReadout::new(session.world()), None);
        let start = source.identity(session.world().state_hash());
        let beginning = snapshot(&session, start);
        Self { session, start, beginning, generation: 0, taken_back: 0, writing: None, readout }
    }

    /// True when nothing has entered and no step was made since it was opened.
    pub fn is_fresh(&self) -> bool {
        snapshot(&self.session, self.start) == self.beginning
    }

    /// Makes at most `steps` steps, and no further one once `slice` has passed; returns how many.
    pub fn advance(&mut self, steps: u64, slice: Duration) -> u64 {
        let begin = Instant::now();
        let mut made = 0;
        while made < steps && (made == 0 || begin.elapsed() < slice) {
            self.generation += 1;
            let report = self.session.step(&mut ());
            self.taken_back += u64::from(report.non_finite);
            made += 1;
        }
        made
    }

    /// Numbers of the present state, as bytes that nothing changes any more.
    pub fn read<'py>(
        &mut self,
        py: Python<'py>,
        what: Quantity,
        index: usize,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let (readout, of) = &mut self.readout;
        if what.is_of_contact() && *of != Some(self.generation) {
            readout.read(self.session.world());
            *of = Some(self.generation);
        }
        what.read(py, &self.session, readout, index)
    }
}
