//! Measures of one tetrahedron.

use thenar_core::{Mat3, Vec3};

/// Corner positions.
pub type Corners = [Vec3; 4];

/// Signed volume, positive when `x1-x0, x2-x0, x3-x0` are right-handed.
pub fn volume(x: &Corners) -> f64 {
    (x[1] - x[0]).dot(&(x[2] - x[0]).cross(&(x[3] - x[0]))) / 6.0
}

/// Gradients of the four barycentric weights \[1/m\]; not finite for a flat tetrahedron.
pub fn gradients(x: &Corners) -> [Vec3; 4] {
    let [a, b, c] = [x[1] - x[0], x[2] - x[0], x[3] - x[0]];
    let det = a.dot(&b.cross(&c));
    let [g1, g2, g3] = [b.cross(&c) / det, c.cross(&a) / det, a.cross(&b) / det];
    [-(g1 + g2 + g3), g1, g2, g3]
}

/// Barycentric weights of `p`, of sum 1; NaN for a flat tetrahedron.
pub fn barycentric(x: &Corners, p: &Vec3) -> [f64; 4] {
    let [a, b, c] = [x[1] - x[0], x[2] - x[0], x[3] - x[0]];
    let q = p - x[0];
    let det = a.dot(&b.cross(&c));
    let w1 = q.dot(&b.cross(&c)) / det;
    let w2 = a.dot(&q.cross(&c)) / det;
    let w3 = a.dot(&b.cross(&q)) / det;
    [1.0 - w1 - w2 - w3, w1, w2, w3]
}

/// Smallest and largest dihedral angle \[rad\].
pub fn dihedral_range(x: &Corners) -> [f64; 2] {
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for (i, j, k, l) in
        [(0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 0, 2), (2, 3, 0, 1)]
    {
        // The angle between the two faces, measured in the plane across the edge ij.
        let axis = (x[j] - x[i]).normalize();
        let across = |m: usize| {
            let d = x[m] - x[i];
            d - axis * axis.dot(&d)
        };
        let angle = across(k).angle(&across(l));
        range = [range[0].min(angle), range[1].max(angle)];
    }
    range
}

/// Longest edge over shortest.
pub fn edge_ratio(x: &Corners) -> f64 {
    let mut range = [f64::INFINITY, 0.0_f64];
    for i in 0..4 {
        for j in 0..i {
            let length = (x[i] - x[j]).norm();
            range = [range[0].min(length), range[1].max(length)];
        }
    }
    range[1] / range[0]
}

/// `det F` of the map that takes the corners `rest` to `now`.
pub fn stretch(rest: &Corners, now: &Corners) -> f64 {
    volume(now) / volume(rest)
}

/// The edges from corner 0 as columns.
pub fn edges(x: &Corners) -> Mat3 {
    Mat3::from_columns(&[x[1] - x[0], x[2] - x[0], x[3] - x[0]])
}
