//! Figures from files, by their ending.

use super::glb::read_glb_plan_of;
use super::{FigureOptions, FigureReport, Plan, build_figure, read_mjcf, read_urdf};
use crate::RigError;
use crate::mesh::read_file;
use std::path::Path;
use thenar_core::model::HandModel;

/// The kind of a file that holds a tree of bones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// GLB or VRM: a skinned mesh.
    Skinned,
    Urdf,
    /// XML, whose first element says which.
    Xml,
}

fn kind(path: &Path) -> Option<Kind> {
    let ending = path.extension()?.to_str()?.to_ascii_lowercase();
    match ending.as_str() {
        "glb" | "vrm" => Some(Kind::Skinned),
        "urdf" => Some(Kind::Urdf),
        "xml" | "mjcf" => Some(Kind::Xml),
        _ => None,
    }
}

/// True if the ending is that of a file that may hold a figure: GLB, VRM, URDF, MJCF, XML.
pub fn is_figure(path: &Path) -> bool {
    kind(path).is_some()
}

/// The plan of a figure in a file: GLB or VRM (a skinned mesh), URDF, or MJCF (`.xml`, `.mjcf`).
///
/// # Errors
/// When the file cannot be read, is of no such kind, or is not well-formed; names the file.
pub fn read_plan(path: &Path) -> Result<Plan, RigError> {
    read_plan_of(path, &[])
}

/// [`read_plan`] of the skinned meshes of these names; without names, of the one that encloses
/// most.
///
/// # Errors
/// As there; also when meshes are named of a file that has no skin, or that has none of that name.
pub fn read_plan_of(path: &Path, meshes: &[String]) -> Result<Plan, RigError> {
    let Some(kind) = kind(path) else {
        return Err(RigError::invalid(format!(
            "{}: expected a .glb, .vrm, .urdf, .xml or .mjcf file",
            path.display()
        )));
    };
    let bytes = read_file(path)?;
    let plan = match kind {
        Kind::Skinned => read_glb_plan_of(&bytes, meshes),
        _ if !meshes.is_empty() => Err(RigError::invalid(
            "only skinned meshes (GLB, VRM) have meshes to choose from: leave their names out",
        )),
        Kind::Urdf | Kind::Xml => described(&bytes, kind, path),
    };
    plan.map_err(|e| e.in_file(path.display()))
}

fn described(bytes: &[u8], kind: Kind, path: &Path) -> Result<Plan, RigError> {
    let text = std::str::from_utf8(bytes)
        .map_err(|e| RigError::invalid(format!("the text is not UTF-8: {e}")))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    // A robot's description may have either ending.
    let is_urdf = kind == Kind::Urdf || text.contains("<robot") && !text.contains("<mujoco");
    if is_urdf { read_urdf(text, folder) } else { read_mjcf(text, folder) }
}

/// Builds a figure from a file.
///
/// # Errors
/// As [`read_plan`] and [`build_figure`], naming the file.
pub fn build_figure_file(
    path: &Path,
    options: &FigureOptions,
) -> Result<(HandModel, FigureReport), RigError> {
    build_figure(read_plan_of(path, &options.meshes)?, options)
        .map_err(|e| e.in_file(path.display()))
}
