//! The tetrahedra that a lattice is made of, before the body cuts it.

use super::bcc::{self, Point, TetKey};
use thenar_core::Vec3;

/// Tetrahedra that fill space: how one is found, and what it is.
pub(super) trait Cells {
    /// The tetrahedron that holds `p`.
    fn locate(&self, p: &Vec3) -> TetKey;
    /// Corners, positively oriented.
    fn corners(&self, key: TetKey) -> [Point; 4];
    /// Place of a corner \[m\].
    fn place(&self, point: Point) -> Vec3;
    /// Volume of a tetrahedron \[m³\].
    fn volume(&self, key: TetKey) -> f64;
}

/// The body-centred cubic lattice with cubes of one size.
pub(super) struct Uniform {
    /// Edge of the cubes \[m\].
    pub cube: f64,
    /// The origin's place in the lattice, in cubes.
    pub shift: Vec3,
}

impl Cells for Uniform {
    fn locate(&self, p: &Vec3) -> TetKey {
        bcc::locate(&(p / self.cube + self.shift))
    }

    fn corners(&self, key: TetKey) -> [Point; 4] {
        bcc::corners(key)
    }

    fn place(&self, point: Point) -> Vec3 {
        (bcc::place(point) - self.shift) * self.cube
    }

    fn volume(&self, _: TetKey) -> f64 {
        bcc::TET_VOLUME * self.cube.powi(3)
    }
}
