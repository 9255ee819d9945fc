//! Whether one linearised step was enough for flesh whose stress is not linear.
//!
//! A step goes to the least of the incremental energy `Φ = |x - x̃|²_M / (2Δt²) + ψ`, with ψ by its second-order
//! expansion about the start. There the expansion of Φ has fallen by `D = ½ Δxᵀ (M/Δt² + K) Δx`, so that Φ itself has
//! not risen as long as what the expansion did not foresee, `ψ(x₁) - ψ(x₀) - ∇ψ·Δx - ½ Δxᵀ K Δx`, is not above D.
//! Each element is asked by itself, with the motion of its nodes against their mean. For one with memory ψ is the
//! energy of which the forces of the step's end are the slope (`memory::Increment`).

use crate::flesh::element::{Linear, Principal};
use crate::flesh::memory::{Faded, Fading, Increment};
use crate::flesh::{FleshModel, RestTet};
use crate::math::{Mat3, Vec3};
use crate::model::{Law, Relaxation};
use std::ops::Range;

/// Changes of the deformation gradient below this are not looked at: of the energies of the laws asked, their third
/// order is there a small part of the second (at the exponents of tissue and moderate stretch `α ΔF / 3`).
pub(super) const CHANGE_SEEN: f64 = 0.05;

impl FleshModel {
    /// False when the energy of one of these elements rose more, from positions `x0` to `x1` in a step of length `h`
    /// \[s\], than the step could take out; `faded` is what they remembered at its beginning. Corotational elements
    /// are linear but for their turn; the logarithmic law is not asked. Skin is.
    pub fn foresaw(
        &self,
        tets: Range<usize>,
        x0: &[Vec3],
        x1: &[Vec3],
        faded: &[Faded],
        h: f64,
    ) -> bool {
        if !self.asks_foresight {
            return true;
        }
        let mut fading = Fading::none(h);
        let shared = |range: &Range<usize>| range.start.max(tets.start)..range.end.min(tets.end);
        self.single.iter().flat_map(shared).all(|t| {
            let (rest, tet) = (&self.rest[t], &self.tets[t]);
            if !asked(rest) {
                return true;
            }
            let F = [x0, x1].map(|x| rest.deformation_gradient(&tet.map(|n| x[n as usize])));
            let remembers = self.memory.of(t).map(|(of, place)| (of, &faded[place]));
            element_foresaw(rest, F, remembers, &mut fading, (tet, x0, x1), h)
        }) && self.patches.foresaw(&self.memory, faded, &tets, x0, x1, &mut fading, h)
            && self.skin_foresaw(&tets, x0, x1, h)
    }
}

/// Whether the law is one that is asked.
pub fn asked(rest: &RestTet) -> bool {
    matches!(rest.law, Law::StableNeoHookean | Law::Ogden { .. })
}

/// The same of one element or patch, whose deformation gradient goes from the first to the second; with what it
/// remembers, and its nodes and their positions before and after.
pub(super) fn element_foresaw(
    rest: &RestTet,
    F: [Mat3; 2],
    remembers: Option<(&Relaxation, &[Faded])>,
    fading: &mut Fading,
    (nodes, x0, x1): (&[u32], &[Vec3], &[Vec3]),
    h: f64,
) -> bool {
    let change = F[1] - F[0];
    if change.norm_squared() < CHANGE_SEEN * CHANGE_SEEN {
        return true;
    }
    let [before, after] = F.map(|F| Principal::new(rest, &F));
    let (linear, risen) = match remembers {
        None => (Linear::elastic(&before, 1.0), after.at.energy - before.at.energy),
        Some((of, faded)) => {
            let fading = fading.of(of, rest.law, h);
            let step = Increment::new(rest, &before, fading, faded);
            (step.linear, step.energy(&after) - step.energy(&before))
        }
    };
    let [slope, curved] = linear.along(&(before.U.tr_mul(&change) * before.V));
    let curved = 0.5 * curved;
    let moved = || nodes.iter().map(|&n| x1[n as usize] - x0[n as usize]);
    let count = nodes.len() as f64;
    let mean = moved().sum::<Vec3>() / count;
    let apart: f64 = moved().map(|d| (d - mean).norm_squared()).sum();
    let inertia = 0.5 * rest.density * apart / (count * h * h);
    risen - slope - curved <= curved + inertia
}
