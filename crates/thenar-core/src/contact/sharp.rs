//! The sharp parts of a rigid shape: corners, straight edges, and points spread over edges.
//!
//! Vertices of a soft surface meet the faces of a shape; what is sharp comes in between them.
//! Corners, and points of rims, are tried against the triangles of the surface, straight edges
//! against its edges. The points are fixed on the shape, so that none comes or goes while things
//! slide. What is round is kept beside them.

use crate::contact::features::{corners, edges, rim, rim_points};
use crate::contact::sharp_blocks::Blocks;
use crate::contact::soft_edge::{Edge, Edges};
use crate::contact::soft_inside::{InnerBall, inner_balls};
use crate::contact::{PlacedShape, Shape};
use crate::math::{Pose, Vec3};

/// Most points within an edge: on a longer one they stand farther apart.
const WITHIN_EDGE_MAX: usize = 512;

/// Sharp and round features of a shape, in the shape frame.
#[derive(Clone, Debug)]
pub(crate) struct Sharp {
    /// First those at corners and on rims, then those within straight edges.
    pub points: Vec<Vec3>,
    /// Number of points at corners and on rims.
    pub corners: usize,
    pub(super) blocks: Blocks,
    /// Straight edges that have points within them.
    pub edges: Edges,
    /// Smooth curved parts, each in its own frame P.
    pub rounds: Vec<PlacedShape>,
    /// Balls inside.
    pub inner: Vec<InnerBall>,
}

impl Sharp {
    /// Corners and edges of a shape, along edges a point at least every `spacing` \[m\].
    pub fn of(shape: &Shape, spacing: f64) -> Self {
        let mut found = SharpFeatures::default();
        found.collect(shape, &Pose::identity(), spacing);
        let mut inner = Vec::new();
        match shape {
            Shape::Compound(parts) => parts.iter().for_each(|part| {
                inner_balls(&part.shape, |ball| {
                    inner.push(InnerBall { center: part.pose_SP.point(&ball.center), ..ball });
                });
            }),
            _ => inner_balls(shape, |ball| inner.push(ball)),
        }
        let SharpFeatures { mut points, within, edges, rounds } = found;
        let corners = points.len();
        points.extend(within);
        let (blocks, edges) = (Blocks::new(&points), Edges::new(edges));
        Self { points, corners, blocks, edges, rounds, inner }
    }
}

#[derive(Default)]
struct SharpFeatures {
    points: Vec<Vec3>,
    /// Points within edges.
    within: Vec<Vec3>,
    edges: Vec<Edge>,
    rounds: Vec<PlacedShape>,
}

impl SharpFeatures {
    fn collect(&mut self, shape: &Shape, pose_SP: &Pose, spacing: f64) {
        let first = [self.points.len(), self.within.len()];
        match shape {
            Shape::HalfSpace
            | Shape::Sphere { .. }
            | Shape::Capsule { .. }
            | Shape::Ellipsoid { .. } => {}
            Shape::Cuboid { half } => {
                self.points.extend(corners(half));
                for ends in edges(half) {
                    self.edge(ends, faces_beside(&ends), pose_SP, spacing);
                }
            }
            Shape::Mesh(mesh) => {
                for edge in &mesh.index.edges.list {
                    let ends = edge.vertices.map(|v| mesh.points[v as usize]);
                    self.points.extend(ends);
                    self.edge(ends, edge.normals, pose_SP, spacing);
                }
                self.points.extend(&mesh.points);
                thin(&mut self.points, first[0], 0.25 * spacing);
                thin(&mut self.within, first[1], 0.25 * spacing);
            }
            Shape::Cylinder { radius, half_length } => {
                let count = rim_points(*radius, spacing);
                for y in [-half_length, *half_length] {
                    self.points.extend(rim(*radius, y, count));
                }
            }
            Shape::Cone { radius, height } => {
                self.points.push(Vec3::y() * (0.75 * height));
                self.points.extend(rim(*radius, -0.25 * height, rim_points(*radius, spacing)));
            }
            Shape::Compound(parts) => {
                for part in parts.iter() {
                    self.collect(&part.shape, &(*pose_SP * part.pose_SP), spacing);
                }
                return;
            }
        }
        self.points[first[0]..].iter_mut().for_each(|p| *p = pose_SP.point(p));
        self.within[first[1]..].iter_mut().for_each(|p| *p = pose_SP.point(p));
        if !matches!(shape, Shape::HalfSpace | Shape::Cuboid { .. } | Shape::Mesh(_)) {
            self.rounds.push(PlacedShape { shape: shape.clone(), pose_SP: *pose_SP });
        }
    }

    /// Adds points within an edge between two faces, and the edge if there are any: of a shorter
    /// one the ends say enough.
    fn edge(&mut self, ends: [Vec3; 2], normals: [Vec3; 2], pose_SP: &Pose, spacing: f64) {
        let Some(edge) = Edge::between(ends, normals) else {
            return spread(&ends, spacing, &mut self.points);
        };
        let before = self.within.len();
        spread(&ends, spacing, &mut self.within);
        if self.within.len() > before {
            self.edges.push(edge.placed(pose_SP));
        }
    }
}

/// Outward normals of the two faces of a cuboid that meet at an edge.
fn faces_beside(ends: &[Vec3; 2]) -> [Vec3; 2] {
    let middle = 0.5 * (ends[0] + ends[1]);
    let along = (ends[1] - ends[0]).iamax();
    [(along + 1) % 3, (along + 2) % 3].map(|k| Vec3::ith(k, middle[k].signum()))
}

/// Leaves out points from `first` on that lie within `apart` \[m\] (along each axis, twice that at
/// most) of an earlier one: a soft surface does not tell them apart.
fn thin(points: &mut Vec<Vec3>, first: usize, apart: f64) {
    if !apart.is_finite() || apart <= 0.0 {
        return;
    }
    let mut seen = std::collections::BTreeSet::new();
    let mut kept = first;
    for i in first..points.len() {
        let p = points[i];
        if seen.insert([0, 1, 2].map(|k| (p[k] / apart).floor() as i64)) {
            points[kept] = p;
            kept += 1;
        }
    }
    points.truncate(kept);
}

/// Adds points within an edge, its ends left out.
fn spread([a, b]: &[Vec3; 2], spacing: f64, points: &mut Vec<Vec3>) {
    let parts = ((b - a).norm() / spacing).ceil().min(WITHIN_EDGE_MAX as f64) as usize;
    points.extend((1..parts).map(|k| a + (b - a) * (k as f64 / parts as f64)));
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
        assert_eq!(sharp.corners, 8);
        for p in &sharp.points {
            let on = (0..3).filter(|&k| (p[k].abs() - half[k]).abs() < 1e-12).count();
            assert!(on >= 2, "{p} is on no edge");
        }
    }

    #[test]
    fn parts_of_a_compound_keep_their_places() {
        let ball = PlacedShape {
            shape: Shape::Sphere { radius: 0.01 },
            pose_SP: Pose::translation(0.0, 0.02, 0.0),
        };
        let cube = Shape::Cuboid { half: Vec3::repeat(0.01) };
        let cube = PlacedShape { shape: cube, pose_SP: Pose::translation(0.1, 0.0, 0.0) };
        let both = Shape::Compound(std::sync::Arc::new(vec![ball.clone(), cube]));
        let sharp = Sharp::of(&both, 0.1);
        assert_eq!((sharp.points.len(), sharp.rounds, sharp.inner.len()), (8, vec![ball], 2));
        assert!(sharp.points.iter().all(|p| (p.x - 0.1).abs() < 0.0101));
    }
}
