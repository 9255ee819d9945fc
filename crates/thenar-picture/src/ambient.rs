//! Ambient occlusion: how much of the sky each vertex, and each place on the ground, sees.
//!
//! The scene is looked at from evenly spread directions; a place receives from each direction
//! in proportion to the cosine with its normal, unless a caster stands in between.

use super::V;
use super::assemble::Geometry;
use super::shadow::DepthMap;

/// Texels along the edge of one direction's map.
const SIZE: usize = 256;
/// Places along the edge of the ground's map.
const GROUND: usize = 128;

/// Occlusion of a part of the ground around the casters.
pub(super) struct GroundOcclusion {
    origin: V,
    axes: [V; 2],
    /// Half the edge of the square \[m\].
    half: f32,
    open: Vec<f32>,
}

impl GroundOcclusion {
    /// Part of the sky seen from a place on the ground, 0 to 1.
    pub(super) fn open(&self, p: &V) -> f32 {
        let place = |axis: &V| {
            let c = (axis.dot(&(p - self.origin)) / self.half + 1.0) / 2.0;
            c * GROUND as f32 - 0.5
        };
        let (x, y) = (place(&self.axes[0]), place(&self.axes[1]));
        let last = GROUND as f32 - 1.001;
        if x < 0.0 || y < 0.0 || x > last || y > last {
            return 1.0;
        }
        let (i, j) = (x as usize, y as usize);
        let (u, v) = (x - i as f32, y - j as f32);
        let at = |di: usize, dj: usize| self.open[(j + dj) * GROUND + i + di];
        (at(0, 0) * (1.0 - u) + at(1, 0) * u) * (1.0 - v)
            + (at(0, 1) * (1.0 - u) + at(1, 1) * u) * v
    }
}

/// A plane: its point nearest to the casters' middle, and its unit normal.
pub(super) struct Plane {
    pub point: V,
    pub normal: V,
}

/// Fills `geometry.ambient` from `count` directions and returns the ground's occlusion.
pub(super) fn occlude(
    geometry: &mut Geometry,
    ground: Option<&Plane>,
    count: usize,
    threads: usize,
) -> Option<GroundOcclusion> {
    let casters: Vec<[u32; 3]> = geometry.casters().collect();
    if casters.is_empty() || count == 0 {
        return None;
    }
    let maps = direction_maps(geometry, &casters, count, threads);
    let lifted: Vec<(V, V)> =
        geometry.points.iter().copied().zip(geometry.normals.iter().copied()).collect();
    let lit: Vec<bool> = geometry
        .vertices
        .iter()
        .zip(&geometry.materials)
        .flat_map(|(r, m)| r.clone().map(|_| !m.unlit))
        .collect();
    let open = in_parallel(lifted.len(), threads, |i| {
        if lit[i] { openness(&maps, &lifted[i].0, &lifted[i].1) } else { 1.0 }
    });
    geometry.ambient = open;
    ground.map(|plane| ground_occlusion(geometry, &casters, &maps, plane, threads))
}

fn ground_occlusion(
    geometry: &Geometry,
    casters: &[[u32; 3]],
    maps: &[(V, DepthMap)],
    plane: &Plane,
    threads: usize,
) -> GroundOcclusion {
    let (mut low, mut high) = (V::repeat(f32::INFINITY), V::repeat(f32::NEG_INFINITY));
    for &i in casters.iter().flatten() {
        low = low.inf(&geometry.points[i as usize]);
        high = high.sup(&geometry.points[i as usize]);
    }
    let middle = (low + high) / 2.0;
    let origin = middle - plane.normal * plane.normal.dot(&(middle - plane.point));
    let half = 0.9 * (high - low).norm();
    let side = if plane.normal.x.abs() < 0.9 { V::x() } else { V::z() };
    let second = side.cross(&plane.normal).normalize();
    let axes = [plane.normal.cross(&second), second];
    let place = |c: usize| ((c as f32 + 0.5) / GROUND as f32 * 2.0 - 1.0) * half;
    let open = in_parallel(GROUND * GROUND, threads, |i| {
        let p = origin + axes[0] * place(i % GROUND) + axes[1] * place(i / GROUND);
        openness(maps, &p, &plane.normal)
    });
    GroundOcclusion { origin, axes, half, open }
}

/// The cosine-weighted part of the directions around `normal` that are free.
fn openness(maps: &[(V, DepthMap)], p: &V, normal: &V) -> f32 {
    let (mut free, mut all) = (0.0, 0.0);
    for (direction, map) in maps {
        let cosine = normal.dot(direction);
        if cosine > 0.0 {
            let lifted = p + normal * (2.0 * map.texel);
            let [x, y, height] = map.locate(&lifted);
            free += cosine * map.lit(x, y, height + map.texel);
            all += cosine;
        }
    }
    if all > 0.0 { free / all } else { 1.0 }
}

fn direction_maps(
    geometry: &Geometry,
    casters: &[[u32; 3]],
    count: usize,
    threads: usize,
) -> Vec<(V, DepthMap)> {
    in_parallel(count, threads, |i| {
        let direction = on_sphere(i, count);
        (direction, DepthMap::new(geometry, casters, direction, SIZE))
    })
}

/// The i-th of `count` points spread evenly over the unit sphere (a sunflower wound round it).
fn on_sphere(i: usize, count: usize) -> V {
    let golden = std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
    let y = 1.0 - 2.0 * (i as f32 + 0.5) / count as f32;
    let radius = (1.0 - y * y).sqrt();
    let (sin, cos) = (i as f32 * golden).sin_cos();
    V::new(radius * cos, y, radius * sin)
}

/// `f(0), ..., f(n - 1)` in order, computed by `threads` threads.
pub(super) fn in_parallel<T: Send>(
    n: usize,
    threads: usize,
    f: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    if threads <= 1 || n < 2 {
        return (0..n).map(f).collect();
    }
    let share = n.div_ceil(threads);
    let f = &f;
    std::thread::scope(|scope| {
        let parts: Vec<_> = (0..threads)
            .map(|t| {
                let range = (t * share).min(n)..((t + 1) * share).min(n);
                scope.spawn(move || range.map(f).collect::<Vec<T>>())
            })
            .collect();
        parts
            .into_iter()
            .flat_map(|part| part.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    })
}
