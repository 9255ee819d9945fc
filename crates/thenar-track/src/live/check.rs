//! Checks that poses must pass.

use super::LivePose;
use crate::TRACKED_JOINTS;
use thenar_core::Pose;
use thenar_input::plain;

/// Farthest place from the origin \[m\].
pub const REACH: f64 = 10.0;
/// Largest deviation of a quaternion's length from 1.
const NORM_SLACK: f64 = 1e-2;
/// Largest radius \[m\].
pub const RADIUS_MAX: f64 = 0.5;

/// Why a live pose was refused. Nothing has changed then.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LiveError {
    /// The scene has no such hand.
    #[error("there is no hand {hand}: the scene has {count}")]
    NoHand {
        /// Index given.
        hand: usize,
        /// Number of hands.
        count: usize,
    },
    /// The scene lets the hand go.
    #[error("hand `{hand}` follows nothing: the scene says `driven = false`")]
    NotDriven {
        /// Name of the hand.
        hand: String,
    },
    /// The hand cannot be moved this way.
    #[error("hand `{hand}` cannot follow this pose: {cause}")]
    Unfit {
        /// Name of the hand.
        hand: String,
        /// Reason in words.
        cause: String,
    },
    /// A number is not finite.
    #[error("{what} is not a finite number")]
    NotFinite {
        /// Joint or quantity.
        what: &'static str,
    },
    /// A quaternion is no rotation.
    #[error("the quaternion of {what} has length {}, expected 1", figure(*norm, 4))]
    Quaternion {
        /// Name of the joint.
        what: &'static str,
        /// Length of the quaternion.
        norm: f64,
    },
    /// A joint is too far away.
    #[error("{what} is {} m from the origin, expected at most {REACH} m", figure(*distance, 1))]
    TooFar {
        /// Name of the joint.
        what: &'static str,
        /// Distance from the origin \[m\].
        distance: f64,
    },
    /// A radius is none.
    #[error("the radius of {what} is {} m, expected 0 to {RADIUS_MAX} m", plain(*radius))]
    Radius {
        /// Name of the joint.
        what: &'static str,
        /// Radius that was given \[m\].
        radius: f64,
    },
}

/// A number with a given number of places; a large one in powers of ten.
fn figure(x: f64, places: usize) -> String {
    if x.abs() < 1e5 { format!("{x:.places$}") } else { plain(x) }
}

/// Refuses what is no pose of a hand nearby; returns it with unit quaternions.
pub fn checked(time: f64, pose: &LivePose) -> Result<LivePose, LiveError> {
    if !time.is_finite() {
        return Err(LiveError::NotFinite { what: "the time" });
    }
    let mut pose = pose.clone();
    match &mut pose {
        LivePose::Joints { joints, radii } => {
            for ((frame, radius), what) in joints.iter_mut().zip(radii).zip(TRACKED_JOINTS) {
                check_frame(frame, what)?;
                if !(0.0..=RADIUS_MAX).contains(radius) {
                    return Err(LiveError::Radius { what, radius: *radius });
                }
            }
        }
        LivePose::Angles { wrist, angles } => {
            check_frame(wrist, "wrist")?;
            if !angles.iter().all(|angle| angle.is_finite()) {
                return Err(LiveError::NotFinite { what: "a joint angle" });
            }
        }
    }
    Ok(pose)
}

fn check_frame(frame: &mut Pose, what: &'static str) -> Result<(), LiveError> {
    if !frame.is_finite() {
        return Err(LiveError::NotFinite { what });
    }
    let distance = frame.position.norm();
    if distance > REACH {
        return Err(LiveError::TooFar { what, distance });
    }
    let norm = frame.rotation.coords.norm();
    if (norm - 1.0).abs() > NORM_SLACK {
        return Err(LiveError::Quaternion { what, norm });
    }
    frame.rotation.renormalize();
    Ok(())
}
