//! Joints in other orders, and hands of which only points are known.

mod rebuild;
mod tables;

pub use rebuild::{RebuildError, rebuild, typical_radii};
pub use tables::{
    OPENXR_JOINTS, POINTS, WEBXR_OF_POINT, webxr_of_apple, webxr_of_mediapipe, webxr_of_openxr,
};

use thenar::Vec3;

/// Nothing tracked is farther from the origin \[m\]; the simulation takes no more.
pub const REACH: f64 = 10.0;

/// True for a place that a tracker can mean.
pub fn in_reach(point: &Vec3) -> bool {
    point.norm() <= REACH // false for numbers that are not finite
}
