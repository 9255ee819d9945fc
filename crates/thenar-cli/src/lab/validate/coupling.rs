//! Flesh-bone coupling and skinning.

mod balance;
mod coupled;
mod differences;
mod jointed;
mod skinning;
mod splitting;

use super::case::{Case, SceneText, case, scene};

/// The cases.
pub const CASES: &[Case] = &[
    case("D1", "skinning weights", skinning::weights),
    case("D2", "a rigid motion of all bones moves all targets", skinning::rigid_motion),
    case("D3", "twist by 90 degrees", skinning::twist),
    case("D4", "coupling forces balance", balance::linear),
    case("D5", "two steps against the monolithic solution", splitting::both_scenes),
    case("D6", "derivatives against finite differences", differences::all),
    case("D7", "targets by rotations blended about joints", skinning::by_joint),
];

/// A hand of about 600 tetrahedra closing to a fist.
const HAND: SceneText = scene!("d01-hand");
/// Two bones in flesh.
const FINGER: SceneText = scene!("d05-finger");
