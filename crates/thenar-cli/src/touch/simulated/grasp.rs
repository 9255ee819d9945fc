//! The paper's own device, simulated: a CyberGlove that closes and opens where bread and car are
//! held, and the tendons of a CyberGrasp on it, behind its bridge.

use super::glove::WavingGlove;
use crate::error::CliError;
use std::net::TcpListener;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use thenar_link::cyberglove::ClassicTwin;
use thenar_link::cybergrasp::{SimulatedUnit, serve_unit};

/// The wrist where `bread-grasp`, `bread-squeeze` and `car-grasp` close their hands, turned by 30
/// degrees about the vertical as theirs are.
const WRIST: &str = "\
[wrist]
position = [0.068, 0.098, 0.071]
rotation = [0.0, 0.258819045, 0.0, 0.965925826]
";
/// From fingers beside the object to fingers that are well into it.
const ABOUT_OBJECT: [[f64; 2]; 5] =
    [[0.1, 0.9], [0.25, 0.85], [0.25, 0.85], [0.25, 0.85], [0.25, 0.85]];

/// Glove, tendons and their bridge.
pub struct WornGrasp {
    glove: WavingGlove,
    profile: PathBuf,
    port: u16,
    stop: Arc<AtomicBool>,
    bridge: Option<JoinHandle<()>>,
}

impl WornGrasp {
    /// Worn by nobody, on its own.
    ///
    /// # Errors
    /// The system gives no pseudo-terminal or no port.
    pub fn start() -> Result<Self, CliError> {
        let failed = |e: std::io::Error| CliError::Other(format!("no simulated CyberGrasp: {e}"));
        let glove = WavingGlove::start(ClassicTwin::new(22), ABOUT_OBJECT)?;
        let profile = glove.path().with_extension("toml");
        std::fs::write(&profile, WRIST).map_err(failed)?;
        let listener = TcpListener::bind("127.0.0.1:0").map_err(failed)?;
        let port = listener.local_addr().map_err(failed)?.port();
        let stop = Arc::new(AtomicBool::new(false));
        let told = stop.clone();
        let serve = move || {
            // It ends when the listener fails: then the driver reports that nobody is there.
            let _ = serve_unit(&listener, &mut SimulatedUnit::default(), &told);
        };
        let bridge = std::thread::Builder::new().name("bridge".into()).spawn(serve);
        Ok(Self { glove, profile, port, stop, bridge: Some(bridge.map_err(failed)?) })
    }

    /// Addresses that drivers open: the glove, then the tendons, with these options of a person.
    pub fn addresses(&self, options: &str) -> Vec<String> {
        let (glove, profile) = (self.glove.path().display(), self.profile.display());
        let side = if options.is_empty() { "?side=right" } else { options };
        vec![
            format!("cyberglove:{glove}?profile={profile}"),
            format!("cybergrasp:127.0.0.1:{}{side}", self.port),
        ]
    }
}

impl Drop for WornGrasp {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(bridge) = self.bridge.take() {
            let _ = bridge.join();
        }
        let _ = std::fs::remove_file(&self.profile);
    }
}
