//! Fingers against people: bands, not points. Every case of a hand has the same constants, those of
//! its scene (`f01-press`, `f06-knuckle`); overrides give another hand, finger, angle or course of
//! the plate alone.

mod curve;
mod friction;
mod knuckle;
mod press;
mod tap;

use super::case::{Case, SceneText, case, scene};
pub use curve::pressed;
pub use friction::tables;
pub use press::plate;
pub use tap::taps;

/// A plate on the pad of a finger.
pub const PRESS: SceneText = scene!("f01-press");
const DRAG: SceneText = scene!("f04-drag");
/// A relaxed finger, bent by a torque.
pub const KNUCKLE: SceneText = scene!("f06-knuckle");

/// A hand that is tried: a name, and what sets it apart from the scene's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct HandVariant {
    /// Name in the table.
    pub name: &'static str,
    /// Overrides of the scene.
    pub changes: &'static [&'static str],
}

/// The scene's own: right, 190 mm.
pub const OWN: HandVariant = HandVariant { name: "right, 190 mm", changes: &[] };
/// Another size, and the other side.
pub const SMALL: HandVariant = HandVariant {
    name: "left, 170 mm",
    changes: &["hand.hand.length=0.17", "hand.hand.model=left"],
};

/// The cases.
pub const CASES: &[Case] = &[
    case("F1", "an index pad on a plate at 5 mm/s: force over depth", press::depth),
    case("F1H", "the same after 10 s of hold", press::held).only_full(),
    case("F2", "a pad held still relaxes; pressed fast it stiffens", press::relaxation).only_full(),
    case("F3", "area of contact over force", press::area),
    case("F4", "friction of skin falls with load", friction::means),
    case("F5", "moduli", press::moduli),
    case("F6", "the knuckle after 10 s of hold", knuckle::stiffness).only_full(),
    case("F7", "the first touch is Hertz's, more is stiffer", press::first_touch),
    case("F8", "a fingertip under 50 N", press::crushed),
];
