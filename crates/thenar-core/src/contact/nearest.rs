//! The point of a triangle, or of a segment, at which a shape's signed distance is least.

use crate::contact::triangle::closest_on_triangle;
use crate::contact::{Distance, Shape};
use crate::math::Vec3;

/// Preference for the middle of the triangle: a point at distance d from it counts as this times
/// d²/(2 L) farther from the shape, with L the triangle's longest edge. It makes the point unique
/// and steady where a triangle lies along the shape, and moves it elsewhere by less than this part
/// of the edge for each unit of curvature times edge.
const TO_MIDDLE: f64 = 1e-3;
/// Cuts through the centroid leave at most 1 - 1/e of the area each (Grünbaum, 1960).
const CUTS_MAX: usize = 64;
/// Within this part of the longest edge the least distance is found. The place is found less well:
/// at an edge of the shape so near as `gap` it may lie `√(2 gap · edge · this)` aside, and the way
/// to the shape leans by that over the gap.
const TOLERANCE: f64 = 1e-9;
const CORNERS_MAX: usize = CUTS_MAX + 4;

impl Shape {
    /// Weights of the point of a triangle (in the shape frame) at which the signed distance is
    /// least. Where that is so along a line or a face, it is the point nearest to the triangle's
    /// middle (preferred by a thousandth, which keeps the point continuous as things tilt).
    ///
    /// Exact for spheres; for other convex shapes within a thousandth of the longest edge times the
    /// tilt in value, found by convex minimisation. Of a compound, the best over its parts. Of
    /// a mesh, which is not convex, the best of a descent from the triangle's middle and corners.
    pub fn nearest_on_triangle(&self, tri: &[Vec3; 3]) -> [f64; 3] {
        match self {
            Self::Sphere { .. } => closest_on_triangle(&Vec3::zeros(), tri).weights,
            Self::Compound(parts) => {
                let mut best = ([1.0 / 3.0; 3], f64::INFINITY);
                for part in parts.iter() {
                    let local = tri.map(|p| part.pose_SP.inverse_point(&p));
                    let weights = part.shape.nearest_on_triangle(&local);
                    let value = part.shape.distance(&point(&local, &weights)).value;
                    if value < best.1 {
                        best = (weights, value);
                    }
                }
                best.0
            }
            Self::Mesh(_) => descend(self, tri),
            _ => minimise(self, tri),
        }
    }
}

impl Shape {
    /// No point of a triangle is nearer to a convex shape than this \[m\]: its distance lies above
    /// the tangent plane at the triangle's middle.
    pub(crate) fn least_over(&self, tri: &[Vec3; 3]) -> f64 {
        let middle = (tri[0] + tri[1] + tri[2]) / 3.0;
        let Distance { value, gradient } = self.distance(&middle);
        let along = tri.map(|p| gradient.dot(&(p - middle)));
        value + along[0].min(along[1]).min(along[2])
    }

    /// No point of the segment from `a` to `b` is nearer to a convex shape than this \[m\], as in
    /// [`Shape::least_over`].
    pub(crate) fn least_along(&self, a: &Vec3, b: &Vec3) -> f64 {
        let Distance { value, gradient } = self.distance(&(0.5 * (a + b)));
        value - 0.5 * gradient.dot(&(b - a)).abs()
    }

    /// Returns the place on the segment from `a` (0) to `b` (1) at which the signed distance of a
    /// convex shape is least; with the same preference for the middle as in
    /// [`Shape::nearest_on_triangle`].
    pub(crate) fn nearest_on_segment(&self, a: &Vec3, b: &Vec3) -> f64 {
        let along = b - a;
        let length = along.norm();
        // Slope of the distance over the length, which grows from end to end.
        let slope = |t: f64| {
            let gradient = self.distance(&(a + t * along)).gradient;
            gradient.dot(&along) + TO_MIDDLE * length * (t - 0.5)
        };
        let (mut low, mut high) = (0.0, 1.0);
        if slope(low) >= 0.0 {
            return low;
        }
        if slope(high) <= 0.0 {
            return high;
        }
        while high - low > TOLERANCE {
            let t = 0.5 * (low + high);
            *(if slope(t) < 0.0 { &mut low } else { &mut high }) = t;
        }
        0.5 * (low + high)
    }
}

/// The point with these weights.
pub(crate) fn point(tri: &[Vec3; 3], w: &[f64; 3]) -> Vec3 {
    tri[0] * w[0] + tri[1] * w[1] + tri[2] * w[2]
}

/// Returns the excess distance that the place found may have over the nearest place of a triangle,
/// or of a segment, with an edge of this length \[m\].
pub(crate) fn place_unknown(length: f64) -> f64 {
    TOLERANCE * length
}

pub(crate) fn longest_edge(tri: &[Vec3; 3]) -> f64 {
    (0..3).map(|k| (tri[(k + 1) % 3] - tri[k]).norm()).fold(0.0, f64::max)
}

/// A shape whose curvature over an edge is less is straight there: differences are good for a
/// hundred thousandth of this.
const STRAIGHT: f64 = 1e-6;
/// A point of less weight lies on the edge across: places are found to a thousandth of this.
const ON_EDGE: f64 = 1e-6;
/// Part of the edge over which curvature is measured: the root of what gradients are good for, and
/// more.
const APART: f64 = 1e-4;
/// Newton steps: each squares what is left of the preference, a thousandth; and one may end on an
/// edge.
const STEPS: usize = 3;

/// The weights of [`Shape::nearest_on_triangle`] without the preference for the middle in
/// directions in which a convex shape is round: by Newton's method within the triangle, or along
/// the edge on which the point lies.
pub(crate) fn sharpened(shape: &Shape, tri: &[Vec3; 3], weights: [f64; 3]) -> [f64; 3] {
    let (e1, e2) = (tri[1] - tri[0], tri[2] - tri[0]);
    let Some(normal) = e1.cross(&e2).try_normalize(0.0) else { return weights };
    let length = longest_edge(tri);
    if matches!(shape, Shape::Sphere { .. } | Shape::Cuboid { .. }) {
        return weights;
    }
    let mut best = (weights, shape.distance(&point(tri, &weights)).value);
    for _ in 0..STEPS {
        let p = point(tri, &best.0);
        let out = (0..3).filter(|&k| best.0[k] <= ON_EDGE);
        let step = match out.clone().count() {
            0 => {
                let axes = [e1.normalize(), normal.cross(&e1).normalize()];
                step_within(shape, &p, axes, length)
            }
            1 => {
                let k = out.sum::<usize>();
                let along = (tri[(k + 2) % 3] - tri[(k + 1) % 3]).normalize();
                let slope = |p: &Vec3| shape.distance(p).gradient.dot(&along);
                let d = APART * length;
                let curvature = (slope(&(p + d * along)) - slope(&(p - d * along))) / (2.0 * d);
                newton(slope(&p), curvature, length) * along
            }
            _ => break,
        };
        let next = closest_on_triangle(&(p + step), tri).weights;
        let value = shape.distance(&point(tri, &next)).value;
        // Deep inside, where the nearest side changes, a step may lead up.
        if value > best.1 {
            break;
        }
        best = (next, value);
    }
    best.0
}

/// The step along a direction of this slope and curvature; none along a straight line.
fn newton(slope: f64, curvature: f64, length: f64) -> f64 {
    if curvature * length > STRAIGHT { -slope / curvature } else { 0.0 }
}

/// The step in a plane with these axes, along both directions of main curvature.
fn step_within(shape: &Shape, p: &Vec3, axes: [Vec3; 2], length: f64) -> Vec3 {
    let slopes = |p: &Vec3| {
        let gradient = shape.distance(p).gradient;
        axes.map(|axis| gradient.dot(&axis))
    };
    let d = APART * length;
    let rows = axes.map(|axis| {
        let [plus, minus] = [slopes(&(p + d * axis)), slopes(&(p - d * axis))];
        [0, 1].map(|k| (plus[k] - minus[k]) / (2.0 * d))
    });
    let [a, b, c] = [rows[0][0], 0.5 * (rows[0][1] + rows[1][0]), rows[1][1]];
    let (mean, half, angle) =
        (0.5 * (a + c), (0.5 * (a - c)).hypot(b), 0.5 * (2.0 * b).atan2(a - c));
    let (sin, cos) = angle.sin_cos();
    let slope = slopes(p);
    [([cos, sin], mean + half), ([-sin, cos], mean - half)]
        .into_iter()
        .map(|([u, v], curvature)| {
            newton(u * slope[0] + v * slope[1], curvature, length) * (u * axes[0] + v * axes[1])
        })
        .sum()
}

/// The method of centres of gravity in the weights of corners 1 and 2: each gradient cuts off the
/// half of what is left in which the function is greater than at its centroid.
fn minimise(shape: &Shape, tri: &[Vec3; 3]) -> [f64; 3] {
    let (e1, e2) = (tri[1] - tri[0], tri[2] - tri[0]);
    let middle = (tri[0] + tri[1] + tri[2]) / 3.0;
    let length = longest_edge(tri);
    if length <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let stiffness = TO_MIDDLE / length;
    let sample = |u: [f64; 2]| {
        let p = tri[0] + u[0] * e1 + u[1] * e2;
        let d = shape.distance(&p);
        let off = p - middle;
        let gradient = d.gradient + stiffness * off;
        (d.value + 0.5 * stiffness * off.norm_squared(), [gradient.dot(&e1), gradient.dot(&e2)])
    };
    let mut area = Area::whole();
    let mut best = ([1.0 / 3.0; 2], f64::INFINITY);
    for u in [[1.0 / 3.0; 2], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]] {
        let (value, gradient) = sample(u);
        if value < best.1 {
            best = (u, value);
        }
        area.cut(u, gradient);
    }
    for _ in 0..CUTS_MAX {
        let Some(u) = area.centroid() else { break };
        let (value, gradient) = sample(u);
        if value < best.1 {
            best = (u, value);
        }
        // By convexity nothing in what is left is below this.
        let bound = area.corners[..area.count]
            .iter()
            .map(|c| value + gradient[0] * (c[0] - u[0]) + gradient[1] * (c[1] - u[1]));
        if bound.fold(f64::INFINITY, f64::min) > best.1 - TOLERANCE * length {
            break;
        }
        area.cut(u, gradient);
    }
    // At a tip of the triangle cuts only come near.
    for corner in area.corners[..area.count].iter() {
        let (value, _) = sample(*corner);
        if value < best.1 {
            best = (*corner, value);
        }
    }
    let [u, v] = best.0.map(|x| x.clamp(0.0, 1.0));
    [(1.0 - u - v).max(0.0), u, v]
}

/// A convex polygon in the plane of the weights.
struct Area {
    corners: [[f64; 2]; CORNERS_MAX],
    count: usize,
}

impl Area {
    fn whole() -> Self {
        let mut corners = [[0.0; 2]; CORNERS_MAX];
        (corners[1], corners[2]) = ([1.0, 0.0], [0.0, 1.0]);
        Self { corners, count: 3 }
    }

    /// Leaves the part in which `g · (x - u) ≤ 0`.
    fn cut(&mut self, u: [f64; 2], g: [f64; 2]) {
        let old = self.corners;
        let height = |c: [f64; 2]| g[0] * (c[0] - u[0]) + g[1] * (c[1] - u[1]);
        let n = std::mem::take(&mut self.count);
        for i in 0..n {
            let (from, to) = (old[i], old[(i + 1) % n]);
            let (h0, h1) = (height(from), height(to));
            if h0 <= 0.0 {
                self.push(from);
            }
            if (h0 < 0.0 && h1 > 0.0) || (h0 > 0.0 && h1 < 0.0) {
                let t = h0 / (h0 - h1);
                self.push([from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])]);
            }
        }
    }

    fn push(&mut self, corner: [f64; 2]) {
        if self.count < CORNERS_MAX {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    /// `None` when nothing is left.
    fn centroid(&self) -> Option<[f64; 2]> {
        let o = *self.corners[..self.count].first()?;
        let (mut twice, mut sum) = (0.0, [0.0; 2]);
        for k in 1..self.count.saturating_sub(1) {
            let [a, b] = [self.corners[k], self.corners[k + 1]].map(|c| [c[0] - o[0], c[1] - o[1]]);
            let area = a[0] * b[1] - a[1] * b[0];
            twice += area;
            (0..2).for_each(|i| sum[i] += area * (a[i] + b[i]) / 3.0);
        }
        if twice <= 1e-18 {
            return None;
        }
        Some([o[0] + sum[0] / twice, o[1] + sum[1] / twice])
    }
}

/// Steps against the gradient, each to the point of the triangle nearest to where the surface
/// would be if it were flat, from the best of five starts.
fn descend(shape: &Shape, tri: &[Vec3; 3]) -> [f64; 3] {
    let third = 1.0 / 3.0;
    let starts = [[third; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let value = |w: &[f64; 3]| shape.distance(&point(tri, w));
    let length = longest_edge(tri);
    let mut best = (starts[0], f64::INFINITY);
    for start in starts {
        let mut w = start;
        let mut d = value(&w);
        let mut stride = d.value.max(0.25 * length);
        for _ in 0..24 {
            let target = point(tri, &w) - stride * d.gradient;
            let next = closest_on_triangle(&target, tri).weights;
            let there = value(&next);
            if there.value < d.value - TOLERANCE * length {
                (w, d) = (next, there);
            } else {
                stride *= 0.4;
            }
        }
        // The middle first: others must be clearly better.
        if d.value < best.1 - TOLERANCE * length {
            best = (w, d.value);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn shapes() -> Vec<Shape> {
        vec![
            Shape::Sphere { radius: 0.02 },
            Shape::Capsule { radius: 0.01, half_length: 0.02 },
            Shape::Cuboid { half: Vec3::new(0.01, 0.02, 0.03) },
            Shape::Cylinder { radius: 0.02, half_length: 0.01 },
            Shape::Cone { radius: 0.02, height: 0.03 },
            Shape::Ellipsoid { half: Vec3::new(0.01, 0.02, 0.03) },
            Shape::HalfSpace,
        ]
    }

    #[test]
    fn bounds_are_below_all_of_a_triangle_and_its_edges() {
        let mut random = Random::new(3);
        let n = 12;
        for shape in shapes() {
            for _ in 0..300 {
                let at = random.vector(0.04);
                let tri = [0; 3].map(|_| at + random.vector(0.02));
                let (least, along) = (shape.least_over(&tri), shape.least_along(&tri[0], &tri[1]));
                for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
                    let [u, v] = [i, j].map(|i| f64::from(i) / f64::from(n));
                    let value = shape.distance(&point(&tri, &[1.0 - u - v, u, v])).value;
                    assert!(value >= least - 1e-12, "{shape:?}");
                    assert!(j > 0 || value >= along - 1e-12, "{shape:?}");
                }
            }
        }
    }

    /// No point of a lattice on the triangle is nearer by more than the preference for the middle.
    #[test]
    fn no_other_point_of_the_triangle_is_nearer() {
        let mut random = Random::new(12);
        let n = 40;
        for shape in shapes() {
            for _ in 0..300 {
                let place = random.vector(0.05);
                let tri = [(); 3].map(|()| place + random.vector(0.02));
                let w = shape.nearest_on_triangle(&tri);
                assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12 && w.iter().all(|w| *w >= 0.0));
                let value = shape.distance(&point(&tri, &w)).value;
                let mut brute = f64::INFINITY;
                for i in 0..=n {
                    for j in 0..=n - i {
                        let w = [i, j, n - i - j].map(|k| f64::from(k) / f64::from(n));
                        brute = brute.min(shape.distance(&point(&tri, &w)).value);
                    }
                }
                let allowed = 0.25 * TO_MIDDLE * longest_edge(&tri);
                assert!(value < brute + allowed, "{shape:?} {tri:?}: {value} {brute}");
            }
        }
    }

    /// No point of a fine division of the segment is nearer by more than the preference for the
    /// middle.
    #[test]
    fn no_other_point_of_the_segment_is_nearer() {
        let mut random = Random::new(14);
        for shape in shapes() {
            for _ in 0..300 {
                let place = random.vector(0.05);
                let [a, b] = [(); 2].map(|()| place + random.vector(0.02));
                let value = |t: f64| shape.distance(&(a + t * (b - a))).value;
                let found = value(shape.nearest_on_segment(&a, &b));
                let brute = (0..=200).map(|k| value(f64::from(k) / 200.0)).fold(f64::MAX, f64::min);
                let allowed = 0.125 * TO_MIDDLE * (b - a).norm() + 1e-12;
                assert!(found < brute + allowed, "{shape:?} {a} {b}: {found} {brute}");
            }
        }
    }

    /// Nearest points of round shapes are exact: in the triangle the distance has no slope, on its
    /// border none inwards; but for one triangle in thousands, next to whose border a little is
    /// left.
    #[test]
    fn sharpened_points_of_round_shapes_are_exact() {
        let mut random = Random::new(15);
        let round = |shape: &&Shape| matches!(shape, Shape::Ellipsoid { .. });
        let ball = Shape::Capsule { radius: 0.01, half_length: 0.0 };
        let shapes = shapes();
        for shape in shapes.iter().filter(round).chain([&ball]) {
            let (mut tested, mut inside, mut sloping) = (0, 0, 0);
            for _ in 0..2000 {
                let place = random.vector(1.0).normalize() * 0.045;
                let tri = [(); 3].map(|()| place + random.vector(0.04));
                let w = sharpened(shape, &tri, shape.nearest_on_triangle(&tri));
                let p = point(&tri, &w);
                let d = shape.distance(&p);
                if d.value < 1e-6 {
                    continue;
                }
                inside += u32::from(w.iter().all(|w| *w > 0.0));
                // No corner lies down the slope.
                let down = tri.map(|corner| -d.gradient.dot(&(corner - p)) / longest_edge(&tri));
                let down = down.into_iter().fold(0.0, f64::max);
                assert!(down < 1e-4, "{shape:?} {tri:?}: {w:?}, {down} down");
                tested += 1;
                sloping += u32::from(down >= 1e-5);
            }
            assert!(inside > 200 && 500 * sloping < tested, "{inside}, {sloping} of {tested}");
        }
    }

    /// On a triangle that lies along the shape it is the point nearest to its middle, and a slight
    /// tilt moves it by little.
    #[test]
    fn along_the_shape_the_middle_is_preferred() {
        let lying = |shape: &Shape, top: f64, tilt: f64| {
            let tri = [[-0.004, -0.002], [0.004, -0.002], [0.0, 0.004]]
                .map(|[x, z]| Vec3::new(x, top + 1e-5 + tilt * x, z));
            point(&tri, &shape.nearest_on_triangle(&tri))
        };
        let boxed = Shape::Cuboid { half: Vec3::repeat(0.02) };
        let cylinder = Shape::Cylinder { radius: 0.02, half_length: 0.01 };
        for (shape, top) in [(&boxed, 0.02), (&cylinder, 0.01), (&Shape::HalfSpace, 0.0)] {
            let level = lying(shape, top, 0.0);
            assert!(level.x.hypot(level.z) < 1e-5, "{shape:?}: {level}");
            let tilted = lying(shape, top, 1e-5);
            assert!((tilted - level).norm() < 0.02 * 0.008, "{shape:?}: {tilted}");
        }
    }
}
