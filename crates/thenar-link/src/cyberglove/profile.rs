//! Profile of one CyberGlove and its wearer.

use super::sensors::{self, NAMES, SENSORS};
use crate::profile::{Check, Link, Tracking, WearerHand, Wrist};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use thenar_core::Pose;
use thenar_core::model::Side;
use thenar_track::ANGLES;

/// Profile shipped for CyberGlove I and II.
pub const SHIPPED: &str = include_str!("../../profiles/cyberglove.toml");
/// For CyberGlove III.
pub const SHIPPED_3: &str = include_str!("../../profiles/cyberglove3.toml");

/// The file's content.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// The hand that wears the glove.
    pub hand: WearerHand,
    /// Pose of the wrist, or of the forearm if the glove's own wrist sensors turn it.
    pub wrist: Wrist,
    /// The cable.
    pub link: Link,
    /// Timing of samples.
    pub tracking: Tracking,
    /// The glove.
    pub glove: Glove,
    /// Calibration by name of sensor.
    pub sensors: BTreeMap<String, Sensor>,
}

/// The table `[glove]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Glove {
    /// 18 or 22.
    pub sensors: usize,
    /// Raw value that counts as 1.
    pub full_scale: f64,
    /// True if the glove's wrist sensors turn the hand.
    pub wrist_turns: bool,
}

/// `[sensors.NAME]`: angle = gain (value - offset).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Sensor {
    /// Degrees from value 0 to value 1.
    pub gain: f64,
    /// Value at zero degrees.
    pub offset: f64,
}

impl Profile {
    /// Angles of all 22 sensors \[degrees\] for the values that the glove sent.
    pub fn degrees(&self, values: &[f64]) -> [f64; SENSORS] {
        let mut degrees = [0.0; SENSORS];
        for (k, value) in values.iter().enumerate() {
            let Some(place) = sensors::place(k, values.len()) else { continue };
            if let Some(sensor) = self.sensors.get(NAMES[place]) {
                degrees[place] = sensor.gain * (value - sensor.offset);
            }
        }
        if values.len() < SENSORS {
            sensors::complete(&mut degrees);
        }
        degrees
    }

    /// Wrist and hand for raw values.
    pub fn pose(&self, values: &[f64]) -> (Pose, [f64; ANGLES]) {
        let degrees = self.degrees(values);
        let forearm = self.wrist.pose();
        let turns = self.glove.wrist_turns;
        let wrist = if turns { sensors::wrist(&forearm, &degrees) } else { forearm };
        (wrist, sensors::hand(&degrees))
    }
}

impl Check for Profile {
    fn check(&self) -> Result<(), (String, String)> {
        self.hand.check()?;
        self.wrist.check()?;
        self.link.check()?;
        self.tracking.check()?;
        if ![18, SENSORS].contains(&self.glove.sensors) {
            let cause = format!("is {}, expected 18 or 22", self.glove.sensors);
            return Err(("glove.sensors".into(), cause));
        }
        if !(1.0..=65_535.0).contains(&self.glove.full_scale) {
            let cause = format!("is {}, expected 1 to 65535", self.glove.full_scale);
            return Err(("glove.full_scale".into(), cause));
        }
        for (name, sensor) in &self.sensors {
            if !NAMES.contains(&name.as_str()) {
                let cause = format!("is not a sensor; there are {}", NAMES.join(", "));
                return Err((format!("sensors.{name}"), cause));
            }
            if !(sensor.gain.abs() <= 1000.0 && sensor.offset.abs() <= 10.0) {
                let cause = "expected a gain within 1000 degrees and an offset within 10";
                return Err((format!("sensors.{name}"), cause.into()));
            }
        }
        Ok(())
    }

    fn set_side(&mut self, side: Side) {
        self.hand.side = side;
    }
}
