//! Look of skin from place to place: blood under it, creases, fingernails. The page draws the same,
//! with finer grain.

use super::V;
use super::normals::smooth;
use super::surface::embedded;
use thenar_core::Vec3;
use thenar_core::model::{Bone, Digit, EmbeddedSurface, HandModel};
use thenar_rig::export::vertex_skin;

/// Place on a hand of a vertex of its skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinSite {
    /// Blood that shows, 0 to 1.
    pub blood: f32,
    /// Openness, from 0 in a crease to 1.
    pub open: f32,
    /// Place across and along the nail, in its half width and half length: beyond 1 is none.
    pub nail: [f32; 2],
}

impl Default for SkinSite {
    fn default() -> Self {
        Self { blood: 0.0, open: 1.0, nail: [0.0, -20.0] }
    }
}

/// Half width and half length of nails, the thumb's and a finger's, of the length of a hand: 6.4,
/// 6.8, 4.6 and 5.4 mm of 190.
const NAILS: [[f64; 2]; 2] = [[6.4 / 190.0, 6.8 / 190.0], [4.6 / 190.0, 5.4 / 190.0]];
/// Below the middle of the bone by so much, of the length of a hand, skin is twice as far off the
/// nail: 1 mm of 190.
const PLANE: f64 = 1.0 / 190.0;
/// Rounds in which curvature is smoothed.
const SMOOTHINGS: usize = 12;

/// The sites of the vertices of a hand's skin; `None` for figures.
pub fn sites(hand: &HandModel, render: &EmbeddedSurface) -> Option<Vec<SkinSite>> {
    hand.bones.iter().find(|bone| bone.digit != Digit::Palm)?;
    let rest = embedded(render, &hand.flesh.tets, &hand.flesh.nodes);
    let curvature = curvature(&rest, &render.triangles);
    let skin = vertex_skin(render, &hand.flesh.tets, &hand.bindings);
    let site = |v: usize| {
        let heaviest = (0..skin[v].weights.len())
            .max_by(|a, b| skin[v].weights[*a].total_cmp(&skin[v].weights[*b]));
        let b = heaviest.map_or(0, |k| usize::from(skin[v].bones[k]));
        let bone = hand.bones.get(b)?;
        // Curvature as of a hand of 190 mm.
        let hollow = -(curvature[v] * hand.length / 0.19) as f32;
        Some(SkinSite {
            blood: (blood(hand, b, &bone.pose_MB.inverse_point(&rest[v]))
                + 0.2 * step(0.0, 120.0, hollow))
            .min(1.0),
            open: 1.0 - 0.75 * step(20.0, 220.0, hollow),
            nail: nail(hand, bone.digit, &rest[v]),
        })
    };
    Some((0..rest.len()).map(|v| site(v).unwrap_or_default()).collect())
}

/// Half the length of a bone \[m\].
fn half(bone: &Bone) -> f64 {
    0.5 * (bone.ends_B[0].z - bone.ends_B[1].z).abs()
}

/// Bones run along -z, their backs look to +y: fingertips and knuckles are red, the palm more than
/// the back.
fn blood(hand: &HandModel, b: usize, p: &Vec3) -> f32 {
    let bone = &hand.bones[b];
    let along = if half(bone) > 0.0 { (-p.z / half(bone)) as f32 } else { 0.0 };
    let last = hand.bones.iter().rposition(|other| other.digit == bone.digit) == Some(b);
    let (finger, back) = (bone.digit != Digit::Palm, p.y > 0.0);
    let mut blood = 0.22;
    if finger && last {
        blood += 0.5 * step(-0.2, 1.2, along) * if back { 0.6 } else { 1.0 };
    } else if finger && back {
        blood += 0.35 * (-((along - 1.0) / 0.35).powi(2)).exp();
    }
    if finger && back {
        blood += 0.3 * (-((along + 1.0) / 0.35).powi(2)).exp();
    }
    blood + if back { 0.0 } else { 0.14 }
}

/// Place on the plane of a digit's nail. Vertices off the nail are far from its middle, in the
/// direction in which they are: between two of them no triangle crosses the nail.
fn nail(hand: &HandModel, digit: Digit, p_M: &Vec3) -> [f32; 2] {
    let last = hand.bones.iter().rfind(|bone| bone.digit == digit && digit != Digit::Palm);
    let Some(bone) = last else { return SkinSite::default().nail };
    let [wide, long] = NAILS[usize::from(digit != Digit::Thumb)].map(|part| part * hand.length);
    let p = bone.pose_MB.inverse_point(p_M);
    let off = if p.y >= 0.0 { 1.0 } else { 1.0 + (-p.y / (PLANE * hand.length)).min(8.0) };
    let along = -p.z - (half(bone) - 0.25 * long);
    [(off * p.x / wide) as f32, (off * along / long) as f32]
}

/// Mean curvature \[1/m\] from how normals turn along edges, smoothed; positive where the surface
/// is convex.
fn curvature(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<f64> {
    let normals = smooth(positions, triangles);
    let mut around = vec![Vec::new(); positions.len()];
    for t in triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            around[a as usize].push(b as usize);
            around[b as usize].push(a as usize);
        }
    }
    let mean = |list: &[usize], of: &dyn Fn(usize) -> f64| {
        list.iter().map(|w| of(*w)).sum::<f64>() / list.len().max(1) as f64
    };
    let turn = |v: usize, w: usize| {
        let way = positions[w] - positions[v];
        way.dot(&(normals[w] - normals[v])) / way.norm_squared().max(1e-18)
    };
    let mut values: Vec<f64> =
        around.iter().enumerate().map(|(v, list)| mean(list, &|w| turn(v, w))).collect();
    for _ in 0..SMOOTHINGS {
        let smoothed = around.iter().zip(&values);
        values = smoothed.map(|(list, own)| 0.5 * (own + mean(list, &|w| values[w]))).collect();
    }
    values
}

/// Colour of skin of a base colour at a site, and how much of a nail it is.
pub(super) fn colour(base: &V, site: &SkinSite) -> (V, f32) {
    let [u, w] = site.nail;
    let radius = u.hypot(w * if w > 0.0 { 1.0 } else { 1.05 });
    let nail = 1.0 - step(0.94, 1.06, radius);
    let groove = 1.0 - ((radius - 1.04).abs() / 0.16).min(1.0);
    let groove = groove * groove * (3.0 - 2.0 * groove);
    let edge = nail * step(0.62, 0.72, w);
    let lunula = nail * (1.0 - step(0.40, 0.52, u.hypot((w + 1.0) * 1.3)));
    let blend = |a: [f32; 3], b: [f32; 3], part: f32| V::from(a).lerp(&V::from(b), part);
    let skin = base
        .component_mul(&blend([1.035, 1.02, 0.985], [1.03, 0.76, 0.70], site.blood))
        .component_mul(&blend([0.62, 0.42, 0.36], [1.0; 3], site.open))
        .component_mul(&blend([1.0; 3], [0.86, 0.70, 0.66], groove));
    let plate = base.component_mul(&V::new(1.10, 0.93, 0.93));
    let plate = plate.lerp(&V::new(0.80, 0.68, 0.58), 0.6 * edge + 0.35 * lunula);
    (skin.lerp(&plate, nail), nail)
}

/// Smooth step from 0 at `from` to 1 at `to`.
fn step(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::super::shapes;
    use super::*;

    #[test]
    fn a_ball_is_as_curved_as_its_radius_says() {
        let ball = shapes::sphere(Vec3::zeros(), 0.05, 48);
        let mean = curvature(&ball.positions, &ball.triangles);
        let off = mean.iter().map(|c| (c - 20.0).abs()).fold(0.0, f64::max);
        assert!(off < 1.0, "{off}");
    }

    #[test]
    fn a_nail_is_paler_than_the_finger_and_its_groove_darker() {
        let base = V::new(0.7, 0.4, 0.3);
        let at = |u: f32| colour(&base, &SkinSite { blood: 0.5, open: 1.0, nail: [u, 0.0] });
        let [(plate, on), (groove, _), (skin, off)] = [0.0, 1.1, 3.0].map(at);
        assert_eq!((on, off), (1.0, 0.0));
        assert!(plate.y > skin.y && groove.y < skin.y, "{plate} {groove} {skin}");
    }
}
