//! The triangles of one mesh primitive.

use super::accessor;
use super::container::Container;
use crate::{RigError, TriMesh};
use gltf::accessor::Dimensions;
use gltf::mesh::{Mode, Semantic};
use nalgebra::{Matrix4, Point3};
use thenar_core::Vec3;

/// Reads triangles (also strips and fans), moved by `placement`. Points and lines give none.
pub(super) fn read(
    file: &Container,
    part: &gltf::Primitive<'_>,
    placement: &Matrix4<f64>,
) -> Result<TriMesh, RigError> {
    if !matches!(part.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(TriMesh::default());
    }
    let positions = positions(file, part, placement)?;
    let indices = indices(file, part, positions.len())?;
    let mut triangles = triangles(part.mode(), &indices);
    // A mirroring transform turns triangles inside out.
    if placement.fixed_view::<3, 3>(0, 0).determinant() < 0.0 {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    Ok(TriMesh { positions, triangles })
}

fn positions(
    file: &Container,
    part: &gltf::Primitive<'_>,
    placement: &Matrix4<f64>,
) -> Result<Vec<Vec3>, RigError> {
    let accessor = part
        .get(&Semantic::Positions)
        .ok_or_else(|| RigError::invalid("a mesh primitive has no POSITION"))?;
    let elements = accessor::open(file, &accessor, Dimensions::Vec3, "POSITION")?;
    (0..elements.count)
        .map(|i| {
            let p = Point3::from(elements.floats::<3>(i)?);
            let moved = placement.transform_point(&p).coords;
            if moved.iter().all(|x| x.is_finite()) {
                Ok(moved)
            } else {
                Err(RigError::invalid(format!("vertex {i} is not finite once placed")))
            }
        })
        .collect()
}

fn indices(
    file: &Container,
    part: &gltf::Primitive<'_>,
    vertices: usize,
) -> Result<Vec<u32>, RigError> {
    let Some(accessor) = part.indices() else { return Ok((0..vertices as u32).collect()) };
    let elements = accessor::open(file, &accessor, Dimensions::Scalar, "indices")?;
    (0..elements.count)
        .map(|i| match elements.integers::<1>(i)? {
            [v] if (v as usize) < vertices => Ok(v),
            [v] => Err(RigError::invalid(format!(
                "index {i} names vertex {v}, but there are only {vertices}"
            ))),
        })
        .collect()
}

fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => indices
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })
            .collect(),
        Mode::TriangleFan => indices.windows(2).skip(1).map(|w| [indices[0], w[0], w[1]]).collect(),
        _ => indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    }
}
