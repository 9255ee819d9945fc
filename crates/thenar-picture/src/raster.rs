//! Rasterisation: the samples that a triangle covers, and how near it is there.

use super::clip::ScreenVertex;

/// Sub-pixel steps: vertices are snapped to 1/256 px, so that neighbours share exact edges.
const STEPS: i64 = 256;

/// Sample places in a pixel, in 1/256 px from its middle. No two share a row or a column.
pub(super) fn sample_pattern<const N: usize>() -> [[i64; 2]; N] {
    const FOUR: [[i64; 2]; 4] = [[-32, -96], [96, -32], [-96, 32], [32, 96]];
    const EIGHT: [[i64; 2]; 8] = [
        [16, -48],
        [-16, 48],
        [80, 16],
        [-48, -80],
        [-80, 80],
        [-112, -16],
        [48, 112],
        [112, -112],
    ];
    std::array::from_fn(|i| match N {
        1 => [0, 0],
        4 => FOUR[i],
        _ => EIGHT[i % 8],
    })
}

/// Nothing there.
pub(super) const NOTHING: u32 = u32::MAX;

/// The nearest surface at each of the `N` samples of each pixel of a tile, row by row.
pub(super) struct Layer<const N: usize> {
    /// One over the distance; larger is nearer.
    pub nearness: Vec<[f32; N]>,
    /// Triangle, ground or [`NOTHING`] at each sample.
    pub id: Vec<[u32; N]>,
}

impl<const N: usize> Layer<N> {
    pub(super) fn new(pixels: usize) -> Self {
        Self { nearness: vec![[0.0; N]; pixels], id: vec![[NOTHING; N]; pixels] }
    }
}

/// The next lower whole number, without the function call that `f32::floor` costs on a plain
/// x86-64.
pub(super) fn floor(x: f32) -> i32 {
    let towards_zero = x as i32;
    towards_zero.saturating_sub(i32::from(towards_zero as f32 > x))
}

/// A rectangle of pixels: first column and row, and the ones past the last.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rect {
    pub x: [i32; 2],
    pub y: [i32; 2],
}

impl Rect {
    pub(super) fn width(&self) -> usize {
        (self.x[1] - self.x[0]) as usize
    }
}

/// A triangle ready to be drawn: `a x + b y + c >= 0` inside each edge, x and y in 1/256 px.
pub(super) struct Setup {
    a: [i64; 3],
    b: [i64; 3],
    c: [i64; 3],
    /// Pixels that may be touched.
    pub bounds: Rect,
    /// Depth at the middle of the pixel `bounds.x[0], bounds.y[0]`, and its slopes \[1/px\].
    depth: [f32; 3],
}

impl Setup {
    /// `None` for a triangle without positive area.
    pub(super) fn new(v: [ScreenVertex; 3]) -> Option<Self> {
        let snap = |c: f32| (c * STEPS as f32).round() as i64;
        let x = v.map(|v| snap(v[0]));
        let y = v.map(|v| snap(v[1]));
        let area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
        if area <= 0 {
            return None;
        }
        let (mut a, mut b, mut c) = ([0; 3], [0; 3], [0; 3]);
        for k in 0..3 {
            let j = (k + 1) % 3;
            let (dx, dy) = (x[j] - x[k], y[j] - y[k]);
            // A sample on an edge belongs to the triangle right of or below it.
            let own = dy < 0 || (dy == 0 && dx > 0);
            (a[k], b[k], c[k]) = (-dy, dx, dy * x[k] - dx * y[k] - i64::from(!own));
        }
        let low = |c: [i64; 3]| (c[0].min(c[1]).min(c[2])).div_euclid(STEPS) as i32;
        let high = |c: [i64; 3]| (c[0].max(c[1]).max(c[2])).div_euclid(STEPS) as i32 + 1;
        let bounds = Rect { x: [low(x), high(x)], y: [low(y), high(y)] };
        Some(Self { a, b, c, bounds, depth: depth_plane(v, &bounds) })
    }

    /// Draws the part inside `rect` into `layer`, which covers `rect`, where it is nearer.
    pub(super) fn draw<const N: usize>(&self, id: u32, rect: &Rect, layer: &mut Layer<N>) {
        let pattern = sample_pattern::<N>();
        let shift: [[i64; N]; 3] =
            std::array::from_fn(|k| pattern.map(|[dx, dy]| self.a[k] * dx + self.b[k] * dy));
        let slant: [f32; N] =
            pattern.map(|[dx, dy]| (self.depth[1] * dx as f32 + self.depth[2] * dy as f32) / 256.0);
        let (x0, x1) = (self.bounds.x[0].max(rect.x[0]), self.bounds.x[1].min(rect.x[1]));
        let (y0, y1) = (self.bounds.y[0].max(rect.y[0]), self.bounds.y[1].min(rect.y[1]));
        let reach: [i64; 3] =
            std::array::from_fn(|k| (self.a[k].abs() + self.b[k].abs()) * STEPS / 2);

        for y in y0..y1 {
            let mut edges = self.edges(x0, y);
            let row = (y - rect.y[0]) as usize * rect.width();
            for x in x0..x1 {
                if (0..3).all(|k| edges[k] + reach[k] >= 0) {
                    let pixel = row + (x - rect.x[0]) as usize;
                    let middle = self.depth_at(x, y);
                    let (near, ids) = (&mut layer.nearness[pixel], &mut layer.id[pixel]);
                    for s in 0..N {
                        let inside = (edges[0] + shift[0][s])
                            .min(edges[1] + shift[1][s])
                            .min(edges[2] + shift[2][s]);
                        let depth = middle + slant[s];
                        if inside >= 0 && depth > near[s] {
                            near[s] = depth;
                            ids[s] = id;
                        }
                    }
                }
                for k in 0..3 {
                    edges[k] += self.a[k] * STEPS;
                }
            }
        }
    }

    /// Raises each pixel of a `size`² map, whose middle the triangle covers, to its depth.
    pub(super) fn raise(&self, size: usize, map: &mut [f32]) {
        let (x0, x1) = (self.bounds.x[0].max(0), self.bounds.x[1].min(size as i32));
        let (y0, y1) = (self.bounds.y[0].max(0), self.bounds.y[1].min(size as i32));
        for y in y0..y1 {
            let mut edges = self.edges(x0, y);
            for x in x0..x1 {
                if edges[0].min(edges[1]).min(edges[2]) >= 0 {
                    let value = &mut map[y as usize * size + x as usize];
                    *value = value.max(self.depth_at(x, y));
                }
                for k in 0..3 {
                    edges[k] += self.a[k] * STEPS;
                }
            }
        }
    }

    /// The edge functions at the middle of a pixel.
    fn edges(&self, x: i32, y: i32) -> [i64; 3] {
        let place = |c: i32| i64::from(c) * STEPS + STEPS / 2;
        std::array::from_fn(|k| self.a[k] * place(x) + self.b[k] * place(y) + self.c[k])
    }

    fn depth_at(&self, x: i32, y: i32) -> f32 {
        self.depth[0]
            + self.depth[1] * (x - self.bounds.x[0]) as f32
            + self.depth[2] * (y - self.bounds.y[0]) as f32
    }
}

/// The plane through three depths: its value at the middle of the first pixel, and its slopes.
fn depth_plane(v: [ScreenVertex; 3], bounds: &Rect) -> [f32; 3] {
    let v = v.map(|v| v.map(f64::from));
    let edge = |k: usize, i: usize| v[k][i] - v[0][i];
    let area = edge(1, 0) * edge(2, 1) - edge(2, 0) * edge(1, 1);
    let slope = |p: f64| if area.abs() > 1e-12 { p / area } else { 0.0 };
    let sx = slope(edge(1, 2) * edge(2, 1) - edge(2, 2) * edge(1, 1));
    let sy = slope(edge(2, 2) * edge(1, 0) - edge(1, 2) * edge(2, 0));
    let (px, py) = (f64::from(bounds.x[0]) + 0.5, f64::from(bounds.y[0]) + 0.5);
    // No sample lies nearer or farther than the corners: slivers must not overshoot.
    let start = v[0][2] + sx * (px - v[0][0]) + sy * (py - v[0][1]);
    [start as f32, sx as f32, sy as f32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_that_share_an_edge_cover_every_sample_once() {
        // A square from (1, 1) to (9, 9), cut along a diagonal that passes through samples.
        let [a, b, c, d] = [[1.0, 1.0, 1.0], [9.0, 1.0, 1.0], [9.0, 9.0, 1.0], [1.0, 9.0, 1.0]];
        let rect = Rect { x: [0, 10], y: [0, 10] };
        let mut covered = 0;
        for triangle in [[a, b, c], [a, c, d]] {
            let mut layer = Layer::<1>::new(100);
            Setup::new(triangle).expect("area").draw(0, &rect, &mut layer);
            covered += layer.id.iter().filter(|id| id[0] == 0).count();
        }
        assert_eq!(covered, 64);
    }

    #[test]
    fn depth_is_the_plane_through_the_corners() {
        // depth = 1 + 0.1 x + 0.02 y
        let plane = |x: f32, y: f32| [x, y, 1.0 + 0.1 * x + 0.02 * y];
        let setup = Setup::new([plane(0.0, 0.0), plane(8.0, 0.0), plane(0.0, 8.0)]).expect("area");
        let mut map = vec![0.0; 64];
        setup.raise(8, &mut map);
        assert!((map[2 * 8 + 3] - (1.0 + 0.35 + 0.05)).abs() < 1e-6, "{}", map[19]);
    }

    #[test]
    fn a_triangle_seen_from_behind_has_no_setup() {
        assert!(Setup::new([[0.0, 0.0, 1.0], [0.0, 8.0, 1.0], [8.0, 0.0, 1.0]]).is_none());
    }
}
