//! The sharp or small features of a rigid shape that soft vertices could miss.

use crate::contact::Shape;
use crate::contact::aabb::Aabb;
use crate::contact::bvh::Bvh;
use crate::math::Vec3;

/// A straight edge (or the axis of a capsule) in the shape frame.
pub(crate) type Segment = [Vec3; 2];

/// Fixed points and segments of a shape, in its frame; each stands for a ball of `radius`.
#[derive(Clone, Debug)]
pub(crate) struct Features {
    pub points: Vec<Vec3>,
    pub segments: Vec<Segment>,
    pub radius: f64,
    pub tree: Bvh,
}

impl Features {
    /// Corners and edges of a cuboid, centre of a sphere, axis of a capsule, points of a mesh.
    pub fn of(shape: &Shape) -> Self {
        let (points, segments, radius) = match shape {
            Shape::Sphere { radius } => (vec![Vec3::zeros()], vec![], *radius),
            Shape::Capsule { radius, half_length } => {
                (vec![], vec![capsule_axis(*half_length)], *radius)
            }
            Shape::Cuboid { half } => (corners(half).to_vec(), edges(half).to_vec(), 0.0),
            Shape::HalfSpace => (vec![], vec![], 0.0),
            Shape::Mesh(mesh) => (mesh.points.clone(), vec![], 0.0),
        };
        let boxes: Vec<Aabb> = points.iter().map(|p| Aabb { min: *p, max: *p }).collect();
        Self { tree: Bvh::build(&boxes), points, segments, radius }
    }
}

/// The ends of a capsule's axis.
pub(crate) fn capsule_axis(half_length: f64) -> Segment {
    [Vec3::new(0.0, -half_length, 0.0), Vec3::new(0.0, half_length, 0.0)]
}

/// Corner `i` has the sign of axis k in bit k (set: positive).
///
/// ```text
///    6----7      y
///   /|   /|      |
///  2----3 |      |__ x
///  | 4--|-5     /
///  |/   |/     z points away: bit 2 set is the far face
///  0----1
/// ```
pub(crate) fn corners(half: &Vec3) -> [Vec3; 8] {
    std::array::from_fn(|i| Vec3::from_fn(|k, _| if i >> k & 1 == 1 { half[k] } else { -half[k] }))
}

/// The twelve edges, four along each axis.
pub(crate) fn edges(half: &Vec3) -> [Segment; 12] {
    let corner = corners(half);
    std::array::from_fn(|e| {
        let (axis, which) = (e / 4, e % 4);
        let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
        let start = (which & 1) << j | (which >> 1) << k;
        [corner[start], corner[start | 1 << axis]]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cuboid_has_twelve_different_edges_of_its_lengths() {
        let half = Vec3::new(1.0, 2.0, 3.0);
        let edges = edges(&half);
        for (e, [a, b]) in edges.iter().enumerate() {
            let mut along = Vec3::zeros();
            along[e / 4] = 2.0 * half[e / 4];
            assert_eq!(b - a, along);
            assert!(edges[..e].iter().all(|other| other[0] != *a || other[1] != *b));
        }
    }
}
