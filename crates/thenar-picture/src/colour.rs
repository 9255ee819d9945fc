//! Colours: linear light, the sRGB curve, and scales for scalars.

use super::V;

/// Linear red, green, blue; 1 is the brightest a display shows.
pub type Rgb = [f32; 3];

/// Linear light of one sRGB component in [0, 1].
fn from_srgb(c: f32) -> f32 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// sRGB component in [0, 1] of linear light.
fn to_srgb(c: f32) -> f32 {
    if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

/// A linear colour from its usual hexadecimal sRGB notation, `0xrrggbb`.
pub fn hex(rrggbb: u32) -> Rgb {
    [16, 8, 0].map(|shift| from_srgb(((rrggbb >> shift) & 255) as f32 / 255.0))
}

/// A linear colour from sRGB components in [0, 1].
pub fn from_srgb_triple(c: [f64; 3]) -> Rgb {
    c.map(|x| from_srgb(x.clamp(0.0, 1.0) as f32))
}

pub(super) fn vector(c: Rgb) -> V {
    V::new(c[0], c[1], c[2])
}

/// Compresses highlights: the identity up to 0.6, then a smooth shoulder that tends to 1.
pub(super) fn tone(c: V) -> V {
    c.map(|x| {
        let over = (x - 0.6).max(0.0);
        x.clamp(0.0, 0.6) + 0.4 * over / (0.4 + over)
    })
}

/// The sRGB curve as a table over the square root of linear light.
pub(super) struct SrgbTable(Vec<u8>);

impl SrgbTable {
    const LAST: f32 = 4095.0;

    pub(super) fn new() -> Self {
        let entry = |i: u32| {
            let root = i as f32 / Self::LAST;
            (to_srgb(root * root) * 255.0 + 0.5) as u8
        };
        Self((0..=Self::LAST as u32).map(entry).collect())
    }

    pub(super) fn encode(&self, linear: f32) -> u8 {
        self.0[(linear.clamp(0.0, 1.0).sqrt() * Self::LAST + 0.5) as usize]
    }
}

fn along(stops: &[u32], t: f64) -> Rgb {
    let t = if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.0 };
    let s = t * (stops.len() - 1) as f64;
    let i = (s as usize).min(stops.len() - 2);
    let f = (s - i as f64) as f32;
    let (a, b) = (hex(stops[i]), hex(stops[i + 1]));
    std::array::from_fn(|k| a[k] * (1.0 - f) + b[k] * f)
}

/// Skin through yellow and red to violet for a pressure in [0, 1] of its scale.
pub fn pressure_colour(p: f64) -> Rgb {
    along(&[0xe2b9a0, 0xf7d154, 0xf0792b, 0xc61f3c, 0x5a0f5e], p)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_table_inverts_the_srgb_curve() {
        let table = SrgbTable::new();
        for byte in 0..=255_u32 {
            let linear = hex(byte << 16)[0];
            assert_eq!(u32::from(table.encode(linear)), byte);
        }
    }

    #[test]
    fn middle_grey_is_21_percent_linear() {
        // sRGB 0.5 is ((0.5 + 0.055) / 1.055)^2.4 = 0.21404114 of linear light (IEC 61966-2-1).
        assert!((from_srgb(0.5) - 0.214_041_14).abs() < 1e-6);
    }

    #[test]
    fn scales_start_and_end_at_their_stops_and_swallow_nan() {
        assert_eq!(pressure_colour(f64::NAN), hex(0xe2b9a0));
    }
}
