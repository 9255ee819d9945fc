//! One tile of the picture: visibility, shading, blending, averaging.

use super::V;
use super::colour::{SrgbTable, tone};
use super::raster::{Layer, NOTHING, Rect, Setup, sample_pattern};
use super::shade::Shader;

/// Number of the ground in a visibility layer.
const GROUND: u32 = NOTHING - 1;

/// Draws tiles for one picture; `N` samples per pixel.
pub(super) struct Tiles<'a, const N: usize> {
    pub shader: &'a Shader<'a>,
    /// One per screen triangle.
    pub setups: &'a [Option<Setup>],
    /// Translucent meshes, farthest first.
    pub translucent: &'a [u32],
    pub srgb: &'a SrgbTable,
}

impl<const N: usize> Tiles<'_, N> {
    /// Draws the triangles (ascending) that touch `rect` and writes its bytes into `rgb`, whose
    /// first byte is the pixel (0, `top`) of a picture `width` wide.
    pub(super) fn draw(
        &self,
        rect: &Rect,
        triangles: &[u32],
        top: i32,
        width: usize,
        rgb: &mut [u8],
    ) {
        let pixels = rect.width() * (rect.y[1] - rect.y[0]) as usize;
        let mut layer = Layer::<N>::new(pixels);
        self.lay_ground(rect, &mut layer);
        for &t in triangles {
            if self.opacity(t) >= 1.0 {
                self.rasterise(t, rect, &mut layer);
            }
        }
        let mut colours = vec![[V::zeros(); N]; pixels];
        self.for_pixels(rect, |pixel, x, y| {
            self.shade_pixel(&layer.id[pixel], &layer.nearness[pixel], x, y, |s, colour, _| {
                colours[pixel][s] = tone(colour);
            });
        });
        for &mesh in self.translucent {
            self.blend(mesh, rect, triangles, &layer, &mut colours);
        }
        self.for_pixels(rect, |pixel, x, y| {
            let mean: V = colours[pixel].iter().sum::<V>() / N as f32;
            let byte = 3 * ((y - top) as usize * width + x as usize);
            for k in 0..3 {
                rgb[byte + k] = self.srgb.encode(mean[k]);
            }
        });
    }

    fn opacity(&self, triangle: u32) -> f32 {
        let mesh = self.shader.screen.mesh_of[triangle as usize];
        self.shader.geometry.materials[mesh as usize].opacity
    }

    fn rasterise(&self, triangle: u32, rect: &Rect, layer: &mut Layer<N>) {
        if let Some(setup) = &self.setups[triangle as usize] {
            setup.draw(triangle, rect, layer);
        }
    }

    fn for_pixels(&self, rect: &Rect, mut f: impl FnMut(usize, i32, i32)) {
        for y in rect.y[0]..rect.y[1] {
            for x in rect.x[0]..rect.x[1] {
                let row = (y - rect.y[0]) as usize * rect.width();
                f(row + (x - rect.x[0]) as usize, x, y);
            }
        }
    }

    fn lay_ground(&self, rect: &Rect, layer: &mut Layer<N>) {
        let Some(ground) = &self.shader.ground else { return };
        let pattern = sample_pattern::<N>();
        self.for_pixels(rect, |pixel, x, y| {
            for (s, [dx, dy]) in pattern.iter().enumerate() {
                let nearness = ground.nearness(&self.ray_at(x, y, *dx, *dy));
                if nearness > 0.0 {
                    layer.nearness[pixel][s] = nearness;
                    layer.id[pixel][s] = GROUND;
                }
            }
        });
    }

    fn ray_at(&self, x: i32, y: i32, dx: i64, dy: i64) -> V {
        self.shader.view.ray(x as f32 + 0.5 + dx as f32 / 256.0, y as f32 + 0.5 + dy as f32 / 256.0)
    }

    /// Shades each distinct surface in a pixel once, at the middle of its samples, and hands
    /// colour and opacity to each of them.
    fn shade_pixel(
        &self,
        ids: &[u32; N],
        nearness: &[f32; N],
        x: i32,
        y: i32,
        mut put: impl FnMut(usize, V, f32),
    ) {
        let pattern = sample_pattern::<N>();
        let mut done = [false; N];
        for first in 0..N {
            if done[first] {
                continue;
            }
            let (mut sum, mut members) = ([0, 0], [false; N]);
            for s in first..N {
                members[s] = !done[s]
                    && self.same_surface([ids[first], ids[s]], [nearness[first], nearness[s]]);
                if members[s] {
                    done[s] = true;
                    sum = [sum[0] + pattern[s][0], sum[1] + pattern[s][1]];
                }
            }
            let count = members.iter().filter(|&&m| m).count() as f32;
            let place = |c: i32, sum: i64| c as f32 + 0.5 + sum as f32 / count / 256.0;
            let (colour, opacity) = self.shade(ids[first], place(x, sum[0]), place(y, sum[1]));
            for s in (first..N).filter(|&s| members[s]) {
                put(s, colour, opacity);
            }
        }
    }

    fn shade(&self, id: u32, x: f32, y: f32) -> (V, f32) {
        match id {
            NOTHING => (self.shader.backdrop(&self.shader.view.ray(x, y)), 1.0),
            GROUND => (self.shader.ground(x, y, &self.shader.view.ray(x, y)), 1.0),
            _ => self.shader.surface(id, x, y),
        }
    }

    /// Neighbouring triangles of a smooth mesh count as one surface.
    fn same_surface(&self, ids: [u32; 2], nearness: [f32; 2]) -> bool {
        if ids[0] == ids[1] {
            return true;
        }
        if ids.iter().any(|&id| id >= GROUND) {
            return false;
        }
        let screen = self.shader.screen;
        let mesh = ids.map(|id| screen.mesh_of[id as usize]);
        let normal =
            ids.map(|id| self.shader.geometry.normals[screen.triangles[id as usize][0] as usize]);
        mesh[0] == mesh[1]
            && (nearness[0] - nearness[1]).abs() < 0.01 * nearness[0].abs()
            && normal[0].dot(&normal[1]) > 0.95
    }

    /// Blends the nearest layer of a translucent mesh over the colours behind it.
    fn blend(
        &self,
        mesh: u32,
        rect: &Rect,
        triangles: &[u32],
        behind: &Layer<N>,
        colours: &mut [[V; N]],
    ) {
        let mesh_of = &self.shader.screen.mesh_of;
        let start = triangles.partition_point(|&t| mesh_of[t as usize] < mesh);
        let end = triangles.partition_point(|&t| mesh_of[t as usize] <= mesh);
        if start == end {
            return;
        }
        let mut layer =
            Layer::<N> { nearness: behind.nearness.clone(), id: vec![[NOTHING; N]; colours.len()] };
        for &t in &triangles[start..end] {
            self.rasterise(t, rect, &mut layer);
        }
        self.for_pixels(rect, |pixel, x, y| {
            let ids = &layer.id[pixel];
            if ids.iter().all(|&id| id == NOTHING) {
                return;
            }
            self.shade_pixel(ids, &layer.nearness[pixel], x, y, |s, colour, opacity| {
                if ids[s] != NOTHING {
                    let under = colours[pixel][s];
                    colours[pixel][s] = under + (tone(colour) - under) * opacity;
                }
            });
        });
    }
}
