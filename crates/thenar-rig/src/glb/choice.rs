//! The choice of the skinned meshes of a file that are the body: those that are named, else the one
//! that encloses most.
//!
//! Avatars have eyes, hair and clothes as meshes of their own. Hair has more area than a body and
//! long clothes as great a box, but both are thin.

use super::container::Container;
use super::skeleton;
use super::{primitive, skin::Nodes};
use crate::mesh::{components, weld_near};
use crate::{RigError, TriMesh};
use nalgebra::Matrix4;
use std::collections::HashMap;
use thenar_core::Vec3;
use thenar_input::quoted;

/// A skinned mesh of a file, in the list of what was chosen.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct SkinnedPart {
    /// Name of its node, else of its mesh.
    pub name: String,
    /// True if it is the body, or a part of it.
    pub chosen: bool,
    /// Edge lengths of its box in the file's bind shape \[m\].
    pub size: Vec3,
    /// Volume of its pieces, each closed at its own middle, in the world as the file poses it
    /// \[m³\].
    pub volume: f64,
    /// Cause for which it cannot be read, if it is damaged; size and volume are 0 then.
    pub damage: Option<String>,
}

/// A skinned mesh as it stands in a file.
pub(super) struct Source<'a> {
    pub name: String,
    pub mesh: gltf::Mesh<'a>,
    pub skin: gltf::Skin<'a>,
}

/// The skinned meshes of the default scene, in its order.
pub(super) fn sources<'a>(nodes: &Nodes<'a>) -> Result<Vec<Source<'a>>, RigError> {
    let skinned = nodes.iter().filter_map(|(node, _)| Some((node, node.skin()?)));
    let found: Vec<Source<'a>> = skinned
        .filter_map(|(node, skin)| {
            let mesh = node.mesh()?;
            let name = node.name().or(mesh.name());
            let name = name.map_or_else(|| format!("node {}", node.index()), str::to_owned);
            Some(Source { name, mesh, skin })
        })
        .collect();
    if !found.is_empty() {
        return Ok(found);
    }
    let any = nodes.iter().any(|(node, _)| node.skin().is_some());
    Err(RigError::invalid(match any {
        true => "the node that names a skin has no mesh",
        false => "the file holds no skinned mesh",
    }))
}

/// Lists the skinned meshes, those that are the body marked: those of these names, or the one of
/// greatest volume; of equals the first. One that is damaged may be the body: it is refused unless
/// another is named.
pub(super) fn choose(
    file: &Container,
    nodes: &Nodes<'_>,
    sources: &[Source<'_>],
    names: &[String],
) -> Result<Vec<SkinnedPart>, RigError> {
    let mut all = TriMesh::default();
    let mut parts = Vec::with_capacity(sources.len());
    let mut growth = HashMap::new();
    let mut first_error: Option<RigError> = None;
    for source in sources {
        let (mesh, damage) = match whole(file, &source.mesh)? {
            Ok(mesh) => (mesh, None),
            Err(error) => {
                let damage = error.to_string();
                first_error.get_or_insert(error);
                (TriMesh::default(), Some(damage))
            }
        };
        all.append(&mesh);
        all.check_count()?;
        let [low, high] = mesh.bounds();
        let empty = mesh.triangles.is_empty();
        let grown = growth
            .entry(source.skin.index())
            .or_insert_with(|| skeleton::growth(file, &source.skin, nodes));
        parts.push(SkinnedPart {
            name: source.name.clone(),
            chosen: false,
            size: if empty { Vec3::zeros() } else { high - low },
            volume: volume(&mesh) * *grown,
            damage,
        });
    }
    if let (Some(error), true) = (first_error, names.is_empty()) {
        let sound = parts.iter().filter(|part| part.damage.is_none());
        let sound = sound.map(|part| quoted(&part.name).to_string()).collect::<Vec<_>>();
        let damaged = parts.iter().find(|part| part.damage.is_some());
        return Err(match damaged.filter(|_| !sound.is_empty()) {
            Some(part) => RigError::invalid(format!(
                "mesh {}: {error}; if the body is another one, name it (`--mesh NAME`, in a scene `mesh`): {}",
                quoted(&part.name),
                sound.join(", ")
            )),
            None => error,
        });
    }
    if names.is_empty() {
        let most =
            (0..parts.len()).reduce(|a, b| if parts[b].volume > parts[a].volume { b } else { a });
        most.into_iter().for_each(|k| parts[k].chosen = true);
        return Ok(parts);
    }
    for name in names {
        let mut found = false;
        for part in parts.iter_mut().filter(|part| part.name == *name) {
            if let Some(damage) = &part.damage {
                return Err(RigError::invalid(format!("mesh {}: {damage}", quoted(name))));
            }
            (part.chosen, found) = (true, true);
        }
        if !found {
            return Err(RigError::invalid(format!(
                "the file has no skinned mesh {}; it has {}",
                quoted(name),
                listed(&parts)
            )));
        }
    }
    Ok(parts)
}

/// Names of parts for an error.
pub(super) fn listed(parts: &[SkinnedPart]) -> String {
    parts.iter().map(|part| quoted(&part.name).to_string()).collect::<Vec<_>>().join(", ")
}

/// The triangles of a mesh, where they stand in the file, or its damage.
///
/// # Errors
/// The mesh is too large, whichever it is.
fn whole(file: &Container, source: &gltf::Mesh<'_>) -> Result<Result<TriMesh, RigError>, RigError> {
    let mut mesh = TriMesh::default();
    for part in source.primitives() {
        match primitive::read(file, &part, &Matrix4::identity()) {
            Ok(piece) => mesh.append(&piece),
            Err(damage) => return Ok(Err(damage)),
        }
        mesh.check_count()?;
    }
    Ok(Ok(mesh))
}

/// Volume of a mesh's connected pieces, each closed by cones from its border to the middle of its
/// vertices: exact of closed pieces, nothing of flat ones, whichever side is out.
fn volume(mesh: &TriMesh) -> f64 {
    let [low, high] = mesh.bounds();
    let size = (high - low).norm();
    // Of nothing the box is empty; of what is out of range the body's own checks tell.
    if !size.is_finite() || mesh.triangles.is_empty() {
        return 0.0;
    }
    let mesh = weld_near(mesh);
    let (of_vertex, count) = components(&mesh);
    let mut sums = vec![(Vec3::zeros(), 0.0); count];
    for (p, &k) in mesh.positions.iter().zip(&of_vertex).filter(|(_, k)| **k != u32::MAX) {
        let (sum, number) = &mut sums[k as usize];
        (*sum, *number) = (*sum + p, *number + 1.0);
    }
    let mut volumes = vec![0.0; count];
    for (t, corners) in mesh.triangles.iter().enumerate() {
        let k = of_vertex[corners[0] as usize] as usize;
        let middle = sums[k].0 / sums[k].1;
        let [a, b, c] = mesh.corners(t).map(|p| p - middle);
        volumes[k] += a.dot(&b.cross(&c)) / 6.0;
    }
    volumes.iter().map(|v: &f64| v.abs()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    /// A box without its lid lacks the pyramid from the lid to its middle, a sixth. A sheet has no
    /// volume.
    #[test]
    fn open_pieces_are_closed_at_their_own_middle() {
        let cube = shapes::cuboid(&Vec3::repeat(0.5));
        assert!((volume(&cube) - 1.0).abs() < 1e-12);
        let mut two = cube.clone();
        let far = cube.clone().transformed(&thenar_core::Pose::translation(40.0, 0.0, 0.0));
        two.append(&far);
        two.triangles.iter_mut().skip(12).for_each(|t| t.swap(1, 2));
        assert!((volume(&two) - 2.0).abs() < 1e-9, "one of them inside out");
        let mut open = cube.clone();
        open.triangles.retain(|t| !t.iter().all(|&v| cube.positions[v as usize].y > 0.49));
        assert!((volume(&open) - 5.0 / 6.0).abs() < 1e-9, "{}", volume(&open));
        let mut sheet = cube.clone();
        sheet.triangles.retain(|t| t.iter().all(|&v| cube.positions[v as usize].y > 0.49));
        assert!(volume(&sheet.compacted()).abs() < 1e-12);
        assert_eq!(volume(&TriMesh::default()), 0.0);
    }
}
