//! Bone poses, given the root and the joint angles, and the way back.

use crate::math::{Pose, Vec3};
use crate::model::{AngleLimit, HandModel, JointDesc, JointKind};
use crate::skeleton::angles::{closest_angles, joint_angles, joint_rotation, joint_spin};

/// Why joints do not make a tree of bones.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TreeError {
    /// Every bone but the root needs one joint.
    #[error("{bones} bones need {} joints, got {joints}", bones.saturating_sub(1))]
    Count {
        /// Number of bones.
        bones: usize,
        /// Number of joints.
        joints: usize,
    },
    /// Joint i must have bone i+1 as child.
    #[error("joint `{joint}` must have bone {expected} as child, got {child}")]
    Child {
        /// Name of the joint.
        joint: String,
        /// Bone it should carry.
        expected: u32,
        /// Bone it names.
        child: u32,
    },
    /// Parents come before children.
    #[error("joint `{joint}` must have a parent before bone {child}, got {parent:?}")]
    Parent {
        /// Name of the joint.
        joint: String,
        /// Child bone.
        child: u32,
        /// Parent it names.
        parent: Option<u32>,
    },
    /// A frame holds a number that is not finite.
    #[error("joint `{joint}` has a frame that is not finite")]
    NonFinite {
        /// Name of the joint.
        joint: String,
    },
    /// A limit is empty or not a number.
    #[error("joint `{joint}` has the range {min}..{max} rad")]
    Limit {
        /// Name of the joint.
        joint: String,
        /// Lower end \[rad\].
        min: f64,
        /// Upper end \[rad\].
        max: f64,
    },
}

/// The joint that carries one bone.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Link {
    kind: JointKind,
    parent: usize,
    pose_PJ: Pose,
    pose_KC: Pose,
    limits: [Option<AngleLimit>; 2],
}

/// Bones joined into a tree: bone 0 is the root, and joint i carries bone i + 1.
///
/// All methods work on slices with one entry per bone or per joint, allocate nothing, and panic
/// when a slice has the wrong length. Angles are those of [`JointKind`], in radians; poses are
/// `pose_WB` of the bone frames in the world.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Tree {
    links: Vec<Link>,
}

impl Tree {
    /// The tree of a hand.
    pub fn of_hand(hand: &HandModel) -> Result<Self, TreeError> {
        Self::new(hand.bones.len(), &hand.joints)
    }

    /// The tree of `bones` bones with these joints.
    pub fn new(bones: usize, joints: &[JointDesc]) -> Result<Self, TreeError> {
        if bones != joints.len() + 1 {
            return Err(TreeError::Count { bones, joints: joints.len() });
        }
        let links = (1..).zip(joints).map(|(child, joint)| link(child, joint));
        Ok(Self { links: links.collect::<Result<_, _>>()? })
    }

    /// Number of bones.
    pub fn bones(&self) -> usize {
        self.links.len() + 1
    }

    /// Number of joints.
    pub fn joints(&self) -> usize {
        self.links.len()
    }

    /// Kind of joint `j`.
    pub fn kind(&self, j: usize) -> JointKind {
        self.links[j].kind
    }

    /// Parent bone of joint `j`, whose child is bone `j + 1`.
    pub fn parent(&self, j: usize) -> usize {
        self.links[j].parent
    }

    /// Range of each angle of joint `j`.
    pub fn limits(&self, j: usize) -> &[Option<AngleLimit>; 2] {
        &self.links[j].limits
    }

    /// The nearest angles within the limits of joint `j`.
    pub fn clamp(&self, j: usize, angles: [f64; 2]) -> [f64; 2] {
        let limits = &self.links[j].limits;
        [0, 1].map(|k| limits[k].map_or(angles[k], |l| angles[k].max(l.min).min(l.max)))
    }

    /// Bone poses from the root's pose and the joint angles. Ball and free joints are at rest.
    pub fn forward(&self, root: &Pose, angles: &[[f64; 2]], out: &mut [Pose]) {
        self.assert_lengths(out.len(), angles.len());
        out[0] = *root;
        for (j, link) in self.links.iter().enumerate() {
            let rotation = joint_rotation(link.kind, angles[j]);
            out[j + 1] = out[link.parent] * link.pose_PJ * turn(rotation) * link.pose_KC;
        }
    }

    /// Bone poses from the root's pose and the pose `pose_JK` of each joint, whatever its kind.
    pub fn forward_joint_poses(&self, root: &Pose, poses_JK: &[Pose], out: &mut [Pose]) {
        self.assert_lengths(out.len(), poses_JK.len());
        out[0] = *root;
        for (j, link) in self.links.iter().enumerate() {
            out[j + 1] = out[link.parent] * link.pose_PJ * poses_JK[j] * link.pose_KC;
        }
    }

    /// Bone velocities (linear \[m/s\] at the bone's origin, angular \[rad/s\], world) at `poses`,
    /// which [`Self::forward`] made from `angles`; `root` and `rates` are the velocities of what
    /// it was made from.
    pub fn velocities(
        &self,
        poses: &[Pose],
        root: [Vec3; 2],
        angles: &[[f64; 2]],
        rates: &[[f64; 2]],
        out: &mut [[Vec3; 2]],
    ) {
        self.assert_lengths(out.len(), angles.len());
        self.assert_lengths(poses.len(), rates.len());
        out[0] = root;
        for (j, link) in self.links.iter().enumerate() {
            let pose_WJ = poses[link.parent] * link.pose_PJ;
            let spin_W = pose_WJ.vector(&joint_spin(link.kind, angles[j], rates[j]));
            let [velocity, angular] = out[link.parent];
            let to_joint = pose_WJ.position - poses[link.parent].position;
            let to_child = poses[j + 1].position - pose_WJ.position;
            let angular_child = angular + spin_W;
            let velocity_child =
                velocity + angular.cross(&to_joint) + angular_child.cross(&to_child);
            out[j + 1] = [velocity_child, angular_child];
        }
    }

    /// Pose `pose_JK` of joint `j` in these bone poses.
    pub fn joint_pose(&self, j: usize, poses: &[Pose]) -> Pose {
        let link = &self.links[j];
        let pose_WJ = poses[link.parent] * link.pose_PJ;
        let pose_WK = poses[j + 1] * link.pose_KC.inverse();
        pose_WJ.inverse() * pose_WK
    }

    /// Angles of all joints in these bone poses; what a joint cannot do is left out.
    pub fn angles(&self, poses: &[Pose], out: &mut [[f64; 2]]) {
        self.assert_lengths(poses.len(), out.len());
        for (j, link) in self.links.iter().enumerate() {
            out[j] = joint_angles(link.kind, &self.joint_pose(j, poses).rotation);
        }
    }

    /// Brings free bone poses onto the tree: from the root outwards, each joint takes the angles
    /// within its limits that turn its bone nearest to the wanted rotation. Wanted positions
    /// count for the root and for free joints only; balls keep their rotation.
    ///
    /// Writes the angles and the poses they make, so that [`Self::forward`] with them gives
    /// `out` back unless the tree has ball or free joints.
    pub fn project(&self, wanted: &[Pose], angles: &mut [[f64; 2]], out: &mut [Pose]) {
        self.assert_lengths(wanted.len(), angles.len());
        self.assert_lengths(out.len(), angles.len());
        out[0] = wanted[0];
        for (j, link) in self.links.iter().enumerate() {
            let pose_WJ = out[link.parent] * link.pose_PJ;
            let pose_JK = pose_WJ.inverse() * wanted[j + 1] * link.pose_KC.inverse();
            angles[j] = closest_angles(link.kind, &pose_JK.rotation, &link.limits);
            let admissible = match link.kind {
                JointKind::Free => pose_JK,
                JointKind::Ball => turn(pose_JK.rotation),
                kind => turn(joint_rotation(kind, angles[j])),
            };
            out[j + 1] = pose_WJ * admissible * link.pose_KC;
        }
    }

    fn assert_lengths(&self, bones: usize, joints: usize) {
        assert_eq!(bones, self.bones(), "one entry per bone");
        assert_eq!(joints, self.joints(), "one entry per joint");
    }
}

/// Mean velocity (linear \[m/s\], angular \[rad/s\], world) that takes `before` to `after` in
/// `dt` \[s\]; the rotation takes its shorter way.
pub fn velocity_between(before: &Pose, after: &Pose, dt: f64) -> [Vec3; 2] {
    let turned = after.rotation * before.rotation.inverse();
    [(after.position - before.position) / dt, turned.scaled_axis() / dt]
}

fn turn(rotation: crate::math::Quat) -> Pose {
    Pose::new(Vec3::zeros(), rotation)
}

fn link(child: u32, joint: &JointDesc) -> Result<Link, TreeError> {
    let name = || joint.name.clone();
    if joint.child != child {
        return Err(TreeError::Child { joint: name(), expected: child, child: joint.child });
    }
    let parent = match joint.parent {
        Some(parent) if parent < child => parent as usize,
        parent => return Err(TreeError::Parent { joint: name(), child, parent }),
    };
    if !(joint.pose_PJ.is_finite() && joint.pose_CK.is_finite()) {
        return Err(TreeError::NonFinite { joint: name() });
    }
    let limits = [joint.axes[0].limit, joint.axes[1].limit];
    for AngleLimit { min, max } in limits.iter().flatten() {
        if min.is_nan() || max.is_nan() || min > max {
            return Err(TreeError::Limit { joint: name(), min: *min, max: *max });
        }
    }
    Ok(Link {
        kind: joint.kind,
        parent,
        pose_PJ: joint.pose_PJ,
        pose_KC: joint.pose_CK.inverse(),
        limits,
    })
}

#[cfg(test)]
mod tests;
