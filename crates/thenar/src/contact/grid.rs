//! Sampling a distance grid.

use crate::contact::{Distance, DistanceGrid};
use crate::math::Vec3;

impl DistanceGrid {
    /// Signed distance at `p` (frame of the grid): trilinear inside the grid, with the gradient
    /// of the same interpolant, normalised. Beyond it, with `c` the nearest grid point and the
    /// mesh inside the box: `d(p)² ≥ d(c)² + |p - c|²`, by convexity of the box; that bound is
    /// returned.
    pub fn sample(&self, p: &Vec3) -> Distance {
        let top = self.origin + self.cell * Vec3::from_fn(|k, _| f64::from(self.dims[k] - 1));
        let c = p.sup(&self.origin).inf(&top);
        let at_c = self.trilinear(&c);
        let beyond = p - c;
        if beyond == Vec3::zeros() {
            return at_c;
        }
        let outside = at_c.value.max(0.0);
        let value = (outside * outside + beyond.norm_squared()).sqrt();
        let to_p = outside * at_c.gradient + beyond;
        Distance { value, gradient: unit_or(to_p, beyond.normalize()) }
    }

    /// The interpolant at a point of the grid box.
    fn trilinear(&self, p: &Vec3) -> Distance {
        let scaled = (p - self.origin) / self.cell;
        let mut base = [0usize; 3];
        let mut f = [0.0; 3];
        for k in 0..3 {
            base[k] = (scaled[k] as usize).min(self.dims[k] as usize - 2);
            f[k] = scaled[k] - base[k] as f64;
        }
        let v = self.corners(base);

        // Values on the four edges along x, then on the two along y, then along z.
        let edge = |i: usize| v[i] + f[0] * (v[i + 1] - v[i]);
        let (e00, e10, e01, e11) = (edge(0), edge(2), edge(4), edge(6));
        let (s0, s1) = (e00 + f[1] * (e10 - e00), e01 + f[1] * (e11 - e01));

        let slope = |i: usize| v[i + 1] - v[i];
        let x0 = slope(0) + f[1] * (slope(2) - slope(0));
        let x1 = slope(4) + f[1] * (slope(6) - slope(4));
        let along_x = x0 + f[2] * (x1 - x0);
        let along_y = (e10 - e00) + f[2] * ((e11 - e01) - (e10 - e00));
        let gradient = Vec3::new(along_x, along_y, s1 - s0);
        Distance { value: s0 + f[2] * (s1 - s0), gradient: unit_or(gradient, Vec3::y()) }
    }

    /// The eight values of a cell, x fastest.
    fn corners(&self, base: [usize; 3]) -> [f64; 8] {
        let (nx, ny) = (self.dims[0] as usize, self.dims[1] as usize);
        let first = base[0] + nx * (base[1] + ny * base[2]);
        let steps = [0, 1, nx, nx + 1, nx * ny, nx * ny + 1, nx * ny + nx, nx * ny + nx + 1];
        steps.map(|s| f64::from(self.values[first + s]))
    }
}

/// `v` made a unit vector, or `fallback` where it vanishes.
fn unit_or(v: Vec3, fallback: Vec3) -> Vec3 {
    let length = v.norm();
    if length > 1e-12 { v / length } else { fallback }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::contact::Shape;
    use crate::contact::triangle::tests::Random;

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

    /// Trilinear interpolation reproduces a linear function, and its gradient, exactly.
    #[test]
    fn linear_functions_are_exact() {
        let slope = Vec3::new(0.6, 0.0, 0.8);
        let mut grid = grid_of(&Shape::HalfSpace, 1.0, 5);
        for (i, value) in grid.values.iter_mut().enumerate() {
            let (x, y, z) = (i % 5, i / 5 % 5, i / 25);
            let p = grid.origin + grid.cell * Vec3::new(x as f64, y as f64, z as f64);
            *value = (slope.dot(&p) - 0.25) as f32;
        }
        let mut random = Random::new(3);
        for _ in 0..100 {
            let p = random.vector(1.0);
            let d = grid.sample(&p);
            assert!((d.value - (slope.dot(&p) - 0.25)).abs() < 1e-6);
            assert!((d.gradient - slope).norm() < 1e-6);
        }
    }

    /// The error of trilinear interpolation of a sphere falls with the square of the spacing:
    /// at most `cell²/8 × Σ|∂²d|`, and `Σ|∂²d| ≤ 2/r` at radius r.
    #[test]
    fn sphere_is_interpolated_to_second_order() {
        let shape = Shape::Sphere { radius: 0.5 };
        for n in [17, 33, 65] {
            let grid = grid_of(&shape, 1.0, n);
            let bound = grid.cell * grid.cell / 8.0 * (3.0 / 0.3) + 1e-6;
            let mut random = Random::new(5);
            for _ in 0..300 {
                let p = random.vector(1.0);
                let exact = shape.distance(&p);
                let d = grid.sample(&p);
                if p.norm() > 0.3 + 2.0 * grid.cell {
                    assert!((d.value - exact.value).abs() < bound, "n {n} at {p}");
                    assert!(d.gradient.dot(&exact.gradient) > 1.0 - 4.0 * grid.cell);
                }
            }
        }
    }

    #[test]
    fn beyond_the_grid_the_value_is_a_lower_bound_that_grows() {
        let shape = Shape::Sphere { radius: 0.5 };
        let grid = grid_of(&shape, 1.0, 33);
        let mut random = Random::new(9);
        for _ in 0..300 {
            let p = random.vector(4.0);
            if p.amax() <= 1.0 {
                continue;
            }
            let (d, exact) = (grid.sample(&p), shape.distance(&p));
            // The interpolant itself errs by up to the square of the cell.
            assert!(d.value <= exact.value + grid.cell * grid.cell);
            if exact.value > 2.0 {
                assert!(d.value > 0.6 * exact.value);
                assert!(d.gradient.dot(&exact.gradient) > 0.8);
            }
        }
    }
}
