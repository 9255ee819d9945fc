//! Tissue with memory: quasi-linear viscoelasticity (Fung 1993, Sec. 7.6) on the stress of an
//! element in its own rotated frame, where a rigid turn neither makes nor takes stress.
//!
//! With `F = R S` and the elastic stress `T = Rᵀ P` (Biot's, symmetric for isotropic laws), term i
//! of a relaxation has let the part p of it fade,
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
//! so that the stiffness of an element is an elastic one times a number in (g∞, 1): no other
//! pattern, and as definite as before. There is no geometric part, which would act on absolute
//! velocities and brake a spin. With dᵢ ≤ cᵢ ≤ 1 a linear material gives back no more than was put
//! in: `c² - 2c + d² ≤ 0`.
//!
//! A stress M that is not along the axes of S is the force `P = R (M + A)` with the skew part A
//! that makes `P Fᵀ` symmetric: without it an element would turn itself. In the axes of S, with
//! stretches σ, `(M + A)_ij = M_ij 2σᵢ/(σᵢ + σⱼ)`.
//!
//! Stress fades in living shapes only: see [`living`](crate::flesh::living).

use crate::flesh::RestTet;
use crate::flesh::element::{Linear, Principal, Response, Stress, positive_part, stress};
use crate::flesh::living::Living;
use crate::math::{Mat3, Vec3};
use crate::model::{Law, Relaxation, TERMS_MAX};
use std::ops::Range;

/// Energies below this part of the shear modulus are mostly round-off: that of a strain of 1e-6.
const ROUNDED: f64 = 1e-12;

/// Stress that has faded by one term of one element \[Pa\]: xx, yy, zz, yz, zx, xy in its rest
/// frame.
pub type Faded = [f64; 6];

/// The elements that have memory, and its places in the state.
#[derive(Clone, Debug, Default)]
pub struct MemoryModel {
    /// Relaxation of each element; empty when none has memory.
    relaxation: Vec<Relaxation>,
    /// Index of the first term of each element, and one past the last of all.
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

    /// Lays out the terms of `tets` elements.
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

    /// True when nothing has memory.
    pub fn is_empty(&self) -> bool {
        self.relaxation.is_empty()
    }

    /// The relaxation of element `t` and where its terms are, if it has memory.
    pub fn of(&self, t: usize) -> Option<(&Relaxation, Range<usize>)> {
        let relaxation = self.relaxation.get(t).filter(|r| !r.is_none())?;
        Some((relaxation, self.start[t] as usize..self.start[t + 1] as usize))
    }

    /// Returns the range of the terms of these elements.
    pub fn span(&self, tets: Range<usize>) -> Range<usize> {
        let at = |t: usize| self.start.get(t).map_or(0, |start| *start as usize);
        at(tets.start)..at(tets.end)
    }

    /// True when one of these elements has memory.
    pub fn any(&self, tets: Range<usize>) -> bool {
        !self.is_empty() && self.start[tets.start] < self.start[tets.end]
    }

    /// The memory of `old` in these elements: as far relaxed as before, relative to moduli and
    /// weights. The same number of terms stays term by term; otherwise each term is as far as all
    /// were together. `stiffer` is the ratio of an element's moduli to what they were.
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

/// The work of a relaxation of a law in a step of a certain length.
#[derive(Clone, Copy, Debug)]
pub struct Fading {
    of: Relaxation,
    law: Law,
    /// Shapes in which stress fades.
    pub living: Living,
    /// `Σ gᵢ`.
    pub weight: f64,
    /// Part of T₀ in the stress at the end of the step.
    pub kept: f64,
    /// Part of the elastic stiffness that the step feels.
    pub tangent: f64,
    /// Part of p that stays, for each term.
    pub stays: [f64; TERMS_MAX],
    /// Parts of T₀ and T₁ that are added to p, for each term.
    adds: [[f64; 2]; TERMS_MAX],
}

impl Fading {
    /// For steps of length `h` \[s\].
    pub fn new(of: &Relaxation, law: Law, h: f64) -> Self {
        let mut fading = Self {
            of: *of,
            law,
            living: Living::of(law),
            weight: of.weight(),
            kept: 1.0,
            tangent: 1.0,
            stays: [0.0; TERMS_MAX],
            adds: [[0.0; 2]; TERMS_MAX],
        };
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

    /// Fading of nothing, for steps of length `h` \[s\].
    pub fn none(h: f64) -> Self {
        Self::new(&Relaxation::NONE, Law::Corotational, h)
    }

    /// Fading of another relaxation or law, computed anew only where it is another.
    pub fn of(&mut self, relaxation: &Relaxation, law: Law, h: f64) -> &Self {
        if self.of != *relaxation || self.law != law {
            *self = Self::new(relaxation, law, h);
        }
        self
    }

    /// Moves what has faded to the end of a step of an element with this shear modulus \[Pa\].
    /// Outside of what tissue lives through, and where it comes back from there, all has faded that
    /// can.
    pub fn remember(&self, mu: f64, faded: &mut [Faded], before: &Stress, after: &Stress) {
        if before.lives && after.lives {
            return self.advance(faded, &before.biot, &after.biot);
        }
        let [_, share, _] = self.living.share(mu, after.energy);
        let stress = entries(&after.biot);
        for (p, term) in faded.iter_mut().zip(self.of.terms()) {
            *p = stress.map(|t| t * (term.weight * share));
        }
    }

    /// `Σ dᵢ pᵢ`.
    pub fn left(&self, faded: &[Faded]) -> Mat3 {
        let terms = faded.iter().zip(self.stays);
        terms.fold(Mat3::zeros(), |sum, (p, d)| sum + matrix(p) * d)
    }

    /// Moves what has faded to the end of the step.
    fn advance(&self, faded: &mut [Faded], before: &Mat3, after: &Mat3) {
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

/// An element with memory as a step sees it: forces of the stress that would be left at its end if
/// nothing moved, energy that it can give back, and its stiffness.
pub fn respond(
    rest: &RestTet,
    F: &Mat3,
    of: &Relaxation,
    fading: &Fading,
    faded: &[Faded],
) -> Response {
    let shape = Principal::new(rest, F);
    let step = Increment::new(rest, &shape, fading, faded);
    let lives = step.lives;
    let stress = Stress { biot: step.biot, energy: shape.at.energy, lives };
    step.linear.response(rest, &shape, energy(rest, of, &stress, faded))
}

/// A step of an element with memory, from the shape in which it begins.
///
/// In living shapes its stiffness is that of the stress against the stretch alone, `dT/dS : dS`,
/// with in the axes of S
///
/// ```text
///   dS_ij = (σᵢ G_ij + σⱼ G_ji) / (|σᵢ| + |σⱼ|),   dT_ij = (Tᵢ - Tⱼ)/(σᵢ - σⱼ) dS_ij
/// ```
///
/// which vanishes for any turn. (The twist of the elastic law, `(Tᵢ + Tⱼ)/(σᵢ + σⱼ)`, goes with
/// stress that may have faded, and the warped stiffness of small strain does not vanish for a turn
/// of a body that rests strained: either would brake its spin.)
#[derive(Clone, Copy, Debug)]
pub struct Increment<'a> {
    /// Stress and stiffness at its beginning.
    pub linear: Linear,
    /// Elastic stress T₀ at the beginning of the step \[Pa\].
    biot: Mat3,
    /// Stress that is left of T₀ whatever the end, less what has faded:
    /// `M = (kept - tangent) T₀ - Σ dᵢ pᵢ`.
    held: Mat3,
    lives: bool,
    mu: f64,
    fading: &'a Fading,
}

impl<'a> Increment<'a> {
    /// From this shape, with what has faded.
    pub fn new(
        rest: &RestTet,
        shape: &Principal,
        fading: &'a Fading,
        faded: &[Faded],
    ) -> Increment<'a> {
        let (mu, biot) = (rest.mu, shape.biot());
        let lives = fading.living.holds(mu, shape);
        let (linear, held) = match lives {
            true => {
                let left = fading.left(faded);
                let linear = remembering(shape, fading, &left);
                (linear, biot * (fading.kept - fading.tangent) - left)
            }
            false => (all_faded(shape, fading, mu), Mat3::zeros()),
        };
        Increment { linear, biot, held, lives, mu, fading }
    }

    /// The energy density of which the forces of the step's end are the slope \[J/m³\], at a shape
    /// where it may end: `tangent ψ + M : S`, or that of the law outside of what tissue lives
    /// through.
    pub fn energy(&self, shape: &Principal) -> f64 {
        let Self { fading, mu, .. } = self;
        match self.lives {
            true => {
                fading.tangent * shape.at.energy + self.held.component_mul(&shape.stretch()).sum()
            }
            false => {
                let [share, ..] = fading.living.share(*mu, shape.at.energy);
                shape.at.energy - fading.weight * share
            }
        }
    }
}

/// Stress and stiffness in a living shape, of which `left` has faded at the end of the step.
fn remembering(shape: &Principal, fading: &Fading, left: &Mat3) -> Linear {
    let Principal { s, V, at, .. } = shape;
    let left = balanced(s, &(V.tr_mul(left) * V));
    let mut pairs = [[[0.0; 2]; 3]; 3];
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        let sum = s[i].abs() + s[j].abs();
        if sum > 0.0 {
            let stiffness = 2.0 * shape.flip(i, j).max(0.0) * fading.tangent;
            let (of_i, of_j) = (s[i] / sum, s[j] / sum);
            pairs[i][j] = [stiffness * of_i * of_i, stiffness * of_i * of_j];
            pairs[j][i] = [stiffness * of_j * of_j, stiffness * of_i * of_j];
        }
    }
    Linear {
        stress: Mat3::from_diagonal(&at.stress.into()) * fading.kept - left,
        stretch: positive_part(&at.hessian) * fading.tangent,
        pairs,
    }
}

/// Stress and stiffness in a shape that is not living: those of the energy `ψ - Σ gᵢ f(ψ)`.
fn all_faded(shape: &Principal, fading: &Fading, mu: f64) -> Linear {
    let [_, share, bend] = fading.living.share(mu, shape.at.energy);
    let part = 1.0 - fading.weight * share;
    let T = Vec3::from(shape.at.stress);
    let hessian = shape.at.hessian * part - T * T.transpose() * (fading.weight * bend);
    Linear { stretch: positive_part(&hessian), ..Linear::elastic(shape, part) }
}

/// `M + A` of a stress M in the axes of S. In an inverted element, whose σ₃ < 0, `|σᵢ| + |σⱼ|`
/// divides instead of the sum, so that nothing grows where a sum vanishes.
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

/// Energy that an element with memory can still give back \[J/m³\]: `g∞ ψ` and that of its terms'
/// springs, `qᵢ = gᵢ T - pᵢ` by the compliance of small strain over gᵢ, less where the law has
/// stiffened: T itself has ψ.
pub fn energy(rest: &RestTet, relaxation: &Relaxation, at: &Stress, faded: &[Faded]) -> f64 {
    if !at.lives {
        let [share, ..] = Living::of(rest.law).share(rest.mu, at.energy);
        return at.energy - relaxation.weight() * share;
    }
    let (lambda, mu) = (rest.lambda, rest.mu);
    let linear = |q: &Mat3| {
        let trace = q.trace();
        let isotropic = lambda / (3.0 * lambda + 2.0 * mu) * trace * trace;
        (q.norm_squared() - isotropic) / (4.0 * mu)
    };
    let springs = relaxation.terms().iter().zip(faded).map(|(term, p)| {
        let q = at.biot * term.weight - matrix(p);
        linear(&q) / term.weight
    });
    let own = linear(&at.biot);
    // Near rest, where round-off is all that the energies differ by, a law has not stiffened.
    let stiffened = if own > ROUNDED * mu { (at.energy / own).clamp(0.0, 1.0) } else { 1.0 };
    (1.0 - relaxation.weight()) * at.energy + stiffened * springs.sum::<f64>()
}

/// The stress of an element at these positions; `living` is that of its law.
pub fn stress_at(rest: &RestTet, tet: &[u32; 4], x: &[Vec3], living: &Living) -> Stress {
    stress(rest, &rest.gradient_at(tet, x), living)
}
