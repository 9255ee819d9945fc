//! Joints between rigid bodies.

use crate::math::Pose;

/// The relative motion a joint leaves free. The joint frame J is fixed in the parent,
/// K in the child; at zero angles they coincide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum JointKind {
    /// No freedom: 6 rows.
    Fixed,
    /// Turns about x: `R_JK = Rx(q0)`; 5 rows.
    Hinge,
    /// Turns about the parent's y, then the child's x: `R_JK = Ry(q0) Rx(q1)`; 4 rows.
    /// For a finger, q0 is abduction and q1 flexion.
    Universal,
    /// Turns freely about a common point: 3 rows.
    Ball,
    /// Six freedoms, no rows, no springs: the two bodies are neighbours (they may share flesh and
    /// do not touch each other).
    Free,
}

impl JointKind {
    /// Number of constraint rows.
    pub fn rows(self) -> usize {
        match self {
            Self::Fixed => 6,
            Self::Hinge => 5,
            Self::Universal => 4,
            Self::Ball => 3,
            Self::Free => 0,
        }
    }

    /// Number of measured joint angles (ball, fixed and free joints have none).
    pub fn angles(self) -> usize {
        match self {
            Self::Hinge => 1,
            Self::Universal => 2,
            _ => 0,
        }
    }
}

/// The admissible range of one joint angle \[rad\].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AngleLimit {
    /// Smallest admissible angle \[rad\].
    pub min: f64,
    /// Largest admissible angle \[rad\].
    pub max: f64,
}

/// Limit, spring and damper about one axis of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Axis {
    /// Range; `None` is unlimited.
    pub limit: Option<AngleLimit>,
    /// Spring \[N m/rad\].
    pub stiffness: f64,
    /// Angle at which the spring is relaxed \[rad\].
    pub rest_angle: f64,
    /// Damper \[N m s/rad\].
    pub damping: f64,
}

/// One joint. `parent` and `child` index the list of rigid bodies it is declared beside.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointDesc {
    /// Name, unique in the scene.
    pub name: String,
    /// Kind, which says how it may turn.
    pub kind: JointKind,
    /// Parent body; `None` is the world.
    pub parent: Option<u32>,
    /// Child body.
    pub child: u32,
    /// Joint frame in the parent (or in the world).
    pub pose_PJ: Pose,
    /// Joint frame in the child.
    pub pose_CK: Pose,
    /// Limits, springs and dampers; hinge uses `axes[0]`, universal `axes[0..2]`
    /// (abduction, flexion); ball uses `axes[0]` as an isotropic spring and damper.
    pub axes: [Axis; 2],
    /// Stiffness of the springs that act past a limit \[N m/rad\].
    pub limit_stiffness: f64,
    /// Damping that acts past a limit \[N m s/rad\].
    pub limit_damping: f64,
}
