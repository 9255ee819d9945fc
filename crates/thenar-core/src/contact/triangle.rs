//! The point of a triangle nearest to a given point.

use crate::math::Vec3;

/// Part of a triangle that a point lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Feature {
    /// Corner 0, 1 or 2.
    Vertex(usize),
    /// Edge k, from corner k to corner k + 1 (mod 3).
    Edge(usize),
    /// The inside.
    Face,
}

/// The nearest point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Closest {
    pub point: Vec3,
    /// Barycentric weights of `point`.
    pub weights: [f64; 3],
    pub feature: Feature,
    pub distance_squared: f64,
}

/// Bounds of distances, and of their squares, leave so much room for rounding: what is tried in
/// vain costs little, what is passed over is missed.
pub(crate) const ROUNDED_UP: f64 = 1.0 + 1e-9;

/// Solid angle under which `p` sees triangle `x`, positive from behind \[sr\] (van Oosterom and
/// Strackee 1983). A closed surface fills 4π times its winding number about the point.
pub(crate) fn solid_angle(p: &Vec3, x: &[Vec3; 3]) -> f64 {
    let [a, b, c] = x.map(|corner| corner - p);
    let lengths = [a.norm(), b.norm(), c.norm()];
    let along = a.dot(&b) * lengths[2] + b.dot(&c) * lengths[0] + c.dot(&a) * lengths[1];
    2.0 * a.dot(&b.cross(&c)).atan2(lengths.iter().product::<f64>() + along)
}

/// Square of the sine between two edges below which a triangle is its edges: a hundred times what
/// rounding makes of the square of no area.
const FLAT: f64 = 1e-14;

/// Area vector of a triangle \[m²\], and whether rounding decides what it is.
pub(crate) fn area_or_flat(x: &[Vec3; 3]) -> (Vec3, bool) {
    let (e1, e2) = (x[1] - x[0], x[2] - x[0]);
    let across = e1.cross(&e2);
    let flat = across.norm_squared() <= FLAT * e1.norm_squared() * e2.norm_squared();
    (0.5 * across, flat)
}

/// True where points of these heights over a plane all lie farther than `far` on one side of it.
#[inline]
pub(crate) fn are_beyond<const N: usize>(heights: &[f64; N], far: f64) -> bool {
    heights.iter().all(|h| *h > far) || heights.iter().all(|h| *h < -far)
}

/// Part of the surface around a vertex that must face its load; where less does, all of it counts.
const ASKEW: f64 = 1e-6;

/// Surface that a vertex pushed along `push_W` stands for \[m²\]: a third of the `triangles` around
/// it, as seen along the push; of all where none faces it.
pub(crate) fn stands_for(triangles: impl Iterator<Item = [Vec3; 3]>, push_W: &Vec3) -> f64 {
    let (mut seen, mut whole) = (0.0, 0.0);
    for x in triangles {
        let area_W = area_vector(&x);
        seen += (-push_W.dot(&area_W)).max(0.0);
        whole += area_W.norm();
    }
    (if seen > ASKEW * whole { seen } else { whole }) / 3.0
}

// `thenar_rig::mesh::closest_on_triangle` answers the same question by cross products, which still
// tell the faces of needles in meshes from files, and gives built models their bits. Here dot
// products do, which cost less: contact asks in each step, of each vertex and each triangle near
// it, and a needle counts as its edges.
/// The point of triangle `x` nearest to `p`. A degenerate triangle is its edges.
pub(crate) fn closest_on_triangle(p: &Vec3, x: &[Vec3; 3]) -> Closest {
    let (e1, e2, d) = (x[1] - x[0], x[2] - x[0], p - x[0]);
    let (a11, a12, a22) = (e1.norm_squared(), e1.dot(&e2), e2.norm_squared());
    let (b1, b2) = (e1.dot(&d), e2.dot(&d));

    // Weights of the foot of the perpendicular, times the squared doubled area.
    let area = a11 * a22 - a12 * a12;
    let (w1, w2) = (a22 * b1 - a12 * b2, a11 * b2 - a12 * b1);
    let flat = area <= FLAT * a11 * a22;
    if w1 > 0.0 && w2 > 0.0 && w1 + w2 < area && !flat {
        let (w1, w2) = (w1 / area, w2 / area);
        let point = x[0] + w1 * e1 + w2 * e2;
        return Closest {
            point,
            weights: [1.0 - w1 - w2, w1, w2],
            feature: Feature::Face,
            distance_squared: (p - point).norm_squared(),
        };
    }
    // Outside, the nearest point is on an edge whose line has the foot on its far side: the edge
    // opposite to a corner without positive weight.
    let weights = [area - w1 - w2, w1, w2];
    let mut best: Option<Closest> = None;
    for k in 0..3 {
        if flat || weights[(k + 2) % 3] <= 0.0 {
            let candidate = on_edge(p, x, k);
            if best.is_none_or(|b| candidate.distance_squared < b.distance_squared) {
                best = Some(candidate);
            }
        }
    }
    best.unwrap_or_else(|| on_edge(p, x, 0))
}

/// The point of edge `k` nearest to `p`.
#[inline]
fn on_edge(p: &Vec3, x: &[Vec3; 3], k: usize) -> Closest {
    let j = (k + 1) % 3;
    let t = segment_parameter(p, &x[k], &x[j]);
    let point = x[k] + t * (x[j] - x[k]);
    let mut weights = [0.0; 3];
    weights[k] = 1.0 - t;
    weights[j] = t;
    let feature = match t {
        0.0 => Feature::Vertex(k),
        1.0 => Feature::Vertex(j),
        _ => Feature::Edge(k),
    };
    Closest { point, weights, feature, distance_squared: (p - point).norm_squared() }
}

/// Parameter in [0, 1] of the point of segment `ab` nearest to `p`; 0 when it has no length.
pub(crate) fn segment_parameter(p: &Vec3, a: &Vec3, b: &Vec3) -> f64 {
    let ab = b - a;
    let length_squared = ab.norm_squared();
    if length_squared > 0.0 { ((p - a).dot(&ab) / length_squared).clamp(0.0, 1.0) } else { 0.0 }
}

/// Area vector of a triangle: its unit normal times its area \[m²\].
pub(crate) fn area_vector(x: &[Vec3; 3]) -> Vec3 {
    0.5 * (x[1] - x[0]).cross(&(x[2] - x[0]))
}

/// Returns the distance from `p` along `d`, in lengths of `d`, at which a ray cuts triangle `x`,
/// and the weights there. A ray along an edge, but for rounding, cuts both triangles beside it.
pub(crate) fn cut_by_ray(p: &Vec3, d: &Vec3, x: &[Vec3; 3]) -> Option<(f64, [f64; 3])> {
    let area = area_vector(x);
    let at = area.dot(&(x[0] - p)) / area.dot(d);
    if !(0.0..f64::INFINITY).contains(&at) {
        return None;
    }
    let cut = p + at * d;
    let part = |k: usize| {
        let (i, j) = (x[(k + 1) % 3], x[(k + 2) % 3]);
        area.dot(&area_vector(&[cut, i, j])) / area.norm_squared()
    };
    let weights = [part(0), part(1), part(2)];
    weights.iter().all(|w| *w >= -ROUNDING).then_some((at, weights))
}

/// Round-off of weights in a triangle: some thousand units in the last place.
const ROUNDING: f64 = 1e-12;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Brute force over a fine barycentric lattice bounds the true distance from above by the
    /// lattice spacing.
    #[test]
    fn nearest_point_beats_brute_force() {
        let mut random = Random::new(42);
        let n = 60;
        for _ in 0..300 {
            let x = [random.vector(1.0), random.vector(1.0), random.vector(1.0)];
            let p = random.vector(1.5);
            let c = closest_on_triangle(&p, &x);
            let again: Vec3 = (0..3).map(|k| x[k] * c.weights[k]).sum();
            assert!((again - c.point).norm() < 1e-12);
            assert!((c.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(c.weights.iter().all(|w| (0.0..=1.0).contains(w)));
            let mut brute = f64::INFINITY;
            for i in 0..=n {
                for j in 0..=n - i {
                    let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                    let q = x[0] + u * (x[1] - x[0]) + v * (x[2] - x[0]);
                    brute = brute.min((q - p).norm());
                }
            }
            let distance = c.distance_squared.sqrt();
            assert!(distance <= brute + 1e-12);
            assert!(brute - distance < 4.0 / f64::from(n));
        }
    }

    #[test]
    fn features_are_named() {
        let x = [Vec3::zeros(), Vec3::x(), Vec3::y()];
        let feature = |p: [f64; 3]| closest_on_triangle(&Vec3::from(p), &x).feature;
        assert_eq!(feature([0.2, 0.2, 1.0]), Feature::Face);
        assert_eq!(feature([0.5, -1.0, 0.3]), Feature::Edge(0));
        assert_eq!(feature([1.0, 1.0, 0.0]), Feature::Edge(1));
        assert_eq!(feature([-1.0, 0.5, 0.0]), Feature::Edge(2));
        assert_eq!(feature([-1.0, -1.0, 0.0]), Feature::Vertex(0));
        assert_eq!(feature([3.0, 0.0, 0.0]), Feature::Vertex(1));
        assert_eq!(feature([0.0, 3.0, 0.0]), Feature::Vertex(2));
    }

    #[test]
    fn degenerate_triangles_are_their_edges() {
        let line = [Vec3::zeros(), Vec3::x(), 2.0 * Vec3::x()];
        let c = closest_on_triangle(&Vec3::new(1.5, 1.0, 0.0), &line);
        assert!((c.distance_squared - 1.0).abs() < 1e-14);
        let point = [Vec3::x(); 3];
        assert_eq!(closest_on_triangle(&Vec3::zeros(), &point).distance_squared, 1.0);
    }
}
