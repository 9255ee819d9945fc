//! Joints in other orders, and hands of which only points are known.

mod rebuild;
mod tables;

pub use rebuild::{RebuildError, rebuild, typical_radii};
pub use tables::{
    OPENXR_JOINTS, POINTS, WEBXR_OF_POINT, webxr_of_apple, webxr_of_mediapipe, webxr_of_openxr,
};

use thenar_core::{Quat, Vec3};
use thenar_track::live::REACH;

/// Largest deviation of a quaternion's length from one.
const UNIT_TOLERANCE: f64 = 0.1;

/// The rotation of a quaternion that a tracker sent, x y z w; its length where that is not one.
pub fn rotation([x, y, z, w]: [f64; 4]) -> Result<Quat, f64> {
    let quaternion = nalgebra::Quaternion::new(w, x, y, z);
    let norm = quaternion.norm();
    let unit = (1.0 - UNIT_TOLERANCE..=1.0 + UNIT_TOLERANCE).contains(&norm);
    if unit { Ok(Quat::from_quaternion(quaternion)) } else { Err(norm) }
}

/// True for a place that a tracker can mean.
pub fn in_reach(point: &Vec3) -> bool {
    point.norm() <= REACH // false for numbers that are not finite
}
