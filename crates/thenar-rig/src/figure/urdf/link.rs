//! Links of URDF files.

use super::super::link_tree::{Body, Link, LinkMass, Meshes, is_inertia};
use super::{Element, RigError, geometry, origin};
use std::path::Path;
use thenar_core::{Mat3, Pose, Vec3};
use thenar_input::quoted;

/// A link, yet without parent and joint.
pub(super) fn read(
    element: Element<'_>,
    name: String,
    folder: &Path,
    meshes: &mut Meshes,
) -> Result<Link, RigError> {
    let body = mass(element, &name)?;
    let drawn = if element.child("collision").is_some() { "collision" } else { "visual" };
    let mut solids = Vec::new();
    for piece in element.named(drawn) {
        solids.push(geometry::read(piece, &name, folder, meshes)?);
    }
    let mass = LinkMass { body, stated: body.is_some() };
    Ok(Link { name, parent: None, pose_PL: Pose::identity(), joints: Vec::new(), mass, solids })
}

/// The mass of a link; none where it is zero.
fn mass(element: Element<'_>, name: &str) -> Result<Option<Body>, RigError> {
    let Some(inertial) = element.child("inertial") else { return Ok(None) };
    let mass = inertial.needs("mass")?.needs_number("value")?;
    if mass < 0.0 {
        let what = format!("link {}: mass must be at least 0, not {mass}", quoted(name));
        return Err(inertial.error(what));
    }
    if mass == 0.0 {
        return Ok(None);
    }
    let inertia = inertial.child("inertia").map(|inertia| tensor(inertia, name)).transpose()?;
    let body = Body { mass, centre: Vec3::zeros(), inertia };
    Ok(Some(body.moved(&origin(inertial)?)))
}

/// The six numbers of a tensor, positive definite.
fn tensor(element: Element<'_>, name: &str) -> Result<Mat3, RigError> {
    let [xx, yy, zz] = ["ixx", "iyy", "izz"].map(|name| element.needs_number(name));
    let [xy, xz, yz] = ["ixy", "ixz", "iyz"].map(|name| element.number(name));
    let (xy, xz, yz) = (xy?.unwrap_or(0.0), xz?.unwrap_or(0.0), yz?.unwrap_or(0.0));
    let tensor = Mat3::new(xx?, xy, xz, xy, yy?, yz, xz, yz, zz?);
    if is_inertia(&tensor) {
        return Ok(tensor);
    }
    Err(element.error(format!("link {}: the inertia is not positive definite", quoted(name))))
}
