//! Outputs of force displays: everything that any of them can render, per finger.

use crate::safety::Limits;
use thenar_core::Vec3;
use thenar_core::model::Side;

/// Fingers of a hand, thumb first.
pub const DIGITS: usize = 5;

/// One finger, in one haptic tick. Forces have passed the safety guard; a display clamps no more
/// than its own wire does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DigitOutput {
    /// Force on the wearer, world \[N\].
    pub force_W: Vec3,
    /// Part of the force along the inward pad normal \[N\], never negative.
    pub pad_force: f64,
    /// Contact area \[m²\].
    pub area: f64,
    /// Mean pressure over it \[Pa\].
    pub pressure_mean: f64,
    /// Largest pressure \[Pa\].
    pub pressure_max: f64,
    /// Speed at which the skin slips over what it touches \[m/s\].
    pub slip_speed: f64,
    /// Curl at which contact began, 0 open to 1 closed; `None` while the finger is free.
    pub curl_at_contact: Option<f64>,
}

/// One hand, in one haptic tick. The default is what every way out sends: nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandOutput {
    /// Side of the hand.
    pub side: Side,
    /// Time of the computation \[ns\].
    pub time_ns: u64,
    /// Thumb first.
    pub digits: [DigitOutput; DIGITS],
    /// Force of the palm's coupling on the wearer, world \[N\]; for devices that hold one point.
    pub force_W: Vec3,
    /// Torque of the palm's coupling on the wearer, world \[N m\].
    pub torque_W: Vec3,
}

impl HandOutput {
    /// No force, no stop, no vibration.
    pub fn released(side: Side, time_ns: u64) -> Self {
        let zero = Vec3::zeros();
        Self { side, time_ns, digits: Default::default(), force_W: zero, torque_W: zero }
    }
}

/// Part of [`HandOutput`] that a display renders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Rendering {
    /// Pulls on fingers, along the pad normal.
    Tendons,
    /// Stops fingers where contact began.
    Stops,
    /// Vibrates at the finger pads.
    Vibration,
    /// A force in space, and perhaps a torque, on one point.
    Wrench,
}

impl Rendering {
    /// Limits as this rendering asks for them: finger pads press or do not, and what would pull a
    /// finger in is nothing to show; a stop lets a finger go that opens, whatever force is wanted.
    pub fn limits(self, own: Limits) -> Limits {
        match self {
            Self::Wrench => own,
            Self::Tendons => Limits { unilateral: true, ..own },
            Self::Stops | Self::Vibration => Limits { unilateral: true, passive: true, ..own },
        }
    }
}
