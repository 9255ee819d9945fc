//! Places, rotations, and poses over time.

use crate::math::Vec3;
use crate::text::{Located, table, words};

table! {
    /// A rotation, given in one of these ways: `quaternion`; `axis` with `angle` or `angle_deg`;
    /// `euler` or `euler_deg`.
    pub struct Rotation {
        /// [x, y, z, w]; need not have length 1, but not zero.
        quaternion: Option<[f64; 4]> where PLACE;
        /// Axis of the rotation; any length but zero.
        axis: Option<Vec3> where PLACE;
        /// Angle about `axis` [rad].
        angle: Option<f64> where ANGLE;
        /// Angle about `axis` [degrees].
        angle_deg: Option<f64> where ANGLE;
        /// Turns about the fixed axes x, then y, then z [rad].
        euler: Option<Vec3> where ANGLE;
        /// Turns about the fixed axes x, then y, then z [degrees].
        euler_deg: Option<Vec3> where ANGLE;
    }
}

table! {
    /// A frame in another frame.
    pub struct Placement {
        /// Origin of the frame [m]. Default [0, 0, 0].
        position: Vec3 where PLACE = Vec3::zeros();
        /// Rotation of the frame. Default none.
        rotation: Option<Located<Rotation>>;
    }
}

table! {
    /// Pose of a body at one time.
    pub struct Keyframe {
        /// Time [s]; later than the keyframe before.
        time: f64 where DURATION;
        /// Position of the body's origin, world [m]; left out, that of the keyframe before.
        position: Option<Vec3> where PLACE;
        /// Rotation; left out, that of the keyframe before.
        rotation: Option<Located<Rotation>>;
    }
}

words! {
    /// Interpolation of values between keyframes.
    pub enum InterpolationWord {
        /// Minimum jerk: velocity and acceleration vanish at each keyframe.
        "smooth" => Smooth,
        /// A straight line.
        "linear" => Linear,
    }
}

table! {
    /// A spring and damper with six degrees of freedom that pulls a body to a target pose.
    pub struct DriveTable {
        /// Spring on the position [N/m].
        stiffness: f64 where SPRING;
        /// Damper on it [N s/m]. Default 0.
        damping: f64 where SPRING = 0.0;
        /// Spring on the orientation [N m/rad]. Default 0.
        angular_stiffness: f64 where SPRING = 0.0;
        /// Damper on it [N m s/rad]. Default 0.
        angular_damping: f64 where SPRING = 0.0;
    }
}
