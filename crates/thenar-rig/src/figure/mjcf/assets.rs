//! Meshes that geoms name.

use super::super::link_tree::{MeshChange, hint};
use super::classes::{Classes, Styled};
use super::place::quaternion;
use super::settings::Settings;
use super::{Element, RigError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use thenar_core::{Quat, Vec3};
use thenar_input::quoted;

/// `<mesh>` elements by name.
pub(super) struct Assets<'a> {
    meshes: BTreeMap<String, Element<'a>>,
}

impl<'a> Assets<'a> {
    /// The meshes of all `<asset>` elements, named after their files where they have no name.
    pub fn read(root: Element<'a>, classes: &Classes<'a>) -> Result<Self, RigError> {
        let mut meshes = BTreeMap::new();
        for mesh in root.named("asset").flat_map(|asset| asset.named("mesh")) {
            classes.named(mesh, "class", 0)?;
            let stem = |file: &str| {
                Path::new(file).file_stem().map(|stem| stem.to_string_lossy().into_owned())
            };
            let name = match mesh.name("name")? {
                Some(name) => Some(name.to_owned()),
                None => mesh.name("file")?.and_then(stem),
            };
            let name = name.ok_or_else(|| mesh.missing("file", "a mesh file"))?;
            if meshes.insert(name.clone(), mesh).is_some() {
                return Err(mesh.error(format!("there is another mesh {}", quoted(&name))));
            }
        }
        Ok(Self { meshes })
    }

    /// The file of a mesh and what is done to its vertices; `by` names it.
    pub fn mesh(
        &self,
        by: Element<'_>,
        name: &str,
        classes: &Classes<'a>,
        settings: &Settings,
    ) -> Result<(PathBuf, MeshChange), RigError> {
        let mesh = self.meshes.get(name).copied().ok_or_else(|| {
            let near = hint(name, self.meshes.keys().map(String::as_str));
            by.error(format!("there is no mesh {}{near}", quoted(name)))
        })?;
        let styled = classes.styled(mesh, 0)?;
        let path = file(mesh, settings)?;
        Ok((path, change(&styled)?))
    }
}

fn file(mesh: Element<'_>, settings: &Settings) -> Result<PathBuf, RigError> {
    let file = mesh.name("file")?.ok_or_else(|| {
        mesh.error("vertices inside the XML and built-in forms are not read: name a mesh file")
    })?;
    let path = Path::new(file);
    let path = match path.file_name().filter(|_| settings.strip_path) {
        Some(last) => Path::new(last),
        None => path,
    };
    Ok(settings.mesh_folder.join(path))
}

fn change(styled: &Styled<'_, '_>) -> Result<MeshChange, RigError> {
    let scale = Vec3::from(styled.numbers_or("scale", [1.0; 3])?);
    if scale.product() == 0.0 {
        return Err(styled.element.error("scale must not be zero"));
    }
    let turn = styled.get("refquat").map_or(Ok(Quat::identity()), quaternion)?;
    Ok(MeshChange { origin: Vec3::from(styled.numbers_or("refpos", [0.0; 3])?), turn, scale })
}
