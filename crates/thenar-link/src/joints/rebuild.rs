//! 25 joint frames from 21 points.
//!
//! Points tell where joints are, not how bones are turned about themselves. A finger is a chain of
//! hinges, and where its hinges' axis lies in the palm hardly depends on the pose: so each bone's
//! frame has -z along the bone and x as close to its finger's axis as that allows. The palm's frame
//! comes from the wrist and the knuckles. Metacarpals of the four fingers begin at some 40 % of the
//! way from wrist to knuckle.
//!
//! The numbers below are the means of a real capture of two hands (headset, 1423 samples). On it,
//! frames are off by 4° on average for fingers and 7° for thumbs, 22° at worst, and bases of
//! metacarpals by 1.3 mm (`tests.rs` beside this file).

use super::{POINTS, WEBXR_OF_POINT, in_reach};
use thenar_core::model::Side;
use thenar_core::{Mat3, Pose, Quat, Vec3};
use thenar_track::live::LivePose;

/// Axes of the fingers' hinges in the palm's frame of a right hand, thumb first. A left hand's are
/// the mirror images: y and z change sign.
const AXES: [[f64; 3]; 5] = [
    [-0.17, 0.83, -0.53],
    [0.98, 0.17, 0.04],
    [0.98, 0.13, 0.16],
    [0.96, 0.02, 0.27],
    [0.90, -0.12, 0.41],
];
/// Bases of the four fingers' metacarpals: part of the way from wrist to knuckle, and offset from
/// it in the palm's frame of a right hand, in parts of the way to the middle knuckle.
const BASES: [(f64, [f64; 3]); 4] = [
    (0.418, [-0.067, -0.104, 0.023]),
    (0.372, [0.004, -0.083, 0.0]),
    (0.412, [0.085, -0.023, 0.019]),
    (0.480, [0.068, -0.021, 0.035]),
];
/// Turn of the wrist's frame in the palm's, right hand \[rad\]: knuckles are not level.
const WRIST_TURN: [f64; 3] = [0.028, -0.016, 0.144];
/// x of the little finger's metacarpal in the palm's frame of a right hand; the other metacarpals
/// have that of the wrist.
const LITTLE_METACARPAL: [f64; 3] = [0.92, -0.275, 0.284];

/// Typical radii of an adult's joints \[m\].
const RADII: [f64; 25] = [
    0.021, 0.019, 0.012, 0.010, 0.009, 0.021, 0.010, 0.009, 0.008, 0.007, 0.021, 0.011, 0.008,
    0.008, 0.007, 0.019, 0.010, 0.008, 0.007, 0.006, 0.018, 0.008, 0.007, 0.006, 0.005,
];
/// From wrist to middle knuckle on the hand of these radii \[m\].
const RADII_PALM: f64 = 0.0957;

/// Shortest way from wrist to middle knuckle, and least distance of index and little knuckles from
/// a line through the wrist \[m\].
const PALM_MIN: f64 = 0.02;
/// Nothing of a hand is farther from its wrist \[m\].
const HAND_MAX: f64 = 0.5;
/// A shorter bone has no direction; it goes on in that of the bone before it \[m\].
const BONE_MIN: f64 = 1e-4;

/// Why points are no hand.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum RebuildError {
    /// Not finite, or out of reach.
    #[error("point {0} is not finite or beyond reach")]
    Unreachable(usize),
    /// Too far from the wrist.
    #[error("point {point} is {distance:.2} m from the wrist; a hand is smaller than {HAND_MAX} m")]
    TooLarge {
        /// Number of the point.
        point: usize,
        /// Distance \[m\].
        distance: f64,
    },
    /// Wrist and knuckles lie on a line or on each other.
    #[error("wrist and knuckles span no palm")]
    NoPalm,
}

/// The joints of a hand of which points are known (order of [`WEBXR_OF_POINT`], \[m\]).
///
/// # Errors
/// These are no points of a hand.
pub fn rebuild(side: Side, points: &[Vec3; POINTS]) -> Result<LivePose, RebuildError> {
    check(points)?;
    let mirror = if side == Side::Left { -1.0 } else { 1.0 };
    let wrist = points[0];
    let palm = palm(mirror, points).ok_or(RebuildError::NoPalm)?;
    let length = (points[9] - wrist).norm();
    let axis_W = |[x, y, z]: [f64; 3]| palm * Vec3::new(x, mirror * y, mirror * z);

    let [x, y, z] = WRIST_TURN;
    let turn = Quat::from_scaled_axis(Vec3::new(x, mirror * y, mirror * z));
    let wrist_rotation = of_columns(&palm) * turn;
    let mut joints = [Pose::new(wrist, wrist_rotation); 25];
    for (point, joint) in points.iter().zip(WEBXR_OF_POINT) {
        joints[joint].position = *point;
    }
    let across = wrist_rotation * Vec3::x();
    for (finger, (part, [x, y, z])) in BASES.into_iter().enumerate() {
        let (base, knuckle) = (5 + 5 * finger, 6 + 5 * finger);
        let along = part * (joints[knuckle].position - wrist);
        joints[base].position = wrist + along + palm * Vec3::new(mirror * x, y, z) * length;
        let axis = if finger == 3 { axis_W(LITTLE_METACARPAL) } else { across };
        let direction = joints[knuckle].position - joints[base].position;
        joints[base].rotation = bone(&direction, &axis, &wrist_rotation);
    }
    for finger in 0..5 {
        let axis = axis_W(AXES[finger]);
        // The thumb's hinges begin with its metacarpal, the fingers' with the knuckle.
        let first = if finger == 0 { 1 } else { 5 * finger + 1 };
        for joint in first..first + 3 {
            let direction = joints[joint + 1].position - joints[joint].position;
            let before = if joint == 1 { wrist_rotation } else { joints[joint - 1].rotation };
            joints[joint].rotation = bone(&direction, &axis, &before);
        }
        joints[first + 3].rotation = joints[first + 2].rotation;
    }
    Ok(LivePose::Joints { joints, radii: typical_radii(length) })
}

/// Radii of a hand whose middle knuckle is so far from the wrist \[m\]: thickness goes with length.
pub fn typical_radii(wrist_to_middle_knuckle: f64) -> [f64; 25] {
    let scale = (wrist_to_middle_knuckle / RADII_PALM).clamp(0.5, 2.0);
    RADII.map(|radius| radius * scale)
}

fn check(points: &[Vec3; POINTS]) -> Result<(), RebuildError> {
    if let Some(point) = points.iter().position(|point| !in_reach(point)) {
        return Err(RebuildError::Unreachable(point));
    }
    for (point, at) in points.iter().enumerate() {
        let distance = (at - points[0]).norm();
        if distance > HAND_MAX {
            return Err(RebuildError::TooLarge { point, distance });
        }
    }
    Ok(())
}

/// The palm's frame: -z to the middle knuckle, y out of the back.
fn palm(mirror: f64, points: &[Vec3; POINTS]) -> Option<Mat3> {
    let from_wrist = |point: usize| points[point] - points[0];
    let (index, middle, little) = (from_wrist(5), from_wrist(9), from_wrist(17));
    let forward = middle.try_normalize(PALM_MIN)?;
    let back = (little.cross(&index) * mirror).try_normalize(PALM_MIN * PALM_MIN)?;
    let x = forward.cross(&back).try_normalize(0.1)?;
    Some(Mat3::from_columns(&[x, x.cross(&forward), -forward]))
}

/// A bone's frame: -z along it, x as near to `axis` as that allows. `before` is the frame of the
/// bone before it, for bones without length and for axes along the bone.
fn bone(direction: &Vec3, axis: &Vec3, before: &Quat) -> Quat {
    let z = -direction.try_normalize(BONE_MIN).unwrap_or(before * -Vec3::z());
    let across = |axis: &Vec3| (axis - z * axis.dot(&z)).try_normalize(0.05);
    let Some(x) = across(axis).or_else(|| across(&(before * Vec3::x()))) else { return *before };
    of_columns(&Mat3::from_columns(&[x, z.cross(&x), z]))
}

fn of_columns(columns: &Mat3) -> Quat {
    Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(*columns))
}

#[cfg(test)]
mod tests;
