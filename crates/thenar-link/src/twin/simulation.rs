//! Simulated devices by name, for people.

use super::{PtyTwin, Twin};
use crate::cyberglove::{ClassicTwin, ThirdTwin};
use crate::lucidgloves::LucidGlovesTwin;
use std::io;
use std::path::Path;

/// What can be simulated: name, and the driver that opens it.
pub const SIMULATIONS: [(&str, &str); 6] = [
    ("lucidgloves", "lucidgloves"),
    ("lucidgloves-splay", "lucidgloves"),
    ("lucidgloves-legacy", "lucidgloves"),
    ("cyberglove", "cyberglove"),
    ("cyberglove-18", "cyberglove"),
    ("cyberglove3", "cyberglove3"),
];

/// A simulated device that runs.
pub trait Simulation {
    /// The wearer moves: see [`Twin::set_curls`].
    fn set_curls(&self, curls: [f64; 5]);

    /// What the wearer feels: see [`Twin::felt`].
    fn felt(&self) -> [f64; 5];
}

impl<T: Twin + 'static> Simulation for PtyTwin<T> {
    fn set_curls(&self, curls: [f64; 5]) {
        self.twin().set_curls(curls);
    }

    fn felt(&self) -> [f64; 5] {
        self.twin().felt()
    }
}

/// Starts the simulated device of this name behind a terminal at `path`; `None` when there is none
/// of that name.
///
/// # Errors
/// As [`PtyTwin::start`].
pub fn simulate(name: &str, path: &Path) -> Option<io::Result<Box<dyn Simulation>>> {
    fn start<T: Twin + 'static>(twin: T, path: &Path) -> io::Result<Box<dyn Simulation>> {
        Ok(Box::new(PtyTwin::start(twin, path)?))
    }
    Some(match name {
        "lucidgloves" => start(LucidGlovesTwin::new(false, false), path),
        "lucidgloves-splay" => start(LucidGlovesTwin::new(false, true), path),
        "lucidgloves-legacy" => start(LucidGlovesTwin::new(true, false), path),
        "cyberglove" => start(ClassicTwin::new(22), path),
        "cyberglove-18" => start(ClassicTwin::new(18), path),
        "cyberglove3" => start(ThirdTwin::default(), path),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_listed_can_be_simulated_and_opened() {
        let known: Vec<_> = crate::drivers().iter().map(|driver| driver.name()).collect();
        for (name, driver) in SIMULATIONS {
            let file = format!("thenar-simulate-{name}-{}", std::process::id());
            let path = std::env::temp_dir().join(file);
            simulate(name, &path).unwrap().unwrap();
            assert!(known.contains(&driver), "{driver}");
            assert!(!path.is_symlink(), "nothing is left behind");
        }
        assert!(simulate("toaster", Path::new("x")).is_none());
    }
}
