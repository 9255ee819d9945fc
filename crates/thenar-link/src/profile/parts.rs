//! Parts that the profiles of several devices share.

use crate::joints::in_reach;
use serde::{Deserialize, Serialize};
use thenar_core::model::Side;
use thenar_core::{Pose, Quat, Vec3};
use thenar_touch::safety::Limits;
use thenar_touch::{LoopProfile, TrackerTiming};

type Refusal = (String, String);

fn refuse<T>(key: &str, cause: impl Into<String>) -> Result<T, Refusal> {
    Err((key.into(), cause.into()))
}

/// `[hand]`: who wears it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct WearerHand {
    /// Side of the hand.
    pub side: Side,
    /// Length of the hand, wrist to middle fingertip \[m\].
    pub length: f64,
}

impl WearerHand {
    /// Refuses what is no hand.
    pub fn check(&self) -> Result<(), Refusal> {
        if (0.08..=0.30).contains(&self.length) {
            return Ok(());
        }
        refuse("hand.length", format!("{} m is not a hand's, expected 0.08 to 0.30", self.length))
    }
}

/// `[wrist]`: where the hand is when the device itself cannot tell.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Wrist {
    /// The wrist in the world, or in the frame of its tracker \[m\].
    pub position: [f64; 3],
    /// Rotation of the wrist in that frame, x y z w.
    pub rotation: [f64; 4],
    /// Address of a device that tracks the wrist; empty for a wrist that stays where it is.
    pub tracker: String,
}

impl Wrist {
    /// Refuses what is no pose.
    pub fn check(&self) -> Result<(), Refusal> {
        // No session takes a hand farther away.
        if !in_reach(&Vec3::from(self.position)) {
            return refuse("wrist.position", "expected three numbers within 10 m of the origin");
        }
        let norm = self.rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(0.99..=1.01).contains(&norm) {
            return refuse("wrist.rotation", format!("has length {norm}, expected 1"));
        }
        Ok(())
    }

    /// The pose.
    pub fn pose(&self) -> Pose {
        let [x, y, z, w] = self.rotation;
        let rotation = Quat::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
        Pose::new(Vec3::from(self.position), rotation)
    }
}

/// `[link]`: the cable.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Link {
    /// Bits per second.
    pub baud: u32,
}

impl Link {
    /// Refuses what no port does.
    pub fn check(&self) -> Result<(), Refusal> {
        if (1200..=4_000_000).contains(&self.baud) {
            return Ok(());
        }
        refuse("link.baud", format!("{} bit/s, expected 1200 to 4000000", self.baud))
    }
}

/// `[tracking]`: when its samples come, and how they scatter.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Tracking {
    /// Samples per second \[Hz\].
    pub rate: f64,
    /// From a motion to the arrival of its sample \[s\].
    pub latency: f64,
    /// Standard deviation of a fingertip that stands still \[m\].
    pub noise: f64,
}

impl Tracking {
    /// Refuses what no tracker does.
    pub fn check(&self) -> Result<(), Refusal> {
        let ranges = [
            ("rate", self.rate, 5.0..=20_000.0, "Hz"),
            ("latency", self.latency, 0.0..=0.5, "s"),
            ("noise", self.noise, 0.0..=0.1, "m"),
        ];
        for (key, value, range, unit) in ranges {
            if !range.contains(&value) {
                let (least, most) = (range.start(), range.end());
                let cause = format!("is {value:?} {unit}, expected {least} to {most}");
                return refuse(&format!("tracking.{key}"), cause);
            }
        }
        Ok(())
    }

    /// For the loop.
    pub fn timing(&self) -> TrackerTiming {
        TrackerTiming { rate: self.rate, latency: self.latency, noise: self.noise }
    }
}

/// `[display]`: what its actuators may do and what bounds a coupling to them.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Display {
    /// Rated force per finger or axis \[N\].
    pub rated: f64,
    /// Part of it that the user allows, 0 to 1.
    pub user_fraction: f64,
    /// Largest change per second \[N/s\].
    pub slew: f64,
    /// Largest change per tick \[N\].
    pub step_max: f64,
    /// A faster finger releases all \[m/s\].
    pub speed_max: f64,
    /// Silence of the device that releases all \[s\].
    pub device_silence_max: f64,
    /// Time in which force comes up after arming \[s\].
    pub ramp: f64,
    /// Smallest step of its command \[N\]; 0 for none.
    pub quantum: f64,
    /// Commands that it takes per second \[Hz\].
    pub rate: f64,
    /// Delay of link and actuator \[s\].
    pub delay: f64,
    /// Viscous damping of the mechanism \[N s/m\].
    pub damping: f64,
    /// Coulomb friction of the device \[N\].
    pub friction: f64,
    /// Position resolution \[m\].
    pub resolution: f64,
    /// Stiffness that its maker rates \[N/m\].
    pub stiffness_max: f64,
}

impl Display {
    /// Refuses what is no actuator.
    pub fn check(&self) -> Result<(), Refusal> {
        // The ranges of mechanisms are those of arms, see `force_device`; beyond a second nothing
        // is felt.
        let ranges = [
            ("delay", self.delay, 0.0..=1.0),
            ("damping", self.damping, 0.0..=100.0),
            ("friction", self.friction, 0.0..=100.0),
            ("resolution", self.resolution, 0.0..=0.01),
        ];
        for (key, value, range) in ranges {
            if !range.contains(&value) {
                let cause = format!("is {value:?}, expected {} to {}", range.start(), range.end());
                return refuse(&format!("display.{key}"), cause);
            }
        }
        if !(1.0..=20_000.0).contains(&self.rate) {
            return refuse("display.rate", format!("is {} Hz, expected 1 to 20000", self.rate));
        }
        if !(self.stiffness_max > 0.0 && self.stiffness_max <= 1e6) {
            let cause =
                format!("is {:?} N/m, expected more than 0, at most 1e6", self.stiffness_max);
            return refuse("display.stiffness_max", cause);
        }
        if !(self.rated > 0.0 && self.rated <= 100.0) {
            return refuse("display.rated", format!("is {} N, expected 0 to 100", self.rated));
        }
        let limits = self.limits(true);
        limits.check().map_err(|e| (format!("display.{}", e.name), e.to_string()))
    }

    /// For the guards.
    pub fn limits(&self, unilateral: bool) -> Limits {
        Limits {
            user_fraction: self.user_fraction,
            unilateral,
            slew: self.slew,
            step_max: self.step_max,
            speed_max: self.speed_max,
            device_silence_max: self.device_silence_max,
            ramp: self.ramp,
            quantum: self.quantum,
            ..Limits::rated(self.rated)
        }
    }

    /// For the rules of stiffness.
    pub fn loop_profile(&self) -> LoopProfile {
        LoopProfile {
            period: 1.0 / self.rate,
            delay: self.delay,
            damping: self.damping,
            friction: self.friction,
            resolution: self.resolution,
            rated_stiffness: self.stiffness_max,
        }
    }
}

/// Angles of one digit in the order of
/// [`hand_angles`](thenar_track::hand_angles): flexion and spread of its base joint, then
/// flexion of its second and third joint.
pub type DigitAngles = [f64; 4];
