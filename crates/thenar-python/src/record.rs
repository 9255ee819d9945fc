//! Recordings of worlds, being written.

use crate::error;
use pyo3::PyResult;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};
use thenar_output::Claim;
use thenar_record::{Build, Header, Recorder};
use thenar_scene::recording::{SessionWriter, TimeOf};
use thenar_scene::session::Witness;

/// A recording being written.
#[derive(Debug)]
pub struct ActiveRecording {
    recorder: Recorder,
    /// No other recording of this process takes its name meanwhile.
    _claim: Claim,
}

/// The recording's header. The build stays unnamed, as the program is Python's interpreter.
fn header() -> Header {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Header {
        program: concat!("thenar ", env!("CARGO_PKG_VERSION"), " for Python").into(),
        build: Build::default(),
        vectors: thenar_core::vector_instructions(),
        system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        created_unix_ns: u64::try_from(since_1970.as_nanos()).unwrap_or(0),
        simulated_time: true,
    }
}

impl ActiveRecording {
    /// Begins a file, which must not be there yet. `keyframes`: simulated time between keyframes
    /// \[s\], 0 for none.
    ///
    /// # Errors
    /// The file is there, or cannot be written; `keyframes` makes no sense.
    pub fn start(file: &Path, keyframes: f64) -> PyResult<(Self, Box<dyn Witness>)> {
        if !(keyframes >= 0.0 && keyframes.is_finite()) {
            return Err(error::RecordingError::new_err("keyframes must be 0 or more"));
        }
        let every = if keyframes == 0.0 { f64::INFINITY } else { keyframes };
        let claim = Claim::of(file).map_err(|e| error::RecordingError::new_err(e.to_string()))?;
        let recorder = Recorder::create(file, &header()).map_err(|e| error::record(&e))?;
        let of = TimeOf::Simulation;
        let writer = SessionWriter::new(recorder.session(), recorder.clock(), of, every);
        Ok((Self { recorder, _claim: claim }, Box::new(writer)))
    }

    /// Ends it; its size \[bytes\]. The file's name is free then: a file that is there is not
    /// written over.
    ///
    /// # Errors
    /// Not all of it could be written.
    pub fn finish(self) -> PyResult<u64> {
        Ok(self.recorder.finish().map_err(|e| error::record(&e))?.bytes)
    }
}
