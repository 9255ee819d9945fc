//! Colourings of the ground, blurred to what one pixel covers.

use super::V;
use super::colour::{hex, vector};
use super::raster::floor;
use super::scene3d::Pattern;

/// The colour at (u, v) \[m\] averaged over about `footprint` \[m\].
pub(super) fn colour(pattern: &Pattern, u: f32, v: f32, footprint: f32) -> V {
    match *pattern {
        Pattern::Plain(c) => vector(c),
        Pattern::Checker([a, b], size) => {
            let width = (footprint / size).max(1e-4);
            let part = 0.5 - 0.5 * square_wave(u / size, width) * square_wave(v / size, width);
            vector(a) * (1.0 - part) + vector(b) * part
        }
        Pattern::Wood(plank) => wood(u / plank, v / plank, footprint / plank),
    }
}

/// A square wave of period 2 between -1 and 1, averaged over `width` around `x`.
fn square_wave(x: f32, width: f32) -> f32 {
    // Its integral is a triangle wave.
    let integral = |x: f32| {
        let phase = (x / 2.0 - (x / 2.0).floor()) * 2.0;
        if phase < 1.0 { phase } else { 2.0 - phase }
    };
    ((integral(x + width / 2.0) - integral(x - width / 2.0)) / width).clamp(-1.0, 1.0)
}

/// Planks along u, one unit wide, with grain.
fn wood(u: f32, v: f32, footprint: f32) -> V {
    let plank = v.floor();
    let tone = hash(plank as i32, 17);
    let across = v - plank;
    let along = u * 0.35 + 9.7 * tone;
    let bend = 0.6 * noise(along * 0.8, across * 1.2 + 5.0 * tone);
    let rings = ((across * 7.0 + bend * 6.0) * std::f32::consts::TAU * 0.5).sin() * 0.5 + 0.5;
    let fibre = noise(along * 6.0, across * 90.0 + 31.0 * tone);
    let clear = (1.0 - 9.0 * footprint).clamp(0.0, 1.0);
    let shade = 0.5 + clear * (0.30 * (rings - 0.5) + 0.28 * (fibre - 0.5)) + 0.35 * (tone - 0.5);
    let light = vector(hex(0xc79a66));
    let dark = vector(hex(0x8a5a33));
    let seam = across.min(1.0 - across);
    let gap =
        1.0 - 0.55 * (1.0 - (seam / (0.012 + footprint)).min(1.0)) * (0.024 / (0.024 + footprint));
    (dark + (light - dark) * shade.clamp(0.0, 1.0)) * gap
}

/// Smooth noise of unit cells in [0, 1].
fn noise(x: f32, y: f32) -> f32 {
    let (ix, iy) = (floor(x), floor(y));
    let ease = |t: f32| t * t * (3.0 - 2.0 * t);
    let (u, v) = (ease(x - ix as f32), ease(y - iy as f32));
    let at = |dx: i32, dy: i32| hash(ix.wrapping_add(dx), iy.wrapping_add(dy));
    (at(0, 0) * (1.0 - u) + at(1, 0) * u) * (1.0 - v) + (at(0, 1) * (1.0 - u) + at(1, 1) * u) * v
}

/// An arbitrary but fixed number in [0, 1) for each cell.
fn hash(x: i32, y: i32) -> f32 {
    let mut h = (x as u32).wrapping_mul(0x9e37_79b1) ^ (y as u32).wrapping_mul(0x85eb_ca77);
    h ^= h >> 15;
    h = h.wrapping_mul(0x2c1b_3c6d);
    h ^= h >> 12;
    (h >> 8) as f32 / (1 << 24) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checker_seen_from_afar_is_the_mean_of_its_colours() {
        let checker = Pattern::Checker([[1.0, 1.0, 1.0], [0.0, 0.0, 0.0]], 0.1);
        let near = colour(&checker, 0.05, 0.05, 1e-4);
        let across = colour(&checker, 0.15, 0.05, 1e-4);
        assert!((near.x - across.x).abs() > 0.99);
        let far = colour(&checker, 0.0371, 0.0213, 5.0);
        assert!((far.x - 0.5).abs() < 0.02, "{far}");
    }
}
