//! Profile of an arm: its limits, its place and the grip on it.

use super::Setup;
use crate::joints::{in_reach, rotation};
use crate::profile::{Check, DigitAngles, WearerHand};
use serde::Deserialize;
use std::collections::BTreeMap;
use thenar_core::model::Side;
use thenar_core::{Pose, Vec3};
use thenar_touch::LoopProfile;
use thenar_touch::safety::Limits;
use thenar_track::ANGLES;

/// The profile that comes with the program.
pub const SHIPPED: &str = include_str!("../../profiles/force-device.toml");

/// The profile.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Name of the arm, one of `arms`.
    pub arm: String,
    /// The hand that holds the handle.
    pub hand: WearerHand,
    /// The arm's frame in the world.
    pub base: MountPose,
    /// The wrist in the frame of the handle.
    pub tool: MountPose,
    /// Grip on the handle.
    pub grip: Grip,
    /// All arms that are known.
    pub arms: BTreeMap<String, Arm>,
}

/// A frame.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MountPose {
    /// Position \[m\].
    pub position: [f64; 3],
    /// x y z w
    pub rotation: [f64; 4],
}

/// Joint angles with the button up and down \[degrees\].
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grip {
    /// Angles of the digits with the handle's button up.
    pub open: [DigitAngles; 5],
    /// Angles of the digits with the handle's button down.
    pub closed: [DigitAngles; 5],
}

/// Limits of an arm.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Arm {
    /// Name of the arm, for a person.
    pub title: String,
    /// Largest force \[N\].
    pub force_max: f64,
    /// Largest torque \[N m\]; 0 for arms that turn nothing.
    pub torque_max: f64,
    /// Largest stable stiffness \[N/m\].
    pub stiffness_max: f64,
    /// Viscous damping of the mechanism \[N s/m\].
    pub damping: f64,
    /// Coulomb friction of the arm \[N\].
    pub friction: f64,
    /// Position resolution \[m\].
    pub resolution: f64,
}

impl Arm {
    /// For the guards.
    pub fn limits(&self) -> Limits {
        Limits::rated(self.force_max)
    }

    /// Likewise; none for an arm that turns nothing.
    pub fn torque_limits(&self) -> Option<Limits> {
        Some(Limits::torque(self.torque_max)).filter(|_| self.torque_max > 0.0)
    }

    /// For the rules of stiffness: a millisecond between datagrams, and one on the way.
    pub fn loop_profile(&self) -> LoopProfile {
        LoopProfile {
            period: 1e-3,
            delay: 1e-3,
            damping: self.damping,
            friction: self.friction,
            resolution: self.resolution,
            rated_stiffness: self.stiffness_max,
        }
    }
}

impl Profile {
    /// The arm; `check` has found it.
    pub fn chosen(&self) -> Option<&Arm> {
        self.arms.get(&self.arm)
    }

    /// For the protocol. `None` for a profile that does not pass `check`.
    pub fn setup(&self) -> Option<Setup> {
        let angles = |digits: &[DigitAngles; 5]| -> [f64; ANGLES] {
            std::array::from_fn(|k| digits[k / 4][k % 4].to_radians())
        };
        Some(Setup {
            side: self.hand.side,
            pose_WD: self.base.pose().ok()?,
            pose_TH: self.tool.pose().ok()?,
            grips: [angles(&self.grip.open), angles(&self.grip.closed)],
            torque_max: self.chosen()?.torque_max,
        })
    }
}

impl MountPose {
    fn pose(&self) -> Result<Pose, String> {
        let position = Vec3::from(self.position);
        let turn = rotation(self.rotation);
        let turn = turn.map_err(|norm| format!("rotation has length {norm}, expected 1"))?;
        match in_reach(&position) {
            true => Ok(Pose::new(position, turn)),
            false => Err(format!("position {:?} is out of reach", self.position)),
        }
    }
}

impl Check for Profile {
    fn check(&self) -> Result<(), (String, String)> {
        self.hand.check()?;
        self.base.pose().map_err(|cause| ("base".to_owned(), cause))?;
        self.tool.pose().map_err(|cause| ("tool".to_owned(), cause))?;
        let grip = self.grip.open.iter().chain(&self.grip.closed).flatten();
        if let Some(odd) = grip.copied().find(|angle| !(-180.0..=180.0).contains(angle)) {
            return Err(("grip".into(), format!("an angle of {odd} degrees")));
        }
        let Some(arm) = self.chosen() else {
            let known: Vec<_> = self.arms.keys().map(String::as_str).collect();
            let cause = format!("`{}` is not an arm; there are {}", self.arm, known.join(", "));
            return Err(("arm".into(), cause));
        };
        let ranges = [
            ("force_max", arm.force_max, 0.01..=100.0),
            ("torque_max", arm.torque_max, 0.0..=10.0),
            ("stiffness_max", arm.stiffness_max, 1.0..=1e6),
            ("damping", arm.damping, 0.0..=100.0),
            ("friction", arm.friction, 0.0..=100.0),
            ("resolution", arm.resolution, 0.0..=0.01),
        ];
        for (name, value, range) in ranges {
            if !range.contains(&value) {
                let key = format!("arms.{}.{name}", self.arm);
                let cause = format!("is {value}, expected {} to {}", range.start(), range.end());
                return Err((key, cause));
            }
        }
        Ok(())
    }

    fn set_side(&mut self, side: Side) {
        self.hand.side = side;
    }
}
