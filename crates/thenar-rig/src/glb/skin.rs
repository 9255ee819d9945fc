//! Skinned meshes.

use super::container::Container;
use super::{accessor, primitive, tree};
use crate::{RigError, TriMesh};
use gltf::accessor::Dimensions;
use gltf::mesh::Semantic;
use nalgebra::{Matrix3, Matrix4, Rotation3};
use std::collections::HashMap;
use thenar_core::{Pose, Quat};

/// A joint of a rig.
#[derive(Clone, Debug)]
pub struct RigJoint {
    /// Name in the file.
    pub name: String,
    /// Rest pose in mesh space; position \[m\].
    pub pose: Pose,
    /// The nearest joint above it in the tree of nodes.
    pub parent: Option<u32>,
}

/// A mesh bound to joints, in its rest shape.
#[derive(Clone, Debug)]
pub struct SkinnedMesh {
    /// Surface, as stored (seams not welded).
    pub mesh: TriMesh,
    /// Joints of the skin.
    pub joints: Vec<RigJoint>,
    /// Per vertex: joints and their weights, of sum 1.
    pub influences: Vec<[(u32, f64); 4]>,
}

pub(super) fn read(file: &Container) -> Result<SkinnedMesh, RigError> {
    let nodes = tree::world_matrices(&file.document)?;
    let (node, skin) = nodes
        .iter()
        .find_map(|(node, _)| Some((node, node.skin()?)))
        .ok_or_else(|| RigError::invalid("the file holds no skinned mesh"))?;
    let source =
        node.mesh().ok_or_else(|| RigError::invalid("the node that names a skin has no mesh"))?;
    let joints = joints(file, &skin, &nodes)?;

    let mut mesh = TriMesh::default();
    let mut influences = Vec::new();
    for part in source.primitives() {
        let piece = primitive::read(file, &part, &Matrix4::identity())?;
        influences.extend(read_influences(file, &part, piece.positions.len(), joints.len())?);
        mesh.append(&piece);
        mesh.check_count()?;
    }
    mesh.check()?;
    Ok(SkinnedMesh { mesh, joints, influences })
}

/// Joint rest poses: the inverse of the bind matrices, or else the nodes' own transforms.
fn joints(
    file: &Container,
    skin: &gltf::Skin<'_>,
    nodes: &[(gltf::Node<'_>, Matrix4<f64>)],
) -> Result<Vec<RigJoint>, RigError> {
    let binds = skin
        .inverse_bind_matrices()
        .map(|a| accessor::open(file, &a, Dimensions::Mat4, "inverse bind matrices"))
        .transpose()?;
    let parents = parents(skin, nodes);
    skin.joints()
        .enumerate()
        .map(|(i, node)| {
            let name = node.name().map_or_else(|| format!("joint {i}"), str::to_owned);
            let rest = match &binds {
                Some(binds) => Matrix4::from_column_slice(&binds.floats::<16>(i)?).try_inverse(),
                None => nodes.iter().find(|(n, _)| n.index() == node.index()).map(|(_, w)| *w),
            };
            let pose = rest.as_ref().and_then(rigid_part).ok_or_else(|| {
                RigError::invalid(format!("joint {name}: its rest transform is not a placement"))
            })?;
            Ok(RigJoint { name, pose, parent: parents.get(i).copied().flatten() })
        })
        .collect()
}

/// The nearest joint of the skin above each of its joints. `nodes` is a tree.
fn parents(skin: &gltf::Skin<'_>, nodes: &[(gltf::Node<'_>, Matrix4<f64>)]) -> Vec<Option<u32>> {
    let above: HashMap<usize, usize> = nodes
        .iter()
        .flat_map(|(node, _)| node.children().map(|child| (child.index(), node.index())))
        .collect();
    let joints: HashMap<usize, u32> =
        skin.joints().enumerate().map(|(i, node)| (node.index(), i as u32)).collect();
    let nearest = |node: gltf::Node<'_>| {
        let up = std::iter::successors(above.get(&node.index()), |i| above.get(i));
        up.take(nodes.len()).find_map(|i| joints.get(i).copied())
    };
    skin.joints().map(nearest).collect()
}

/// The placement nearest to a matrix; none if it is singular, mirrors or is not finite.
fn rigid_part(matrix: &Matrix4<f64>) -> Option<Pose> {
    let linear: Matrix3<f64> = matrix.fixed_view::<3, 3>(0, 0).into();
    let axes: Vec<_> = (0..3).map(|c| linear.column(c).try_normalize(1e-12)).collect();
    let [Some(x), Some(y), Some(z)] = axes[..] else { return None };
    let axes = Matrix3::from_columns(&[x, y, z]);
    let determinant = axes.determinant();
    if determinant.is_nan() || determinant < 0.5 {
        return None;
    }
    // Gram-Schmidt leaves the long axis z and the flexion axis x where they are, to first order.
    let y = z.cross(&x).try_normalize(1e-12)?;
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[y.cross(&z), y, z]));
    let pose =
        Pose::new(matrix.fixed_view::<3, 1>(0, 3).into(), Quat::from_rotation_matrix(&rotation));
    pose.is_finite().then_some(pose)
}

fn read_influences(
    file: &Container,
    part: &gltf::Primitive<'_>,
    vertices: usize,
    joints: usize,
) -> Result<Vec<[(u32, f64); 4]>, RigError> {
    let get = |semantic: Semantic, name: &str| {
        let accessor = part
            .get(&semantic)
            .ok_or_else(|| RigError::invalid(format!("the skinned mesh has no {name}")))?;
        let elements = accessor::open(file, &accessor, Dimensions::Vec4, name)?;
        if elements.count != vertices {
            return Err(RigError::invalid(format!(
                "{name} has {} elements for {vertices} vertices",
                elements.count
            )));
        }
        Ok(elements)
    };
    let indices = get(Semantic::Joints(0), "JOINTS_0")?;
    let weights = get(Semantic::Weights(0), "WEIGHTS_0")?;
    (0..vertices)
        .map(|i| {
            let (j, w) = (indices.integers::<4>(i)?, weights.floats::<4>(i)?);
            let sum: f64 = w.iter().sum();
            if w.iter().any(|&w| w < 0.0) || sum < 1e-6 {
                return Err(RigError::invalid(format!("vertex {i} has no valid skin weights")));
            }
            if let Some(j) = j.iter().zip(&w).find(|&(&j, &w)| w > 0.0 && j as usize >= joints) {
                return Err(RigError::invalid(format!(
                    "vertex {i} is bound to joint {}, but there are only {joints}",
                    j.0
                )));
            }
            Ok(std::array::from_fn(|k| (j[k].min(joints.saturating_sub(1) as u32), w[k] / sum)))
        })
        .collect()
}
