//! Changes to the joints of a plan.

use super::options::JointChange;
use super::plan::{Plan, PlanJoint};
use crate::RigError;
use nalgebra::{Matrix3, Rotation3};
use thenar_core::math::tangents;
use thenar_core::model::{Axis, HandModel, JointDesc, JointKind};
use thenar_core::{Pose, Quat, Vec3};

/// Changes joints of a figure that is not built yet, one change after the other.
///
/// # Errors
/// A name fits no joint, or a change does not fit a joint.
pub fn change_plan(plan: &mut Plan, changes: &[JointChange]) -> Result<(), RigError> {
    for change in changes {
        let mut found = false;
        for bone in &mut plan.bones {
            let own = change.fits(&bone.name);
            for joint in bone.joint.iter_mut().filter(|joint| own || change.fits(&joint.name)) {
                found = true;
                change_kind(joint, change)?;
                change_axes(&joint.name, joint.kind, &mut joint.axes, change)?;
            }
        }
        if !found {
            let known = plan.bones.iter().flat_map(|bone| &bone.joint).map(|joint| &joint.name[..]);
            return Err(unknown(&change.name, known));
        }
    }
    Ok(())
}

/// Changes ranges, springs and dampers of joints of a figure that is built.
///
/// # Errors
/// The name fits no joint, or the change does not fit a joint; kinds and axes are those of the
/// build.
pub fn change_joints(figure: &mut HandModel, change: &JointChange) -> Result<(), RigError> {
    if change.kind.is_some() {
        return Err(RigError::invalid("the kind of a joint is chosen when the figure is built"));
    }
    let bones = &figure.bones;
    let fitting = |joint: &&mut JointDesc| {
        change.fits(&joint.name) || change.fits(&bones[joint.child as usize].name)
    };
    let mut found = false;
    for joint in figure.joints.iter_mut().filter(fitting) {
        found = true;
        change_axes(&joint.name, joint.kind, &mut joint.axes, change)?;
    }
    match found {
        true => Ok(()),
        false => Err(unknown(&change.name, figure.joints.iter().map(|joint| &joint.name[..]))),
    }
}

/// No joint has this name.
fn unknown<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> RigError {
    let known: Vec<&str> = known.collect();
    RigError::invalid(format!("no joint is named \"{name}\"; there are {}", known.join(", ")))
}

impl JointChange {
    fn fits(&self, name: &str) -> bool {
        match self.name.strip_suffix('*') {
            Some(start) => name.starts_with(start),
            None => name == self.name,
        }
    }
}

fn change_kind(joint: &mut PlanJoint, change: &JointChange) -> Result<(), RigError> {
    let name = &joint.name;
    if let Some((kind, axes)) = &change.kind {
        let turn = frame(*kind, axes).ok_or_else(|| {
            RigError::invalid(format!(
                "joint \"{name}\": a hinge has one axis, a universal joint two at right angles, others none"
            ))
        })?;
        let turn = turn.unwrap_or(joint.pose_MJ.rotation);
        (joint.kind, joint.pose_MJ) = (*kind, Pose::new(joint.pose_MJ.position, turn));
        joint.axes = [Axis::default(); 2];
    }
    Ok(())
}

fn change_axes(
    name: &str,
    kind: JointKind,
    axes: &mut [Axis; 2],
    change: &JointChange,
) -> Result<(), RigError> {
    let springs = if kind == JointKind::Ball { 1 } else { kind.angles() };
    let fits = |what: &str, got: usize, wanted: usize| match got == 0 || got == wanted {
        true => Ok(()),
        false => Err(RigError::invalid(format!(
            "joint \"{name}\" is a {kind:?} joint and takes {wanted} of {what}, not {got}"
        ))),
    };
    fits("ranges", change.ranges.len(), kind.angles())?;
    fits("springs", change.stiffness.len(), springs)?;
    fits("dampers", change.damping.len(), springs)?;
    if let Some(range) =
        change.ranges.iter().find(|r| !(r.min < r.max && r.min <= 0.0 && r.max >= 0.0))
    {
        return Err(RigError::invalid(format!(
            "joint \"{name}\": expected a range [smallest, largest] around the rest pose, 0, got [{:.1}, {:.1}] degrees",
            range.min.to_degrees(),
            range.max.to_degrees()
        )));
    }
    for (axis, range) in axes.iter_mut().zip(&change.ranges) {
        axis.limit = Some(*range);
    }
    for (axis, stiffness) in axes.iter_mut().zip(&change.stiffness) {
        // A spring that is given is relaxed in the rest pose.
        (axis.stiffness, axis.rest_angle) = (*stiffness, 0.0);
    }
    for (axis, damping) in axes.iter_mut().zip(&change.damping) {
        axis.damping = *damping;
    }
    Ok(())
}

/// Rotation of the joint's frame in M for these axes; inner none where any will do. None if they do
/// not fit the kind.
fn frame(kind: JointKind, axes: &[Vec3]) -> Option<Option<Quat>> {
    let units: Vec<Vec3> = axes.iter().map(|a| a.try_normalize(1e-9)).collect::<Option<_>>()?;
    match (kind, &units[..]) {
        (JointKind::Hinge, [x]) => {
            let (y, z) = tangents(x);
            Some(Some(of_axes(*x, y, z)))
        }
        // J turns about the parent's y, then the child's x.
        (JointKind::Universal, [y, x]) if x.dot(y).abs() < 1e-6 => {
            let x = (x - y * x.dot(y)).normalize();
            Some(Some(of_axes(x, *y, x.cross(y))))
        }
        (JointKind::Ball | JointKind::Fixed, []) => Some(None),
        _ => None,
    }
}

fn of_axes(x: Vec3, y: Vec3, z: Vec3) -> Quat {
    let axes = Matrix3::from_columns(&[x, y, z]);
    Quat::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
}
