//! Offsets of skinning targets by the pose of joints.

use crate::math::{Quat, Vec3};

/// Offsets of targets by one joint's pose, of nodes that its two bodies carry: pose-space
/// deformation (Lewis et al. 2000), interpolated smoothly between poses and zero at rest. The joint
/// may be of any kind.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseOffsets {
    /// Index into `WorldDesc::softs`.
    pub soft: u32,
    /// Index into `WorldDesc::joints`.
    pub joint: u32,
    /// Poses other than rest, each as the rotation of the child from rest against the parent, in
    /// the parent's frame.
    pub poses: Vec<Quat>,
    /// Nodes of the body that the joint's two bodies carry together, each once.
    pub nodes: Vec<u32>,
    /// Offsets \[m\] in the body's model frame, from which the blended bones carry them: for each
    /// node one for each pose.
    pub offsets: Vec<Vec3>,
}
