//! Whether one linearised step was enough for flesh whose stress is not linear.
//!
//! A step goes to the least of the incremental energy `Φ = |x - x̃|²_M / (2Δt²) + ψ`, with ψ by its second-order
//! expansion about the start. There the expansion of Φ has fallen by `D = ½ Δxᵀ (M/Δt² + K) Δx`, so that Φ itself has
//! not risen as long as what the expansion did not foresee, `ψ(x₁) - ψ(x₀) - ∇ψ·Δx - ½ Δxᵀ K Δx`, is not above D.
//! Each element is asked by itself, with the motion of its nodes against their mean.

use crate::flesh::element::{Principal, positive_part};
use crate::flesh::{FleshModel, RestTet};
use crate::math::{Mat3, Vec3};
use crate::model::Law;
use std::ops::Range;

/// Changes of the deformation gradient below this are not looked at: of the energies of the laws asked, their third
/// order is there a small part of the second (at the exponents of tissue and moderate stretch `α ΔF / 3`).
const CHANGE_SEEN: f64 = 0.05;

impl FleshModel {
    /// False when the energy of one of these elements rose more, from positions `x0` to `x1` in a step of length `h`
    /// \[s\], than the step could take out. Corotational elements are linear but for their turn; the logarithmic law
    /// is not asked.
    pub fn foresaw(&self, tets: Range<usize>, x0: &[Vec3], x1: &[Vec3], h: f64) -> bool {
        if !self.asks_foresight {
            return true;
        }
        let shared = |range: &Range<usize>| range.start.max(tets.start)..range.end.min(tets.end);
        self.single.iter().flat_map(shared).all(|t| {
            let (rest, tet) = (&self.rest[t], &self.tets[t]);
            let F = |x: &[Vec3]| rest.deformation_gradient(&tet.map(|n| x[n as usize]));
            !asked(rest) || element_foresaw(rest, &F(x0), &F(x1), tet, x0, x1, h)
        }) && self.patches.foresaw(&tets, x0, x1, h)
    }
}

/// Whether the law is one that is asked.
pub fn asked(rest: &RestTet) -> bool {
    matches!(rest.law, Law::StableNeoHookean | Law::Ogden { .. })
}

/// The same of one element or patch with these nodes, whose deformation gradient goes from `F0` to `F1`.
pub(super) fn element_foresaw(
    rest: &RestTet,
    F0: &Mat3,
    F1: &Mat3,
    nodes: &[u32],
    x0: &[Vec3],
    x1: &[Vec3],
    h: f64,
) -> bool {
    let change = F1 - F0;
    if change.norm_squared() < CHANGE_SEEN * CHANGE_SEEN {
        return true;
    }
    let before = Principal::new(rest, F0);
    let after = Principal::new(rest, F1).at.energy;
    let G = before.U.tr_mul(&change) * before.V;
    let slope: f64 = (0..3).map(|i| before.at.stress[i] * G[(i, i)]).sum();
    let curved = 0.5 * before.curvature(&G);
    let moved = || nodes.iter().map(|&n| x1[n as usize] - x0[n as usize]);
    let count = nodes.len() as f64;
    let mean = moved().sum::<Vec3>() / count;
    let apart: f64 = moved().map(|d| (d - mean).norm_squared()).sum();
    let inertia = 0.5 * rest.density * apart / (count * h * h);
    after - before.at.energy - slope - curved <= curved + inertia
}

impl Principal {
    /// `dF : dP` per rest volume of a change with these entries in the axes, by the stiffness that steps use.
    fn curvature(&self, G: &Mat3) -> f64 {
        let d = G.diagonal();
        let mut sum = d.dot(&(positive_part(&self.at.hessian) * d));
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let [own, cross] = self.twist_flip(i, j);
            let (a, b) = (G[(i, j)], G[(j, i)]);
            sum += own * (a * a + b * b) + 2.0 * cross * a * b;
        }
        sum
    }
}
