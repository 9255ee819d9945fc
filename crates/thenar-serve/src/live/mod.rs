//! The simulation's thread: steps a scene in real time, takes what clients send and sends them
//! what happens.
//!
//! It never waits for a client, and never for a scene to be made ready: that happens on another
//! thread while the old scene goes on. It sleeps between steps. Where a step costs more than it
//! may, simulated time goes slower than real time and every snapshot says so. Nobody watching, it
//! rests after five seconds, and begins anew when somebody comes.

mod adopt;
mod builder;
mod commands;
pub(crate) mod control;
mod haptics;
mod pacer;
pub(crate) mod play;
pub(crate) mod publish;
mod run;
mod source;
pub(crate) mod status;

pub use haptics::Haptics;
pub use source::{LiveError, SceneSource};

use crate::dead_man::DeadMan;
use crate::hub::{Hub, pair_with};
use builder::Builder;
use run::Loop;
use source::Catalogue;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use thenar_scene::session::{Session, StartOverlap, Witness};

/// Is shown the session after every step; must not take long.
pub type StepCallback = Box<dyn FnMut(&Session) + Send>;

/// Options for serving.
#[derive(Default)]
pub struct Options {
    /// Set in the first scene, `key=value` as of `thenar run --set`.
    pub overrides: Vec<String>,
    /// Sees every step.
    pub watcher: Option<StepCallback>,
    /// Devices to feel it with.
    pub haptics: Option<Haptics>,
    /// Receives all that enters the session, and every scene that takes its place.
    pub witness: Option<Box<dyn Witness>>,
}

/// A running simulation; it ends when this is dropped.
#[derive(Debug)]
pub struct Live {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    reporter: Option<JoinHandle<()>>,
    start_overlaps: Vec<StartOverlap>,
    warnings: Vec<String>,
}

impl Live {
    /// Warnings about the first scene, a sentence each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Overlaps of bodies where the first scene begins.
    pub fn start_overlaps(&self) -> &[StartOverlap] {
        &self.start_overlaps
    }

    /// Makes the scene ready and starts the simulation's thread.
    ///
    /// # Errors
    /// There is no such scene, something in it is wrong, or no thread can be started.
    pub fn start(source: &SceneSource, options: Options) -> Result<(Self, Hub), LiveError> {
        let (catalogue, spec) = Catalogue::new(source, &options.overrides)?;
        let ready = catalogue.make(&spec)?;
        let (hub, endpoint) = pair_with(catalogue.names());
        let devices = options.haptics.as_ref().map(|haptics| DeadMan::new(haptics.remote.clone()));
        let hub = hub.with_devices(devices.clone());
        let stop = Arc::new(AtomicBool::new(false));
        let told = stop.clone();
        let start_overlaps = ready.session.start_overlaps().to_vec();
        let warnings = ready.session.warnings();
        let mut new = Self { stop, thread: None, reporter: None, start_overlaps, warnings };
        if let Some(devices) = devices.clone() {
            let (touch, stop) = (endpoint.touch.clone(), new.stop.clone());
            let report = move || haptics::report(&devices, &touch, &stop);
            let named = std::thread::Builder::new().name("touch".into());
            new.reporter = Some(named.spawn(report)?);
        }
        let builder = Builder::new(catalogue);
        let Options { watcher, haptics, witness, .. } = options;
        let running = Loop::new(endpoint, builder, ready, watcher, haptics, devices, witness);
        let named = std::thread::Builder::new().name("simulation".into());
        new.thread = Some(named.spawn(move || running.run(&told))?);
        Ok((new, hub))
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.thread.take().into_iter().chain(self.reporter.take()) {
            // It catches its own panics; there is nothing to learn from its end.
            let _ = thread.join();
        }
    }
}
