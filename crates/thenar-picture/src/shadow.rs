//! Soft shadows of a distant light: a map of what is nearest to the light.

use super::V;
use super::assemble::Geometry;
use super::raster::{Setup, floor};

/// Surfaces that a parallel light meets first, on a square of `size`² texels.
pub(super) struct DepthMap {
    /// Towards the light, unit.
    towards: V,
    /// Rows that turn a place into texels; the third row is the height towards the light.
    axes: [V; 2],
    corner: [f32; 2],
    /// Edge of a texel \[m\].
    pub texel: f32,
    size: usize,
    /// Height of the highest caster per texel \[m\]; very low where there is none.
    heights: Vec<f32>,
}

/// Lower than everything.
const BELOW: f32 = -1e9;

impl DepthMap {
    /// The casters of a scene seen from `towards`; only faces turned to the light are drawn.
    pub(super) fn new(geometry: &Geometry, casters: &[[u32; 3]], towards: V, size: usize) -> Self {
        let side = if towards.y.abs() < 0.9 { V::y() } else { V::x() };
        let first = side.cross(&towards).normalize();
        let axes = [first, towards.cross(&first)];
        let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        for &i in casters.iter().flatten() {
            for k in 0..2 {
                let c = axes[k].dot(&geometry.points[i as usize]);
                low[k] = low[k].min(c);
                high[k] = high[k].max(c);
            }
        }
        let extent = (high[0] - low[0]).max(high[1] - low[1]);
        let extent = if extent.is_finite() { extent.max(1e-6) } else { 1.0 };
        // Two texels stay free at the border.
        let texel = extent / (size as f32 - 4.0);
        let corner = low.map(|c| if c.is_finite() { c - 2.0 * texel } else { 0.0 });
        let mut map =
            Self { towards, axes, corner, texel, size, heights: vec![BELOW; size * size] };
        let places: Vec<[f32; 3]> = geometry.points.iter().map(|p| map.locate(p)).collect();
        for triangle in casters {
            let corners = triangle.map(|i| places[i as usize]);
            // Seen from the light, outward faces turn one way only; y grows upwards here.
            if covers_a_middle(&corners)
                && let Some(setup) = Setup::new(corners)
            {
                setup.raise(size, &mut map.heights);
            }
        }
        map
    }

    /// Texel coordinates and height of a place.
    pub(super) fn locate(&self, p: &V) -> [f32; 3] {
        let texels = |k: usize| (self.axes[k].dot(p) - self.corner[k]) / self.texel;
        [texels(0), texels(1), self.towards.dot(p)]
    }

    /// Height of the caster at a texel.
    fn height(&self, x: i32, y: i32) -> f32 {
        if x < 0 || y < 0 || x >= self.size as i32 || y >= self.size as i32 {
            return BELOW;
        }
        self.heights[y as usize * self.size + x as usize]
    }

    /// Part of the four texels around (x, y) that lets light through to `height`, 0 to 1.
    pub(super) fn lit(&self, x: f32, y: f32, height: f32) -> f32 {
        let (fx, fy) = (x - 0.5, y - 0.5);
        let (ix, iy) = (floor(fx), floor(fy));
        let (u, v) = (fx - ix as f32, fy - iy as f32);
        let open = |dx: i32, dy: i32| {
            f32::from(self.height(ix.saturating_add(dx), iy.saturating_add(dy)) <= height)
        };
        let top = open(0, 0) * (1.0 - u) + open(1, 0) * u;
        let bottom = open(0, 1) * (1.0 - u) + open(1, 1) * u;
        top * (1.0 - v) + bottom * v
    }
}

/// True if the box round a triangle holds the middle of a texel: most triangles of a fine mesh
/// slip between them.
fn covers_a_middle(corners: &[[f32; 3]; 3]) -> bool {
    (0..2).all(|k| {
        let [a, b, c] = corners.map(|p| p[k] - 0.5);
        // Vertices are snapped to 1/256 texel, so a little more room on each side.
        floor(a.min(b).min(c) - 0.004) < floor(a.max(b).max(c) + 0.004)
    })
}

/// Texels that one coarse cell stands for.
const BLOCK: usize = 16;
/// The widest blur \[texels\].
const BLUR_MAX: f32 = 30.0;

/// The shadow of the key light, sharp where the caster is near.
pub(super) struct Shadow {
    map: DepthMap,
    /// Highest caster within [`BLUR_MAX`] of any texel of a block.
    coarse: Vec<f32>,
    coarse_size: usize,
    /// Apparent radius of the light \[rad\].
    radius: f32,
    disc: [[f32; 2]; TAPS],
}

const TAPS: usize = 32;

impl Shadow {
    pub(super) fn new(geometry: &Geometry, towards: V, radius: f32, size: usize) -> Self {
        let casters: Vec<[u32; 3]> = geometry.casters().collect();
        let map = DepthMap::new(geometry, &casters, towards, size);
        let coarse_size = size.div_ceil(BLOCK);
        Self { coarse: coarse_heights(&map, coarse_size), coarse_size, map, radius, disc: disc() }
    }

    /// Part of the key light that reaches a place with this normal, 0 to 1; `slack` \[m\] is how
    /// deep under the surface nearest to the light it may lie and still count as lit.
    pub(super) fn lit(&self, p: &V, normal: &V, slack: f32) -> f32 {
        let lifted = p + normal * (1.5 * self.map.texel);
        let [x, y, height] = self.map.locate(&lifted);
        let height = height + slack + 1.0 * self.map.texel;
        let top = self.highest_near(x, y);
        if top <= height {
            return 1.0;
        }
        let texels = |drop: f32| (self.radius * drop / self.map.texel).clamp(1.2, BLUR_MAX);
        let Some(drop) = self.mean_drop(x, y, height, texels(top - height)) else { return 1.0 };
        let blur = texels(drop);
        let sum: f32 =
            self.disc.iter().map(|d| self.map.lit(x + blur * d[0], y + blur * d[1], height)).sum();
        sum / TAPS as f32
    }

    /// Mean height of those casters around (x, y) that rise above `height`, over it.
    fn mean_drop(&self, x: f32, y: f32, height: f32, reach: f32) -> Option<f32> {
        let (mut sum, mut count) = (0.0, 0);
        for d in &self.disc {
            let (tx, ty) = (x + reach * d[0], y + reach * d[1]);
            let caster = self.map.height(floor(tx), floor(ty));
            if caster > height {
                sum += caster - height;
                count += 1;
            }
        }
        (count > 0).then(|| sum / count as f32)
    }

    fn highest_near(&self, x: f32, y: f32) -> f32 {
        let cell = |c: f32| floor(c / BLOCK as f32).saturating_add(MARGIN);
        let (i, j) = (cell(x), cell(y));
        let last = self.coarse_size as i32 + 2 * MARGIN;
        if i < 0 || j < 0 || i >= last || j >= last {
            return BELOW;
        }
        self.coarse[(j * last + i) as usize]
    }
}

/// Blocks by which the coarse map is wider than the fine one on each side.
const MARGIN: i32 = 2;

fn coarse_heights(map: &DepthMap, coarse_size: usize) -> Vec<f32> {
    let mut blocks = vec![BELOW; coarse_size * coarse_size];
    for (i, &height) in map.heights.iter().enumerate() {
        let block = (i / map.size / BLOCK) * coarse_size + i % map.size / BLOCK;
        blocks[block] = blocks[block].max(height);
    }
    let last = coarse_size as i32 + 2 * MARGIN;
    let mut coarse = vec![BELOW; (last * last) as usize];
    for j in 0..last {
        for i in 0..last {
            let cell = &mut coarse[(j * last + i) as usize];
            for y in (j - 2 * MARGIN).max(0)..=j.min(coarse_size as i32 - 1) {
                for x in (i - 2 * MARGIN).max(0)..=i.min(coarse_size as i32 - 1) {
                    *cell = cell.max(blocks[y as usize * coarse_size + x as usize]);
                }
            }
        }
    }
    coarse
}

/// Evenly spread points of the unit disc (a sunflower).
fn disc() -> [[f32; 2]; TAPS] {
    let golden = std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
    std::array::from_fn(|i| {
        let radius = ((i as f32 + 0.5) / TAPS as f32).sqrt();
        let (sin, cos) = (i as f32 * golden).sin_cos();
        [radius * cos, radius * sin]
    })
}
