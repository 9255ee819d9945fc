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

impl Side {
    /// Lower-case name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

/// The part of the hand a bone belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Digit {
    /// Palm, or a bone of a body that is not a hand.
    Palm,
    /// First digit, the thumb.
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

    /// Parts of a hand, in the order of their numbers: the palm and the fingers, thumb first.
    pub const PARTS: [Self; 6] =
        [Self::Palm, Self::Thumb, Self::Index, Self::Middle, Self::Ring, Self::Little];

    /// Number of the digit among the parts of a hand (`BodyParts`): the palm 0, the fingers from 1.
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
    /// Digit that the bone belongs to.
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

/// Solid of a bone that touches other bodies when its flesh is crushed.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BoneSolid {
    /// Contact shape, in its frame S.
    pub shape: Shape,
    /// Placement of the shape in the bone's frame B.
    pub pose_BS: Pose,
}

/// The part of a hand's flesh that the springs of Eq. 7 to 9 hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum CouplingKind {
    /// Every node, by the flesh that it stands for: the paper's. Skin and pads are held too.
    #[default]
    Uniform,
    /// Nodes in bone, by the bone that they stand for. Flesh between bone and skin is free.
    Bone,
}

/// A part of the hand's skin, and of the flesh under it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum HandRegion {
    /// The palm's side of the last bones.
    Pad,
    /// Nails and what lies under them.
    Nail,
    /// The palm's side of all else.
    Palm,
    /// The back of all else.
    Back,
}

impl HandRegion {
    /// All four.
    pub const ALL: [Self; 4] = [Self::Pad, Self::Nail, Self::Palm, Self::Back];

    /// Lower-case name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pad => "pad",
            Self::Nail => "nail",
            Self::Palm => "palm",
            Self::Back => "back",
        }
    }
}

/// A node that stands for bone.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BoneNode {
    /// Flesh node.
    pub node: u32,
    /// The bone, or the two adjacent ones by their shares.
    pub binding: Binding,
    /// Volume of bone that the node stands for \[m³\].
    pub volume: f64,
}

/// A hand in its rest pose, in its model frame M.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HandModel {
    /// Name of the hand.
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
    /// Volume of embedded body that each node stands for \[m³\]; where the coupling is uniform, a
    /// node's stiffness is `coupling stiffness per volume × this`.
    pub node_volumes: Vec<f64>,
    /// Fine surface for drawing.
    pub render: EmbeddedSurface,
    /// Digit of each collision vertex.
    pub collision_digits: Vec<Digit>,
    /// Wrist to middle fingertip in the rest pose \[m\].
    pub length: f64,
    /// Solid of each bone, or empty: bones then touch nothing.
    pub solids: Vec<BoneSolid>,
    /// The flesh that the springs hold where a scene does not say.
    pub coupling: CouplingKind,
    /// Nodes that stand for bone, ascending; empty in models that hold uniformly alone.
    pub bone_nodes: Vec<BoneNode>,
    /// Region of each collision triangle; empty in models of earlier versions.
    pub regions: Vec<HandRegion>,
    /// Nodes that stand for nails and their beds, which are grown to the last bones, ascending; a
    /// node may stand for bone too.
    pub nail_nodes: Vec<BoneNode>,
    /// Stiffness of the flesh against turns of the joints \[N m/rad\]: a symmetric matrix, row by
    /// row, over all axes of the joints ([`HandModel::axes`]); the secant about rest. Empty where
    /// it was not measured.
    pub bending: Vec<f64>,
}

/// Springs per volume of flesh of the paper's coupling \[N/m⁴\].
const UNIFORM_STIFFNESS: f64 = 2e9;
/// Springs per volume of bone, over Young's modulus of the flesh and the inverse squared length of
/// the hand.
///
/// Under 10 N on a pad bone may yield a twentieth of what the flesh over it does. A pad sinks by 3
/// mm then, in a hand of L = 190 mm and E = 50 kPa: like a spring of 0.35 E L. The least solid
/// under a pad, that of the little finger, has v = 3.2e-5 L³ (0.22 ml). From `κ v ≥ 20 · 0.35 E L`
/// follows `κ ≥ 2.2e5 E/L²`.
const BONE_STIFFNESS: f64 = 2.2e5;

impl HandModel {
    /// All axes of the joints: the joint's number, and which of its axes.
    pub fn axes(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let joints = self.joints.iter().enumerate();
        joints.flat_map(|(j, joint)| (0..joint.kind.angles()).map(move |k| (j, k)))
    }

    /// Springs per volume when a scene gives none \[N/m⁴\]: per volume of flesh, or of bone. Those
    /// in bone are proportional to the flesh's largest modulus and to the inverse squared length of
    /// the hand, so that hands of all sizes and moduli yield in the same proportions.
    pub fn usual_coupling_stiffness(&self, kind: CouplingKind) -> f64 {
        match kind {
            CouplingKind::Uniform => UNIFORM_STIFFNESS,
            CouplingKind::Bone => {
                let young = self.flesh.materials.iter().map(|m| m.young).fold(0.0, f64::max);
                BONE_STIFFNESS * young / (self.length * self.length)
            }
        }
    }

    /// Binding of every node and the volume by which its spring holds it \[m³\]; 0 leaves it free.
    /// With `nails`, flesh that hangs on bone is held in nails and their beds too.
    pub fn held(&self, kind: CouplingKind, nails: bool) -> (Vec<Binding>, Vec<f64>) {
        let mut bindings = self.bindings.clone();
        if kind == CouplingKind::Uniform {
            return (bindings, self.node_volumes.clone());
        }
        let mut volumes = vec![0.0; bindings.len()];
        for bone in &self.bone_nodes {
            bindings[bone.node as usize] = bone.binding;
            volumes[bone.node as usize] = bone.volume;
        }
        for nail in self.nail_nodes.iter().filter(|_| nails) {
            let volume = &mut volumes[nail.node as usize];
            // The nail of a node that stands for bone stiffens its spring.
            if *volume == 0.0 {
                bindings[nail.node as usize] = nail.binding;
            }
            *volume += nail.volume;
        }
        (bindings, volumes)
    }
}

#[cfg(test)]
mod tests {
    use super::Digit;

    #[test]
    fn parts_of_a_hand_stand_at_their_numbers() {
        assert_eq!(Digit::PARTS.map(Digit::part), [0, 1, 2, 3, 4, 5]);
        assert_eq!(Digit::PARTS[1..], Digit::FINGERS);
    }
}
