//! Small fixed-size linear algebra, all in f64.

pub mod lanes;

use nalgebra as na;

/// A point or a vector in space.
pub type Vec3 = na::Vector3<f64>;
/// A 3×3 matrix.
pub type Mat3 = na::Matrix3<f64>;
/// A linear part (rows 0-2) above an angular part (rows 3-5).
pub type Vec6 = na::Vector6<f64>;
/// A 6×6 matrix over linear and angular parts.
pub type Mat6 = na::Matrix6<f64>;
/// A rotation.
pub type Quat = na::UnitQuaternion<f64>;

/// A rigid placement: `p_A = rotation * p_B + position` for `pose_AB`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pose {
    /// Origin of B in A \[m\].
    pub position: Vec3,
    /// Rotation from B to A.
    pub rotation: Quat,
}

impl Pose {
    /// The pose with this origin and rotation.
    pub fn new(position: Vec3, rotation: Quat) -> Self {
        Self { position, rotation }
    }

    /// B coincides with A.
    pub fn identity() -> Self {
        Self::new(Vec3::zeros(), Quat::identity())
    }

    /// A pure translation.
    pub fn translation(x: f64, y: f64, z: f64) -> Self {
        Self::new(Vec3::new(x, y, z), Quat::identity())
    }

    /// `pose_BA` from `pose_AB`.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.inverse();
        Self::new(-(rotation * self.position), rotation)
    }

    /// A point of B, expressed in A.
    pub fn point(&self, p: &Vec3) -> Vec3 {
        self.rotation * p + self.position
    }

    /// A direction of B, expressed in A.
    pub fn vector(&self, v: &Vec3) -> Vec3 {
        self.rotation * v
    }

    /// A point of A, expressed in B.
    pub fn inverse_point(&self, p: &Vec3) -> Vec3 {
        self.rotation.inverse_transform_vector(&(p - self.position))
    }

    /// A direction of A, expressed in B.
    pub fn inverse_vector(&self, v: &Vec3) -> Vec3 {
        self.rotation.inverse_transform_vector(v)
    }

    /// True when every number is finite.
    pub fn is_finite(&self) -> bool {
        self.position.iter().all(|x| x.is_finite())
            && self.rotation.coords.iter().all(|x| x.is_finite())
    }
}

impl std::ops::Mul for Pose {
    type Output = Pose;
    fn mul(self, rhs: Pose) -> Pose {
        Pose::new(self.point(&rhs.position), self.rotation * rhs.rotation)
    }
}

/// Lengths of rotations are off by less than this. Steps make them of length one to a few
/// roundings, 1e-14; the rest is for what descriptions and files bring along.
pub(crate) const ROTATION_OFF: f64 = 1e-9;

/// True for a rotation of length one.
pub(crate) fn is_turn(rotation: &Quat) -> bool {
    (rotation.coords.norm() - 1.0).abs() <= ROTATION_OFF
}

/// A rotation as it is where its length is one, brought to that where it is another; `None` for
/// what says nothing of a direction.
pub(crate) fn to_turn(rotation: &Quat) -> Option<Quat> {
    if is_turn(rotation) {
        return Some(*rotation);
    }
    Some(Quat::new_normalize(rotation.into_inner())).filter(is_turn)
}

/// The matrix of the cross product: `skew(a) * b = a × b`.
pub fn skew(a: &Vec3) -> Mat3 {
    Mat3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// Rotation vector of a rotation, angle in [0, π].
pub fn rotation_vector(q: &Quat) -> Vec3 {
    q.scaled_axis()
}

/// Two unit vectors that complete the unit vector `n` to a right-handed basis `(n, t1, t2)`.
pub fn tangents(n: &Vec3) -> (Vec3, Vec3) {
    let s = 1.0_f64.copysign(n.z);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    let t1 = Vec3::new(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
    let t2 = Vec3::new(b, s + n.y * n.y * a, -n.y);
    (t1, t2)
}
