//! Rigs as they come: names, joints and axes of any of them, read as those of WebXR.

mod found;
mod frames;
mod list;
mod posed;
#[cfg(test)]
mod tests;
mod words;

pub(super) use found::{RigJoints, find};
pub(super) use frames::Frames;
pub use list::{ListedJoint, RigListing, rig_listing};
pub(super) use posed::Posed;
