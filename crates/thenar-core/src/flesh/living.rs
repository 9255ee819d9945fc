//! The shapes in which stress fades, and what becomes of memory outside.
//!
//! A term of a relaxation is a spring behind a dashpot. With its energy
//! `gᵢ (ψ(S) - ψ(Sᵥ) - Tᵥ:(S - Sᵥ))`, where `Tᵥ = pᵢ/gᵢ` is the stress at the stretch Sᵥ that the
//! dashpot has reached, it takes the power `gᵢ (T - Tᵥ):(S - Sᵥ)/τᵢ` out: never a negative one
//! where ψ is convex in S (Bregman 1967). Corotational elements are so everywhere. Hyperelastic
//! ones are so for what tissue lives through, and not where they are crushed, blown up or turned
//! inside out: a memory of such stress drives an element without end.
//!
//! Memory therefore ends where ψ stops being convex, and at the energy of the largest stretches of
//! living tissue, ψ₀. Outside all stress that can fade has faded, and an element is elastic, with
//! the energy
//!
//! ```text
//!   ψ - Σ gᵢ f(ψ),   f = ψ below ψ₀, 2 ψ₀ - ψ₀²/ψ above
//! ```
//!
//! which goes on from `g∞ ψ` with its slope, so that what leads a crushed element back does not
//! fade. Terms that are given up stored no negative energy: to give them up brings none in.

use crate::flesh::element::Principal;
use crate::flesh::ogden::{Jet, power_end};
use crate::flesh::principal::density;
use crate::model::Law;

/// Least and largest stretch along one axis that is taken for one of living tissue. Pulled skin
/// fails at 1.54 ± 0.17 (Ní Annaidh et al. 2012); a pad pressed to 0.4 of its thickness has, at an
/// exponent of 8, eighty times the force of one pressed to 0.9.
const STRETCHES: [f64; 2] = [0.4, 2.0];

/// Range of shapes in which the stress of a law fades.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Living {
    /// ψ₀ over the shear modulus; infinite for a law that is convex in S everywhere.
    end: f64,
}

impl Living {
    /// Every shape.
    pub const ANY: Self = Self { end: f64::INFINITY };

    /// Shapes in which the stress of a law fades. Those of Ogden's law end where its powers do, if
    /// that is earlier.
    pub fn of(law: Law) -> Self {
        let longest = match law {
            Law::Corotational => return Self::ANY,
            Law::NeoHookean | Law::StableNeoHookean => STRETCHES[1],
            Law::Ogden { alpha } => STRETCHES[1].min(power_end(alpha)),
        };
        let shortest = STRETCHES[0].max(longest.powi(-2));
        // At kept volume, where the first Lamé parameter does nothing.
        let energy = |s: f64| density(law, 0.0, 1.0, [s, s.powf(-0.5), s.powf(-0.5)]).energy;
        Self { end: energy(shortest).max(energy(longest)) }
    }

    /// True when stress fades in this shape, at a shear modulus μ \[Pa\].
    pub fn holds(&self, mu: f64, shape: &Principal) -> bool {
        self.end == f64::INFINITY
            || (shape.at.energy <= self.end * mu && shape.s[2] > 0.0 && shape.is_convex())
    }

    /// f with its first two derivatives, at an energy ψ \[J/m³\].
    pub fn share(&self, mu: f64, energy: f64) -> Jet {
        let end = self.end * mu;
        if energy <= end {
            return [energy, 1.0, 0.0];
        }
        let part = end / energy;
        [end * (2.0 - part), part * part, -2.0 * part * part / energy]
    }
}

impl Principal {
    /// True when ψ is convex in S here: its second derivative is positive along the axes and
    /// against turns of them.
    fn is_convex(&self) -> bool {
        let H = &self.at.hessian;
        let minor = H[(0, 0)] * H[(1, 1)] - H[(0, 1)] * H[(1, 0)];
        H[(0, 0)] > 0.0
            && minor > 0.0
            && H.determinant() > 0.0
            && [(0, 1), (0, 2), (1, 2)].iter().all(|&(i, j)| self.flip(i, j) > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flesh::RestTet;
    use crate::math::{Mat3, Vec3};
    use crate::model::Material;

    fn rest(law: Law, poisson: f64) -> RestTet {
        let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        RestTet::new(&corners, &Material { law, young: 5e4, poisson, density: 1e3 }).unwrap()
    }

    fn holds(law: Law, poisson: f64, s: [f64; 3]) -> bool {
        let rest = rest(law, poisson);
        let shape = Principal::new(&rest, &Mat3::from_diagonal(&s.into()));
        Living::of(law).holds(rest.mu, &shape)
    }

    /// Pulled and pressed along one axis, with kept volume and without, sheared by a third; not
    /// turned inside out. Hardly compressible tissue keeps its memory to larger stretches.
    #[test]
    fn tissue_remembers_what_it_lives_through() {
        let tissue = [4.0, 6.5, 8.0, 9.5].map(|alpha| Law::Ogden { alpha });
        for law in tissue.into_iter().chain([Law::Corotational, Law::StableNeoHookean]) {
            for poisson in [0.43, 0.49] {
                let longest = if poisson == 0.49 { 1.7 } else { 1.5 };
                for s in [0.45_f64, 0.6, 0.8, 1.0, 1.2, longest] {
                    let side = s.powf(-0.5);
                    assert!(holds(law, poisson, [s, side, side]), "{law:?} {poisson} {s}");
                }
                for s in [[0.95; 3], [0.9, 1.0, 1.0], [1.33, 0.75, 1.0]] {
                    assert!(holds(law, poisson, s), "{law:?} {poisson} {s:?}");
                }
            }
            let inside_out = holds(law, 0.43, [1.0, 1.0, -1.0]);
            assert_eq!(inside_out, law == Law::Corotational);
        }
    }

    /// f goes on from ψ with its slope and is bounded; its derivatives are its derivatives.
    #[test]
    fn the_share_that_fades_is_smooth_and_bounded() {
        let living = Living::of(Law::Ogden { alpha: 8.0 });
        let (mu, end) = (2e4, 2e4 * living.end);
        let at = |psi: f64| living.share(mu, psi);
        assert_eq!(at(0.5 * end), [0.5 * end, 1.0, 0.0]);
        for psi in [1.1 * end, 2.0 * end, 30.0 * end] {
            let step = 1e-5 * psi;
            let [value, slope, curvature] = at(psi);
            assert!(value < 2.0 * end);
            for (k, want) in [(0, slope), (1, curvature)] {
                let numeric = (at(psi + step)[k] - at(psi - step)[k]) / (2.0 * step);
                assert!((numeric / want - 1.0).abs() < 1e-6, "{psi} {k}");
            }
        }
        let [value, slope, _] = at(end * (1.0 + 1e-9));
        assert!((value / end - 1.0).abs() < 1e-8 && (slope - 1.0).abs() < 1e-8);
    }
}
