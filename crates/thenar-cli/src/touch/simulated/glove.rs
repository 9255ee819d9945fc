//! A simulated glove that opens and closes by itself, behind a pseudo-terminal.

use crate::error::CliError;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use thenar_link::twin::{PtyTwin, Twin};

/// Time in which the hand opens and closes once \[s\].
const PERIOD: f64 = 4.0;
/// Curls between which each finger goes: 0 open, 1 closed.
pub const OPEN_TO_CLOSED: [[f64; 2]; 5] = [[0.0, 0.8]; 5];

/// The twin, and the thread that moves its fingers.
pub struct WavingGlove {
    path: PathBuf,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl WavingGlove {
    /// Plugged in; each finger goes between these curls.
    ///
    /// # Errors
    /// The system gives no pseudo-terminal.
    pub fn start<T: Twin + 'static>(twin: T, between: [[f64; 2]; 5]) -> Result<Self, CliError> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("thenar-glove-{}-{number}", std::process::id());
        let path = std::env::temp_dir().join(name);
        let failed = |e: std::io::Error| CliError::Other(format!("no simulated glove: {e}"));
        let twin = PtyTwin::start(twin, &path).map_err(failed)?;
        let stop = Arc::new(AtomicBool::new(false));
        let told = stop.clone();
        let wave = move || {
            let begun = Instant::now();
            while !told.load(Ordering::Relaxed) {
                let phase = begun.elapsed().as_secs_f64() / PERIOD * TAU;
                let part = 0.5 * (1.0 - phase.cos());
                twin.twin().set_curls(between.map(|[open, closed]| open + part * (closed - open)));
                std::thread::sleep(Duration::from_millis(2));
            }
        };
        let thread = std::thread::Builder::new().name("glove".into()).spawn(wave);
        Ok(Self { path, stop, thread: Some(thread.map_err(failed)?) })
    }

    /// Path at which a driver finds it.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for WavingGlove {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
