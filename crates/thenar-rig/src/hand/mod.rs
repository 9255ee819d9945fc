//! Hands: from a skinned mesh to a [`HandModel`](thenar::model::HandModel).

mod bones;
mod build;
mod digits;
mod joints;
mod names;
mod options;
mod regions;
mod weights;

pub use build::build_hand;
pub use names::NameMap;
pub use options::{HandOptions, Size};
