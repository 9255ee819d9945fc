//! Joints that the skins of several meshes have in common, in one space.

use super::accessor;
use super::container::Container;
use super::skin::{Nodes, RigJoint, rigid_part};
use crate::RigError;
use gltf::accessor::Dimensions;
use nalgebra::Matrix4;
use std::collections::HashMap;
use thenar_input::quoted;

/// A joint at rest.
struct RestJoint {
    /// Index of its node.
    node: usize,
    name: String,
    /// From the joint's frame to the space of the first mesh.
    matrix: Matrix4<f64>,
}

/// The joints of one skin and of others that share some with it.
#[derive(Default)]
pub(super) struct Skeleton {
    rests: Vec<RestJoint>,
    of_node: HashMap<usize, u32>,
}

/// A skin's joints as they are found in a skeleton, and what moves its mesh to where that skeleton
/// rests.
pub(super) struct Placed {
    /// Joint of the skeleton, and the move of what the joint carries; none where that is no move.
    joints: Vec<(u32, Option<Matrix4<f64>>)>,
}

impl Placed {
    /// Number of joints.
    pub fn len(&self) -> usize {
        self.joints.len()
    }

    /// The joint of the skeleton that a joint of the skin is.
    pub fn joint(&self, own: u32) -> u32 {
        self.joints.get(own as usize).map_or(0, |(joint, _)| *joint)
    }

    /// The move of what a joint of the skin carries.
    pub fn by(&self, own: u32) -> Option<&Matrix4<f64>> {
        self.joints.get(own as usize).and_then(|(_, by)| by.as_ref())
    }

    /// True if the skin rests as the skeleton does.
    pub fn stays(&self) -> bool {
        self.joints.iter().all(|(_, by)| by.is_none())
    }
}

impl Skeleton {
    /// Adds a skin that shares a joint with those before; `None` if none is common.
    pub fn add(
        &mut self,
        file: &Container,
        skin: &gltf::Skin<'_>,
        nodes: &Nodes<'_>,
    ) -> Result<Option<Placed>, RigError> {
        let own = rests(file, skin, nodes)?;
        let common = own.iter().find_map(|rest| {
            let there = self.rests.get(*self.of_node.get(&rest.node)? as usize)?;
            Some(moved(&rest.matrix, &there.matrix))
        });
        let to_first = match common {
            Some(to_first) => to_first,
            None if self.rests.is_empty() => None,
            None => return Ok(None),
        };
        let mut joints = Vec::with_capacity(own.len());
        for rest in own {
            let placed = match self.of_node.get(&rest.node) {
                Some(&known) => (known, moved(&rest.matrix, &self.rests[known as usize].matrix)),
                None => {
                    let new = self.rests.len() as u32;
                    self.of_node.insert(rest.node, new);
                    let matrix = to_first.map_or(rest.matrix, |by| by * rest.matrix);
                    self.rests.push(RestJoint { matrix, ..rest });
                    (new, to_first)
                }
            };
            joints.push(placed);
        }
        Ok(Some(Placed { joints }))
    }

    /// The joints with their parents. `nodes` is a tree.
    pub fn joints(&self, nodes: &Nodes<'_>) -> Result<Vec<RigJoint>, RigError> {
        let above: HashMap<usize, usize> = nodes
            .iter()
            .flat_map(|(node, _)| node.children().map(|child| (child.index(), node.index())))
            .collect();
        let nearest = |node: usize| {
            let up = std::iter::successors(above.get(&node), |i| above.get(i));
            up.take(nodes.len()).find_map(|i| self.of_node.get(i).copied())
        };
        let each = self.rests.iter().map(|rest| {
            let pose = rigid_part(&rest.matrix).ok_or_else(|| not_placed(&rest.name))?;
            Ok(RigJoint { name: rest.name.clone(), pose, parent: nearest(rest.node) })
        });
        each.collect()
    }
}

fn not_placed(name: &str) -> RigError {
    RigError::invalid(format!(
        "joint {}: its rest transform is not a placement, for it mirrors or flattens: apply scales and rotations to the \
         skeleton (in Blender: Object, Apply, All Transforms) and export it again",
        quoted(name)
    ))
}

/// The joints of a skin at rest: the inverse of the bind matrices, or else the nodes' own
/// transforms.
fn rests(
    file: &Container,
    skin: &gltf::Skin<'_>,
    nodes: &Nodes<'_>,
) -> Result<Vec<RestJoint>, RigError> {
    let binds = skin
        .inverse_bind_matrices()
        .map(|a| accessor::open(file, &a, Dimensions::Mat4, "inverse bind matrices"))
        .transpose()?;
    let each = skin.joints().enumerate().map(|(i, node)| {
        let name = node.name().map_or_else(|| format!("joint {i}"), str::to_owned);
        let matrix = match &binds {
            Some(binds) => Matrix4::from_column_slice(&binds.floats::<16>(i)?).try_inverse(),
            None => nodes.iter().find(|(n, _)| n.index() == node.index()).map(|(_, w)| *w),
        };
        let matrix = matrix.ok_or_else(|| not_placed(&name))?;
        Ok(RestJoint { node: node.index(), name, matrix })
    });
    each.collect()
}

/// The move that takes one rest of a joint to another; none where they are the same.
fn moved(from: &Matrix4<f64>, to: &Matrix4<f64>) -> Option<Matrix4<f64>> {
    if from == to {
        return None;
    }
    from.try_inverse().map(|back| to * back)
}

/// The factor by which volumes of a skin's mesh grow on the way to the world, as its first joint is
/// posed; 1 where that is not known.
pub(super) fn growth(file: &Container, skin: &gltf::Skin<'_>, nodes: &Nodes<'_>) -> f64 {
    let of = |node: usize| nodes.iter().find(|(n, _)| n.index() == node).map(|(_, world)| *world);
    let rests = rests(file, skin, nodes).unwrap_or_default();
    let first = rests.iter().find_map(|rest| Some(of(rest.node)? * rest.matrix.try_inverse()?));
    let grown = first.map_or(1.0, |by| by.fixed_view::<3, 3>(0, 0).determinant().abs());
    if grown.is_finite() && grown > 0.0 { grown } else { 1.0 }
}
