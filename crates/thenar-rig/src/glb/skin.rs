//! Skinned meshes.

use super::choice::{self, SkinnedPart, Source};
use super::container::Container;
use super::skeleton::{Placed, Skeleton};
use super::{accessor, primitive, tree};
use crate::size::place_in_words;
use crate::{RigError, TriMesh};
use gltf::accessor::Dimensions;
use gltf::mesh::Semantic;
use nalgebra::{Matrix3, Matrix4, Rotation3};
use thenar_core::{Pose, Quat, Vec3};
use thenar_input::quoted;

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

/// A mesh bound to joints, in its rest shape; perhaps of several meshes of a file.
#[derive(Clone, Debug)]
pub struct SkinnedMesh {
    /// Surface, as stored (seams not welded).
    pub mesh: TriMesh,
    /// Joints of the skins.
    pub joints: Vec<RigJoint>,
    /// Per vertex: joints and their weights, of sum 1.
    pub influences: Vec<[(u32, f64); 4]>,
    /// The skinned meshes of the file, with those that this one is of marked.
    pub parts: Vec<SkinnedPart>,
}

/// Every node of the scene with its matrix to the world.
pub(super) type Nodes<'a> = [(gltf::Node<'a>, Matrix4<f64>)];

pub(super) fn read(file: &Container, names: &[String]) -> Result<SkinnedMesh, RigError> {
    let nodes = tree::world_matrices(&file.document)?;
    let sources = choice::sources(&nodes)?;
    let parts = choice::choose(file, &nodes, &sources, names)?;
    let mut skeleton = Skeleton::default();
    let mut body = Body::default();
    let mut left: Vec<&Source> =
        sources.iter().zip(&parts).filter(|(_, part)| part.chosen).map(|(s, _)| s).collect();
    // One that shares no joint with the first may share some with a later one.
    while !left.is_empty() {
        let mut apart = Vec::new();
        let before = left.len();
        for source in left {
            match skeleton.add(file, &source.skin, &nodes)? {
                Some(placed) => body.add(file, source, &placed)?,
                None => apart.push(source),
            }
        }
        if let (true, Some(first)) = (apart.len() == before, apart.first()) {
            return Err(RigError::invalid(format!(
                "mesh {} has no joint in common with the others that are to be joined: leave it out, or bind all to one \
                 skeleton",
                quoted(&first.name)
            )));
        }
        left = apart;
    }
    body.mesh.check()?;
    let joints = skeleton.joints(&nodes)?;
    Ok(SkinnedMesh { mesh: body.mesh, joints, influences: body.influences, parts })
}

/// Surface and weights of the meshes so far.
#[derive(Default)]
struct Body {
    mesh: TriMesh,
    influences: Vec<[(u32, f64); 4]>,
}

impl Body {
    fn add(&mut self, file: &Container, from: &Source<'_>, at: &Placed) -> Result<(), RigError> {
        for part in from.mesh.primitives() {
            let mut piece = primitive::read(file, &part, &Matrix4::identity())?;
            let own = read_influences(file, &part, &piece.positions, at.len())
                .map_err(|e| RigError::invalid(format!("mesh {}: {e}", quoted(&from.name))))?;
            if !at.stays() {
                let places = piece.positions.iter_mut().zip(&own);
                places.for_each(|(p, four)| *p = carried(p, four, at));
            }
            self.influences.extend(own.iter().map(|four| four.map(|(j, w)| (at.joint(j), w))));
            self.mesh.append(&piece);
            self.mesh.check_count()?;
        }
        Ok(())
    }
}

/// A vertex where the skeleton rests.
fn carried(p: &Vec3, four: &[(u32, f64); 4], at: &Placed) -> Vec3 {
    let moved =
        |j: u32| at.by(j).map_or(*p, |by| by.transform_point(&nalgebra::Point3::from(*p)).coords);
    four.iter().filter(|(_, w)| *w > 0.0).map(|&(j, w)| moved(j) * w).sum()
}

/// The placement nearest to a matrix; none if it is singular, mirrors or is not finite.
pub(super) fn rigid_part(matrix: &Matrix4<f64>) -> Option<Pose> {
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
    positions: &[Vec3],
    joints: usize,
) -> Result<Vec<[(u32, f64); 4]>, RigError> {
    let vertices = positions.len();
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
    let four = |i: usize| -> Result<[f64; 4], RigError> { weights.floats::<4>(i) };
    let valid = |w: &[f64; 4]| w.iter().all(|&w| w >= 0.0) && w.iter().sum::<f64>() >= 1e-6;
    let mut influences = Vec::with_capacity(vertices);
    for (i, p) in positions.iter().enumerate() {
        let (j, w) = (indices.integers::<4>(i)?, four(i)?);
        if !valid(&w) {
            let more = (i + 1..vertices).filter(|&i| four(i).is_ok_and(|w| !valid(&w))).count();
            return Err(unweighted(i, p, &w, more));
        }
        if let Some(j) = j.iter().zip(&w).find(|&(&j, &w)| w > 0.0 && j as usize >= joints) {
            return Err(RigError::invalid(format!(
                "vertex {i} at {} is bound to joint {}, but there are only {joints}: bind it anew",
                place_in_words(p),
                j.0
            )));
        }
        let sum: f64 = w.iter().sum();
        let last = joints.saturating_sub(1) as u32;
        influences.push(std::array::from_fn(|k| (j[k].min(last), w[k] / sum)));
    }
    Ok(influences)
}

/// A vertex that no joint carries, and how many more there are.
fn unweighted(i: usize, p: &Vec3, w: &[f64; 4], more: usize) -> RigError {
    let more = if more > 0 { format!(" (nor have {more} more)") } else { String::new() };
    RigError::invalid(format!(
        "vertex {i} at {} has no valid skin weights{more}, but {w:.3?}: bind it to a joint where the rig was made (in \
         Blender: Weights, Normalize All, or Assign Automatic From Bones), or leave its mesh out",
        place_in_words(p)
    ))
}
