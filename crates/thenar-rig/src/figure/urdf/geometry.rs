//! Geometry of URDF links.

use super::super::link_tree::{LinkSolid, MeshChange, Meshes, y_to_z};
use super::{Element, RigError, origin};
use std::path::{Path, PathBuf};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Quat, Vec3};
use thenar_input::quoted;

/// Folders above the file's own in which meshes of packages are looked for.
const ANCESTORS: usize = 3;

/// The solid of a `<collision>` or `<visual>`.
pub(super) fn read(
    piece: Element<'_>,
    link: &str,
    folder: &Path,
    meshes: &mut Meshes,
) -> Result<LinkSolid, RigError> {
    let geometry = piece.needs("geometry")?;
    let pose_LG = origin(piece)?;
    let Some(form) = geometry.children().next() else {
        return Err(geometry.error(format!("link {}: no shape is given", quoted(link))));
    };
    if form.tag() == "mesh" {
        return mesh(form, &pose_LG, folder, meshes);
    }
    let (shape, turn) = primitive(form, link)?;
    Ok(LinkSolid { shape, pose_LS: pose_LG * Pose::new(Vec3::zeros(), turn) })
}

/// A shape and the turn of its frame in that of the geometry, where axes lie along z.
fn primitive(form: Element<'_>, link: &str) -> Result<(Shape, Quat), RigError> {
    match form.tag() {
        "box" => {
            let size = form.numbers::<3>("size")?;
            let size = Vec3::from(size.ok_or_else(|| form.missing("size", "three lengths"))?);
            let half = size * 0.5;
            if half.min() <= 0.0 {
                return Err(form.error("size must be positive along each axis"));
            }
            Ok((Shape::Cuboid { half }, Quat::identity()))
        }
        "sphere" => Ok((Shape::Sphere { radius: length(form, "radius")? }, Quat::identity())),
        "cylinder" | "capsule" => {
            let radius = length(form, "radius")?;
            let half_length = 0.5 * length(form, "length")?;
            let shape = match form.tag() {
                "cylinder" => Shape::Cylinder { radius, half_length },
                _ => Shape::Capsule { radius, half_length },
            };
            Ok((shape, y_to_z()))
        }
        _ => Err(form.error(format!(
            "link {} has a shape that is not known (box, sphere, cylinder, capsule and mesh are)",
            quoted(link)
        ))),
    }
}

fn length(form: Element<'_>, name: &str) -> Result<f64, RigError> {
    let length = form.needs_number(name)?;
    if length > 0.0 {
        return Ok(length);
    }
    Err(form.error(format!("{name} must be positive, not {length}")))
}

fn mesh(
    form: Element<'_>,
    pose_LG: &Pose,
    folder: &Path,
    meshes: &mut Meshes,
) -> Result<LinkSolid, RigError> {
    let name = form.needs_name("filename")?;
    let scale = form.numbers::<3>("scale")?.map_or(Vec3::repeat(1.0), Vec3::from);
    if scale.product() == 0.0 {
        return Err(form.error("scale must not be zero"));
    }
    let path = find(name, folder).ok_or_else(|| {
        form.error(format!(
            "the mesh file {} is neither in {} nor in the {ANCESTORS} folders above",
            quoted(name),
            quoted(&folder.display().to_string())
        ))
    })?;
    let change = MeshChange { origin: Vec3::zeros(), turn: Quat::identity(), scale };
    let solid = meshes.solid(&path, &change)?;
    Ok(LinkSolid { shape: solid.shape, pose_LS: *pose_LG * solid.pose_FS })
}

/// Finds the file of a mesh. Packages are looked for in the file's folder and above it, with and
/// without their names.
fn find(name: &str, folder: &Path) -> Option<PathBuf> {
    let package = ["package://", "model://"].iter().find_map(|scheme| name.strip_prefix(scheme));
    let plain = name.strip_prefix("file://").unwrap_or(name);
    let inside = package.and_then(|rest| rest.split_once('/')).map(|(_, inside)| inside);
    let candidates = [Some(package.unwrap_or(plain)), inside];
    // Above a folder like `.` only its full path tells what is.
    let whole = std::fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
    for above in [folder].into_iter().chain(whole.ancestors().skip(1).take(ANCESTORS)) {
        for candidate in candidates.iter().flatten() {
            let path = above.join(candidate);
            if path.is_file() {
                return Some(path);
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_are_found_beside_and_above_the_file() {
        let root = std::env::temp_dir().join(format!("thenar-urdf-find-{}", std::process::id()));
        let urdf = root.join("robot/urdf/deep");
        std::fs::create_dir_all(&urdf).unwrap();
        std::fs::create_dir_all(root.join("robot/meshes")).unwrap();
        let mesh = root.join("robot/meshes/arm.stl");
        std::fs::write(&mesh, "").unwrap();
        let same = |name: &str| {
            let found = find(name, &urdf).map(|path| path.canonicalize().unwrap());
            found == Some(mesh.canonicalize().unwrap())
        };
        assert!(same("package://robot/meshes/arm.stl"));
        assert!(same("package://else/meshes/arm.stl"));
        assert!(same("../../meshes/arm.stl") && same("meshes/arm.stl"));
        assert!(same(&format!("file://{}", mesh.display())));
        assert!(find("package://robot/meshes/leg.stl", &urdf).is_none());
        std::fs::remove_dir_all(&root).unwrap();
    }
}
