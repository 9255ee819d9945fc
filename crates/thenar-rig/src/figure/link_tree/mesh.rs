//! Meshes of links.

use super::Body;
use crate::RigError;
use crate::mesh::load_mesh;
use crate::object::{ImportOptions, Weight, rigid_from_mesh};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Quat, Vec3};

/// Change to the vertices of a mesh file: moved, turned, then multiplied.
#[derive(Clone, Copy, Debug)]
pub(in crate::figure) struct MeshChange {
    /// Place in the file that becomes the origin.
    pub origin: Vec3,
    /// Turn of the mesh's frame, which the vertices undo.
    pub turn: Quat,
    /// Factors along x, y and z; negative ones mirror.
    pub scale: Vec3,
}

/// A mesh made ready for contact, in the frame F of its changed vertices.
#[derive(Clone, Debug)]
pub(in crate::figure) struct MeshSolid {
    /// The shape.
    pub shape: Shape,
    /// Shape frame S in F.
    pub pose_FS: Pose,
    /// Body that the mesh encloses at density 1, in F.
    pub body: Body,
}

/// Mesh files, each made ready once.
#[derive(Debug, Default)]
pub(in crate::figure) struct Meshes {
    ready: BTreeMap<(PathBuf, String), MeshSolid>,
}

impl Meshes {
    /// The mesh of a file, changed so.
    ///
    /// # Errors
    /// Names the file and the cause.
    pub fn solid(&mut self, path: &Path, change: &MeshChange) -> Result<MeshSolid, RigError> {
        let key = (path.to_owned(), format!("{change:?}"));
        if let Some(ready) = self.ready.get(&key) {
            return Ok(ready.clone());
        }
        let solid = load(path, change)?;
        self.ready.insert(key, solid.clone());
        Ok(solid)
    }
}

fn load(path: &Path, change: &MeshChange) -> Result<MeshSolid, RigError> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    if extension.as_deref() == Some("dae") {
        let what = "Collada meshes (.dae) are not read: convert it to STL, OBJ or PLY";
        return Err(RigError::invalid(what).in_file(path.display()));
    }
    let mut mesh = load_mesh(path, 1.0)?;
    for p in &mut mesh.positions {
        let turned = change.turn.inverse_transform_vector(&(*p - change.origin));
        *p = turned.component_mul(&change.scale);
    }
    if change.scale.product() < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    let made = rigid_from_mesh("", &mesh, Weight::Density(1.0), &ImportOptions::default());
    let (model, _) = made.map_err(|error| match error {
        RigError::Stopped => error,
        other => other.in_file(path.display()),
    })?;
    let body = Body { mass: model.mass, centre: Vec3::zeros(), inertia: Some(model.inertia) };
    Ok(MeshSolid {
        shape: model.shape,
        pose_FS: model.pose_MB * model.pose_BS,
        body: body.moved(&model.pose_MB),
    })
}
