//! Simulated devices by name, for people.

use super::network;
#[cfg(unix)]
use super::{PtyTwin, Twin};
#[cfg(unix)]
use crate::cyberglove::{ClassicTwin, ThirdTwin};
#[cfg(unix)]
use crate::lucidgloves::LucidGlovesTwin;
use std::io;

/// A device that can be simulated.
pub struct SimulatedDevice {
    /// Name of the simulation.
    pub name: &'static str,
    /// The driver that opens it.
    pub driver: &'static str,
    /// Default place on the network, replaced by another `HOST:PORT`; `None` for a device behind a
    /// terminal, whose place is a path.
    pub place: Option<&'static str>,
    start: fn(&str) -> io::Result<Box<dyn Simulation>>,
}

impl SimulatedDevice {
    /// Starts it.
    ///
    /// # Errors
    /// Its place is taken, or the system has none such.
    pub fn start(&self, place: &str) -> io::Result<Box<dyn Simulation>> {
        (self.start)(place)
    }
}

/// All of them. Those behind terminals need a system that has pseudo-terminals.
pub const SIMULATIONS: &[SimulatedDevice] = &[
    #[cfg(unix)]
    glove("lucidgloves", "lucidgloves", |at| pty(LucidGlovesTwin::new(false, false), at)),
    #[cfg(unix)]
    glove("lucidgloves-splay", "lucidgloves", |at| pty(LucidGlovesTwin::new(false, true), at)),
    #[cfg(unix)]
    glove("lucidgloves-legacy", "lucidgloves", |at| pty(LucidGlovesTwin::new(true, false), at)),
    #[cfg(unix)]
    glove("cyberglove", "cyberglove", |at| pty(ClassicTwin::new(22), at)),
    #[cfg(unix)]
    glove("cyberglove-18", "cyberglove", |at| pty(ClassicTwin::new(18), at)),
    #[cfg(unix)]
    glove("cyberglove3", "cyberglove3", |at| pty(ThirdTwin::default(), at)),
    networked("cybergrasp", "cybergrasp", "127.0.0.1:7070", network::tendons),
    networked("force-device", "force-device", "127.0.0.1:9020", network::arm),
    networked("bhaptics", "bhaptics", "127.0.0.1:15881", network::player),
    networked("hts", "hts", "127.0.0.1:9000", |at| network::tracker(at, true)),
    networked("poses", "poses", "127.0.0.1:9010", |at| network::tracker(at, false)),
];

#[cfg(unix)]
const fn glove(
    name: &'static str,
    driver: &'static str,
    start: fn(&str) -> io::Result<Box<dyn Simulation>>,
) -> SimulatedDevice {
    SimulatedDevice { name, driver, place: None, start }
}

const fn networked(
    name: &'static str,
    driver: &'static str,
    place: &'static str,
    start: fn(&str) -> io::Result<Box<dyn Simulation>>,
) -> SimulatedDevice {
    SimulatedDevice { name, driver, place: Some(place), start }
}

/// A simulated device that runs until it is dropped.
pub trait Simulation {
    /// The wearer moves: each finger's curl, 0 open to 1 closed, thumb first. What has no fingers
    /// moves in its own way, or not.
    fn set_curls(&self, curls: [f64; 5]);

    /// Sensation of the wearer, for a person.
    fn felt(&self) -> String;
}

/// Thumb first.
pub(super) fn per_finger(felt: [String; 5]) -> String {
    let [t, i, m, r, l] = felt;
    format!("thumb {t}, index {i}, middle {m}, ring {r}, little {l}")
}

#[cfg(unix)]
fn pty<T: Twin + 'static>(twin: T, path: &str) -> io::Result<Box<dyn Simulation>> {
    Ok(Box::new(PtyTwin::start(twin, std::path::Path::new(path))?))
}

#[cfg(unix)]
impl<T: Twin + 'static> Simulation for PtyTwin<T> {
    fn set_curls(&self, curls: [f64; 5]) {
        self.twin().set_curls(curls);
    }

    fn felt(&self) -> String {
        per_finger(self.twin().felt().map(|felt| format!("{}%", (felt * 100.0).round())))
    }
}

#[cfg(test)]
mod tests;
