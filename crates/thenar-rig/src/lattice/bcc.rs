//! The body-centred cubic lattice and its tetrahedra.
//!
//! ```text
//!   Two cubes that share a face; c and c' are their centres, A and B the ends of one edge of the
//!   face. Each of the face's four edges makes one tetrahedron (c, c', A, B); all are alike:
//!
//!        +-------A-------+         edges: 2 of length a (cc', AB), 4 of length √3/2 a
//!       /       /|      /          dihedral angles: 2 of 90°, 4 of 60°
//!      /   c   / |  c' /           volume: a³/12
//!     +-------+--B----+
//! ```
//!
//! Few lattices come nearer to regular tetrahedra (Labelle & Shewchuk 2007, section 2).

use thenar_core::Vec3;

/// A lattice point in units of half the cube edge: all coordinates even (a cube's corner) or all
/// odd (a cube's centre).
pub(super) type Point = [i32; 3];

/// A tetrahedron: `[cube x, y, z, code]`, where the code tells the shared face's axis and the
/// face's edge.
pub(super) type TetKey = [i32; 4];

/// The tetrahedron that holds `p`, in units of the cube edge.
pub(super) fn locate(p: &Vec3) -> TetKey {
    let mut cube: [i32; 3] = std::array::from_fn(|d| p[d].floor() as i32);
    let f: [f64; 3] = std::array::from_fn(|d| p[d] - f64::from(cube[d]) - 0.5);
    // From the centre, the largest coordinate names the face, the next one the face's edge.
    let face = (0..3).fold(0, |best, d| if f[d].abs() > f[best].abs() { d } else { best });
    let (e, g) = ((face + 1) % 3, (face + 2) % 3);
    let (edge, which) = if f[e].abs() >= f[g].abs() { (e, 0) } else { (g, 1) };
    if f[face] < 0.0 {
        cube[face] -= 1;
    }
    let side = i32::from(f[edge] >= 0.0);
    [cube[0], cube[1], cube[2], (face as i32 * 2 + which) * 2 + side]
}

/// The corners of a tetrahedron, positively oriented.
pub(super) fn corners([x, y, z, code]: TetKey) -> [Point; 4] {
    let (face, which, side) = (code as usize / 4, code as usize / 2 % 2, code % 2);
    let edge = (face + 1 + which) % 3;
    let along = 3 - face - edge;
    let c = [2 * x + 1, 2 * y + 1, 2 * z + 1];
    let mut next = c;
    next[face] += 2;
    let mut a = c;
    a[face] += 1;
    a[edge] += 2 * side - 1;
    let mut b = a;
    a[along] -= 1;
    b[along] += 1;
    // (face, edge, along) is an even or odd permutation, and the side mirrors.
    let even = which == 0;
    if even == (side == 1) { [c, next, a, b] } else { [c, next, b, a] }
}

/// Volume of a tetrahedron whose cubes have edge 1.
pub(super) const TET_VOLUME: f64 = 1.0 / 12.0;

/// Place of a lattice point, in units of the cube edge.
pub(super) fn place(point: Point) -> Vec3 {
    Vec3::from(point.map(f64::from)) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::tet;

    /// A point spread evenly over a few cubes (Halton sequence).
    fn halton(i: usize) -> Vec3 {
        let digit_sum = |base: usize| {
            let (mut i, mut f, mut x) = (i + 1, 1.0, 0.0);
            while i > 0 {
                f /= base as f64;
                x += f * (i % base) as f64;
                i /= base;
            }
            x
        };
        Vec3::new(digit_sum(2), digit_sum(3), digit_sum(5)) * 4.0 - Vec3::repeat(2.0)
    }

    #[test]
    fn every_point_lies_in_the_tetrahedron_found_for_it() {
        for i in 0..5000 {
            let p = halton(i);
            let corners = corners(locate(&p)).map(place);
            let weights = tet::barycentric(&corners, &p);
            assert!(weights.iter().all(|&w| w > -1e-12), "{p:?}: {weights:?}");
        }
    }

    #[test]
    fn all_tetrahedra_are_alike() {
        for i in 0..500 {
            let corners = corners(locate(&halton(i))).map(place);
            assert!((tet::volume(&corners) - TET_VOLUME).abs() < 1e-15);
            let [low, high] = tet::dihedral_range(&corners);
            assert!((low - 60_f64.to_radians()).abs() < 1e-12);
            assert!((high - 90_f64.to_radians()).abs() < 1e-12);
        }
    }
}
