//! The sharp parts of a rigid shape: points spread over its corners and edges.
//!
//! Vertices of a soft surface meet the faces of a shape; what is sharp comes in between them, and is
//! tried as points against the triangles of the surface. The points are fixed on the shape, so that
//! none comes or goes while things slide.

use crate::contact::Shape;
use crate::contact::aabb::Aabb;
use crate::contact::bvh::Bvh;
use crate::contact::features::{corners, edges};
use crate::contact::triangle::area_vector;
use crate::math::Vec3;

/// Points within an edge are at most so many: of a longer one they stand farther apart.
const WITHIN_EDGE_MAX: usize = 512;
/// Two faces of a mesh that turn less than this (cosine of 1°) are one.
const FLAT: f64 = 0.999_847_7;

/// Points on sharp corners and edges, in the shape frame.
#[derive(Clone, Debug)]
pub(crate) struct Sharp {
    pub points: Vec<Vec3>,
    pub tree: Bvh,
}

impl Sharp {
    /// Corners and edges of a cuboid or mesh; along edges a point at least every `spacing` \[m\].
    /// Round shapes have none.
    pub fn of(shape: &Shape, spacing: f64) -> Self {
        let mut points = Vec::new();
        match shape {
            Shape::Sphere { .. } | Shape::Capsule { .. } | Shape::HalfSpace => {}
            Shape::Cuboid { half } => {
                points.extend(corners(half));
                edges(half).iter().for_each(|edge| spread(edge, spacing, &mut points));
            }
            Shape::Mesh(mesh) => {
                points.clone_from(&mesh.points);
                for edge in convex_edges(&mesh.points, &mesh.triangles) {
                    spread(&edge, spacing, &mut points);
                }
            }
        }
        let boxes: Vec<Aabb> = points.iter().map(|p| Aabb { min: *p, max: *p }).collect();
        Self { tree: Bvh::build(&boxes), points }
    }
}

/// Adds points within an edge, its ends left out.
fn spread([a, b]: &[Vec3; 2], spacing: f64, points: &mut Vec<Vec3>) {
    let parts = ((b - a).norm() / spacing).ceil().min(WITHIN_EDGE_MAX as f64) as usize;
    points.extend((1..parts).map(|k| a + (b - a) * (k as f64 / parts as f64)));
}

/// The edges of a mesh at which it is bent outward, or which bound it.
fn convex_edges(x: &[Vec3], triangles: &[[u32; 3]]) -> Vec<[Vec3; 2]> {
    let mut sides: Vec<([u32; 2], usize)> = Vec::with_capacity(3 * triangles.len());
    for (t, v) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (i, j) = (v[k], v[(k + 1) % 3]);
            sides.push(([i.min(j), i.max(j)], t));
        }
    }
    sides.sort_unstable();
    let normal = |t: usize| {
        let area = area_vector(&triangles[t].map(|v| x[v as usize]));
        area.try_normalize(0.0).unwrap_or_else(Vec3::zeros)
    };
    let is_convex = |edge: &[u32; 2], t: usize, u: usize| {
        let far = triangles[u].into_iter().find(|v| !edge.contains(v));
        let falls =
            far.is_some_and(|v| normal(t).dot(&(x[v as usize] - x[edge[0] as usize])) < 0.0);
        falls && normal(t).dot(&normal(u)) < FLAT
    };
    let mut found = Vec::new();
    for same in sides.chunk_by(|a, b| a.0 == b.0) {
        let edge = same[0].0;
        let flat = same.len() == 2 && !is_convex(&edge, same[0].1, same[1].1);
        if !flat {
            found.push(edge.map(|v| x[v as usize]));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_cover_the_edges_of_a_cuboid_at_the_spacing() {
        let half = Vec3::new(0.01, 0.02, 0.03);
        let sharp = Sharp::of(&Shape::Cuboid { half }, 0.004);
        // 8 corners, and on edges of 20, 40 and 60 mm 4, 9 and 14 points within.
        assert_eq!(sharp.points.len(), 8 + 4 * (4 + 9 + 14));
        for p in &sharp.points {
            let on = (0..3).filter(|&k| (p[k].abs() - half[k]).abs() < 1e-12).count();
            assert!(on >= 2, "{p} is on no edge");
        }
    }

    /// A cube of twelve triangles has twelve sharp edges; its six diagonals are flat.
    #[test]
    fn flat_edges_of_a_mesh_have_no_points() {
        let half = Vec3::repeat(0.01);
        let x = corners(&half);
        let quads =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles: Vec<[u32; 3]> =
            quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        let edges = convex_edges(&x, &triangles);
        assert_eq!(edges.len(), 12);
        assert!(edges.iter().all(|[a, b]| ((b - a).norm() - 0.02).abs() < 1e-12));
    }
}
