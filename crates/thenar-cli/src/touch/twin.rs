//! A simulated glove that opens and closes by itself, behind a real pseudo-terminal.

use crate::error::CliError;
use std::path::PathBuf;

/// Name of the simulated glove as a device.
pub const SIMULATED: &str = "simulated";

#[cfg(unix)]
pub use unix::WavingGlove;

#[cfg(unix)]
mod unix {
    use super::{CliError, PathBuf};
    use std::f64::consts::TAU;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
    use std::thread::JoinHandle;
    use std::time::{Duration, Instant};
    use thenar_link::lucidgloves::LucidGlovesTwin;
    use thenar_link::twin::{PtyTwin, Twin};

    /// Opens and closes the hand once in so long \[s\].
    const PERIOD: f64 = 4.0;

    /// The twin, and the thread that moves its fingers.
    pub struct WavingGlove {
        path: PathBuf,
        stop: Arc<AtomicBool>,
        thread: Option<JoinHandle<()>>,
    }

    impl WavingGlove {
        /// Plugged in.
        ///
        /// # Errors
        /// The system gives no pseudo-terminal.
        pub fn start() -> Result<Self, CliError> {
            static COUNT: AtomicU32 = AtomicU32::new(0);
            let number = COUNT.fetch_add(1, Ordering::Relaxed);
            let name = format!("thenar-glove-{}-{number}", std::process::id());
            let path = std::env::temp_dir().join(name);
            let failed = |e: std::io::Error| CliError::Other(format!("no simulated glove: {e}"));
            let twin = PtyTwin::start(LucidGlovesTwin::new(false, false), &path).map_err(failed)?;
            let stop = Arc::new(AtomicBool::new(false));
            let told = stop.clone();
            let wave = move || {
                let begun = Instant::now();
                while !told.load(Ordering::Relaxed) {
                    let phase = begun.elapsed().as_secs_f64() / PERIOD * TAU;
                    twin.twin().set_curls([0.4 * (1.0 - phase.cos()); 5]);
                    std::thread::sleep(Duration::from_millis(2));
                }
            };
            let thread = std::thread::Builder::new().name("glove".into()).spawn(wave);
            Ok(Self { path, stop, thread: Some(thread.map_err(failed)?) })
        }

        /// The device that a driver opens.
        pub fn address(&self) -> String {
            format!("lucidgloves:{}", self.path.display())
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
}

/// Where there are no pseudo-terminals.
#[cfg(not(unix))]
pub struct WavingGlove;

#[cfg(not(unix))]
impl WavingGlove {
    /// Refuses: there is no pseudo-terminal here.
    ///
    /// # Errors
    /// Always.
    pub fn start() -> Result<Self, CliError> {
        Err(CliError::Input("this system has no pseudo-terminals for a simulated glove".into()))
    }

    /// No address.
    pub fn address(&self) -> String {
        PathBuf::new().display().to_string()
    }
}
