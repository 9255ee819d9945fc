//! Isotropic laws in principal stretches: energy density ψ(σ₁, σ₂, σ₃), its gradient and Hessian.

use crate::flesh::ogden;
use crate::math::Mat3;
use crate::model::Law;

/// Below this stretch the logarithmic law is continued by its second-order expansion, since it
/// has no value for crushed or inverted elements.
pub const STRETCH_MIN: f64 = 0.05;

/// ψ \[J/m³\], ∂ψ/∂σ \[Pa\], ∂²ψ/∂σ² \[Pa\].
#[derive(Clone, Copy, Debug)]
pub struct Density {
    /// Energy per rest volume \[J/m³\].
    pub energy: f64,
    /// Principal first Piola stresses \[Pa\].
    pub stress: [f64; 3],
    /// Derivatives of the principal stresses in the principal stretches \[Pa\].
    pub hessian: Mat3,
}

/// Evaluates a law at the signed principal stretches.
pub fn density(law: Law, lambda: f64, mu: f64, s: [f64; 3]) -> Density {
    match law {
        Law::Corotational => corotational(lambda, mu, s),
        Law::NeoHookean => neo_hookean(lambda, mu, s),
        Law::StableNeoHookean => stable_neo_hookean(lambda, mu, s),
        Law::Ogden { alpha } => ogden::density(alpha, lambda, mu, s),
    }
}

/// `μ Σ(σᵢ-1)² + λ/2 (Σ(σᵢ-1))²`.
fn corotational(lambda: f64, mu: f64, s: [f64; 3]) -> Density {
    let e = s.map(|s| s - 1.0);
    let trace: f64 = e.iter().sum();
    Density {
        energy: mu * e.iter().map(|e| e * e).sum::<f64>() + 0.5 * lambda * trace * trace,
        stress: e.map(|e| 2.0 * mu * e + lambda * trace),
        hessian: Mat3::from_diagonal_element(2.0 * mu) + Mat3::from_element(lambda),
    }
}

/// `μ/2 (Σσᵢ² - 3) - μ ln J + λ/2 ln² J`.
fn neo_hookean(lambda: f64, mu: f64, s: [f64; 3]) -> Density {
    let at = s.map(|s| s.max(STRETCH_MIN));
    let ln_j: f64 = at.iter().map(|s| s.ln()).sum();
    let mut energy = 0.5 * mu * (at.iter().map(|s| s * s).sum::<f64>() - 3.0) - mu * ln_j
        + 0.5 * lambda * ln_j * ln_j;
    let mut stress = at.map(|s| mu * s + (lambda * ln_j - mu) / s);
    let hessian = Mat3::from_fn(|i, j| {
        let cross = lambda / (at[i] * at[j]);
        if i == j { mu - (lambda * ln_j - mu) / (at[i] * at[i]) + cross } else { cross }
    });
    let past: [f64; 3] = std::array::from_fn(|i| s[i] - at[i]);
    for i in 0..3 {
        let slope: f64 = (0..3).map(|j| hessian[(i, j)] * past[j]).sum();
        energy += past[i] * (stress[i] + 0.5 * slope);
    }
    let slopes: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| hessian[(i, j)] * past[j]).sum());
    for i in 0..3 {
        stress[i] += slopes[i];
    }
    Density { energy, stress, hessian }
}

/// `μ/2 (Σσᵢ² - 3) - μ (J-1) + λ'/2 (J-1)²` with `λ' = λ + μ`, which agrees with linear
/// elasticity at small strain and is finite for every F (after Smith, de Goes and Kim 2018).
fn stable_neo_hookean(lambda: f64, mu: f64, s: [f64; 3]) -> Density {
    let lambda = lambda + mu;
    let J = s[0] * s[1] * s[2];
    let area = [s[1] * s[2], s[2] * s[0], s[0] * s[1]];
    let pressure = lambda * (J - 1.0) - mu;
    Density {
        energy: 0.5 * mu * (s.iter().map(|s| s * s).sum::<f64>() - 3.0) - mu * (J - 1.0)
            + 0.5 * lambda * (J - 1.0) * (J - 1.0),
        stress: std::array::from_fn(|i| mu * s[i] + pressure * area[i]),
        hessian: Mat3::from_fn(|i, j| {
            let cross = lambda * area[i] * area[j];
            if i == j { mu + cross } else { cross + pressure * s[3 - i - j] }
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::testing::{assert_close, jacobian};

    #[test]
    fn stress_and_hessian_are_derivatives_of_the_energy() {
        let mut random = Random::new(5);
        let [pulp, stiffening] = [4.0, 9.2].map(|alpha| Law::Ogden { alpha });
        for law in [Law::Corotational, Law::NeoHookean, Law::StableNeoHookean, pulp, stiffening] {
            for k in 0..50 {
                let mut s =
                    [random.range(0.3, 1.8), random.range(0.3, 1.8), random.range(0.3, 1.8)];
                if law != Law::NeoHookean && k % 3 == 0 {
                    s[2] = -s[2];
                }
                let at = |x: &[f64]| density(law, 3.0e4, 2.0e4, [x[0], x[1], x[2]]);
                let here = at(&s);
                let stress = jacobian(|x| vec![at(x).energy], &s, 1e-6);
                assert_close(&[here.stress.to_vec()], &stress, 1e-6);
                let hessian = jacobian(|x| at(x).stress.to_vec(), &s, 1e-6);
                let rows: Vec<Vec<f64>> =
                    (0..3).map(|i| here.hessian.row(i).iter().copied().collect()).collect();
                assert_close(&rows, &hessian, 1e-6);
            }
        }
    }
}
