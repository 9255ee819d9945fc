//! The loop on a clock that somebody else turns.

use super::incident::{Incident, IncidentReader};
use super::settings::bounds_of;
use super::{
    Core, LoopError, LoopMode, MonitorEndpoints, Remote, Settings, Shared, SimulationPort,
    TickRecord, TickTime, share, tick,
};
use crate::{CouplingDesign, FeltBounds, ForceDisplay, Tracker};
use rtrb::Consumer;
use std::sync::{Arc, PoisonError};

/// A haptic loop without threads and clocks: whoever holds it says when it ticks. For tests and
/// benches.
pub struct ManualLoop {
    pub(super) shared: Arc<Shared>,
    mode: LoopMode,
    design: CouplingDesign,
    bounds: FeltBounds,
    /// Records of the ticks.
    pub records: Consumer<TickRecord>,
    /// Inputs of the last seconds, where a folder for trips is set.
    pub incident_reader: Option<IncidentReader>,
}

impl ManualLoop {
    /// Without a hand.
    ///
    /// # Errors
    /// As [`HapticLoop::start`].
    pub fn new(
        settings: &Settings,
        trackers: Vec<Box<dyn Tracker>>,
        displays: Vec<Box<dyn ForceDisplay>>,
    ) -> Result<Self, LoopError> {
        let bounds = bounds_of(settings, &displays);
        let (shared, MonitorEndpoints { records, incident_reader }) =
            share(settings, trackers, displays, false)?;
        let (mode, design) = (settings.mode, settings.design);
        Ok(Self { shared, mode, design, bounds, records, incident_reader })
    }

    /// One tick at `now_ns`; false when it was left out.
    pub fn tick(&mut self, now_ns: u64) -> bool {
        tick(&self.shared, &TickTime { now_ns, ..TickTime::default() })
    }

    /// Arms and stops; its status stays empty.
    pub fn remote(&self) -> Remote {
        Remote(self.shared.control.clone())
    }

    /// For whoever steps the simulation.
    pub fn port(&self) -> SimulationPort {
        SimulationPort::new(self.shared.clone(), self.mode, self.design, self.bounds)
    }

    /// Returns the incident of the last seconds, with these records of them; `None` where nothing
    /// is kept.
    pub fn incident(&mut self, reason: &str, records: &[TickRecord]) -> Option<Incident> {
        let displays = self.core(|core| core.displays().to_vec());
        let (incident_reader, frames) =
            (self.incident_reader.as_mut()?, self.shared.frames.as_ref()?);
        incident_reader.drain();
        incident_reader.incident(reason, &displays, frames, records)
    }

    /// Looks at what the loop ticks.
    pub fn core<T>(&self, look: impl FnOnce(&mut Core) -> T) -> T {
        look(&mut self.shared.core.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
