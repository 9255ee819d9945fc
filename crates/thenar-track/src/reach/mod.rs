//! Digits that reach: a chain of joints from the palm to a pad, and the angles that bring the pad
//! to a place.

mod chain;
mod solve;
mod tips;
mod within;

pub use chain::{
    ALONG, Angles, Chain, FREEDOMS_MAX, Freedom, Pad, PadKinematics, PadPlace, palmar_pad,
};
pub use solve::{Goal, solve};
pub use tips::Fingertips;
pub(crate) use within::step_within;
