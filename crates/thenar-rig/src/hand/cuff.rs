//! A cuff: a band of cloth around the wrist, where the flesh of a hand ends. It is seen and never
//! touched.

use crate::TriMesh;
use std::f64::consts::TAU;
use thenar_core::Vec3;
use thenar_core::model::{Digit, HandModel};

/// Directions around the wrist.
const AROUND: usize = 64;
/// Length of the cuff, of the length of a hand: 26 mm of 190.
const LONG: f64 = 26.0 / 190.0;
/// Distance from cuff to skin, of the length of a hand: 1.5 mm of 190.
const OFF: f64 = 1.5 / 190.0;
/// Rounds in which its outline is smoothed: over some 20° to either side.
const SMOOTHINGS: usize = 6;
/// Profile from inside over its hem at the hand, along the way back in parts of its length, and
/// outwards from the band in parts of `OFF`: two folds, the band, and a rounded end.
const PROFILE: [[f64; 2]; 13] = [
    [0.80, -1.8],
    [0.10, -1.8],
    [0.01, -1.2],
    [0.00, -0.4],
    [0.02, 0.5],
    [0.06, 0.9],
    [0.16, 0.9],
    [0.19, 0.3],
    [0.23, 0.6],
    [0.90, 0.2],
    [0.97, -0.4],
    [1.00, -1.6],
    [1.00, -4.0],
];
/// Farther behind the wrist than this, of the length of a hand, flesh is a forearm: that ends by
/// itself.
const FOREARM: f64 = 0.35;

/// The cuff of a hand at rest, in the frame of its palm's bone \[m\]; `None` for hands with a
/// forearm, and for figures.
pub fn cuff(hand: &HandModel) -> Option<TriMesh> {
    let palm = hand.bones.first()?;
    hand.bones.iter().find(|bone| bone.digit != Digit::Palm)?;
    let (flesh, render) = (&hand.flesh, &hand.render);
    let mut skin = vec![Vec3::zeros(); render.vertices.len()];
    render.positions(&flesh.tets, &flesh.nodes, &mut skin);
    // In the frame of the wrist, whose -z goes to the fingers.
    let pose_MT = palm.pose_MB * palm.pose_BT;
    skin.iter_mut().for_each(|p| *p = pose_MT.inverse_point(p));
    let end = skin.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
    let long = LONG * hand.length;
    let wrist: Vec<&Vec3> = skin.iter().filter(|p| p.z > end - 1.1 * long).collect();
    if wrist.len() < 8 || end > FOREARM * hand.length {
        return None;
    }
    let bounds = |k: usize| {
        let values = wrist.iter().map(|p| p[k]);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
    };
    let [middle_x, middle_y] = [0, 1].map(|k| bounds(k).iter().sum::<f64>() / 2.0);
    let outline = outline(wrist.iter().map(|p| [p.x - middle_x, p.y - middle_y]));
    let off = OFF * hand.length;
    let front = end + off - long;
    let mut mesh = TriMesh { positions: Vec::new(), triangles: Vec::new() };
    for [back, out] in PROFILE {
        for (k, radius) in outline.iter().enumerate() {
            let (sin, cos) = (k as f64 / AROUND as f64 * TAU).sin_cos();
            let r = radius + off * (1.0 + out);
            mesh.positions.push(Vec3::new(
                middle_x + r * cos,
                middle_y + r * sin,
                front + back * long,
            ));
        }
    }
    let n = AROUND as u32;
    for ring in 0..PROFILE.len() as u32 - 1 {
        for k in 0..n {
            let [a, b] = [ring * n + k, ring * n + (k + 1) % n];
            mesh.triangles.extend([[a, b, a + n], [b, b + n, a + n]]);
        }
    }
    // The end is closed: what is behind is not seen.
    let last = (PROFILE.len() as u32 - 1) * n;
    let centre = mesh.positions.len() as u32;
    mesh.positions.push(Vec3::new(middle_x, middle_y, front + long));
    mesh.triangles.extend((0..n).map(|k| [last + k, last + (k + 1) % n, centre]));
    mesh.positions.iter_mut().for_each(|p| *p = palm.pose_BT.point(p));
    Some(mesh)
}

/// Reach of the skin in each direction around the wrist \[m\], smoothed but nowhere less.
fn outline(points: impl Iterator<Item = [f64; 2]>) -> [f64; AROUND] {
    let points: Vec<[f64; 2]> = points.collect();
    // What the tangent at right angles to a direction is off: smooth, and outside of all points.
    let reach = |k: usize| {
        let (sin, cos) = (k as f64 / AROUND as f64 * TAU).sin_cos();
        points.iter().map(|[x, y]| x * cos + y * sin).fold(0.0, f64::max)
    };
    let support: [f64; AROUND] = std::array::from_fn(reach);
    // The convex outline's own radius: the nearest of all tangents along each direction.
    let radius = |k: usize| {
        let nearest = (0..AROUND).filter_map(|j| {
            let turn = ((j + AROUND - k) % AROUND) as f64 / AROUND as f64 * TAU;
            (turn.cos() > 0.2).then(|| support[j] / turn.cos())
        });
        nearest.fold(f64::INFINITY, f64::min)
    };
    let convex: [f64; AROUND] = std::array::from_fn(radius);
    let mut outline = convex;
    for _ in 0..SMOOTHINGS {
        let at = |k: usize| outline[k % AROUND];
        let mean = |k: usize| 0.5 * at(k) + 0.25 * (at(k + 1) + at(k + AROUND - 1));
        let mean = |k: usize| mean(k).max(convex[k]);
        outline = std::array::from_fn(mean);
    }
    outline
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hand::uniform_hand;
    use thenar_core::model::Side;

    /// The shipped hands wear one, faces outwards, the left the mirror of the right, as wide as a
    /// wrist and as long as it says.
    #[test]
    fn shipped_hands_wear_a_cuff() {
        let mut sizes = Vec::new();
        for side in [Side::Right, Side::Left] {
            let hand = uniform_hand(side, 600).expect("a shipped hand");
            let cuff = cuff(&hand).expect("a cuff");
            let places = cuff.positions.iter().map(|p| hand.bones[0].pose_BT.inverse_point(p));
            let places: Vec<Vec3> = places.collect();
            let size = |k: usize| {
                let low = places.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min);
                places.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max) - low
            };
            let size = [0, 1, 2].map(size);
            assert!(
                (0.05..0.08).contains(&size[0]) && (0.035..0.06).contains(&size[1]),
                "{size:?}"
            );
            assert!((size[2] - LONG * hand.length).abs() < 1e-9, "{size:?}");
            let centre = places[places.len() - 1];
            for t in &cuff.triangles[5 * 2 * AROUND..8 * 2 * AROUND] {
                let [a, b, c] = t.map(|i| places[i as usize]);
                let out = (a - centre).component_mul(&Vec3::new(1.0, 1.0, 0.0));
                assert!((b - a).cross(&(c - a)).dot(&out) > 0.0, "{side:?}");
            }
            sizes.push(size);
        }
        assert!((0..2).all(|k| (sizes[0][k] - sizes[1][k]).abs() < 1e-3), "{sizes:?}");
    }

    #[test]
    fn an_outline_lies_around_its_points() {
        let square = [[0.03, 0.02], [-0.03, 0.02], [-0.03, -0.02], [0.03, -0.02]];
        let found = outline(square.into_iter());
        assert!(
            (found[0] - 0.03).abs() < 1e-3 && (found[AROUND / 4] - 0.02).abs() < 1e-3,
            "{found:?}"
        );
        let corner = (2.0f64 / 3.0).atan() / TAU * AROUND as f64;
        assert!((found[corner.round() as usize] - 0.036).abs() < 0.003, "{found:?}");
    }
}
