//! Common form of descriptions of robots: links with joints between them, fixed and weightless ones
//! among them, of which a [`Plan`] of bones is made.

mod combine;
mod mass;
mod merge;
mod mesh;
mod mimic;
mod settle;

pub(super) use mass::{Body, LinkMass, is_inertia, of_shape};
pub(super) use mesh::{MeshChange, Meshes};
pub(super) use mimic::Follows;

use super::plan::{Plan, PlanBone, PlanSolid};
use crate::RigError;
use crate::mesh::COORDINATE_MAX;
use merge::Bone;
use nalgebra::Rotation3;
use settle::settle;
use thenar_core::math::tangents;
use thenar_core::model::{Axis, JointKind};
use thenar_core::shape::Shape;
use thenar_core::{Mat3, Pose, Quat, Vec3};
use thenar_input::quoted;

/// Shorter vectors have no direction.
pub(super) const SHORT: f64 = 1e-10;
/// Names that a message lists before it counts the rest.
const LISTED: usize = 8;

/// Links as a file has them, parents before children, the first the root. The file's z is up.
#[derive(Clone, Debug)]
pub(super) struct LinkTree {
    /// Name of the figure; empty where it has none.
    pub name: String,
    /// Word for a link in the format.
    pub noun: &'static str,
    /// All links.
    pub links: Vec<Link>,
    /// Joints that follow others.
    pub follows: Vec<Follows>,
    /// Notes on what was changed or passed over.
    pub notes: Vec<String>,
}

/// A link with its frame L.
#[derive(Clone, Debug)]
pub(super) struct Link {
    /// Unique name.
    pub name: String,
    /// Index of the parent, smaller than the link's own.
    pub parent: Option<usize>,
    /// Placement in the parent's frame at zero angles.
    pub pose_PL: Pose,
    /// Joints to the parent, in the order in which they turn the link; none holds it fast.
    pub joints: Vec<LinkJoint>,
    /// Mass in L.
    pub mass: LinkMass,
    /// Geometry in L.
    pub solids: Vec<LinkSolid>,
}

/// A hinge or ball joint of a link.
#[derive(Clone, Debug)]
pub(super) struct LinkJoint {
    /// Unique name.
    pub name: String,
    /// Hinge or ball.
    pub kind: JointKind,
    /// A point on the axis, in L.
    pub point_L: Vec3,
    /// Unit axis in L.
    pub axis_L: Vec3,
    /// Range, spring and damper; angles count from the placement of the link in its parent.
    pub axis: Axis,
}

/// A piece of a link.
#[derive(Clone, Debug)]
pub(super) struct LinkSolid {
    /// Shape of the piece.
    pub shape: Shape,
    /// Placement of the shape's frame in L.
    pub pose_LS: Pose,
}

/// From the file's axes (z up) to the figure's (y up).
pub(super) fn upright() -> Quat {
    Quat::from_axis_angle(&Vec3::x_axis(), -std::f64::consts::FRAC_PI_2)
}

/// From a shape's axis y to the z along which the file's capsules and cylinders lie.
pub(super) fn y_to_z() -> Quat {
    Quat::from_axis_angle(&Vec3::x_axis(), std::f64::consts::FRAC_PI_2)
}

/// A vector of length 1 in this direction, if it has any.
pub(super) fn unit(v: &Vec3) -> Option<Vec3> {
    let length = v.norm();
    (length.is_finite() && length > SHORT).then(|| v / length)
}

/// The turn to the frame of these perpendicular unit vectors x and y.
pub(super) fn frame_of(x: &Vec3, y: &Vec3) -> Quat {
    let axes = Mat3::from_columns(&[*x, *y, x.cross(y)]);
    Quat::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
}

/// A right-handed frame whose x is this unit vector.
fn frame_of_x(x: &Vec3) -> Quat {
    frame_of(x, &tangents(x).0)
}

/// `"a", "b" and 3 more`, for a note.
pub(super) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut names = names.into_iter();
    let shown: Vec<String> = names.by_ref().take(LISTED).map(quoted).collect();
    let more = names.count();
    match (more, shown.split_last()) {
        (0, Some((last, [_, ..]))) => {
            format!("{} and {last}", shown[..shown.len() - 1].join(", "))
        }
        (0, _) => shown.join(", "),
        _ => format!("{} and {more} more", shown.join(", ")),
    }
}

/// The name most like `word`, for a message; empty when none is near.
pub(super) fn hint<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let limit = (word.chars().count() / 3).clamp(1, 4);
    let distances = known.into_iter().map(|name| (edits(word, name), name));
    match distances.filter(|(distance, _)| *distance <= limit).min_by_key(|(d, _)| *d) {
        Some((_, name)) => format!("; did you mean {}?", quoted(name)),
        None => String::new(),
    }
}

/// Least number of characters put in, left out or replaced between the first 64 of two words.
fn edits(a: &str, b: &str) -> usize {
    let [a, b] = [a, b].map(|word| word.chars().take(64).collect::<Vec<char>>());
    let mut above: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut row = vec![i + 1];
        for (j, y) in b.iter().enumerate() {
            let replaced = above[j] + usize::from(x != y);
            row.push(replaced.min(above[j + 1] + 1).min(row[j] + 1));
        }
        above = row;
    }
    above[b.len()]
}

impl LinkTree {
    /// Stands the links upright, merges what does not move by itself, and makes bones of the rest.
    ///
    /// # Errors
    /// Names the link or the joint that cannot be simulated.
    pub fn finish(self) -> Result<Plan, RigError> {
        let Self { name, noun, links, follows, mut notes } = self;
        let settled = settle(links, &mut notes);
        let size = settle::size(&settled);
        let bones = merge::bones(settled, noun, size, &mut notes)?;
        for bone in &bones {
            check(bone, noun)?;
        }
        let mimics = mimic::resolve(&follows, &bones, &mut notes)?;
        let bones = bones.into_iter().map(plan_bone).collect();
        Ok(Plan { name, bones, skin: None, mimics, notes })
    }
}

fn plan_bone(bone: Bone) -> PlanBone {
    let solid = |s: LinkSolid| PlanSolid { shape: s.shape, pose_MS: s.pose_LS };
    PlanBone {
        name: bone.link.name,
        parent: bone.parent,
        pose_ML: bone.link.pose_ML,
        joint: bone.joint,
        mass: bone.link.mass.told(),
        solids: bone.link.solids.into_iter().map(solid).collect(),
    }
}

/// Errs when a number of the bone became infinite or senselessly large.
fn check(bone: &Bone, noun: &str) -> Result<(), RigError> {
    let near = |pose: &Pose| pose.is_finite() && pose.position.amax() <= COORDINATE_MAX;
    let solids = bone.link.solids.iter().all(|solid| near(&solid.pose_LS));
    let joint = bone.joint.as_ref().is_none_or(|joint| near(&joint.pose_MJ));
    let mass = bone.link.mass.told().is_none_or(|mass| {
        let inertia = mass.inertia_M.is_none_or(|i| i.iter().all(|x| x.is_finite()));
        mass.mass.is_finite() && near(&Pose::new(mass.centre_M, Quat::identity())) && inertia
    });
    if near(&bone.link.pose_ML) && solids && joint && mass {
        return Ok(());
    }
    Err(RigError::invalid(format!(
        "{noun} {} has a place beyond {COORDINATE_MAX:e} m or a mass that is not finite (are the units right?)",
        quoted(&bone.link.name)
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_listed_and_suggested() {
        assert_eq!(listed(["a"]), "\"a\"");
        assert_eq!(listed(["a", "b", "c"]), "\"a\", \"b\" and \"c\"");
        assert!(listed(["x"; 11]).ends_with("\"x\" and 3 more"));
        assert_eq!(hint("forarm", ["hand", "forearm"]), "; did you mean \"forearm\"?");
        assert_eq!(hint("leg", ["hand", "forearm"]), "");
        assert_eq!(edits("kitten", "sitting"), 3);
    }

    #[test]
    fn turns_are_those_that_their_names_say() {
        assert!((upright() * Vec3::new(1.0, 2.0, 3.0) - Vec3::new(1.0, 3.0, -2.0)).norm() < 1e-12);
        assert!((y_to_z() * Vec3::y() - Vec3::z()).norm() < 1e-12);
        for axis in [Vec3::x(), -Vec3::x(), Vec3::new(0.6, 0.0, -0.8), -Vec3::z()] {
            assert!((frame_of_x(&axis) * Vec3::x() - axis).norm() < 1e-12, "{axis}");
        }
    }
}
