//! A ball of tetrahedra in shells over a subdivided icosahedron.

use super::boundary;
use super::lattice::Tets;
use super::place::direction;
use crate::format::BallShape;
use crate::math::{Quat, Vec3};
use crate::text::{At, Fault};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Builds the ball.
///
/// # Errors
/// The core is not smaller than the ball, or there would be too many elements.
pub fn build(ball: &BallShape, at: &At<impl Sized>) -> Result<Tets, Fault> {
    if ball.core_radius > 0.99 * ball.radius {
        return Err(at.fault(format!(
            "expected `core_radius` below 0.99 × `radius`, got {} and {}",
            ball.core_radius, ball.radius
        )));
    }
    let (mut directions, triangles) = icosphere(ball.subdivisions);
    if triangles.len() * ball.layers as usize * 3 > 500_000 {
        return Err(at.fault("too many elements: lower `subdivisions` or `layers`"));
    }
    if let Some(towards) = &ball.refine_towards {
        let pole = direction(towards)
            .ok_or_else(|| at.fault("expected `refine_towards` that is not zero"))?;
        directions.iter_mut().for_each(|d| *d = drawn_to(d, &pole, ball.refine));
    }
    let radii = radii(ball);
    let full = ball.core_radius == 0.0;
    let mut nodes: Vec<Vec3> = if full { vec![Vec3::zeros()] } else { Vec::new() };
    let shells = &radii[usize::from(full)..];
    let first = nodes.len() as u32;
    nodes.extend(shells.iter().flat_map(|r| directions.iter().map(move |d| d * *r)));

    let n = directions.len() as u32;
    let mut tets = Vec::new();
    if full {
        tets.extend(triangles.iter().map(|[a, b, c]| [0, first + a, first + b, first + c]));
    }
    for s in 0..shells.len() as u32 - 1 {
        let base = first + s * n;
        tets.extend(triangles.iter().flat_map(|t| prism(t.map(|v| v + base), n)));
    }
    for tet in &mut tets {
        if boundary::determinant(&tet.map(|i| nodes[i as usize])) < 0.0 {
            tet.swap(1, 2);
        }
    }
    Ok((nodes, tets))
}

/// Radii from the core to the outside; each shell thicker than the one below by a fixed ratio.
fn radii(ball: &BallShape) -> Vec<f64> {
    let n = ball.layers as usize;
    let ratio = if n > 1 { ball.grading.powf(1.0 / (n - 1) as f64) } else { 1.0 };
    let thickness: Vec<f64> = (0..n).map(|k| ratio.powi(k as i32)).collect();
    let scale = (ball.radius - ball.core_radius) / thickness.iter().sum::<f64>();
    let mut radii = vec![ball.core_radius];
    for t in thickness {
        radii.push(radii[radii.len() - 1] + t * scale);
    }
    radii
}

/// Three tetrahedra of the prism between a triangle and the same triangle one shell above.
/// Cutting each side from its lower-numbered bottom node makes neighbours agree.
fn prism(mut below: [u32; 3], n: u32) -> [[u32; 4]; 3] {
    below.sort_unstable();
    let [a, b, c] = below;
    let [d, e, f] = below.map(|v| v + n);
    [[a, b, c, f], [a, b, e, f], [a, d, e, f]]
}

/// Moves a direction towards the pole so that distances there shrink by `times`.
fn drawn_to(d: &Vec3, pole: &Vec3, times: f64) -> Vec3 {
    let angle = d.dot(pole).clamp(-1.0, 1.0).acos();
    let s = angle / PI;
    let wanted = PI * s / (times - (times - 1.0) * s);
    match direction(&pole.cross(d)) {
        Some(axis) if angle < PI - 1e-9 => Quat::from_scaled_axis(axis * wanted) * pole,
        _ => *d,
    }
}

/// Directions and triangles, counter-clockwise from outside, of a subdivided icosahedron.
fn icosphere(subdivisions: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut nodes: Vec<Vec3> = Vec::new();
    for (s, t) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        nodes.push(Vec3::new(s, t, 0.0).normalize());
        nodes.push(Vec3::new(0.0, s, t).normalize());
        nodes.push(Vec3::new(t, 0.0, s).normalize());
    }
    let mut triangles = nearest_triangles(&nodes);
    for _ in 0..subdivisions {
        let mut middles: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                nodes.push((nodes[a as usize] + nodes[b as usize]).normalize());
                nodes.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    (nodes, triangles)
}

/// The triangles of an icosahedron: all triples of mutual neighbours, seen from outside.
fn nearest_triangles(nodes: &[Vec3]) -> Vec<[u32; 3]> {
    let near = |a: usize, b: usize| nodes[a].dot(&nodes[b]) > 0.4; // cos 63.4° between neighbours
    let mut triangles = Vec::new();
    for a in 0..nodes.len() {
        for b in a + 1..nodes.len() {
            for c in b + 1..nodes.len() {
                if near(a, b) && near(b, c) && near(a, c) {
                    let outside = nodes[a].cross(&nodes[b]).dot(&nodes[c]) > 0.0;
                    triangles.push(if outside { [a, b, c] } else { [a, c, b] }.map(|i| i as u32));
                }
            }
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::Place;

    fn check(ball: &BallShape) -> (f64, usize) {
        let at = At { value: (), place: Place::Text(0..0), key: String::new() };
        let (nodes, tets) = build(ball, &at).unwrap();
        let volume = |t: &[u32; 4]| boundary::determinant(&t.map(|n| nodes[n as usize])) / 6.0;
        assert!(tets.iter().all(|t| volume(t) > 0.0));
        (tets.iter().map(volume).sum(), boundary::faces(&tets).len())
    }

    #[test]
    fn a_ball_and_a_shell_have_their_volume_and_surface() {
        let mut ball = BallShape {
            radius: 2.0,
            core_radius: 0.0,
            subdivisions: 3,
            layers: 4,
            grading: 1.5,
            refine_towards: None,
            refine: 1.0,
        };
        let exact = 4.0 / 3.0 * PI * 8.0;
        let (volume, faces) = check(&ball);
        assert_eq!(faces, 20 * 64); // closed, nothing inside: neighbours agree
        assert!((volume / exact - 1.0).abs() < 0.02, "{volume} {exact}");

        ball.core_radius = 1.0;
        let (volume, faces) = check(&ball);
        assert_eq!(faces, 2 * 20 * 64);
        assert!((volume / (exact * 7.0 / 8.0) - 1.0).abs() < 0.02);

        ball.refine_towards = Some(-Vec3::y());
        ball.refine = 3.0;
        assert_eq!(check(&ball).1, 2 * 20 * 64);
    }
}
