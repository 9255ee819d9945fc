//! Offsets of skinning targets that a hand's own flesh gives: where it comes to rest around bent
//! bones that hold it at the bone alone, and how far skinning puts it from there (pose-space
//! deformation of Lewis et al. 2000, with physics for the sculptor).

use super::bend::{AxisOf, Bender, SHAPE_STEP, moves};
use crate::RigError;
use crate::work::Stage;
use thenar_core::math::Mat3;
use thenar_core::model::{Binding, CouplingKind, HandModel, PoseOffsets, Skinning};
use thenar_core::{Pose, Quat, Vec3};

/// Widest way between two poses of an axis \[rad\], 30°. Where poses lay 45° apart, half of what
/// targets lacked was left between the first two of a last finger joint.
const APART: f64 = std::f64::consts::FRAC_PI_6;
/// A turn that is not worth a pose \[rad\]: a sixth of that.
const SMALL: f64 = APART / 6.0;

/// Offsets of the targets of a hand's flesh by the poses of all its joints, with indices of the
/// hand's own joints and `soft` 0. Each axis is bent alone, to both ends of its range.
///
/// # Errors
/// The hand has no bone in its flesh, the work would be too much, or the flesh finds no rest.
pub fn sculpted_offsets(
    hand: &HandModel,
    skinning: Skinning,
) -> Result<Vec<PoseOffsets>, RigError> {
    if hand.bone_nodes.iter().all(|node| node.volume == 0.0) {
        return Err(RigError::invalid(
            "no node of the flesh lies in bone, around which it could come to rest",
        ));
    }
    let mut all: Vec<PoseOffsets> =
        (0..hand.joints.len()).map(|j| without_poses(hand, j)).collect();
    let mut bender = Bender::held(hand, CouplingKind::Bone, SHAPE_STEP)?;
    let axes = Bender::axes(hand).into_iter().filter(|(j, _)| !all[*j].nodes.is_empty());
    let turns: Vec<(AxisOf, f64)> = axes.flat_map(|axis| turns(&bender, hand, axis)).collect();
    let work = (Bender::SHAPE_WORK * hand.flesh.tets.len() * turns.len()) as f64;
    let stage = Stage::new("shapes of bent joints", turns.len(), work, "ask for fewer tetrahedra")?;
    let mut shapes: Vec<Vec<Vec3>> = vec![Vec::new(); hand.joints.len()];
    for (done, &((j, k), turn)) in turns.iter().enumerate() {
        let (poses, x) = bender.shape((j, k), turn)?;
        let target = Blend { hand, moves: &moves(hand, &poses), joint: j, skinning };
        for &node in &all[j].nodes {
            shapes[j].push(target.offset(node as usize, &x[node as usize])?);
        }
        all[j].poses.push(turned(hand, &poses, j));
        stage.at(done + 1)?;
    }
    for (given, shapes) in all.iter_mut().zip(&shapes) {
        let (nodes, poses) = (given.nodes.len(), given.poses.len());
        given.offsets = (0..nodes * poses).map(|i| shapes[i % poses * nodes + i / poses]).collect();
    }
    all.retain(|given| !given.poses.is_empty());
    Ok(all)
}

/// The turns of an axis from rest to the ends of its range, in parts.
fn turns(bender: &Bender<'_>, hand: &HandModel, (j, k): AxisOf) -> Vec<(AxisOf, f64)> {
    let Some(limit) = hand.joints[j].axes[k].limit else { return Vec::new() };
    let ends = [limit.min, limit.max].map(|end| end - bender.angle_at_rest((j, k)));
    let parts = |end: f64| {
        let count = (end.abs() / APART).ceil();
        (1..=count as usize).map(move |part| end * part as f64 / count)
    };
    let worth = ends.into_iter().filter(|end| end.abs() > SMALL);
    worth.flat_map(parts).map(|turn| ((j, k), turn)).collect()
}

/// The nodes that the bodies of a joint carry together.
fn without_poses(hand: &HandModel, j: usize) -> PoseOffsets {
    let joint = &hand.joints[j];
    let both = |binding: &Binding| {
        let of = |bone: u32| (0..2).any(|k| binding.bones[k] == bone && binding.weights[k] > 0.0);
        of(joint.child) && joint.parent.is_some_and(of)
    };
    let nodes = hand.bindings.iter().zip(0..).filter(|(binding, _)| both(binding)).map(|(_, n)| n);
    PoseOffsets {
        soft: 0,
        joint: j as u32,
        poses: Vec::new(),
        nodes: nodes.collect(),
        offsets: Vec::new(),
    }
}

/// Rotation of a joint's child from rest against its parent, in the parent's frame.
fn turned(hand: &HandModel, poses: &[Pose], j: usize) -> Quat {
    let child = hand.joints[j].child as usize;
    let parent = poses[hand.joints[j].parent.unwrap_or(0) as usize].rotation;
    let rest = hand.bones[child].pose_MB.rotation;
    parent.inverse() * poses[child].rotation * rest.inverse() * parent
}

/// Skinning of the nodes that one joint's bodies carry.
struct Blend<'a> {
    hand: &'a HandModel,
    moves: &'a [Pose],
    joint: usize,
    skinning: Skinning,
}

impl Blend<'_> {
    /// The offset at rest, model frame \[m\], that takes a node's target to `x`.
    fn offset(&self, node: usize, x: &Vec3) -> Result<Vec3, RigError> {
        let (binding, rest) = (&self.hand.bindings[node], &self.hand.flesh.nodes[node]);
        let [a, b] = binding.bones.map(|bone| &self.moves[bone as usize]);
        let [u, v] = binding.weights;
        let blend = |p: &Vec3| a.point(p) * u + b.point(p) * v;
        match self.skinning {
            Skinning::Linear => {
                let matrix = |pose: &Pose| *pose.rotation.to_rotation_matrix().matrix();
                let carried: Mat3 = matrix(a) * u + matrix(b) * v;
                let inverse = carried.try_inverse().ok_or_else(|| {
                    RigError::invalid(
                        "linear blending flattens a node where a joint is bent by half a turn",
                    )
                })?;
                Ok(inverse * (x - blend(rest)))
            }
            Skinning::Joint => {
                let joint = &self.hand.joints[self.joint];
                let centre =
                    (self.hand.bones[joint.child as usize].pose_MB * joint.pose_CK).position;
                let sign = 1.0_f64.copysign(a.rotation.coords.dot(&b.rotation.coords));
                let blended = a.rotation.coords * u + b.rotation.coords * (v * sign);
                let turn = Quat::new_normalize(blended.into());
                Ok(turn.inverse() * (x - blend(&centre)) - (rest - centre))
            }
        }
    }
}
