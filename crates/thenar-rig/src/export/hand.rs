//! Hand models as files.

use super::gltf::{GlbMesh, Skeleton, glb};
use super::skinning::{dominant_bone, vertex_skin};
use super::vtk::{self, Field};
use super::write_whole;
use crate::RigError;
use std::path::Path;
use thenar_core::Vec3;
use thenar_core::model::{EmbeddedSurface, HandModel};

/// A GLB file of the hand at rest: its render surface, skinned by its bones.
///
/// # Errors
/// When the model is not consistent.
pub fn hand_glb(hand: &HandModel) -> Result<Vec<u8>, RigError> {
    check(hand)?;
    let skeleton = Skeleton {
        names: hand.bones.iter().map(|b| b.name.as_str()).collect(),
        parents: hand.bones.iter().map(|b| b.parent).collect(),
        // A bone's node lies at its joint, not at its centre of mass: other programs turn it there.
        poses: hand.bones.iter().map(|b| b.pose_MB * b.pose_BT).collect(),
    };
    let positions = embedded(hand, &hand.render);
    let skin = vertex_skin(&hand.render, &hand.flesh.tets, &hand.bindings);
    let mesh = GlbMesh {
        name: &hand.name,
        positions: &positions,
        triangles: &hand.render.triangles,
        colour: [0.72, 0.40, 0.28],
        skin: Some(&skin),
    };
    glb(&[mesh], Some(&skeleton))
}

/// Writes [`hand_glb`] to a file.
///
/// # Errors
/// As there, and when the file cannot be written.
pub fn write_hand_glb(path: &Path, hand: &HandModel) -> Result<(), RigError> {
    write_whole(path, &hand_glb(hand)?)
}

/// Writes the hand at rest as four VTK files in `folder`: `NAME-flesh.vtu` (tetrahedra; per node
/// the dominant bone, its weight and one weight per bone; per tetrahedron the material),
/// `NAME-skin.vtp`, `NAME-collision.vtp` and `NAME-bones.vtp`.
///
/// # Errors
/// When the model is not consistent, or a file cannot be written.
pub fn write_hand_vtk(folder: &Path, hand: &HandModel) -> Result<(), RigError> {
    check(hand)?;
    std::fs::create_dir_all(folder)
        .map_err(|cause| RigError::Write { file: folder.display().to_string(), cause })?;
    let flesh = &hand.flesh;
    let parts = [
        (
            "flesh.vtu",
            vtk::tetrahedra(
                &flesh.nodes,
                &flesh.tets,
                &weight_fields(hand),
                &vtk::flesh_cell_fields(flesh),
            )?,
        ),
        ("skin.vtp", skin_file(hand, &hand.render, &[])?),
        ("collision.vtp", skin_file(hand, &flesh.collision, &[digits(hand)])?),
        ("bones.vtp", bones_file(hand)?),
    ];
    for (suffix, text) in parts {
        write_whole(&folder.join(format!("{}-{suffix}", hand.name)), text.as_bytes())?;
    }
    Ok(())
}

/// Every index of the model points at something.
pub(super) fn check(hand: &HandModel) -> Result<(), RigError> {
    let (nodes, bones) = (hand.flesh.nodes.len(), hand.bones.len());
    let known = |tet: &[u32; 4]| tet.iter().all(|&i| (i as usize) < nodes);
    let inside = |surface: &EmbeddedSurface| {
        surface.vertices.iter().all(|v| (v.tet as usize) < hand.flesh.tets.len())
    };
    let bound =
        |b: &thenar_core::model::Binding| b.bones.iter().all(|&bone| (bone as usize) < bones);
    let fault = if !hand.flesh.tets.iter().all(known) {
        "a tetrahedron names a node that does not exist"
    } else if !inside(&hand.render) || !inside(&hand.flesh.collision) {
        "a surface vertex names a tetrahedron that does not exist"
    } else if hand.bindings.len() != nodes || !hand.bindings.iter().all(bound) {
        "not every node is bound to bones that exist"
    } else {
        return Ok(());
    };
    Err(RigError::invalid(format!("hand \"{}\": {fault}", hand.name)))
}

fn embedded(hand: &HandModel, surface: &EmbeddedSurface) -> Vec<Vec3> {
    let mut positions = vec![Vec3::zeros(); surface.vertices.len()];
    surface.positions(&hand.flesh.tets, &hand.flesh.nodes, &mut positions);
    positions
}

fn weight_fields(hand: &HandModel) -> Vec<Field> {
    let dominant: Vec<(u32, f64)> = hand.bindings.iter().map(dominant_bone).collect();
    let mut fields = vec![
        Field::whole("dominant bone", dominant.iter().map(|d| d.0 as i32).collect()),
        Field::scalar("dominant weight", dominant.iter().map(|d| d.1).collect()),
        Field::scalar("node volume [m3]", hand.node_volumes.clone()),
    ];
    for (j, bone) in hand.bones.iter().enumerate() {
        let weight = |b: &thenar_core::model::Binding| -> f64 {
            (0..2)
                .filter(|&k| b.bones[k] == j as u32)
                .map(|k| b.weights[k])
                .fold(0.0, |sum, w| sum + w)
        };
        let weights = hand.bindings.iter().map(weight).collect();
        fields.push(Field::scalar(format!("weight {}", bone.name), weights));
    }
    fields
}

fn digits(hand: &HandModel) -> Field {
    Field::whole("digit", hand.collision_digits.iter().map(|d| *d as i32).collect())
}

fn skin_file(
    hand: &HandModel,
    surface: &EmbeddedSurface,
    more: &[Field],
) -> Result<String, RigError> {
    let skin = vertex_skin(surface, &hand.flesh.tets, &hand.bindings);
    let mut fields = vec![
        Field::whole("dominant bone", skin.iter().map(|s| i32::from(s.bones[0])).collect()),
        Field::scalar("dominant weight", skin.iter().map(|s| f64::from(s.weights[0])).collect()),
    ];
    fields.extend_from_slice(more);
    vtk::surface(&embedded(hand, surface), &surface.triangles, &fields, &[])
}

fn bones_file(hand: &HandModel) -> Result<String, RigError> {
    let ends = |b: &thenar_core::model::Bone| b.ends_B.map(|p| b.pose_MB.point(&p));
    let points: Vec<Vec3> = hand.bones.iter().flat_map(ends).collect();
    let count = hand.bones.len() as u32;
    let segments: Vec<[u32; 2]> = (0..count).map(|i| [2 * i, 2 * i + 1]).collect();
    let real = |name: &str, f: fn(&thenar_core::model::Bone) -> f64| {
        Field::scalar(name, hand.bones.iter().map(f).collect())
    };
    let fields = [
        Field::whole("bone", (0..count as i32).collect()),
        real("mass [kg]", |b| b.mass),
        real("radius [m]", |b| b.radius),
    ];
    vtk::lines(&points, &segments, &[], &fields)
}
