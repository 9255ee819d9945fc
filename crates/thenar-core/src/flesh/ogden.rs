//! Ogden's law of one term (Ogden 1972), nearly incompressible, and finite for every deformation
//! gradient.
//!
//! ```text
//!   ψ = 2μ/α² (g(J) Σ |σᵢ|^α - 3) + κ'/2 (J - 1)²,   g(J) = exp(α/3 (1 - J)),   κ' = λ + 2μ/3 + 2μ/α
//! ```
//!
//! The usual factor is `J^(-α/3)`, which parts the change of shape from that of volume and has no
//! value for inverted elements; g has the same value and slope at J = 1, so that both become
//! Ogden's `2μ/α² (Σσ^α - 3)` where volume is kept, and κ' gives small strains the moduli λ and μ.
//! For J < 0 g goes on by its second-order expansion about 0, and `σ^α` above 1000 about the
//! stretch where it is that (2.4 for α = 8, past what tissue bears), so that nothing overflows.
//!
//! An element that is inverted (σ₃ < 0) is pushed right: every term of ∂ψ/∂σ₃ is negative then. One
//! that is crushed evenly to a stretch s < 1 is pushed apart, whatever s: with y = s³ and a = α/3
//! its pressure has the sign of `1 + κα/(2μ) - y^(a-1) e^(a(1-y))`, whose last part is at most
//! `((a-1)/a)^(a-1) e`: 1.71 for α = 4, less for more, and the first two are `1 + a` at least where
//! ν ≥ 0. Hence the bounds on α and ν; the neo-Hookean laws are those for α = 2. No convexity in F
//! is claimed: the tangent is projected, as for the other laws.

use crate::flesh::principal::Density;
use crate::math::Mat3;

/// `|σ|^α` beyond which the law goes on by its second-order expansion.
const POWER_MAX: f64 = 1e3;

/// Derivatives of a function of one variable, from the zeroth.
pub type Jet = [f64; 3];

/// The stretch beyond which `σ^α` goes on by its expansion.
pub fn power_end(alpha: f64) -> f64 {
    POWER_MAX.powf(1.0 / alpha)
}

/// `|x|^α`, for α ≥ 2, with `end` its [`power_end`].
pub fn power(x: f64, alpha: f64, end: f64) -> Jet {
    let size = x.abs();
    let at = size.min(end);
    let curved = at.powf(alpha - 2.0);
    let jet = [curved * at * at, alpha * curved * at, alpha * (alpha - 1.0) * curved];
    let [value, slope, curvature] = jet;
    let past = size - at;
    let slope_past = slope + curvature * past;
    [value + (slope + 0.5 * curvature * past) * past, slope_past.copysign(x), curvature]
}

/// Factor g of the change of volume, with its derivatives in J; `a` is α/3.
pub fn volume_factor(J: f64, a: f64) -> Jet {
    let value = (a * (1.0 - J.max(0.0))).exp();
    let past = a * J.min(0.0);
    [value * (1.0 - past + 0.5 * past * past), -a * value * (1.0 - past), a * a * value]
}

/// ψ and its derivatives at the signed principal stretches.
pub fn density(alpha: f64, lambda: f64, mu: f64, s: [f64; 3]) -> Density {
    let shape = 2.0 * mu / (alpha * alpha);
    let bulk = lambda + 2.0 / 3.0 * mu + 2.0 * mu / alpha;
    let J = s[0] * s[1] * s[2];
    let area = [s[1] * s[2], s[2] * s[0], s[0] * s[1]];
    let end = power_end(alpha);
    let f = s.map(|s| power(s, alpha, end));
    let sum = f[0][0] + f[1][0] + f[2][0];
    let [g, slope, curvature] = volume_factor(J, alpha / 3.0);
    // ∂ψ/∂J and ∂²ψ/∂J² of what depends on J.
    let pressure = shape * sum * slope + bulk * (J - 1.0);
    let stiffness = shape * sum * curvature + bulk;
    Density {
        energy: shape * (g * sum - 3.0) + 0.5 * bulk * (J - 1.0) * (J - 1.0),
        stress: std::array::from_fn(|i| shape * g * f[i][1] + pressure * area[i]),
        hessian: Mat3::from_fn(|i, j| {
            let mixed = shape * slope * (f[i][1] * area[j] + f[j][1] * area[i]);
            let both = stiffness * area[i] * area[j] + mixed;
            match i == j {
                true => both + shape * g * f[i][2],
                false => both + pressure * s[3 - i - j],
            }
        }),
    }
}
