//! Skin: elastic sheets in the tetrahedra that they pass through.
//!
//! Skin sticks to flesh, and moves as the linear field of the tetrahedron around it. A piece with
//! the unit tangents T = (t₁ t₂) is then stretched by `A = F T = Σ_a x_a ⊗ Tᵀ g_a`, a 3×2 matrix,
//! so that its energy `a w(A)` depends on the four nodes of one tetrahedron: it adds to blocks that
//! are there, and the sum over pieces is the integral over the true surface, not over that of the
//! elements. (Springs between the corners of a surface's triangles would join up to twelve nodes
//! each.)
//!
//! The law is plane stress, linear in the principal stretches `s₁ ≥ s₂` of A as that of
//! corotational flesh is, around a tension T₀ at rest, and cannot be pressed together with more
//! than τ \[N/m\]: the sheet then wrinkles, and what it shortens by wrinkling, p, costs only τ (for
//! τ = 0 this is tension field theory, Reissner 1938, Pipkin 1986):
//!
//! ```text
//!   e_i = s_i − 1 + e₀,   e₀ = T₀ (1 − ν)/(E t),   τ = E t × wrinkling
//!   w   = min over p ≥ 0 of  E t/(2 (1 − ν²)) [(e₁+p₁)² + (e₂+p₂)² + 2ν (e₁+p₁)(e₂+p₂)] + τ (p₁ + p₂)
//! ```
//!
//! As the smallest value of a convex function over p, w is convex in the stretches and once
//! differentiable: its stresses are those of the sheet, none below −τ. The stiffness is the second
//! derivative of w(A) where it is not negative, and zero in the directions where it is: what a
//! compressed sheet gives way by, buckling out of its plane, is left to the flesh.
//!
//! A sheet is linear in its stretches but not in its nodes: a turn stretches it by second order,
//! and slack skin snaps taut. Whether a step overlooked that is asked as of stiffening flesh
//! (`foresight`).
//!
//! Skin is elastic: it has its element's share of Rayleigh damping and no memory, and no mass of
//! its own, since flesh fills its place.

use crate::flesh::foresight::CHANGE_SEEN;
use crate::flesh::{FleshModel, Response, RestTet, Tally};
use crate::math::{Mat3, Vec3};
use crate::model::{Facet, Sheet};
use crate::solver::BlockMatrix;
use std::ops::Range;

/// All pieces of skin, by ascending tetrahedra, which are numbered through all deformable bodies.
#[derive(Clone, Debug, Default)]
pub struct Membranes {
    pieces: Vec<Piece>,
}

#[derive(Clone, Copy, Debug)]
struct Piece {
    tet: u32,
    rest: RestPiece,
}

/// Rest shape and material of a piece.
#[derive(Clone, Copy, Debug)]
struct RestPiece {
    /// Area \[m²\].
    area: f64,
    /// Gradients of the four barycentric coordinates along the tangents, in the rest shape \[1/m\].
    gradients: [[f64; 2]; 4],
    law: SheetLaw,
}

/// w in its own terms.
#[derive(Clone, Copy, Debug)]
struct SheetLaw {
    /// Stiffness E t \[N/m\].
    stiffness: f64,
    poisson: f64,
    /// Strain e₀ that makes the tension at rest.
    prestrain: f64,
    /// Tension τ up to which the sheet can be pressed together \[N/m\].
    wrinkles: f64,
}

/// w and its derivatives in the principal stretches.
#[derive(Clone, Copy, Debug)]
struct Tension {
    /// Energy w per rest area \[J/m²\].
    energy: f64,
    /// First derivatives `[w₁, w₂]` \[N/m\].
    stress: [f64; 2],
    /// Second derivatives `[w₁₁, w₂₂, w₁₂]` \[N/m\].
    stretch: [f64; 3],
    /// Stiffness against shear, `(w₁ − w₂)/(s₁ − s₂)` \[N/m\].
    shear: f64,
}

impl SheetLaw {
    fn new(sheet: &Sheet) -> Self {
        let stiffness = sheet.young * sheet.thickness;
        Self {
            stiffness,
            poisson: sheet.poisson,
            prestrain: sheet.pretension * (1.0 - sheet.poisson) / stiffness,
            wrinkles: stiffness * sheet.wrinkling,
        }
    }

    /// w at the stretches `s[0] ≥ s[1]`.
    fn at(&self, s: [f64; 2]) -> Tension {
        let (k, nu, bound) = (self.stiffness, self.poisson, -self.wrinkles);
        let c = k / (1.0 - nu * nu);
        let e = s.map(|s| s - 1.0 + self.prestrain);
        let whole = [c * (e[0] + nu * e[1]), c * (e[1] + nu * e[0])];
        if whole[1] >= bound {
            return Tension {
                energy: 0.5 * (whole[0] * e[0] + whole[1] * e[1]),
                stress: whole,
                stretch: [c, c, c * nu],
                shear: c * (1.0 - nu),
            };
        }
        // Wrinkled across: along the second stretch it bears the bound.
        let first = k * e[0] + nu * bound;
        if first >= bound {
            let smooth = (bound - nu * first) / k;
            let energy = 0.5 * (first * e[0] + bound * smooth) - bound * (smooth - e[1]);
            let shear =
                ((first - bound) / (s[0] - s[1]).max(f64::MIN_POSITIVE)).min(c * (1.0 - nu));
            return Tension { energy, stress: [first, bound], stretch: [k, 0.0, 0.0], shear };
        }
        let smooth = bound * (1.0 - nu) / k;
        let energy = bound * smooth - bound * (2.0 * smooth - e[0] - e[1]);
        Tension { energy, stress: [bound; 2], stretch: [0.0; 3], shear: 0.0 }
    }

    /// Stiffness against turns, where it is not negative.
    fn turned(&self, s: &[f64; 2], stress: &[f64; 2], shear: f64) -> GeometricStiffness {
        let spin = ((stress[0] + stress[1]) / (s[0] + s[1]).max(f64::MIN_POSITIVE)).max(0.0);
        let out = [0, 1].map(|i| (stress[i] / s[i].max(f64::MIN_POSITIVE)).max(0.0));
        GeometricStiffness { own: 0.5 * (shear + spin), cross: 0.5 * (shear - spin), out }
    }
}

impl RestPiece {
    fn new(rest: &RestTet, facet: &Facet, law: SheetLaw) -> Self {
        let n = facet.normal;
        let t1 = n.cross(&Vec3::ith(n.iamin(), 1.0)).normalize();
        let t2 = n.cross(&t1);
        let gradients = rest.gradients.map(|g| [t1.dot(&g), t2.dot(&g)]);
        Self { area: facet.area, gradients, law }
    }

    /// The columns of A.
    fn images(&self, x: &[Vec3; 4]) -> [Vec3; 2] {
        [0, 1].map(|k| {
            let g = |a: usize| self.gradients[a][k];
            (x[1] - x[0]) * g(1) + (x[2] - x[0]) * g(2) + (x[3] - x[0]) * g(3)
        })
    }

    fn stretched(&self, x: &[Vec3; 4]) -> ThinSvd {
        ThinSvd::new(self.images(x))
    }

    fn energy(&self, x: &[Vec3; 4]) -> f64 {
        self.area * self.law.at(self.stretched(x).s).energy
    }

    /// Adds energy, forces and stiffness.
    fn add(&self, x: &[Vec3; 4], sums: &mut Response) {
        let ThinSvd { s, U, V } = self.stretched(x);
        let Tension { energy, stress, stretch, shear } = self.law.at(s);
        sums.energy += self.area * energy;
        // Gradients along the principal directions.
        let g = self.gradients.map(|[p, q]| [p * V[0][0] + q * V[0][1], p * V[1][0] + q * V[1][1]]);
        for (force, g) in sums.forces.iter_mut().zip(&g) {
            *force -= (U[0] * (stress[0] * g[0]) + U[1] * (stress[1] * g[1])) * self.area;
        }

        // Curvature of w along each pair of principal directions, 3×3; positive parts of turns in
        // the plane and out of it.
        let GeometricStiffness { own, cross, out } = self.law.turned(&s, &stress, shear);
        let [w11, w22, w12] = stretch;
        let outer = |a: &Vec3, b: &Vec3| a * (b.transpose() * self.area);
        let [u1, u2, u3] = &U;
        let (squares, normal) = ([outer(u1, u1), outer(u2, u2)], outer(u3, u3));
        let mixed = outer(u1, u2);
        let along = squares[0] * w11 + squares[1] * own + normal * out[0];
        let across = squares[1] * w22 + squares[0] * own + normal * out[1];
        let both = mixed * w12 + mixed.transpose() * cross;
        let turned = both.transpose();
        // Gradients sum to nothing: the blocks of the first node are minus the sums of the others'.
        let block = |a: usize, b: usize| {
            along * (g[a][0] * g[b][0])
                + across * (g[a][1] * g[b][1])
                + both * (g[a][0] * g[b][1])
                + turned * (g[a][1] * g[b][0])
        };
        let [k11, k22, k33] = [block(1, 1), block(2, 2), block(3, 3)];
        let [k12, k13, k23] = [block(1, 2), block(1, 3), block(2, 3)];
        let k01 = -(k11 + k12.transpose() + k13.transpose());
        let k02 = -(k12 + k22 + k23.transpose());
        let k03 = -(k13 + k23 + k33);
        let k00 = -(k01 + k02 + k03).transpose();
        let blocks = [k00, k11, k22, k33, k01, k02, k03, k12, k13, k23];
        for (sum, block) in sums.stiffness.iter_mut().zip(blocks) {
            *sum += block;
        }
    }

    /// Returns the rise of the energy from `x0` to `x1` above its second-order expansion about
    /// `x0`, and half of the second order \[J\]; zeros where the stretch changes little.
    fn surprise(&self, x0: &[Vec3; 4], x1: &[Vec3; 4]) -> [f64; 2] {
        let [before, after] = [x0, x1].map(|x| self.images(x));
        let change = [after[0] - before[0], after[1] - before[1]];
        if change[0].norm_squared() + change[1].norm_squared() < CHANGE_SEEN * CHANGE_SEEN {
            return [0.0; 2];
        }
        let at = ThinSvd::new(before);
        let here = self.law.at(at.s);
        let GeometricStiffness { own, cross, out } =
            self.law.turned(&at.s, &here.stress, here.shear);
        let image = |v: [f64; 2]| change[0] * v[0] + change[1] * v[1];
        let d = at.V.map(image).map(|d| at.U.map(|u| u.dot(&d)));
        let [w11, w22, w12] = here.stretch;
        let slope = here.stress[0] * d[0][0] + here.stress[1] * d[1][1];
        let curved = w11 * d[0][0] * d[0][0]
            + w22 * d[1][1] * d[1][1]
            + 2.0 * w12 * d[0][0] * d[1][1]
            + own * (d[0][1] * d[0][1] + d[1][0] * d[1][0])
            + 2.0 * cross * d[0][1] * d[1][0]
            + out[0] * d[0][2] * d[0][2]
            + out[1] * d[1][2] * d[1][2];
        let risen = self.law.at(ThinSvd::new(after).s).energy - here.energy;
        [risen - slope - 0.5 * curved, 0.5 * curved].map(|e| e * self.area)
    }
}

/// Stiffness against turns \[N/m\]: in the plane as `own (G₁₂² + G₂₁²) + 2 cross G₁₂ G₂₁`, out of
/// it along each direction.
struct GeometricStiffness {
    own: f64,
    cross: f64,
    out: [f64; 2],
}

/// `A = Σ s_i u_i ⊗ v_i` with the normal `u₃ = u₁ × u₂`.
struct ThinSvd {
    /// Descending, not negative.
    s: [f64; 2],
    /// u₁, u₂, u₃, orthonormal.
    U: [Vec3; 3],
    /// v₁, v₂.
    V: [[f64; 2]; 2],
}

impl ThinSvd {
    fn new(A: [Vec3; 2]) -> Self {
        // The larger eigenvector of AᵀA, without cancellation.
        let (b, d) = (A[0].dot(&A[1]), 0.5 * (A[0].norm_squared() - A[1].norm_squared()));
        let r = (d * d + b * b).sqrt();
        let long = if d >= 0.0 { [d + r, b] } else { [b, r - d] };
        let length = (long[0] * long[0] + long[1] * long[1]).sqrt();
        let v = if length > 0.0 { long.map(|x| x / length) } else { [1.0, 0.0] };
        let across = [-v[1], v[0]];
        let image = |v: [f64; 2]| A[0] * v[0] + A[1] * v[1];
        let [first, second] = [image(v), image(across)];
        let u1 = first.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vec3::x);
        let second = second - u1 * u1.dot(&second);
        let u2 = second.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(|| {
            // Crushed to a line: any direction across.
            u1.cross(&Vec3::ith(u1.iamin(), 1.0)).normalize()
        });
        Self { s: [first.norm(), second.norm()], U: [u1, u2, u1.cross(&u2)], V: [v, across] }
    }
}

impl Membranes {
    /// True when nothing has skin.
    pub fn is_empty(&self) -> bool {
        self.pieces.is_empty()
    }

    /// Pieces of skin.
    pub fn len(&self) -> usize {
        self.pieces.len()
    }
}

impl FleshModel {
    /// Adds the skin of a body whose first tetrahedron is `tet0`.
    pub(crate) fn add_skin(&mut self, tet0: usize, sheets: &[Sheet], facets: &[Facet]) {
        let laws: Vec<SheetLaw> = sheets.iter().map(SheetLaw::new).collect();
        let pieces = &mut self.membranes.pieces;
        pieces.extend(facets.iter().map(|facet| {
            let tet = tet0 + facet.tet as usize;
            let rest = RestPiece::new(&self.rest[tet], facet, laws[facet.sheet as usize]);
            Piece { tet: tet as u32, rest }
        }));
        pieces.sort_by_key(|piece| piece.tet);
    }

    /// Adds the tension of skin to the system of a step of length `h` \[s\].
    pub(super) fn stretch_skin(
        &self,
        x: &[Vec3],
        h: f64,
        A: &mut BlockMatrix,
        b: &mut [Vec3],
        sums: &mut Tally,
    ) {
        for pieces in self.membranes.pieces.chunk_by(|a, b| a.tet == b.tet) {
            let t = pieces[0].tet as usize;
            let x = self.tets[t].map(|n| x[n as usize]);
            let mut response = Response {
                energy: 0.0,
                forces: [Vec3::zeros(); 4],
                stiffness: [Mat3::zeros(); 10],
                inverted: false,
            };
            pieces.iter().for_each(|piece| piece.rest.add(&x, &mut response));
            sums.energy += response.energy;
            self.scatter(t, &response, h, A, b);
        }
    }

    /// `FleshModel::foresaw` of the skin in these tetrahedra, each with the inertia of its flesh.
    pub(super) fn skin_foresaw(
        &self,
        tets: &Range<usize>,
        x0: &[Vec3],
        x1: &[Vec3],
        h: f64,
    ) -> bool {
        let pieces = &self.membranes.pieces;
        let first = pieces.partition_point(|piece| (piece.tet as usize) < tets.start);
        let end = pieces.partition_point(|piece| (piece.tet as usize) < tets.end);
        pieces[first..end].chunk_by(|a, b| a.tet == b.tet).all(|pieces| {
            let t = pieces[0].tet as usize;
            let at = |x: &[Vec3]| self.tets[t].map(|n| x[n as usize]);
            let (before, after) = (at(x0), at(x1));
            let surprises = pieces.iter().map(|piece| piece.rest.surprise(&before, &after));
            let [unforeseen, curved] = surprises.fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
            unforeseen <= curved || {
                let moved: [Vec3; 4] = std::array::from_fn(|k| after[k] - before[k]);
                let mean = moved.iter().sum::<Vec3>() / 4.0;
                let apart: f64 = moved.iter().map(|d| (d - mean).norm_squared()).sum();
                let rest = &self.rest[t];
                let inertia = 0.5 * rest.density * rest.volume * apart / (4.0 * h * h);
                unforeseen <= curved + inertia
            }
        })
    }

    /// Energy of skin \[J\].
    pub(super) fn skin_energy(&self, x: &[Vec3]) -> f64 {
        let energy = |piece: &Piece| {
            piece.rest.energy(&self.tets[piece.tet as usize].map(|n| x[n as usize]))
        };
        self.membranes.pieces.iter().map(energy).sum()
    }
}

#[cfg(test)]
mod tests;
