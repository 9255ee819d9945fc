//! Two edges that cross: the contact that neither surface's vertices see.
//!
//! ```text
//!          outward of B
//!               ^
//!     face 0   / \   face 1        an edge seen along itself; `falls` point down its faces.
//!     <-------/   \------->        A plane rests on it if its normal lies between the normals
//!      fall 0      fall 1          of the faces: both falls lead away below the plane.
//! ```

use crate::contact::surface::Surface;
use crate::contact::triangle::Feature;
use crate::math::Vec3;

/// Square of the sine below which two edges count as parallel: the normal of their crossing then
/// has lost half of its digits. Every other crossing counts, however near to an end, for where one
/// edge hands over to the next on another body's ridge, a gap between them is a place at which
/// nothing holds.
pub(crate) const PARALLEL: f64 = f64::EPSILON;
/// A face that reaches less far from its edge has no area, and no direction \[m\]: round-off leaves
/// as much of places ten kilometres away.
const AREALESS: f64 = 1e-12;
/// A face level to this (sine) lies as near to a plane as a gap is known: to a hundredth of an
/// edge.
const LEVEL: f64 = 0.01;

/// Directions of the two faces of an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ridge {
    /// Unit vectors in the faces, square to the edge, away from it.
    pub falls: [Vec3; 2],
    /// Between the outward normals of the faces; of any length.
    pub outward: Vec3,
}

/// Contact of two edges that pass each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// Place along A and along B, in [0, 1].
    pub at: [f64; 2],
    /// Unit normal from B to A.
    pub normal: Vec3,
    pub gap: f64,
}

impl Ridge {
    /// Edge `k` of a triangle; `None` at a border, or where a face has no area.
    pub fn of(surface: &Surface, triangle: u32, k: usize, x: &[Vec3]) -> Option<Self> {
        let t = surface.triangles[triangle as usize];
        let across = surface.across(triangle, k)?;
        let (i, j) = (t[k], t[(k + 1) % 3]);
        let far = surface.triangles[across as usize].into_iter().find(|v| *v != i && *v != j)?;
        let outward = surface.pseudonormal(triangle, Feature::Edge(k), x);
        let falls = [fall([i, j], t[(k + 2) % 3], x)?, fall([i, j], far, x)?];
        Some(Self { outward, falls })
    }

    /// Edge `k` of a triangle where the other edge may touch the triangle's own face only: the face
    /// across falls straight down, wherever it is.
    pub fn rim(surface: &Surface, triangle: u32, k: usize, x: &[Vec3]) -> Option<Self> {
        let t = surface.triangles[triangle as usize];
        let outward = surface.pseudonormal(triangle, Feature::Face, x);
        let own = fall([t[k], t[(k + 1) % 3]], t[(k + 2) % 3], x)?;
        Some(Self { outward, falls: [own, -outward] })
    }

    /// Returns the slopes of the faces against a plane with this outward normal: the sine at which
    /// the steeper-falling one falls away below it, and that at which the steeper-rising one rises
    /// above.
    fn fall_and_rise(&self, outward: &Vec3) -> [f64; 2] {
        let [one, other] = self.falls.map(|fall| fall.dot(outward));
        [-one.min(other), one.max(other)]
    }
}

/// The unit vector square to an edge, from its line to a vertex.
fn fall([i, j]: [u32; 2], to: u32, x: &[Vec3]) -> Option<Vec3> {
    let start = x[i as usize];
    let along = (x[j as usize] - start).try_normalize(0.0)?;
    let out = x[to as usize] - start;
    (out - along * out.dot(&along)).try_normalize(AREALESS)
}

/// Nearest points of two lines, within both edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passing {
    at: [f64; 2],
    normal: Vec3,
    /// Along the normal, from B to A.
    offset: f64,
}

/// The passing of two edges, given their ends; `None` where it lies beyond an end, or farther apart
/// than `within`.
pub(crate) fn passing(a: &[Vec3; 2], b: &[Vec3; 2], within: f64) -> Option<Passing> {
    let (u, v, w) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    // By its square from products of lengths all digits would be gone where half are here.
    let across = u.cross(&v);
    let area = across.norm_squared();
    if area <= PARALLEL * u.norm_squared() * v.norm_squared() {
        return None;
    }
    let at = [v.cross(&w).dot(&across) / area, u.cross(&w).dot(&across) / area];
    if at.iter().any(|s| !(0.0..=1.0).contains(s)) {
        return None;
    }
    let normal = across / area.sqrt();
    let offset = normal.dot(&w);
    (offset.abs() <= within).then_some(Passing { at, normal, offset })
}

/// The contact of two edges that pass; `None` where their faces meet instead.
pub(crate) fn crossing(passing: &Passing, a: &Ridge, b: &Ridge) -> Option<Crossing> {
    let Passing { at, normal, offset } = *passing;
    let upwards = normal.dot(&(b.outward - a.outward));
    let (normal, gap) = if upwards < 0.0 { (-normal, -offset) } else { (normal, offset) };
    if normal.dot(&a.outward) >= 0.0 || normal.dot(&b.outward) <= 0.0 {
        return None;
    }
    let [fall_a, rise_a] = a.fall_and_rise(&-normal);
    let [fall_b, rise_b] = b.fall_and_rise(&normal);
    // Beside an edge that rises the bodies are nearer than at the crossing; plains meet at their
    // vertices.
    let holds = rise_a.max(rise_b) < LEVEL && fall_a.max(fall_b) > LEVEL;
    holds.then_some(Crossing { at, normal, gap })
}

#[cfg(test)]
mod tests {
    use super::*;

    type Roof = ([Vec3; 2], Ridge);

    fn meet(a: &Roof, b: &Roof) -> Option<Crossing> {
        crossing(&passing(&a.0, &b.0, 2e-3)?, &a.1, &b.1)
    }

    fn point((ends, _): &Roof, at: f64) -> Vec3 {
        ends[0] + at * (ends[1] - ends[0])
    }

    /// A roof of this slope with its ridge through `top` along `along`, open towards -`up`.
    fn roof(top: Vec3, along: Vec3, up: Vec3, slope: f64) -> Roof {
        let (sin, cos) = slope.sin_cos();
        let across = along.cross(&up);
        let falls = [across, -across].map(|side| side * cos - up * sin);
        ([top - 0.01 * along, top + 0.01 * along], Ridge { falls, outward: up })
    }

    #[test]
    fn crossed_roofs_touch_at_their_ridges() {
        let below = roof(Vec3::zeros(), Vec3::x(), Vec3::y(), 0.3);
        for gap in [1e-3, -1e-3] {
            let top = Vec3::new(0.002, gap, -0.003);
            let above = roof(top, Vec3::z(), -Vec3::y(), 0.2);
            let c = meet(&above, &below).expect("they cross");
            assert!((c.gap - gap).abs() < 1e-15 && (c.normal - Vec3::y()).norm() < 1e-12);
            assert!((point(&above, c.at[0]).xz() - point(&below, c.at[1]).xz()).norm() < 1e-15);
            let seen_from_below = meet(&below, &above).expect("they cross");
            assert!((seen_from_below.gap - gap).abs() < 1e-15);
            assert!((seen_from_below.normal + Vec3::y()).norm() < 1e-12);
            assert!(passing(&above.0, &below.0, 5e-4).is_none(), "out of reach");
        }
    }

    /// Beside an edge that rises by a sine `r` the other surface is nearer by up to `r` times its
    /// size.
    #[test]
    fn plains_and_valleys_do_not_hold_each_other() {
        let above = |slope| roof(Vec3::y() * 1e-3, Vec3::z(), -Vec3::y(), slope);
        let below = |slope| roof(Vec3::zeros(), Vec3::x(), Vec3::y(), slope);
        let meet = |a, b| meet(&above(a), &below(b)).is_some();
        assert!(!meet(0.0, 0.0) && !meet(0.009, 0.009), "two plains meet at vertices");
        assert!(meet(0.2, 0.0), "a ridge on a plane's inner edge");
        assert!(meet(0.2, -0.009), "level as far as a gap is known");
        assert!(!meet(0.2, -0.011) && !meet(0.2, -0.8), "a ridge does not reach into a valley");
    }

    /// Rims that are level on the inner side bear where flat boxes cross; plains that are only
    /// tilted against the way past each other do not.
    #[test]
    fn rims_of_flat_faces_hold_each_other() {
        let edge = |up: Vec3, along: Vec3, falls: [f64; 2], at: Vec3| {
            let across = along.cross(&up);
            let fall = |side: f64, angle: f64| across * side * angle.cos() - up * angle.sin();
            let ends = [at - 0.01 * along, at + 0.01 * along];
            (ends, Ridge { falls: [fall(1.0, falls[0]), fall(-1.0, falls[1])], outward: up })
        };
        let pair = |falls| {
            let above = edge(-Vec3::y(), Vec3::z(), falls, Vec3::y() * -1e-3);
            let below = edge(Vec3::y(), Vec3::x(), falls, Vec3::zeros());
            meet(&above, &below)
        };
        let rims = pair([0.0, std::f64::consts::FRAC_PI_2]).expect("rims cross");
        assert!((rims.gap + 1e-3).abs() < 1e-15);
        assert!(pair([-0.2, 0.2]).is_none(), "tilted plains");
    }

    /// A ridge is held by edges of every slope, those of a surface that it has pressed flat too.
    #[test]
    fn ridges_hold_and_are_held_at_every_slope() {
        for slopes in [[0.0, 0.02], [0.02, 0.0], [0.005, 0.02], [0.02, 0.005], [0.029, 0.031]] {
            let below = roof(Vec3::zeros(), Vec3::x(), Vec3::y(), slopes[0]);
            let above = roof(Vec3::y() * -5e-5, Vec3::z(), -Vec3::y(), slopes[1]);
            let c = meet(&above, &below).expect("they hold each other");
            assert!((c.gap + 5e-5).abs() < 1e-15, "{slopes:?}");
        }
    }

    /// A ridge that moves over a surface is held by one of two edges that share an end at every
    /// place, up to the end itself, however obliquely they cross.
    #[test]
    fn edges_hand_over_to_each_other_without_a_gap() {
        for turn in [1.0_f64, 0.1, 1e-3, 1e-6] {
            let along = Vec3::new(turn.cos(), 0.0, turn.sin());
            let below = roof(Vec3::zeros(), Vec3::x(), Vec3::y(), 0.2);
            for place in [-1e-2, -1e-4, -1e-9, 0.0] {
                let above =
                    roof(Vec3::new(place, -5e-5, 0.0) + along * 0.01, along, -Vec3::y(), 0.2);
                assert!(meet(&above, &below).is_some(), "{turn} {place}");
            }
        }
    }

    #[test]
    fn edges_that_pass_beside_or_along_each_other_do_not_touch() {
        let below = roof(Vec3::zeros(), Vec3::x(), Vec3::y(), 0.3);
        let beside = roof(Vec3::new(0.02, 1e-3, 0.0), Vec3::z(), -Vec3::y(), 0.2);
        assert!(meet(&beside, &below).is_none());
        let along = roof(Vec3::y() * 1e-3, Vec3::x(), -Vec3::y(), 0.2);
        assert!(meet(&along, &below).is_none());
    }
}
