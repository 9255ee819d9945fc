//! Named hand shapes.

use crate::grip::{GripKind, Opposition};
use serde::{Deserialize, Serialize};
use thenar_core::model::{Digit, HandModel};

/// A named shape of the whole hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// Shape in which the hand's mesh was modelled: flesh without strain.
    Rest,
    /// Flat, fingers a little apart.
    Open,
    /// Hanging loose.
    Relaxed,
    /// Closed on itself.
    Fist,
    /// Index straight, the others closed.
    Point,
    /// Thumb and index pads against each other.
    Pinch,
    /// All fingers and the thumb around something of 5 to 8 cm.
    PowerGrasp,
}

/// Depth to which the pads of a pinch press into each other \[m\]: usual drives (500 N/m at a
/// fingertip) give 1.5 N for 3 mm on either side.
const PRESS: f64 = 6e-3;

/// Thumb that lets fingers pass: flexion of its three joints, and its spread \[degrees\].
pub(super) const THUMB_ASIDE: Shape = ([-10.0, 0.0, 0.0], 22.0);

/// Flexion of the three joints of a digit from the palm outwards, and its spread \[degrees\].
pub(crate) type Shape = ([f64; 3], f64);

impl Preset {
    /// All shapes by the names that scenes and motion files give them.
    pub const NAMED: [(&'static str, Self); 7] = [
        ("rest", Self::Rest),
        ("open", Self::Open),
        ("relaxed", Self::Relaxed),
        ("fist", Self::Fist),
        ("point", Self::Point),
        ("pinch", Self::Pinch),
        ("power-grasp", Self::PowerGrasp),
    ];

    /// True for shapes with the thumb over bent fingers, which bend before it.
    pub(super) fn is_closed(self) -> bool {
        matches!(self, Self::Fist | Self::Point)
    }

    /// Angles of thumb and index finger whose pads press into each other \[rad\], each with its
    /// joint and which of its angles it is; `None` for hands that cannot make them meet.
    pub(super) fn pinch(hand: &HandModel) -> Option<Vec<(usize, usize, f64)>> {
        Opposition::pressed(hand, GripKind::Pinch, PRESS)
    }

    /// Flexion by place in the digit, and spread \[degrees\]; `None` is the angle at rest.
    pub(crate) fn angles_deg(self, digit: Digit) -> Option<Shape> {
        use Digit::{Index, Thumb};
        let shape = match (self, digit) {
            (Self::Rest, _) => return None,
            (Self::Open, Thumb) => ([0.0, 0.0, 0.0], 0.0),
            (Self::Open, _) => ([0.0, 0.0, 0.0], 4.0),
            (Self::Relaxed, Thumb) => ([5.0, 12.0, 15.0], 5.0),
            (Self::Relaxed, _) => ([22.0, 30.0, 15.0], 0.0),
            (Self::Fist | Self::Point, Thumb) => ([10.0, 30.0, 40.0], 22.0),
            (Self::Point, Index) => ([5.0, 5.0, 3.0], 0.0),
            (Self::Fist | Self::Point, _) => ([80.0, 92.0, 50.0], 0.0),
            (Self::Pinch, Thumb) => ([10.0, 20.0, 30.0], 15.0),
            (Self::Pinch, Index) => ([45.0, 50.0, 35.0], 0.0),
            (Self::Pinch, _) => ([25.0, 30.0, 15.0], 0.0),
            (Self::PowerGrasp, Thumb) => ([0.0, 25.0, 25.0], 22.0),
            (Self::PowerGrasp, _) => ([50.0, 45.0, 25.0], 0.0),
        };
        Some(shape)
    }
}
