//! A recorded motion as a person asks for it.

use crate::FitError;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};
use std::path::PathBuf;
use thenar_core::model::Side;
use thenar_core::{Pose, Quat, Vec3};

/// A recording that drives a hand, and how.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedDesc {
    /// The recording.
    pub file: PathBuf,
    /// Side of the recorded hand; the side of the simulated one if absent. The other side is
    /// mirrored.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hand: Option<Side>,
    /// Part of the recording to skip \[s\].
    #[serde(default)]
    pub start_s: f64,
    /// Position of the recording's origin in the world \[m\].
    #[serde(default)]
    pub position: [f64; 3],
    /// Turn of the recording about the vertical (+y) \[degrees\].
    #[serde(default)]
    pub heading_deg: f64,
    /// Natural frequency of the filter \[Hz\]; lower is smoother and later. Normal: 8.
    #[serde(default = "filter_hz")]
    pub filter_hz: f64,
    /// A longer gap between samples is a loss of tracking \[s\].
    #[serde(default = "loss_s")]
    pub loss_s: f64,
    /// Time in which the hand gets back its full speed after a loss \[s\].
    #[serde(default = "reacquire_s")]
    pub reacquire_s: f64,
    /// Fastest wrist \[m/s\].
    #[serde(default = "speed_max")]
    pub speed_max: f64,
    /// Fastest turn of the wrist \[degrees/s\].
    #[serde(default = "spin_max_deg")]
    pub spin_max_deg: f64,
    /// Fastest joint \[degrees/s\].
    #[serde(default = "joint_rate_max_deg")]
    pub joint_rate_max_deg: f64,
}

fn filter_hz() -> f64 {
    8.0
}
fn loss_s() -> f64 {
    0.1
}
fn reacquire_s() -> f64 {
    0.5
}
fn speed_max() -> f64 {
    3.0
}
fn spin_max_deg() -> f64 {
    1000.0
}
fn joint_rate_max_deg() -> f64 {
    1500.0
}

/// A checked description, in SI units.
#[derive(Clone, Debug)]
pub struct Settings {
    pub placement: Pose,
    pub omega: f64,
    pub loss: f64,
    pub reacquire: f64,
    pub speed_max: f64,
    pub spin_max: f64,
    pub joint_rate_max: f64,
}

impl RecordedDesc {
    /// With usual settings.
    pub fn of_file(file: impl Into<PathBuf>) -> Self {
        Self {
            file: file.into(),
            hand: None,
            start_s: 0.0,
            position: [0.0; 3],
            heading_deg: 0.0,
            filter_hz: filter_hz(),
            loss_s: loss_s(),
            reacquire_s: reacquire_s(),
            speed_max: speed_max(),
            spin_max_deg: spin_max_deg(),
            joint_rate_max_deg: joint_rate_max_deg(),
        }
    }

    /// Checks the description.
    pub(super) fn settings(&self) -> Result<Settings, FitError> {
        check("start_s", self.start_s, 0.0, 1e7, "between 0 and 1e7 s")?;
        check("heading_deg", self.heading_deg, -360.0, 360.0, "between -360° and 360°")?;
        for x in self.position {
            check("position", x, -1e3, 1e3, "within 1 km")?;
        }
        check("filter_hz", self.filter_hz, 0.5, 100.0, "between 0.5 and 100 Hz")?;
        check("loss_s", self.loss_s, 0.02, 10.0, "between 0.02 and 10 s")?;
        check("reacquire_s", self.reacquire_s, 0.01, 10.0, "between 0.01 and 10 s")?;
        check("speed_max", self.speed_max, 0.01, 20.0, "between 0.01 and 20 m/s")?;
        let omega = TAU * self.filter_hz;
        // The filter lags by 2/ω at most, and must not lag by half a turn.
        let spin_max = self.spin_max_deg.to_radians().min(0.4 * PI * omega);
        check("spin_max_deg", self.spin_max_deg, 1.0, 1e4, "between 1 and 10000 °/s")?;
        let rate = self.joint_rate_max_deg;
        check("joint_rate_max_deg", rate, 1.0, 1e4, "between 1 and 10000 °/s")?;
        let heading = Quat::from_scaled_axis(Vec3::y() * self.heading_deg.to_radians());
        Ok(Settings {
            placement: Pose::new(Vec3::from(self.position), heading),
            omega,
            loss: self.loss_s,
            reacquire: self.reacquire_s,
            speed_max: self.speed_max,
            spin_max,
            joint_rate_max: rate.to_radians(),
        })
    }
}

fn check(
    key: &'static str,
    value: f64,
    min: f64,
    max: f64,
    expected: &'static str,
) -> Result<(), FitError> {
    match (min..=max).contains(&value) {
        true => Ok(()),
        false => Err(FitError::Setting { key, expected, value }),
    }
}
