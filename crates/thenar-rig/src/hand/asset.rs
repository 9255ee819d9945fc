//! The hands that come with the program.

use super::{HandOptions, build_hand};
use crate::RigError;
use thenar_core::model::{HandModel, Side};

/// The WebXR generic hand (MIT licence, see `assets/hands`).
const RIGHT: &[u8] = include_bytes!("../../assets/hands/right.glb");
const LEFT: &[u8] = include_bytes!("../../assets/hands/left.glb");

/// The bytes of the shipped GLB file of this side.
pub fn asset(side: Side) -> &'static [u8] {
    match side {
        Side::Right => RIGHT,
        Side::Left => LEFT,
    }
}

/// The shipped hand at its own size, as [`HandOptions::default`] has it.
///
/// # Errors
/// None that a caller could cause: the mesh is a part of the program.
pub fn default_hand(side: Side) -> Result<HandModel, RigError> {
    shipped(side, HandOptions::default())
}

/// The shipped hand at its own size with about `tets` tetrahedra of one size, otherwise as
/// [`HandOptions::paper`] has it.
///
/// # Errors
/// When `tets` is out of range.
pub fn uniform_hand(side: Side, tets: usize) -> Result<HandModel, RigError> {
    shipped(side, HandOptions { tets, ..HandOptions::paper() })
}

fn shipped(side: Side, options: HandOptions) -> Result<HandModel, RigError> {
    let name = match side {
        Side::Right => "right-hand",
        Side::Left => "left-hand",
    };
    build_hand(asset(side), &HandOptions { name: name.into(), side: Some(side), ..options })
}
