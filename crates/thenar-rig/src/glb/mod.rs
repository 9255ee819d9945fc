//! Reading of binary glTF (GLB): plain meshes for objects, skinned meshes for hands.
//!
//! Everything a file says is checked before it is used: ranges, strides, counts, indices, finite
//! numbers, the tree of nodes. Buffers outside the file, sparse accessors and compressed meshes
//! are refused. Morph targets, materials and animations are ignored.

mod accessor;
mod choice;
mod container;
mod primitive;
mod skeleton;
mod skin;
mod tree;

pub use choice::SkinnedPart;
pub use skin::{RigJoint, SkinnedMesh};

use crate::{RigError, TriMesh};
use container::Container;

/// All triangles of a file's default scene as one mesh, node transforms applied \[m\].
/// Skinned meshes are taken in their bind shape.
///
/// # Errors
/// When the bytes are not a well-formed GLB 2.0 file or hold no triangles.
pub fn read_glb(bytes: &[u8]) -> Result<TriMesh, RigError> {
    let file = Container::new(bytes)?;
    let mut mesh = TriMesh::default();
    for (node, world) in tree::world_matrices(&file.document)? {
        let Some(source) = node.mesh() else { continue };
        // glTF 2.0, section 3.7.3.3: the transform of a skinned mesh's node is ignored.
        let placement = if node.skin().is_some() { nalgebra::Matrix4::identity() } else { world };
        for part in source.primitives() {
            mesh.append(&primitive::read(&file, &part, &placement)?);
            mesh.check_count()?;
        }
    }
    if mesh.triangles.is_empty() {
        return Err(RigError::invalid("the file's scene holds no triangles"));
    }
    mesh.check()?;
    Ok(mesh)
}

/// The skinned mesh of a file that encloses most, with its joints, in mesh space \[m\]: of an
/// avatar the body, not an eye.
///
/// # Errors
/// When the bytes are not a well-formed GLB 2.0 file, or no mesh is bound to a skin.
pub fn read_skinned_glb(bytes: &[u8]) -> Result<SkinnedMesh, RigError> {
    read_skinned_glb_of(bytes, &[])
}

/// The skinned meshes of these names as one, with the joints of their skeleton, in the space of the
/// first \[m\]; without names, the mesh that encloses most.
///
/// # Errors
/// As [`read_skinned_glb`]; also when a name is none of the file's, or meshes hang on skeletons
/// without common joints.
pub fn read_skinned_glb_of(bytes: &[u8], names: &[String]) -> Result<SkinnedMesh, RigError> {
    skin::read(&Container::new(bytes)?, names)
}

/// Names of the skinned meshes of a file, in its order.
///
/// # Errors
/// When the bytes are not a well-formed GLB 2.0 file, or no mesh is bound to a skin.
pub fn skinned_names(bytes: &[u8]) -> Result<Vec<String>, RigError> {
    let file = Container::new(bytes)?;
    let nodes = tree::world_matrices(&file.document)?;
    Ok(choice::sources(&nodes)?.into_iter().map(|source| source.name).collect())
}

#[cfg(test)]
mod tests;
