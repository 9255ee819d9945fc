//! Hands: from a skinned mesh to a [`HandModel`](thenar_core::model::HandModel).

mod asset;
mod bend;
pub(crate) mod bones;
mod build;
mod cuff;
mod digits;
mod fist;
mod grading;
pub(crate) mod in_bone;
mod joints;
mod layers;
mod loose;
mod nails;
mod names;
mod options;
mod passive;
mod regions;
mod relax;
mod report;
mod rig;
mod sculpt;
mod sides;
mod solids;
mod unit;
mod weights;

pub use asset::{asset, default_hand, uniform_hand};
pub use build::{LENGTHS, build_hand, build_hand_file, build_hand_with_report};
pub use cuff::cuff;
pub use fist::{Inversions, fist};
pub use grading::{DETAILS, graded_tets};
pub use layers::Layer;
pub use names::{NameMap, joint_names};
pub use options::{HandOptions, Size, Springs};
pub use passive::{JointStiffness, joint_stiffness};
pub use report::{BoneCover, BoneLength, HandReport, RigReading};
pub use sculpt::sculpted_offsets;
