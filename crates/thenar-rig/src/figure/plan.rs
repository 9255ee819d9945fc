//! Plan of a figure as its file describes it, before it has flesh.

use super::mimic::Mimic;
use crate::TriMesh;
use thenar_core::model::{Axis, JointKind};
use thenar_core::shape::Shape;
use thenar_core::{Mat3, Pose, Vec3};

/// A tree of bones with typed joints, at rest in the figure's frame M: +y is up, lengths are in
/// metres.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Name in the file; empty where it has none.
    pub name: String,
    /// Bones, parents before children; the first is the root.
    pub bones: Vec<PlanBone>,
    /// The skin, where the file has one; otherwise flesh is laid around the bones' solids.
    pub skin: Option<PlanSkin>,
    /// Joints that follow others; joint i carries bone i + 1.
    pub mimics: Vec<Mimic>,
    /// Notes on what was changed or passed over, one sentence each, for whoever builds the figure.
    pub notes: Vec<String>,
}

/// A bone of a plan.
#[derive(Clone, Debug)]
pub struct PlanBone {
    /// Name, unique in the plan.
    pub name: String,
    /// Index of the parent, smaller than the bone's own; `None` for the root.
    pub parent: Option<u32>,
    /// Frame of the bone in the file (link, body or node), in M.
    pub pose_ML: Pose,
    /// The joint to the parent; `None` for the root.
    pub joint: Option<PlanJoint>,
    /// Mass, where the file gives it; otherwise that of the solids counts.
    pub mass: Option<PlanMass>,
    /// The bone's own geometry, which flesh surrounds.
    pub solids: Vec<PlanSolid>,
}

/// A joint of a plan. Its angles are zero in the rest pose.
#[derive(Clone, Debug)]
pub struct PlanJoint {
    /// Name, unique in the plan.
    pub name: String,
    /// Kind: fixed, hinge, universal or ball.
    pub kind: JointKind,
    /// Joint frame, at rest the same in parent and child: a hinge turns about its x, a universal
    /// joint about its y and then the child's x.
    pub pose_MJ: Pose,
    /// Range, spring and damper of each axis; those of a ball stand in the first.
    pub axes: [Axis; 2],
}

/// Mass of a bone.
#[derive(Clone, Copy, Debug)]
pub struct PlanMass {
    /// Mass \[kg\].
    pub mass: f64,
    /// Centre of mass in M \[m\].
    pub centre_M: Vec3,
    /// Inertia about it, axes of M \[kg m²\]; `None` where the file gives none.
    pub inertia_M: Option<Mat3>,
}

/// A piece of a bone.
#[derive(Clone, Debug)]
pub struct PlanSolid {
    /// Shape of the piece: no half-space and no compound.
    pub shape: Shape,
    /// Placement of the shape's frame S in M.
    pub pose_MS: Pose,
}

/// The skin of a plan.
#[derive(Clone, Debug)]
pub struct PlanSkin {
    /// Surface at rest, in M.
    pub mesh: TriMesh,
    /// Per vertex: bones and their weights, of sum 1.
    pub influences: Vec<[(u32, f64); 4]>,
    /// True if it is of several meshes, which may be open where they cross: the body is what they
    /// enclose together.
    pub joined: bool,
}
