//! What an engine made of a job.

use crate::job::PoseRow;
use serde::Serialize;

/// Places after one step.
#[derive(Debug, Serialize)]
pub struct Frame {
    pub step: usize,
    pub nodes: Vec<[f64; 3]>,
    pub bones: Vec<PoseRow>,
}

/// Measurements, step by step.
#[derive(Debug, Default, Serialize)]
pub struct Outcome {
    pub engine: String,
    /// Processor time of each step \[ms\]: one thread, and nothing of what else the machine does.
    pub step_ms: Vec<f64>,
    /// Force of the hand on the table after each step \[N\], as the engine reports it.
    pub table_force: Vec<[f64; 3]>,
    /// Points that the engine had in contact.
    pub contacts: Vec<u32>,
    /// Kinetic energy of the flesh after each step \[J\].
    pub kinetic: Vec<f64>,
    pub frames: Vec<Frame>,
    /// Why the engine stopped early, if it did.
    pub failure: Option<String>,
}

impl Outcome {
    /// Writes it; the message names the file.
    pub fn write(&self, path: &str) -> Result<(), String> {
        let bytes = serde_json::to_vec(self).map_err(|e| format!("{path}: {e}"))?;
        std::fs::write(path, bytes).map_err(|e| format!("{path}: {e}"))
    }

    /// Notes a failure when the flesh moves faster than anything here can.
    pub fn watch(&mut self, step: usize, kinetic: f64, mass: f64) -> bool {
        self.kinetic.push(kinetic);
        // A mean speed of 20 m/s, hundreds of times that of the hand.
        let burst = !kinetic.is_finite() || kinetic > 0.5 * mass * 400.0;
        if burst {
            self.failure = Some(format!("diverged at step {}", step + 1));
        }
        burst
    }
}
