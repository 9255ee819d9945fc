//! A hand (or any jointed soft body): bones, joints, flesh and what binds them.

use crate::contact::Shape;
use crate::math::{Mat3, Pose, Vec3};
use crate::model::{Binding, EmbeddedSurface, Flesh, JointDesc};

/// Left or right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Side {
    /// A left hand.
    Left,
    /// A right hand.
    Right,
}

/// The part of the hand a bone belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Digit {
    /// Palm, or a bone of a body that is not a hand.
    Palm,
    /// Thumb.
    Thumb,
    /// Index finger.
    Index,
    /// Middle finger.
    Middle,
    /// Ring finger.
    Ring,
    /// Little finger.
    Little,
}

impl Digit {
    /// The five fingers, thumb first.
    pub const FINGERS: [Self; 5] =
        [Self::Thumb, Self::Index, Self::Middle, Self::Ring, Self::Little];

    /// Its number among the parts of a hand (`BodyParts`): the palm 0, the fingers from 1.
    pub fn part(self) -> u8 {
        self as u8
    }

    /// Lower-case name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Palm => "palm",
            Self::Thumb => "thumb",
            Self::Index => "index",
            Self::Middle => "middle",
            Self::Ring => "ring",
            Self::Little => "little",
        }
    }
}

/// One bone. Its frame B has the axes of the tracked joint at its proximal end (WebXR:
/// -z along the bone away from the wrist, +y out of the back of the hand) and its origin at the
/// centre of mass.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bone {
    /// Name, e.g. `index-proximal`.
    pub name: String,
    /// Index of the parent bone, smaller than this bone's own; `None` for the root.
    pub parent: Option<u32>,
    /// Rest pose in the model frame M.
    pub pose_MB: Pose,
    /// Mass \[kg\].
    pub mass: f64,
    /// Inertia about the centre of mass, in B \[kg m²\].
    pub inertia: Mat3,
    /// Digit.
    pub digit: Digit,
    /// Proximal and distal end in B \[m\].
    pub ends_B: [Vec3; 2],
    /// Radius of the bone itself \[m\] (drawing and inertia).
    pub radius: f64,
    /// Name of the tracked (WebXR) joint at the proximal end, if there is one.
    pub tracked_joint: Option<String>,
    /// Frame T of that tracked joint in B.
    pub pose_BT: Pose,
}

/// What of a bone touches other bodies when its flesh is crushed.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BoneSolid {
    /// Contact shape, in its frame S.
    pub shape: Shape,
    /// Placement of the shape in the bone's frame B.
    pub pose_BS: Pose,
}

/// A hand in its rest pose, in its model frame M.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HandModel {
    /// Name.
    pub name: String,
    /// Side, when it is a hand.
    pub side: Option<Side>,
    /// Bones, parents before children; bone 0 is the root (the palm).
    pub bones: Vec<Bone>,
    /// Joints between bones (indices into `bones`); the joint of bone i > 0 is `joints[i-1]`.
    pub joints: Vec<JointDesc>,
    /// Flesh; its collision surface touches.
    pub flesh: Flesh,
    /// One binding per flesh node.
    pub bindings: Vec<Binding>,
    /// Volume of embedded body that each node stands for \[m³\]; a node's coupling stiffness is
    /// `coupling stiffness per volume × this`.
    pub node_volumes: Vec<f64>,
    /// Fine surface for drawing.
    pub render: EmbeddedSurface,
    /// Digit of each collision vertex.
    pub collision_digits: Vec<Digit>,
    /// Wrist to middle fingertip in the rest pose \[m\].
    pub length: f64,
    /// Solid of each bone, or empty: bones then touch nothing.
    pub solids: Vec<BoneSolid>,
}
