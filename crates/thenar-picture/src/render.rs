//! From a scene to a picture.

use super::ambient;
use super::assemble::Geometry;
use super::camera::{Camera, View};
use super::clip::Screen;
use super::colour::SrgbTable;
use super::image::Image;
use super::raster::{Rect, Setup};
use super::scene3d::Scene3d;
use super::shade::{GroundPlane, Shader, towards};
use super::shadow::Shadow;
use super::tile::Tiles;

/// Edge of a tile \[px\].
const TILE: usize = 32;

/// Amount of work that goes into a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quality {
    /// Samples per pixel: 1, 4 or 8.
    pub samples: u32,
    /// Edge of the shadow map \[texels\].
    pub shadow_map: usize,
    /// Directions of ambient occlusion; 0 for none.
    pub ambient_directions: usize,
    /// Threads; the picture does not depend on it.
    pub threads: usize,
}

impl Quality {
    /// For frames of a movie.
    pub fn movie() -> Self {
        Self { samples: 4, shadow_map: 1024, ambient_directions: 20, threads: 2 }
    }

    /// For a single picture.
    pub fn still() -> Self {
        Self { samples: 8, shadow_map: 2048, ambient_directions: 96, threads: 2 }
    }
}

/// Draws `scene` as `camera` sees it, `width` by `height` pixels.
pub fn render(
    scene: &Scene3d,
    camera: &Camera,
    width: u32,
    height: u32,
    quality: &Quality,
) -> Image {
    match quality.samples {
        ..=1 => render_with::<1>(scene, camera, width, height, quality),
        2..=4 => render_with::<4>(scene, camera, width, height, quality),
        _ => render_with::<8>(scene, camera, width, height, quality),
    }
}

fn render_with<const N: usize>(
    scene: &Scene3d,
    camera: &Camera,
    width: u32,
    height: u32,
    quality: &Quality,
) -> Image {
    let view = View::new(camera, width, height);
    let threads = quality.threads.max(1);
    let mut geometry = Geometry::gather(scene, camera.target);
    let ground = scene.ground.and_then(|g| GroundPlane::new(&g, camera.target, &view));

    let plane = ground.as_ref().map(|g| &g.plane);
    let occlusion = ambient::occlude(&mut geometry, plane, quality.ambient_directions, threads);
    let shadow = Shadow::new(
        &geometry,
        towards(&scene.light),
        scene.light.radius,
        quality.shadow_map.clamp(16, 8192),
    );

    let screen = Screen::project(&mut geometry, &view);
    let shader = Shader::new(scene, &geometry, &screen, &view, shadow, occlusion, ground);
    let setups: Vec<Option<Setup>> = screen
        .triangles
        .iter()
        .map(|t| Setup::new(t.map(|i| screen.vertices[i as usize])))
        .collect();
    let translucent = farthest_first(&geometry, &view);
    let srgb = SrgbTable::new();
    let tiles =
        Tiles::<N> { shader: &shader, setups: &setups, translucent: &translucent, srgb: &srgb };
    draw_tiles(&tiles, &bin(&setups, width, height), width, height, threads)
}

/// Translucent meshes by the distance of their middle.
fn farthest_first(geometry: &Geometry, view: &View) -> Vec<u32> {
    let mut far: Vec<(f32, u32)> = Vec::new();
    for (mesh, material) in geometry.materials.iter().enumerate() {
        let range = geometry.vertices[mesh].clone();
        if material.opacity < 1.0 && !range.is_empty() {
            let points = &geometry.points[range.start as usize..range.end as usize];
            let sum: f32 = points.iter().map(|&p| view.to_eye(p).z).sum();
            far.push((sum / points.len() as f32, mesh as u32));
        }
    }
    far.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    far.into_iter().map(|(_, mesh)| mesh).collect()
}

/// The triangles that may touch each tile, ascending; tiles row by row.
fn bin(setups: &[Option<Setup>], width: u32, height: u32) -> Vec<Vec<u32>> {
    let tiles = |pixels: u32| (pixels as usize).div_ceil(TILE);
    let (columns, rows) = (tiles(width), tiles(height));
    let mut bins = vec![Vec::new(); columns * rows];
    for (t, setup) in setups.iter().enumerate() {
        let Some(setup) = setup else { continue };
        let span = |range: [i32; 2], count: usize| {
            let low = range[0].max(0) as usize / TILE;
            let high = (range[1].max(0) as usize).div_ceil(TILE).min(count);
            low..high
        };
        for row in span(setup.bounds.y, rows) {
            for column in span(setup.bounds.x, columns) {
                bins[row * columns + column].push(t as u32);
            }
        }
    }
    bins
}

/// Draws all tiles; each thread takes every `threads`-th row of tiles.
fn draw_tiles<const N: usize>(
    tiles: &Tiles<N>,
    bins: &[Vec<u32>],
    width: u32,
    height: u32,
    threads: usize,
) -> Image {
    let mut image = Image::new(width, height);
    let row_bytes = 3 * width as usize * TILE;
    let columns = (width as usize).div_ceil(TILE);
    let mut shares: Vec<Vec<(usize, &mut [u8])>> = (0..threads).map(|_| Vec::new()).collect();
    if width > 0 {
        for (row, bytes) in image.rgb.chunks_mut(row_bytes).enumerate() {
            shares[row % threads].push((row, bytes));
        }
    }
    let draw_row = |row: usize, bytes: &mut [u8]| {
        let top = row * TILE;
        let y = [top as i32, (top + TILE).min(height as usize) as i32];
        for column in 0..columns {
            let left = column * TILE;
            let x = [left as i32, (left + TILE).min(width as usize) as i32];
            let bin = &bins[row * columns + column];
            tiles.draw(&Rect { x, y }, bin, top as i32, width as usize, bytes);
        }
    };
    let draw_row = &draw_row;
    std::thread::scope(|scope| {
        for share in shares {
            scope.spawn(move || {
                for (row, bytes) in share {
                    draw_row(row, bytes);
                }
            });
        }
    });
    image
}
