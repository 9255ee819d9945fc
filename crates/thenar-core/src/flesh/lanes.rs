//! Eight tetrahedra side by side: one number of each in the eight lanes of a vector
//! ([`crate::math::lanes`]).

use crate::flesh::RestTet;
use crate::flesh::ogden::power_end;
use crate::math::Vec3;
use crate::math::lanes::{LANES, Vec3x8, cross, three};
use crate::model::Law;
use fearless_simd::{Simd, f64x8, prelude::*};

/// A 3×3 matrix in each lane, column-major.
pub type Mat3x8<S> = [f64x8<S>; 9];

/// Rest shapes and materials of eight elements; the last is repeated where there are fewer.
#[derive(Clone, Debug)]
pub struct RestLanes {
    /// Number of elements.
    pub count: usize,
    /// Kind of evaluation.
    pub kind: Kind,
    /// Nodes of each element.
    pub tets: [[u32; 4]; LANES],
    /// Gradients of the barycentric coordinates of nodes 1 to 3 \[1/m\], node by node.
    gradients: [[f64; LANES]; 9],
    /// Rest volume \[m³\].
    pub volume: [f64; LANES],
    /// First Lamé parameter \[Pa\].
    pub lambda: [f64; LANES],
    /// Shear modulus \[Pa\].
    pub mu: [f64; LANES],
    /// Stiffness-proportional damping \[s\].
    pub damping: [f64; LANES],
    /// Ogden's exponents; 0 with other laws.
    pub alpha: [f64; LANES],
    /// Stretches beyond which powers go on by their expansion.
    pub power_end: [f64; LANES],
}

/// The kernel that elements go to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// All are corotational.
    Corotational,
    /// All are stable neo-Hookean.
    StableNeoHookean,
    /// All have Ogden's law.
    Ogden,
    /// All have the logarithmic law.
    NeoHookean,
    /// Elements of several laws, or with memory: one by one.
    Apart,
}

impl Kind {
    fn of(rest: &[RestTet]) -> Self {
        let kind = |rest: &RestTet| match rest.law {
            Law::Corotational => Self::Corotational,
            Law::StableNeoHookean => Self::StableNeoHookean,
            Law::Ogden { .. } => Self::Ogden,
            Law::NeoHookean => Self::NeoHookean,
        };
        let first = kind(&rest[0]);
        if rest.iter().all(|rest| kind(rest) == first) { first } else { Self::Apart }
    }
}

/// The exponent of Ogden's law.
fn exponent(rest: &RestTet) -> f64 {
    if let Law::Ogden { alpha } = rest.law { alpha } else { 0.0 }
}

impl RestLanes {
    /// Arranges up to eight elements; with `alone` they are evaluated one by one.
    pub fn new(tets: &[[u32; 4]], rest: &[RestTet], damping: &[f64], alone: bool) -> Self {
        let count = tets.len();
        let of = |lane: usize| lane.min(count - 1);
        let number = |f: &dyn Fn(&RestTet) -> f64| std::array::from_fn(|lane| f(&rest[of(lane)]));
        Self {
            count,
            kind: if alone { Kind::Apart } else { Kind::of(rest) },
            tets: std::array::from_fn(|lane| tets[of(lane)]),
            gradients: std::array::from_fn(|i| number(&|r| r.gradients[1 + i / 3][i % 3])),
            volume: number(&|r| r.volume),
            lambda: number(&|r| r.lambda),
            mu: number(&|r| r.mu),
            damping: std::array::from_fn(|lane| damping[of(lane)]),
            alpha: number(&exponent),
            power_end: number(&|r| power_end(exponent(r))),
        }
    }

    /// Gradients of the barycentric coordinates of nodes 1 to 3.
    #[inline(always)]
    pub fn gradients<S: Simd>(&self, simd: S) -> [Vec3x8<S>; 3] {
        let g = &self.gradients;
        three(
            #[inline(always)]
            |a| {
                three(
                    #[inline(always)]
                    |k| f64x8::load_array_ref(simd, &g[3 * a + k]),
                )
            },
        )
    }

    /// Deformation gradients `F = Σ (x_a - x_0) ⊗ g_a`.
    #[inline(always)]
    pub fn deformation_gradients<S: Simd>(&self, simd: S, x: &[Vec3]) -> Mat3x8<S> {
        let (x0, g) = (self.places(simd, 0, x), self.gradients(simd));
        let edges = three(
            #[inline(always)]
            |a| {
                let x = self.places(simd, a + 1, x);
                [x[0] - x0[0], x[1] - x0[1], x[2] - x0[2]]
            },
        );
        entries(
            #[inline(always)]
            |r, c| {
                let rest = edges[1][r].mul_add(g[1][c], edges[2][r] * g[2][c]);
                edges[0][r].mul_add(g[0][c], rest)
            },
        )
    }

    /// Positions of node `a` of each element.
    #[inline(always)]
    fn places<S: Simd>(&self, simd: S, a: usize, x: &[Vec3]) -> Vec3x8<S> {
        let mut at = [[0.0; LANES]; 3];
        for (lane, tet) in self.tets.iter().enumerate() {
            let x = &x[tet[a] as usize];
            for k in 0..3 {
                at[k][lane] = x[k];
            }
        }
        three(
            #[inline(always)]
            |k| f64x8::load_array(simd, at[k]),
        )
    }
}

/// A matrix from its entries (row, column).
#[inline(always)]
pub fn entries<S: Simd>(f: impl Fn(usize, usize) -> f64x8<S>) -> Mat3x8<S> {
    [f(0, 0), f(1, 0), f(2, 0), f(0, 1), f(1, 1), f(2, 1), f(0, 2), f(1, 2), f(2, 2)]
}

/// The cofactor matrix, `det(M) M⁻ᵀ`.
#[inline(always)]
pub fn cofactors<S: Simd>(m: &Mat3x8<S>) -> Mat3x8<S> {
    let (a, b, c) = (&m[0..3], &m[3..6], &m[6..9]);
    let (x, y, z) = (cross(b, c), cross(c, a), cross(a, b));
    [x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]]
}

/// `M v`.
#[inline(always)]
pub fn times<S: Simd>(m: &Mat3x8<S>, v: &Vec3x8<S>) -> Vec3x8<S> {
    three(
        #[inline(always)]
        |r| m[r].mul_add(v[0], m[3 + r].mul_add(v[1], m[6 + r] * v[2])),
    )
}

/// Turns eight vectors with one number per element into one vector per element.
#[inline(always)]
pub fn transposed<S: Simd>(simd: S, rows: [f64x8<S>; 8]) -> [f64x8<S>; 8] {
    // Dealing two halves together, three times over, is a transposition.
    let mut r = rows;
    for _ in 0..3 {
        let (a, b) = simd.interleave_f64x8(r[0], r[4]);
        let (c, d) = simd.interleave_f64x8(r[1], r[5]);
        let (e, f) = simd.interleave_f64x8(r[2], r[6]);
        let (g, h) = simd.interleave_f64x8(r[3], r[7]);
        r = [a, b, c, d, e, f, g, h];
    }
    r
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn transposition_moves_every_number_to_its_mirror_place() {
        dispatch!(Level::new(), simd => {
            let rows = std::array::from_fn(|i| {
                f64x8::load_array(simd, std::array::from_fn(|j| (10 * i + j) as f64))
            });
            for (i, row) in transposed(simd, rows).iter().enumerate() {
                for (j, x) in row.to_array().iter().enumerate() {
                    assert_eq!(*x, (10 * j + i) as f64);
                }
            }
        });
    }
}
