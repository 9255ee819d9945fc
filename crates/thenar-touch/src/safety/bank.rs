//! All actuators of one device: when one trips, all do.

use crate::safety::{Guard, LimitError, Limits, Signal, Status, Trip};

/// The guards of one device.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Bank<const N: usize> {
    guards: Vec<Guard<N>>,
}

impl<const N: usize> Bank<N> {
    /// One guard per actuator, all off, each with room for `log_ticks` records.
    pub fn new(limits: &[Limits], log_ticks: usize) -> Result<Self, LimitError> {
        let guards: Result<_, _> = limits.iter().map(|l| Guard::new(*l, log_ticks)).collect();
        Ok(Self { guards: guards? })
    }

    /// The guards.
    pub fn guards(&self) -> &[Guard<N>] {
        &self.guards
    }

    /// Arms all.
    pub fn arm(&mut self) {
        self.guards.iter_mut().for_each(Guard::arm);
    }

    /// Stops all until armed.
    pub fn trip(&mut self, reason: Trip) {
        self.guards.iter_mut().for_each(|guard| guard.trip(reason));
    }

    /// See [`Guard::see_late`].
    pub fn see_late(&mut self, delay: f64) {
        self.guards.iter_mut().for_each(|guard| guard.see_late(delay));
    }

    /// See [`Guard::see_away`].
    pub fn see_away(&mut self, away: bool) {
        self.guards.iter_mut().for_each(|guard| guard.see_away(away));
    }

    /// The first trip in force, with its actuator. A companion's reason is not the first.
    pub fn tripped(&self) -> Option<(usize, Trip)> {
        let mut trips =
            (self.guards.iter().enumerate()).filter_map(|(i, guard)| match guard.status() {
                Status::Tripped(reason) => Some((i, reason)),
                _ => None,
            });
        trips.clone().find(|(_, r)| !matches!(r, Trip::Companion { .. })).or(trips.next())
    }

    /// The forces to send \[N\], one per actuator, for the signals of this tick. Actuators
    /// without a signal, and all when one has tripped, get zero.
    pub fn tick(&mut self, now_ns: u64, signals: &[Signal<N>], forces: &mut [[f64; N]]) {
        forces.fill([0.0; N]);
        for ((guard, signal), force) in self.guards.iter_mut().zip(signals).zip(&mut *forces) {
            *force = guard.tick(now_ns, signal);
        }
        if let Some((actuator, _)) = self.tripped() {
            self.trip(Trip::Companion { actuator });
            forces.fill([0.0; N]);
        }
    }
}
