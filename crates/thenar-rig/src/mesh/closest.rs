//! The point of a triangle nearest to a given point.

use thenar_core::Vec3;

/// Part of a triangle on which a point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// Inside the triangle.
    Face,
    /// On the edge from corner k to corner k+1.
    Edge(u8),
    /// At corner k.
    Vertex(u8),
}

/// The point of a mesh nearest to a given one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// Triangle index.
    pub triangle: u32,
    /// The point.
    pub point: Vec3,
    /// Barycentric coordinates of the closest point in the triangle: non-negative, of sum 1.
    pub weights: [f64; 3],
    /// Part of the triangle on which the point lies.
    pub feature: Feature,
    /// Distance \[m\].
    pub distance: f64,
}

// Contact has a way of its own (`thenar-core`, `contact/triangle.rs`), by dot products: it costs
// less, and takes a triangle whose edges differ by less than 1e-7 rad for its edges. Here cross
// products tell the faces of such needles, too, which meshes from files have; and models that were
// built keep their bits.
/// Barycentric coordinates and feature of the point of triangle `abc` nearest to `p`.
/// Degenerate triangles count as the segments or the point that they are.
///
/// ```text
///        c          The plane is cut into the Voronoi regions of the corners, edges and face
///       / \         (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
///   e2 /   \ e1
///     a-----b
///       e0
/// ```
pub fn closest_on_triangle(p: &Vec3, [a, b, c]: &[Vec3; 3]) -> ([f64; 3], Feature) {
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(&ac);
    let area2 = normal.norm_squared();
    let scale2 = ab.norm_squared().max(ac.norm_squared());
    if area2 > 1e-24 * scale2 * scale2 {
        // Signed areas opposite each corner; all positive means above the face.
        let u = normal.dot(&(b - p).cross(&(c - p)));
        let v = normal.dot(&(c - p).cross(&(a - p)));
        let w = normal.dot(&(a - p).cross(&(b - p)));
        if u > 0.0 && v > 0.0 && w > 0.0 {
            let sum = u + v + w;
            return ([u / sum, v / sum, w / sum], Feature::Face);
        }
    }
    closest_on_edges(p, &[*a, *b, *c])
}

/// The closest point among the three edges.
fn closest_on_edges(p: &Vec3, corners: &[Vec3; 3]) -> ([f64; 3], Feature) {
    let mut best = ([1.0, 0.0, 0.0], Feature::Vertex(0));
    let mut best_distance2 = f64::INFINITY;
    for k in 0..3 {
        let (i, j) = (k, (k + 1) % 3);
        let d = corners[j] - corners[i];
        let length2 = d.norm_squared();
        let along = if length2 > 0.0 { (p - corners[i]).dot(&d) / length2 } else { 0.0 };
        let s = along.clamp(0.0, 1.0);
        let distance2 = (corners[i] + d * s - p).norm_squared();
        if distance2 < best_distance2 {
            best_distance2 = distance2;
            let mut weights = [0.0; 3];
            weights[i] = 1.0 - s;
            weights[j] = s;
            let feature = match s {
                0.0 => Feature::Vertex(i as u8),
                1.0 => Feature::Vertex(j as u8),
                _ => Feature::Edge(k as u8),
            };
            best = (weights, feature);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    const ABC: [Vec3; 3] =
        [Vec3::new(0.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];

    #[test]
    fn each_region_has_its_feature() {
        let case = |x: f64, y: f64, weights: [f64; 3], feature| {
            let (w, f) = closest_on_triangle(&Vec3::new(x, y, 0.7), &ABC);
            assert_eq!(f, feature);
            for k in 0..3 {
                assert!((w[k] - weights[k]).abs() < 1e-15, "{w:?} {weights:?}");
            }
        };
        case(0.25, 0.25, [0.5, 0.25, 0.25], Feature::Face);
        case(0.25, -1.0, [0.75, 0.25, 0.0], Feature::Edge(0));
        case(1.0, 1.0, [0.0, 0.5, 0.5], Feature::Edge(1));
        case(-2.0, 0.25, [0.75, 0.0, 0.25], Feature::Edge(2));
        case(-1.0, -1.0, [1.0, 0.0, 0.0], Feature::Vertex(0));
        case(3.0, -1.0, [0.0, 1.0, 0.0], Feature::Vertex(1));
        case(-1.0, 3.0, [0.0, 0.0, 1.0], Feature::Vertex(2));
    }

    #[test]
    fn a_triangle_flattened_to_a_segment_counts_as_one() {
        let flat = [Vec3::zeros(), Vec3::new(1.0, 0.0, 0.0), Vec3::new(2.0, 0.0, 0.0)];
        let (w, _) = closest_on_triangle(&Vec3::new(1.5, 1.0, 0.0), &flat);
        let x: f64 = (0..3).map(|k| w[k] * flat[k].x).sum();
        assert!((x - 1.5).abs() < 1e-15);
    }
}
