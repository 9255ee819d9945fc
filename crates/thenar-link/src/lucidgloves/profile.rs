//! Profile of one LucidGlove.

use super::encoding::State;
use crate::profile::{Check, DigitAngles, Display, Link, Tracking, WearerHand, Wrist};
use serde::{Deserialize, Serialize};
use thenar_core::model::Side;
use thenar_touch::servo_stop;
use thenar_track::ANGLES;

/// Shipped profile.
pub const SHIPPED: &str = include_str!("../../profiles/lucidgloves.toml");

/// The file's content.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// The hand that wears the glove.
    pub hand: WearerHand,
    /// Pose of the wrist.
    pub wrist: Wrist,
    /// The cable.
    pub link: Link,
    /// Timing of samples.
    pub tracking: Tracking,
    /// All sensors.
    pub sensors: Sensors,
    /// Calibration of the thumb.
    pub thumb: Digit,
    /// Index finger.
    pub index: Digit,
    /// Middle finger.
    pub middle: Digit,
    /// Ring finger.
    pub ring: Digit,
    /// Little finger.
    pub little: Digit,
    /// The servos.
    pub display: Display,
}

/// The table `[sensors]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Sensors {
    /// Largest value that the glove's converter gives.
    pub analog_max: u16,
    /// Spread at the end of a splay sensor's range \[degrees\].
    pub splay_deg: f64,
}

/// One of the tables `[thumb]` to `[little]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Digit {
    /// Sensor value, 0 to 1, of the open and of the closed finger.
    pub raw: [f64; 2],
    /// Angles of the open finger \[degrees\].
    pub open: DigitAngles,
    /// Angles of the closed finger \[degrees\].
    pub closed: DigitAngles,
    /// Sense in which splay spreads: 1, -1, or 0 for not at all.
    pub splay: f64,
}

impl Profile {
    /// Thumb first.
    pub fn digits(&self) -> [&Digit; 5] {
        [&self.thumb, &self.index, &self.middle, &self.ring, &self.little]
    }

    /// Servo positions that stop fingers at these curls of the wearer, thumb first. A servo's 0 to
    /// 1000 cover all of its finger's travel, of which the wearer uses the range `raw`.
    pub fn stops(&self, curls: [Option<f64>; 5]) -> [u16; 5] {
        let digits = self.digits();
        std::array::from_fn(|d| {
            let [open, closed] = digits[d].raw;
            // Sensors may be mounted the other way round; servos are not.
            let [open, closed] =
                if open < closed { [open, closed] } else { [1.0 - open, 1.0 - closed] };
            servo_stop(curls[d].map(|curl| open + curl.clamp(0.0, 1.0) * (closed - open)))
        })
    }

    /// The twenty angles \[rad\] of what the sensors say; what they do not say is taken for open.
    pub fn angles(&self, state: &State) -> [f64; ANGLES] {
        let full = f64::from(self.sensors.analog_max);
        let mut angles = [0.0; ANGLES];
        for (d, digit) in self.digits().into_iter().enumerate() {
            let curl = |raw: Option<u16>| {
                raw.map(|raw| {
                    let [open, closed] = digit.raw;
                    ((f64::from(raw) / full - open) / (closed - open)).clamp(0.0, 1.0)
                })
            };
            let whole = curl(state.curl[d]);
            // A finger's joint 0 is its metacarpal, the thumb's is the base joint.
            let first = usize::from(d > 0);
            let joint = |k: usize| curl(state.joints[d][first + k]).or(whole).unwrap_or(0.0);
            let blend =
                |k: usize, curl: f64| digit.open[k] + curl * (digit.closed[k] - digit.open[k]);
            let splay = state.splay[d].map_or(0.0, |raw| 2.0 * f64::from(raw) / full - 1.0);
            let spread = blend(1, whole.unwrap_or_else(|| joint(0)));
            let degrees = [
                blend(0, joint(0)),
                spread + splay * digit.splay * self.sensors.splay_deg,
                blend(2, joint(1)),
                blend(3, joint(2)),
            ];
            for (k, degrees) in degrees.into_iter().enumerate() {
                angles[4 * d + k] = degrees.to_radians();
            }
        }
        angles
    }
}

impl Check for Profile {
    fn check(&self) -> Result<(), (String, String)> {
        self.hand.check()?;
        self.wrist.check()?;
        self.link.check()?;
        self.tracking.check()?;
        self.display.check()?;
        if !(255..=u16::MAX).contains(&self.sensors.analog_max) {
            let cause = format!("is {}, expected 255 to 65535", self.sensors.analog_max);
            return Err(("sensors.analog_max".into(), cause));
        }
        if !(0.0..=45.0).contains(&self.sensors.splay_deg) {
            let cause = format!("is {}, expected 0 to 45", self.sensors.splay_deg);
            return Err(("sensors.splay_deg".into(), cause));
        }
        let names = ["thumb", "index", "middle", "ring", "little"];
        for (digit, name) in self.digits().into_iter().zip(names) {
            let [open, closed] = digit.raw;
            if !(open.abs() <= 1.0 && closed.abs() <= 1.0 && (open - closed).abs() >= 0.05) {
                let cause = "expected two values between 0 and 1, apart by 0.05 or more";
                return Err((format!("{name}.raw"), cause.into()));
            }
            for (key, angles) in [("open", &digit.open), ("closed", &digit.closed)] {
                if !angles.iter().all(|a| a.abs() <= 180.0) {
                    return Err((
                        format!("{name}.{key}"),
                        "expected angles within 180 degrees".into(),
                    ));
                }
            }
            if !(-2.0..=2.0).contains(&digit.splay) {
                return Err((format!("{name}.splay"), "expected -2 to 2".into()));
            }
        }
        Ok(())
    }

    fn set_side(&mut self, side: Side) {
        self.hand.side = side;
    }
}
