//! Sharp points by eights, and how far those of an eight are from a triangle at least.

use crate::contact::aabb::Aabb;
use crate::contact::bvh::Bvh;
use crate::contact::triangle::ROUNDED_UP;
use crate::math::Vec3;
use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};

/// Points that are asked together.
pub(super) const LANES: usize = 8;

/// Points that lie together; of fewer the last is repeated.
#[derive(Clone, Debug)]
pub(super) struct Block {
    at: [[f64; LANES]; 3],
    /// Numbers of the points, and how many there are.
    pub points: [u32; LANES],
    pub count: usize,
}

/// All points, and a tree over the blocks.
#[derive(Clone, Debug)]
pub(super) struct Blocks {
    pub list: Vec<Block>,
    pub tree: Bvh,
}

impl Blocks {
    pub fn new(points: &[Vec3]) -> Self {
        let boxes: Vec<Aabb> = points.iter().map(|p| Aabb { min: *p, max: *p }).collect();
        // As the leaves of a tree follow each other, so do points that lie together.
        let order = Bvh::build(&boxes).renumber();
        let block = |numbers: &[u32]| {
            let of = |lane: usize| numbers[lane.min(numbers.len() - 1)];
            let place = |k: usize| std::array::from_fn(|lane| points[of(lane) as usize][k]);
            let at = [place(0), place(1), place(2)];
            Block { at, points: std::array::from_fn(of), count: numbers.len() }
        };
        let list: Vec<Block> = order.chunks(LANES).map(block).collect();
        let around =
            |block: &Block| Aabb::of_points(block.points.iter().map(|&i| &points[i as usize]));
        Self { tree: Bvh::build(&list.iter().map(around).collect::<Vec<_>>()), list }
    }
}

/// The space over and under a triangle: all beyond it is farther from the triangle than from the
/// planes that bound it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prism {
    /// Place and unit normal of the triangle's plane.
    base: Vec3,
    normal: Vec3,
    /// Places and outward unit normals of the planes through the triangle's edges.
    sides: [(Vec3, Vec3); 3],
    /// Distances in the plane below this are taken for rounding \[m\].
    rounding: f64,
}

/// Rounding of distances, in parts of a triangle's lengths: far more than round-off of coordinates
/// of some thousand edges, and nothing beside a gap.
const ROUNDING: f64 = 1e-9;

impl Prism {
    /// Over triangle `x` with this unit normal; zero where it has none.
    pub fn new(x: &[Vec3; 3], normal: &Vec3) -> Self {
        let side = |k: usize| {
            let edge = x[(k + 1) % 3] - x[k];
            let outward = edge.cross(normal).try_normalize(0.0);
            (x[k], outward.unwrap_or_else(Vec3::zeros))
        };
        let rounding = ROUNDING * (x[1] - x[0]).norm();
        Self { base: x[0], normal: *normal, sides: [side(0), side(1), side(2)], rounding }
    }

    /// True when the triangle may come within `margin` \[m\] of `p` when its corners move by
    /// `motions` \[m\]: it stays behind each plane of the prism, moved as far as the corner that
    /// goes farthest that way.
    pub fn may_come(&self, p: &Vec3, motions: &[Vec3; 3], margin: f64) -> bool {
        let goes = |n: &Vec3| motions.iter().map(|u| n.dot(u)).fold(0.0, f64::max);
        let height = self.normal.dot(&(p - self.base));
        let up = if height < 0.0 { -self.normal } else { self.normal };
        let near = |far: f64, n: &Vec3| far <= (margin + goes(n)) * ROUNDED_UP + self.rounding;
        near(height.abs(), &up)
            && self.sides.iter().all(|(base, outward)| near(outward.dot(&(p - base)), outward))
    }

    /// Squared distances from the triangle that the points of a block do not fall below \[m²\].
    pub fn least_squared(&self, block: &Block) -> [f64; LANES] {
        dispatch!(Level::new(), simd => self.of_lanes(simd, block))
    }

    #[inline(always)]
    fn of_lanes<S: Simd>(&self, simd: S, block: &Block) -> [f64; LANES] {
        let [x, y, z] = [0, 1, 2].map(
            #[inline(always)]
            |k| f64x8::load_array_ref(simd, &block.at[k]),
        );
        let at = [x, y, z];
        let height = over(&at, &self.base, &self.normal);
        let mut beside = f64x8::splat(simd, self.rounding);
        for (base, outward) in &self.sides {
            beside = beside.max(over(&at, base, outward));
        }
        let beside = beside - self.rounding;
        (height * height + beside * beside).to_array()
    }
}

/// Heights over the plane through `base` with normal `n`.
#[inline(always)]
fn over<S: Simd>([x, y, z]: &[f64x8<S>; 3], base: &Vec3, n: &Vec3) -> f64x8<S> {
    (*x - base.x) * n.x + (*y - base.y) * n.y + (*z - base.z) * n.z
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::triangle::{area_vector, closest_on_triangle};
    use crate::random::Random;

    /// Distances are not below the bound, and over the triangle and beside its edges they are just
    /// that.
    #[test]
    fn no_point_is_nearer_than_told() {
        let mut random = Random::new(8);
        let points: Vec<Vec3> = (0..203).map(|_| random.vector(0.02)).collect();
        let blocks = Blocks::new(&points);
        let mut seen = vec![0; points.len()];
        let (mut tight, mut all) = (0, 0);
        for _ in 0..100 {
            let x = [0; 3].map(|_| random.vector(0.01));
            let prism = Prism::new(&x, &area_vector(&x).normalize());
            for block in &blocks.list {
                let least = prism.least_squared(block);
                for (&i, least) in block.points.iter().zip(least).take(block.count) {
                    let exact = closest_on_triangle(&points[i as usize], &x).distance_squared;
                    assert!(least <= exact * (1.0 + 1e-12), "{least} {exact}");
                    seen[i as usize] += 1;
                    all += 1;
                    tight += u32::from(least >= 0.999 * exact);
                }
            }
        }
        assert!(seen.iter().all(|count| *count == 100));
        assert!(3 * tight > all, "{tight} of {all}");
    }

    /// Whatever comes near is let through; what flies away or past at a distance, mostly not.
    #[test]
    fn what_comes_within_the_margin_may_come() {
        let (mut random, margin) = (Random::new(15), 1e-3);
        let (mut near, mut passed) = (0, 0);
        for _ in 0..10_000 {
            let x = [0; 3].map(|_| random.vector(0.006));
            let way = random.vector(0.02);
            let ways = [0; 3].map(|_| way + random.vector(0.004));
            let p = random.vector(0.015);
            let least = (0..=100).map(|i| {
                let s = f64::from(i) / 100.0;
                closest_on_triangle(&p, &[0, 1, 2].map(|k| x[k] + s * ways[k])).distance_squared
            });
            let comes = least.fold(f64::INFINITY, f64::min) <= margin * margin;
            let prism = Prism::new(&x, &area_vector(&x).normalize());
            let may = prism.may_come(&p, &ways, margin);
            assert!(may || !comes, "{x:?} {ways:?} {p}");
            near += u32::from(comes);
            passed += u32::from(!may);
        }
        assert!(near > 200 && passed > 4000, "{near} {passed}");
    }

    #[test]
    fn a_triangle_without_area_tells_nothing() {
        let x = [Vec3::zeros(), Vec3::x(), Vec3::x() * 0.5];
        let blocks = Blocks::new(&[Vec3::new(3.0, 4.0, 0.0)]);
        assert_eq!(Prism::new(&x, &Vec3::zeros()).least_squared(&blocks.list[0]), [0.0; LANES]);
    }
}
