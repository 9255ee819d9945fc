//! Links in the rest pose, upright.

use super::{Link, LinkJoint, LinkMass, LinkSolid, upright};
use crate::size::bounds;
use nalgebra::UnitVector3;
use thenar_core::model::{AngleLimit, Axis, JointKind};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Quat, Vec3};
use thenar_input::quoted;

/// A link in M; what stands in L before stands in M here.
#[derive(Clone, Debug)]
pub(super) struct Settled {
    pub name: String,
    pub parent: Option<usize>,
    pub pose_ML: Pose,
    pub joints: Vec<SettledJoint>,
    pub mass: LinkMass,
    pub solids: Vec<LinkSolid>,
}

/// A joint in M at rest; angles count from there.
#[derive(Clone, Debug)]
pub(super) struct SettledJoint {
    pub name: String,
    pub kind: JointKind,
    pub point_M: Vec3,
    pub axis_M: Vec3,
    pub axis: Axis,
    /// Angle of the file at which a hinge rests \[rad\].
    pub rest: f64,
}

/// Places links in M, each hinge at the admissible angle nearest to zero; tells of those that are
/// not at zero.
pub(super) fn settle(links: Vec<Link>, notes: &mut Vec<String>) -> Vec<Settled> {
    let mut settled: Vec<Settled> = Vec::with_capacity(links.len());
    for link in links {
        let parent = link.parent.and_then(|parent| settled.get(parent));
        let pose_MP = parent.map_or(Pose::new(Vec3::zeros(), upright()), |parent| parent.pose_ML);
        let mut pose_ML = pose_MP * link.pose_PL;
        let joints =
            link.joints.into_iter().map(|joint| settle_joint(joint, &mut pose_ML, notes)).collect();
        let in_M = |s: LinkSolid| LinkSolid { pose_LS: pose_ML * s.pose_LS, ..s };
        settled.push(Settled {
            name: link.name,
            parent: link.parent,
            pose_ML,
            joints,
            mass: link.mass.moved(&pose_ML),
            solids: link.solids.into_iter().map(in_M).collect(),
        });
    }
    settled
}

/// A joint at its angle of rest, about which the link is turned.
fn settle_joint(joint: LinkJoint, pose_ML: &mut Pose, notes: &mut Vec<String>) -> SettledJoint {
    let (point_M, axis_M) = (pose_ML.point(&joint.point_L), pose_ML.vector(&joint.axis_L));
    let mut axis = joint.axis;
    let rest = axis.limit.map_or(0.0, |limit| 0.0_f64.max(limit.min).min(limit.max));
    if joint.kind == JointKind::Hinge && rest != 0.0 {
        let turn = Quat::from_axis_angle(&UnitVector3::new_unchecked(axis_M), rest);
        let arm = pose_ML.position - point_M;
        *pose_ML = Pose::new(point_M + turn * arm, turn * pose_ML.rotation);
        axis.limit = axis.limit.map(|l| AngleLimit { min: l.min - rest, max: l.max - rest });
        axis.rest_angle -= rest;
        notes.push(format!(
            "the range of joint {} does not contain 0, so it rests at {rest:.4} rad and its angles count from \
             there",
            quoted(&joint.name)
        ));
    }
    SettledJoint { name: joint.name, kind: joint.kind, point_M, axis_M, axis, rest }
}

/// Longest side of the box around links, joints and solids \[m\]; that of nothing is 1.
pub(super) fn size(links: &[Settled]) -> f64 {
    let mut points = Vec::new();
    for link in links {
        points.push(link.pose_ML.position);
        points.extend(link.joints.iter().map(|joint| joint.point_M));
        for solid in &link.solids {
            let reach = Vec3::repeat(reach(&solid.shape));
            points.extend([solid.pose_LS.position - reach, solid.pose_LS.position + reach]);
        }
    }
    let [min, max] = bounds(&points);
    let size = (max - min).max();
    if size.is_finite() && size > 0.0 { size } else { 1.0 }
}

/// Distance of a shape's farthest point from its origin, or a little more.
fn reach(shape: &Shape) -> f64 {
    match shape {
        Shape::Sphere { radius } => *radius,
        Shape::Capsule { radius, half_length } | Shape::Cylinder { radius, half_length } => {
            radius + half_length
        }
        Shape::Cuboid { half } | Shape::Ellipsoid { half } => half.norm(),
        Shape::Mesh(mesh) => mesh.points.iter().map(Vec3::norm).fold(0.0, f64::max),
        _ => 0.0,
    }
}
