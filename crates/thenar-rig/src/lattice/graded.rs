//! Tetrahedra over a balanced octree: the body-centred cubic lattice, with transitions between
//! cubes of two sizes (Labelle & Shewchuk 2007, section 3).
//!
//! ```text
//!   Seen along a face; c, c' are centres of cubes, F of the larger one's face, M of an edge:
//!
//!     two of one size           one of one size and four of half of it
//!     A-------B                 A---M---B      c  F A M   quadrisected: 8 at the larger cube
//!     |  c c' |                 |c'/|\c'|      c' F A M   half pyramid: 2 at each smaller cube
//!     | 4 of  |                 M---F---M      the squares A M F M are cut along A F on both sides
//!     | c c'AB|                 |c'\|/c'|
//!     +-------+                 +---M---+
//! ```
//!
//! Where a smaller cube elsewhere halves an edge AB at M, the tetrahedron (c, c', A, B) is bisected
//! into (c, c', A, M) and (c, c', M, B). Dihedral angles lie between 45° and 120°; those of
//! bisected and quadrisected ones are no worse than 45° and 90°.

use super::bcc::{Point, TetKey};
use super::cells::Cells;
use super::octree::{Octant, Octree};
use thenar_core::Vec3;

/// The octree's tetrahedra.
pub(super) struct Graded {
    pub tree: Octree,
}

/// The place of a tetrahedron in the lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Between cubes of one size.
    Whole,
    /// Half of that.
    Bisected,
    /// In a cube whose neighbour is halved.
    Quadrisected,
    /// In a cube whose neighbour is twice as large.
    HalfPyramid,
}

const KINDS: [Kind; 4] = [Kind::Whole, Kind::Bisected, Kind::Quadrisected, Kind::HalfPyramid];

/// A tetrahedron: the cube, the axis and side of its face, and three bits that choose one there.
struct Parts {
    cube: Octant,
    kind: Kind,
    face: usize,
    positive: bool,
    bits: [bool; 3],
}

impl Parts {
    fn key(&self) -> TetKey {
        let kind = KINDS.iter().position(|&kind| kind == self.kind).unwrap_or(0);
        let mut code = (self.cube.level * KINDS.len() + kind) * 3 + self.face;
        for bit in [self.positive].iter().chain(&self.bits) {
            code = 2 * code + usize::from(*bit);
        }
        let [x, y, z] = self.cube.at;
        [x, y, z, code as i32]
    }

    fn of([x, y, z, code]: TetKey) -> Self {
        let code = code as usize;
        let bit = |k: usize| code >> k & 1 == 1;
        let (face, kind) = (code / 16 % 3, code / 48 % KINDS.len());
        Self {
            cube: Octant { level: code / 48 / KINDS.len(), at: [x, y, z] },
            kind: KINDS[kind],
            face,
            positive: bit(3),
            bits: [bit(2), bit(1), bit(0)],
        }
    }
}

/// One step along an axis, up or down.
fn along(axis: usize, up: bool) -> [i32; 3] {
    let mut by = [0; 3];
    by[axis] = if up { 1 } else { -1 };
    by
}

impl Graded {
    /// Edge of a cube, in units of half the finest cubes' edge.
    fn units(&self, level: usize) -> i32 {
        2 << (self.tree.levels() - level)
    }

    /// True if the edge of a face on side `side` along axis `edge`, shared by the cubes `c` and
    /// `next`, is halved by a smaller cube.
    fn is_halved(&self, c: &Octant, next: &Octant, edge: usize, side: bool) -> bool {
        let by = along(edge, side);
        self.tree.is_split(&c.beside(by)) || self.tree.is_split(&next.beside(by))
    }
}

impl Cells for Graded {
    fn locate(&self, p: &Vec3) -> TetKey {
        let (cube, f) = self.tree.leaf(p);
        // From the centre, the largest coordinate names the face.
        let face = (0..3).fold(0, |best, d| if f[d].abs() > f[best].abs() { d } else { best });
        let (e, g) = ((face + 1) % 3, (face + 2) % 3);
        let positive = f[face] >= 0.0;
        let next = cube.beside(along(face, positive));
        let parts = if !self.tree.exists(&next) {
            // The larger face's centre is the corner towards the middle of the cube of twice the
            // size.
            let inwards = |d: usize| if cube.at[d] & 1 == 0 { f[d] } else { -f[d] };
            let bits = [inwards(e) >= inwards(g), false, false];
            Parts { cube, kind: Kind::HalfPyramid, face, positive, bits }
        } else if self.tree.is_split(&next) {
            let bits = [f[e].abs() >= f[g].abs(), f[e] >= 0.0, f[g] >= 0.0];
            Parts { cube, kind: Kind::Quadrisected, face, positive, bits }
        } else {
            let first = f[e].abs() >= f[g].abs();
            let (edge, last) = if first { (e, g) } else { (g, e) };
            let side = f[edge] >= 0.0;
            let halved = self.is_halved(&cube, &next, edge, side);
            let kind = if halved { Kind::Bisected } else { Kind::Whole };
            // Both cubes have the tetrahedron; the lower one gives it its name.
            let cube = if positive { cube } else { next };
            let bits = [first, side, halved && f[last] >= 0.0];
            Parts { cube, kind, face, positive: true, bits }
        };
        parts.key()
    }

    fn corners(&self, key: TetKey) -> [Point; 4] {
        let Parts { cube, kind, face, positive, bits } = Parts::of(key);
        let (e, g) = ((face + 1) % 3, (face + 2) % 3);
        let edge = self.units(cube.level);
        let half = edge / 2;
        let sign = |up: bool| if up { half } else { -half };
        let moved = |mut from: Point, axis: usize, by: i32| {
            from[axis] += by;
            from
        };
        let c = cube.at.map(|x| x * edge + half);
        let middle = moved(c, face, sign(positive));
        let corner = |along_e: i32, along_g: i32| moved(moved(middle, e, along_e), g, along_g);
        let mut corners = match kind {
            Kind::Whole | Kind::Bisected => {
                let (edge_axis, last) = if bits[0] { (e, g) } else { (g, e) };
                let m = moved(middle, edge_axis, sign(bits[1]));
                let (mut a, mut b) = (moved(m, last, -half), moved(m, last, half));
                if kind == Kind::Bisected {
                    (a, b) = if bits[2] { (m, b) } else { (a, m) };
                }
                [c, moved(c, face, edge), a, b]
            }
            Kind::Quadrisected => {
                let a = corner(sign(bits[1]), sign(bits[2]));
                let m = if bits[0] { corner(sign(bits[1]), 0) } else { corner(0, sign(bits[2])) };
                [c, middle, a, m]
            }
            Kind::HalfPyramid => {
                let [in_e, in_g] = [e, g].map(|d| sign(cube.at[d] & 1 == 0));
                let m = if bits[0] { corner(in_e, -in_g) } else { corner(-in_e, in_g) };
                [c, corner(in_e, in_g), corner(-in_e, -in_g), m]
            }
        };
        if six_volumes(&corners) < 0 {
            corners.swap(2, 3);
        }
        corners
    }

    fn place(&self, point: Point) -> Vec3 {
        let unit = self.tree.edge(self.tree.levels()) / 2.0;
        self.tree.origin() + Vec3::from(point.map(f64::from)) * unit
    }

    fn volume(&self, key: TetKey) -> f64 {
        let Parts { cube, kind, .. } = Parts::of(key);
        let part = match kind {
            Kind::Whole | Kind::HalfPyramid => 12.0,
            Kind::Bisected => 24.0,
            Kind::Quadrisected => 48.0,
        };
        self.tree.edge(cube.level).powi(3) / part
    }
}

/// Six times the signed volume.
fn six_volumes([a, b, c, d]: &[Point; 4]) -> i64 {
    let [u, v, w] = [b, c, d].map(|p| [0, 1, 2].map(|k| i64::from(p[k] - a[k])));
    u[0] * (v[1] * w[2] - v[2] * w[1])
        + u[1] * (v[2] * w[0] - v[0] * w[2])
        + u[2] * (v[0] * w[1] - v[1] * w[0])
}

#[cfg(test)]
mod tests;
