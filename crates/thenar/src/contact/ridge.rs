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

/// Edges that cross at a smaller sine are left to their ends.
const SINE_MIN: f64 = 0.05;
/// Nearer to its end than this part of an edge, the end's own contact stands for it.
const END: f64 = 0.01;
/// A fall this steep (sine) makes an edge a ridge that can hold something up.
const STEEP: f64 = 0.03;
/// Faces that fall by less (sine) are flat: held at their vertices, what rests on the edge sinks by less than this
/// part of their size.
const FLAT: f64 = 1e-3;
/// On the other side the surface may rise by so much (sine): it may have a valley there.
const RISE_MAX: f64 = 0.35;

/// How the two faces of an edge lie.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ridge {
    /// Unit vectors in the faces, square to the edge, away from it.
    pub falls: [Vec3; 2],
    /// Between the outward normals of the faces; of any length.
    pub outward: Vec3,
}

/// Where two edges pass each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// Place along A and along B, in (0, 1).
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
        let start = x[i as usize];
        let along = (x[j as usize] - start).try_normalize(0.0)?;
        let fall = |v: u32| {
            let out = x[v as usize] - start;
            (out - along * out.dot(&along)).try_normalize(1e-12)
        };
        let outward = surface.pseudonormal(triangle, Feature::Edge(k), x);
        Some(Self { outward, falls: [fall(t[(k + 2) % 3])?, fall(far)?] })
    }

    /// How far the steeper-falling face falls away below a plane with this outward normal (sine).
    fn fall(&self, outward: &Vec3) -> f64 {
        -self.falls[0].dot(outward).min(self.falls[1].dot(outward))
    }

    /// How far the steeper-rising face rises above a plane with this outward normal (sine).
    fn rise(&self, outward: &Vec3) -> f64 {
        self.falls[0].dot(outward).max(self.falls[1].dot(outward))
    }
}

/// Where two lines come nearest, inside both edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passing {
    at: [f64; 2],
    normal: Vec3,
    /// Along the normal, from B to A.
    offset: f64,
}

/// The passing of two edges, given their ends; `None` where it lies at an end or beyond, or farther
/// apart than `within`.
pub(crate) fn passing(a: &[Vec3; 2], b: &[Vec3; 2], within: f64) -> Option<Passing> {
    let (u, v, w) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (uu, uv, vv) = (u.norm_squared(), u.dot(&v), v.norm_squared());
    let area = uu * vv - uv * uv;
    if area <= SINE_MIN * SINE_MIN * uu * vv {
        return None;
    }
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    let at = [(uv * vw - vv * uw) / area, (uu * vw - uv * uw) / area];
    if at.iter().any(|s| !(END..=1.0 - END).contains(s)) {
        return None;
    }
    let normal = u.cross(&v) / area.sqrt();
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
    let (rise_a, rise_b) = (a.rise(&-normal), b.rise(&normal));
    let rise = rise_a.max(rise_b);
    // However gently they fall: what rests on such an edge would sink as far as they fall on to their ends.
    let fall = a.fall(&-normal).min(b.fall(&normal));
    let is_ridge = rise < RISE_MAX && rise_a.min(rise_b) < -STEEP;
    let are_rims = rise < fall.min(STEEP) && fall > FLAT;
    let holds = is_ridge || are_rims;
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

    #[test]
    fn plains_and_valleys_do_not_hold_each_other() {
        let above = |slope| roof(Vec3::y() * 1e-3, Vec3::z(), -Vec3::y(), slope);
        let below = |slope| roof(Vec3::zeros(), Vec3::x(), Vec3::y(), slope);
        let meet = |a, b| meet(&above(a), &below(b)).is_some();
        assert!(!meet(0.0, 0.0), "two planes meet at vertices");
        assert!(meet(0.2, 0.0), "a ridge on a plane's inner edge");
        assert!(meet(0.2, -0.1), "a ridge in a shallow valley");
        assert!(!meet(0.2, -0.8), "a ridge does not reach into a deep valley");
    }

    /// Where flat boxes cross, the rims bear that are level on the inner side; plains that are only tilted
    /// against the way past each other do not.
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

    /// Edges whose faces all fall away are where their bodies touch, at every slope from that at which
    /// vertices hold them as near.
    #[test]
    fn gentle_ridges_hold_each_other_at_every_slope() {
        for slopes in [[0.002, 0.002], [0.005, 0.02], [0.02, 0.005], [0.029, 0.031], [0.029, 0.029]]
        {
            let below = roof(Vec3::zeros(), Vec3::x(), Vec3::y(), slopes[0]);
            let above = roof(Vec3::y() * -5e-5, Vec3::z(), -Vec3::y(), slopes[1]);
            let c = meet(&above, &below).expect("they hold each other");
            assert!((c.gap + 5e-5).abs() < 1e-15, "{slopes:?}");
        }
        let flat = |y: f64, along, up| roof(Vec3::y() * y, along, up, 1e-4);
        let pair = [flat(-5e-5, Vec3::z(), -Vec3::y()), flat(0.0, Vec3::x(), Vec3::y())];
        assert!(meet(&pair[0], &pair[1]).is_none(), "flat faces meet at vertices");
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
