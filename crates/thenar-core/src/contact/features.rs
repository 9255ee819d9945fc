//! Corners, edges and rims of shapes, in their frames.

use crate::contact::area::TOUCHING;
use crate::math::Vec3;

/// A straight edge (or the axis of a capsule) in the shape frame.
pub(crate) type Segment = [Vec3; 2];

/// Points around a rim by default: the chord between two bends off the rim by 0.5 % of its radius.
const RIM_POINTS: usize = 32;
/// Most points around a rim.
const RIM_POINTS_MAX: usize = 1 << 12;

/// Returns the number of points that a rim needs to have one at least every `spacing` \[m\], to
/// bend off the chord between two by no more than [`TOUCHING`], and no fewer than by default.
pub(crate) fn rim_points(radius: f64, spacing: f64) -> usize {
    let half_turn = (1.0 - TOUCHING / radius).clamp(-1.0, 1.0).acos();
    let needed = (std::f64::consts::TAU * radius / spacing).max(std::f64::consts::PI / half_turn);
    (needed.ceil() as usize).clamp(RIM_POINTS, RIM_POINTS_MAX)
}

/// Points evenly around the circle of `radius` at height `y`, the first at +x, towards +z.
pub(crate) fn rim(radius: f64, y: f64, count: usize) -> impl Iterator<Item = Vec3> {
    (0..count).map(move |k| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / count as f64).sin_cos();
        Vec3::new(radius * cos, y, radius * sin)
    })
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
