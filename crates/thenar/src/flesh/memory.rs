//! Tissue with memory: quasi-linear viscoelasticity (Fung 1993, Sec. 7.6) on the stress of an element in its
//! own rotated frame, where a rigid turn neither makes nor takes stress.
//!
//! With `F = R S` and the elastic stress `T = Rᵀ P` (Biot's, symmetric for isotropic laws), term i of a
//! relaxation has let the part p of it fade,
//!
//! ```text
//!   T_now = T - Σ pᵢ,   ṗᵢ = (gᵢ T - pᵢ) / τᵢ
//! ```
//!
//! Over a step in which T goes straight from T₀ to T₁ this is, without error,
//!
//! ```text
//!   pᵢ ← dᵢ pᵢ + gᵢ (cᵢ - dᵢ) T₀ + gᵢ (1 - cᵢ) T₁,   dᵢ = exp(-Δt/τᵢ),  cᵢ = (1 - dᵢ) τᵢ/Δt
//! ```
//!
//! (the recurrence of Taylor et al. 1970 and Simo 1987, written for what has faded). Put into
//! the end of the step with T₁ linearised, the stress is
//!
//! ```text
//!   (1 - Σ gᵢ (1 - dᵢ)) T₀ - Σ dᵢ pᵢ + (1 - Σ gᵢ (1 - cᵢ)) (T₁ - T₀)
//! ```
//!
//! so that the stiffness of an element is an elastic one times a number in (g∞, 1): no other pattern, and as
//! definite as before. There is no geometric part, which would act on absolute velocities and brake a spin. With
//! dᵢ ≤ cᵢ ≤ 1 a linear material gives back no more than was put in: `c² - 2c + d² ≤ 0`.
//!
//! A stress M that is not along the axes of S is the force `P = R (M + A)` with the skew part A that makes
//! `P Fᵀ` symmetric: without it an element would turn itself. In the axes of S, with stretches σ,
//! `(M + A)_ij = M_ij 2σᵢ/(σᵢ + σⱼ)`.

use crate::flesh::RestTet;
use crate::flesh::element::{Principal, Response, Stress, positive_part, stress};
use crate::math::{Mat3, Vec3};
use crate::model::{Relaxation, TERMS_MAX};
use std::ops::Range;

/// Stress that has faded by one term of one element \[Pa\]: xx, yy, zz, yz, zx, xy in its rest frame.
pub type Faded = [f64; 6];

/// The elements that have memory, and its places in the state.
#[derive(Clone, Debug, Default)]
pub struct MemoryModel {
    /// Of each element; empty when none has memory.
    relaxation: Vec<Relaxation>,
    /// Where the terms of each element begin, and where the last end.
    start: Vec<u32>,
}

impl MemoryModel {
    /// Adds the relaxations of a body whose first element is `tet0`: one of each element, or none.
    pub fn add(&mut self, tet0: usize, relaxation: &[Relaxation]) {
        if relaxation.iter().any(|r| !r.is_none()) {
            self.relaxation.resize(tet0, Relaxation::NONE);
            self.relaxation.extend_from_slice(relaxation);
        }
    }

    /// Lays the terms of so many elements out.
    pub fn arrange(&mut self, tets: usize) {
        self.start.clear();
        if self.relaxation.is_empty() {
            return;
        }
        self.relaxation.resize(tets, Relaxation::NONE);
        let mut end = 0;
        self.start.push(end);
        for relaxation in &self.relaxation {
            end += relaxation.terms().len() as u32;
            self.start.push(end);
        }
    }

    /// Terms of all elements.
    pub fn len(&self) -> usize {
        self.start.last().map_or(0, |end| *end as usize)
    }

    /// Whether nothing has memory.
    pub fn is_empty(&self) -> bool {
        self.relaxation.is_empty()
    }

    /// The relaxation of element `t` and where its terms are, if it has memory.
    pub fn of(&self, t: usize) -> Option<(&Relaxation, Range<usize>)> {
        let relaxation = self.relaxation.get(t).filter(|r| !r.is_none())?;
        Some((relaxation, self.start[t] as usize..self.start[t + 1] as usize))
    }

    /// Whether one of these elements has memory.
    pub fn any(&self, tets: Range<usize>) -> bool {
        !self.is_empty() && self.start[tets.start] < self.start[tets.end]
    }

    /// The memory of `old` in these elements: as far relaxed as before, relative to moduli and weights.
    /// The same number of terms stays term by term; otherwise each term is as far as all were together.
    /// `stiffer` is the ratio of an element's moduli to what they were.
    pub fn carry_over(
        &self,
        old: &Self,
        faded: &[Faded],
        stiffer: impl Fn(usize) -> f64,
    ) -> Vec<Faded> {
        let mut carried = vec![Faded::default(); self.len()];
        for t in 0..self.relaxation.len() {
            let (Some((new, to)), Some((was, from))) = (self.of(t), old.of(t)) else { continue };
            let (ratio, from) = (stiffer(t), &faded[from]);
            let total: Faded = std::array::from_fn(|k| from.iter().map(|p| p[k]).sum());
            for (i, (to, term)) in carried[to].iter_mut().zip(new.terms()).enumerate() {
                let (of, weight) = match new.terms().len() == was.terms().len() {
                    true => (from[i], was.terms()[i].weight),
                    false => (total, was.weight()),
                };
                *to = of.map(|p| p * (ratio * term.weight / weight));
            }
        }
        carried
    }
}

/// The work of a relaxation in a step of a certain length.
#[derive(Clone, Copy, Debug)]
pub struct Fading {
    of: Relaxation,
    /// Part of T₀ in the stress at the end of the step.
    pub kept: f64,
    /// Part of the elastic stiffness that the step feels.
    pub tangent: f64,
    /// Of each term: the part of p that stays.
    pub stays: [f64; TERMS_MAX],
    /// The parts of T₀ and T₁ that are added to it.
    adds: [[f64; 2]; TERMS_MAX],
}

impl Fading {
    /// For steps of length `h` \[s\].
    pub fn new(of: &Relaxation, h: f64) -> Self {
        let mut fading =
            Self { of: *of, kept: 1.0, tangent: 1.0, stays: [0.0; 4], adds: [[0.0; 2]; 4] };
        for (k, term) in of.terms().iter().enumerate() {
            let x = h / term.time;
            let d = (-x).exp();
            let c = -(-x).exp_m1() / x;
            fading.stays[k] = d;
            fading.adds[k] = [term.weight * (c - d), term.weight * (1.0 - c)];
            fading.kept -= term.weight * (1.0 - d);
            fading.tangent -= term.weight * (1.0 - c);
        }
        fading
    }

    /// The same of another relaxation, computed anew only where it is another.
    pub fn of(&mut self, relaxation: &Relaxation, h: f64) -> &Self {
        if self.of != *relaxation {
            *self = Self::new(relaxation, h);
        }
        self
    }

    /// `Σ dᵢ pᵢ`.
    pub fn left(&self, faded: &[Faded]) -> Mat3 {
        let terms = faded.iter().zip(self.stays);
        terms.fold(Mat3::zeros(), |sum, (p, d)| sum + matrix(p) * d)
    }

    /// Moves what has faded to the end of the step.
    pub fn advance(&self, faded: &mut [Faded], before: &Mat3, after: &Mat3) {
        let (before, after) = (entries(before), entries(after));
        for (k, p) in faded.iter_mut().enumerate() {
            let [of_before, of_after] = self.adds[k];
            for i in 0..6 {
                p[i] = self.stays[k] * p[i] + of_before * before[i] + of_after * after[i];
            }
        }
    }
}

/// A symmetric matrix of its entries.
fn matrix(of: &Faded) -> Mat3 {
    let [xx, yy, zz, yz, zx, xy] = *of;
    Mat3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz)
}

/// The entries of a symmetric matrix.
fn entries(of: &Mat3) -> Faded {
    [of[(0, 0)], of[(1, 1)], of[(2, 2)], of[(1, 2)], of[(0, 2)], of[(0, 1)]]
}

/// An element with memory as a step sees it: forces of the stress that would be left at its end if nothing moved,
/// energy that it can give back, and its stiffness.
///
/// The stiffness is that of the stress against the stretch alone, `dT/dS : dS`, with in the axes of S
///
/// ```text
///   dS_ij = (σᵢ G_ij + σⱼ G_ji) / (|σᵢ| + |σⱼ|),   dT_ij = (Tᵢ - Tⱼ)/(σᵢ - σⱼ) dS_ij
/// ```
///
/// which vanishes for any turn. (The twist of the elastic law, `(Tᵢ + Tⱼ)/(σᵢ + σⱼ)`, goes with stress that may
/// have faded, and the warped stiffness of small strain does not vanish for a turn of a body that rests
/// strained: either would brake its spin.)
pub fn respond(
    rest: &RestTet,
    F: &Mat3,
    of: &Relaxation,
    fading: &Fading,
    faded: &[Faded],
) -> Response {
    let principal = Principal::new(rest, F);
    let Principal { U, s, V, at } = &principal;
    let left = balanced(s, &(V.tr_mul(&fading.left(faded)) * V));
    let kept = Mat3::from_diagonal(&at.stress.into()) * fading.kept;
    let P = U * (kept - left) * V.transpose();
    let mut pairs = [[[0.0; 2]; 3]; 3];
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        let sum = s[i].abs() + s[j].abs();
        if sum > 0.0 {
            let stiffness = 2.0 * principal.flip(i, j).max(0.0) * fading.tangent;
            let (of_i, of_j) = (s[i] / sum, s[j] / sum);
            pairs[i][j] = [stiffness * of_i * of_i, stiffness * of_i * of_j];
            pairs[j][i] = [stiffness * of_j * of_j, stiffness * of_i * of_j];
        }
    }
    let stretch = positive_part(&at.hessian) * fading.tangent;
    let biot = V * Mat3::from_diagonal(&at.stress.into()) * V.transpose();
    let stress = Stress { biot, energy: at.energy };
    Response {
        energy: rest.volume * energy(rest, of, &stress, faded),
        forces: rest.gradients.map(|g| P * g * -rest.volume),
        stiffness: principal.blocks(rest, &stretch, &pairs),
        inverted: s[2] < 0.0,
    }
}

/// `M + A` of a stress M in the axes of S. In an inverted element, whose σ₃ < 0, `|σᵢ| + |σⱼ|` divides instead of
/// the sum, so that nothing grows where a sum vanishes.
fn balanced(s: &[f64; 3], M: &Mat3) -> Mat3 {
    Mat3::from_fn(|i, j| {
        let sum = s[i].abs() + s[j].abs();
        match i == j {
            true => M[(i, j)],
            false if sum > 0.0 => M[(i, j)] * 2.0 * s[i] / sum,
            false => 0.0,
        }
    })
}

/// Energy that an element with memory can still give back \[J/m³\]: `g∞ ψ` and that of its terms' springs,
/// `qᵢ = gᵢ T - pᵢ` by the compliance of small strain over gᵢ.
pub fn energy(rest: &RestTet, relaxation: &Relaxation, at: &Stress, faded: &[Faded]) -> f64 {
    let (lambda, mu) = (rest.lambda, rest.mu);
    let springs = relaxation.terms().iter().zip(faded).map(|(term, p)| {
        let q = at.biot * term.weight - matrix(p);
        let trace = q.trace();
        let isotropic = lambda / (3.0 * lambda + 2.0 * mu) * trace * trace;
        (q.norm_squared() - isotropic) / (4.0 * mu * term.weight)
    });
    (1.0 - relaxation.weight()) * at.energy + springs.sum::<f64>()
}

/// The stress of an element at these positions.
pub fn stress_at(rest: &RestTet, tet: &[u32; 4], x: &[Vec3]) -> Stress {
    stress(rest, &rest.deformation_gradient(&tet.map(|n| x[n as usize])))
}
