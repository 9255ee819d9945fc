//! Hands: from a skinned mesh to a [`HandModel`](thenar::model::HandModel).

mod asset;
mod bones;
mod build;
mod digits;
mod fist;
mod grading;
mod in_bone;
mod joints;
mod names;
mod options;
mod regions;
mod relax;
mod report;
mod solids;
mod weights;

pub use asset::{asset, default_hand, uniform_hand};
pub use build::{LENGTHS, build_hand, build_hand_file, build_hand_with_report};
pub use fist::{Inversions, fist};
pub use grading::{DETAILS, graded_tets};
pub use names::NameMap;
pub use options::{HandOptions, Size};
pub use report::{BoneCover, BoneLength, HandReport};
