//! The tree of nodes and their transforms.

use crate::RigError;
use nalgebra::Matrix4;

/// Every node of the default scene (or of no scene at all: every root) with its matrix to the
/// world. A node that is reached twice is an error, so that cycles end.
pub(super) fn world_matrices(
    document: &gltf::Document,
) -> Result<Vec<(gltf::Node<'_>, Matrix4<f64>)>, RigError> {
    let nodes: Vec<gltf::Node> = document.nodes().collect();
    let mut seen = vec![false; nodes.len()];
    let mut stack: Vec<(usize, Matrix4<f64>)> =
        roots(document, &nodes).into_iter().rev().map(|n| (n, Matrix4::identity())).collect();

    let mut out = Vec::new();
    while let Some((index, parent)) = stack.pop() {
        if std::mem::replace(&mut seen[index], true) {
            return Err(RigError::invalid(format!(
                "node {index} has two parents or is its own ancestor"
            )));
        }
        let node = nodes[index].clone();
        let world = parent * local_matrix(&node)?;
        let children: Vec<usize> = node.children().map(|c| c.index()).collect();
        stack.extend(children.into_iter().rev().map(|child| (child, world)));
        out.push((node, world));
    }
    Ok(out)
}

fn roots(document: &gltf::Document, nodes: &[gltf::Node]) -> Vec<usize> {
    if let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) {
        return scene.nodes().map(|n| n.index()).collect();
    }
    let mut child = vec![false; nodes.len()];
    nodes.iter().flat_map(|n| n.children()).for_each(|c| child[c.index()] = true);
    (0..nodes.len()).filter(|&i| !child[i]).collect()
}

fn local_matrix(node: &gltf::Node) -> Result<Matrix4<f64>, RigError> {
    let columns = node.transform().matrix();
    let matrix = Matrix4::from_fn(|r, c| f64::from(columns[c][r]));
    if matrix.iter().all(|x| x.is_finite()) {
        Ok(matrix)
    } else {
        Err(RigError::invalid(format!("the transform of node {} is not finite", node.index())))
    }
}
