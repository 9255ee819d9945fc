//! One case, for any engine.

use serde::Deserialize;
use std::collections::BTreeMap;

/// x, y, z \[m\], then a quaternion x, y, z, w.
pub type PoseRow = [f64; 7];

/// What to simulate and for how long.
#[derive(Debug, Deserialize)]
pub struct Job {
    pub time_step: f64,
    pub steps: usize,
    /// A frame is recorded after every so many steps, and after the last.
    pub record_every: usize,
    pub gravity: [f64; 3],
    pub young: f64,
    pub poisson: f64,
    pub density: f64,
    pub mass_damping: f64,
    pub stiffness_damping: f64,
    pub nodes: Vec<[f64; 3]>,
    pub tets: Vec<[u32; 4]>,
    pub node_masses: Vec<f64>,
    pub boundary: Vec<[u32; 3]>,
    pub fixed: Vec<u32>,
    pub node_forces: Vec<[f64; 3]>,
    pub ties: Vec<Tie>,
    pub tie_damping_time: f64,
    pub bones: Vec<Bone>,
    /// Bones follow `targets`; otherwise they move freely and the first one is driven.
    pub kinematic: bool,
    pub joints: Vec<Joint>,
    pub drive: Option<Drive>,
    pub targets: Vec<Vec<PoseRow>>,
    pub table: Option<Table>,
    /// Settings that one engine understands.
    pub settings: BTreeMap<String, serde_json::Value>,
}

/// A spring between a node and its place in a bone's frame.
#[derive(Debug, Deserialize)]
pub struct Tie {
    pub node: u32,
    pub bone: u32,
    pub stiffness: f64,
}

#[derive(Debug, Deserialize)]
pub struct Bone {
    pub pose: PoseRow,
    pub mass: f64,
    pub inertia: [[f64; 3]; 3],
}

#[derive(Debug, Deserialize)]
pub struct Joint {
    pub kind: Kind,
    pub parent: u32,
    pub child: u32,
    pub pose_in_parent: PoseRow,
    pub pose_in_child: PoseRow,
    pub axes: Vec<Axis>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    Hinge,
    Universal,
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Axis {
    pub stiffness: f64,
    pub damping: f64,
    pub rest_angle: f64,
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Drive {
    pub stiffness: f64,
    pub damping: f64,
    pub angular_stiffness: f64,
    pub angular_damping: f64,
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Table {
    pub height: f64,
    pub friction: f64,
}

impl Job {
    /// Reads a job; the message names the file.
    pub fn read(path: &str) -> Result<Self, String> {
        let bytes = std::fs::read(path).map_err(|e| format!("{path}: {e}"))?;
        serde_json::from_slice(&bytes).map_err(|e| format!("{path}: {e}"))
    }

    /// A number among the settings, or its usual value.
    pub fn number(&self, key: &str, usual: f64) -> f64 {
        self.settings.get(key).and_then(serde_json::Value::as_f64).unwrap_or(usual)
    }

    /// A word among the settings, or its usual value.
    pub fn word<'a>(&'a self, key: &str, usual: &'a str) -> &'a str {
        self.settings.get(key).and_then(serde_json::Value::as_str).unwrap_or(usual)
    }

    /// Whether a frame is due after step `i`.
    pub fn recorded(&self, i: usize) -> bool {
        (i + 1) % self.record_every == 0 || i + 1 == self.steps
    }

    /// Target `k` at the end of step `i` and at its beginning.
    pub fn targets(&self, i: usize, k: usize) -> (PoseRow, PoseRow) {
        let before = if i == 0 { self.bones[k].pose } else { self.targets[i - 1][k] };
        (self.targets[i][k], before)
    }
}
