//! Rotations and frames.

use crate::format::{Placement, Rotation};
use crate::math::{Mat3, Pose, Quat, Vec3};
use crate::text::{Fault, Located};
use thenar_core::math::Mat3 as M3;

/// The rotation that a table describes; none when there is no table.
pub fn rotation(table: Option<&Located<Rotation>>) -> Result<Quat, Fault> {
    let Some(at) = table else { return Ok(Quat::identity()) };
    let r = &at.value;
    let euler = match (r.euler, r.euler_deg) {
        (Some(e), None) => Some(e),
        (None, Some(e)) => Some(e.map(f64::to_radians)),
        (None, None) => None,
        (Some(_), Some(_)) => return Err(at.fault("give `euler` or `euler_deg`, not both")),
    };
    let angle = match (r.angle, r.angle_deg) {
        (Some(a), None) => Some(a),
        (None, Some(a)) => Some(a.to_radians()),
        (None, None) => None,
        (Some(_), Some(_)) => return Err(at.fault("give `angle` or `angle_deg`, not both")),
    };
    match (r.quaternion, r.axis, angle, euler) {
        (Some([x, y, z, w]), None, None, None) => {
            let q = nalgebra::Quaternion::new(w, x, y, z);
            match q.norm() > 1e-6 {
                true => Ok(Quat::from_quaternion(q)),
                false => Err(at.fault("expected a quaternion that is not zero")),
            }
        }
        (None, Some(axis), Some(angle), None) => {
            let axis = direction(&axis).ok_or_else(|| at.fault("expected an axis that is not zero"))?;
            Ok(Quat::from_scaled_axis(axis * angle))
        }
        (None, None, None, Some(e)) => Ok(Quat::from_euler_angles(e.x, e.y, e.z)),
        (None, None, None, None) => Ok(Quat::identity()),
        _ => Err(at.fault(
            "expected one of: `quaternion`; `axis` with `angle` or `angle_deg`; `euler` or `euler_deg`",
        )),
    }
}

/// The frame that a table describes; the identity when there is no table.
pub fn frame(table: Option<&Placement>) -> Result<Pose, Fault> {
    match table {
        Some(p) => Ok(Pose::new(p.position, rotation(p.rotation.as_ref())?)),
        None => Ok(Pose::identity()),
    }
}

/// The unit vector along `v`, unless `v` is zero.
pub fn direction(v: &Vec3) -> Option<Vec3> {
    v.try_normalize(1e-9)
}

/// The rotation whose columns are these right-handed orthonormal axes.
pub fn from_axes(x: Vec3, y: Vec3, z: Vec3) -> Quat {
    let matrix: M3 = Mat3::from_columns(&[x, y, z]);
    Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(matrix))
}
