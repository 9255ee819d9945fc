//! A distance grid: which side a point is on, and how far the surface can be at most.

use crate::contact::DistanceGrid;
use crate::math::Vec3;

impl DistanceGrid {
    /// True when there are as many values as the sizes say, at least two along each axis, and a
    /// spacing that is finite and positive.
    pub(crate) fn is_sound(&self) -> bool {
        let count = self.dims.iter().try_fold(1_usize, |n, &d| n.checked_mul(d as usize));
        count == Some(self.values.len())
            && self.dims.iter().all(|&d| d >= 2)
            && self.cell > 0.0
            && self.cell.is_finite()
    }

    /// A distance that the surface is not farther than from `p` (frame of the grid), by the nearest
    /// grid point: `|d(p)| ≤ |d(q)| + |p - q|`. `None` beyond the grid. A hint: the grid may have
    /// been made from a finer mesh than the triangles are.
    pub(crate) fn bound(&self, p: &Vec3) -> Option<f64> {
        let scaled = (p - self.origin) / self.cell;
        let mut at = [0usize; 3];
        for k in 0..3 {
            let nearest = scaled[k] + 0.5;
            if !(nearest >= 0.0 && nearest < f64::from(self.dims[k])) {
                return None;
            }
            at[k] = nearest as usize;
        }
        let q = self.origin + self.cell * Vec3::from_fn(|k, _| at[k] as f64);
        let (nx, ny) = (self.dims[0] as usize, self.dims[1] as usize);
        let value = self.values.get(at[0] + nx * (at[1] + ny * at[2]))?;
        // Values are single precision.
        Some((f64::from(value.abs()) + (p - q).norm()) * (1.0 + 1e-6))
    }

    /// The grid point with the least value, the first of several; the origin of an unsound grid.
    pub(crate) fn deepest(&self) -> Vec3 {
        let values = if self.is_sound() { self.values.as_slice() } else { &[] };
        let least = values.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
        let index = least.map_or(0, |(i, _)| i);
        let (nx, ny) = (self.dims[0].max(1) as usize, self.dims[1].max(1) as usize);
        let at = [index % nx, index / nx % ny, index / nx / ny];
        self.origin + self.cell * Vec3::from_fn(|k, _| at[k] as f64)
    }

    /// True when the trilinear interpolant is negative at `p`; beyond the grid nothing is inside.
    pub(crate) fn is_inside(&self, p: &Vec3) -> bool {
        let scaled = (p - self.origin) / self.cell;
        let top = |k: usize| f64::from(self.dims[k]) - 1.0;
        if !self.is_sound() || (0..3).any(|k| !(scaled[k] >= 0.0 && scaled[k] <= top(k))) {
            return false;
        }
        let base: [usize; 3] =
            std::array::from_fn(|k| (scaled[k] as usize).min(self.dims[k] as usize - 2));
        let (nx, ny) = (self.dims[0] as usize, self.dims[1] as usize);
        let mut value = 0.0;
        for corner in 0..8usize {
            let mut weight = 1.0;
            let mut at = [0usize; 3];
            for k in 0..3 {
                let up = corner >> k & 1;
                let f = scaled[k] - base[k] as f64;
                weight *= if up == 1 { f } else { 1.0 - f };
                at[k] = base[k] + up;
            }
            value += weight * f64::from(self.values[at[0] + nx * (at[1] + ny * at[2])]);
        }
        value < 0.0
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::contact::Shape;
    use crate::random::Random;

    /// The exact distance of `shape` sampled on a grid of `n`³ values over ±`reach`.
    pub fn grid_of(shape: &Shape, reach: f64, n: u32) -> DistanceGrid {
        let origin = Vec3::repeat(-reach);
        let cell = 2.0 * reach / f64::from(n - 1);
        let mut values = Vec::new();
        for z in 0..n {
            for y in 0..n {
                for x in 0..n {
                    let p = origin + cell * Vec3::new(f64::from(x), f64::from(y), f64::from(z));
                    values.push(shape.distance(&p).value as f32);
                }
            }
        }
        DistanceGrid { origin, cell, dims: [n; 3], values }
    }

    #[test]
    fn bounds_and_sides_are_those_of_the_shape() {
        let shape = Shape::Sphere { radius: 0.5 };
        let grid = grid_of(&shape, 1.0, 33);
        let mut random = Random::new(5);
        for _ in 0..1000 {
            let p = random.vector(1.3);
            let exact = shape.distance(&p).value;
            match grid.bound(&p) {
                Some(bound) => {
                    assert!(bound >= exact.abs() && bound < exact.abs() + 2.0 * grid.cell);
                }
                None => assert!(p.amax() > 1.0),
            }
            // The interpolant errs by less than cell²/8 times the sum of curvatures.
            if exact.abs() > grid.cell * grid.cell {
                assert_eq!(grid.is_inside(&p), exact < 0.0, "{p}");
            }
        }
    }
}
