//! Laws in principal stretches (`principal`, `ogden`) of eight elements at once.

use crate::flesh::lanes::{Kind, RestLanes};
use crate::flesh::ogden::{power, volume_factor};
use crate::flesh::principal::STRETCH_MIN;
use crate::math::lanes::{LANES, Vec3x8, dot, three};
use fearless_simd::{Simd, f64x8, prelude::*};

/// A law at its stretches. What belongs to a pair of axes has the index of the third.
pub struct PrincipalResponse<S: Simd> {
    /// ψ \[J/m³\].
    pub energy: f64x8<S>,
    /// Principal first Piola stresses \[Pa\].
    pub stress: Vec3x8<S>,
    /// Hessian of ψ, its diagonal \[Pa\].
    pub diagonal: Vec3x8<S>,
    /// The Hessian's other entries.
    pub beside: Vec3x8<S>,
    /// `(Pᵢ + Pⱼ) / (σᵢ + σⱼ)`.
    pub twist: Vec3x8<S>,
    /// `(Pᵢ - Pⱼ) / (σᵢ - σⱼ)`.
    pub flip: Vec3x8<S>,
}

/// Differences of stretches below this are taken for none.
const ALIKE: f64 = 1e-6;

/// The law of these elements, one that is evaluated together.
#[inline(always)]
pub fn density<S: Simd>(simd: S, rest: &RestLanes, s: &Vec3x8<S>) -> PrincipalResponse<S> {
    let lambda = f64x8::load_array_ref(simd, &rest.lambda);
    let mu = f64x8::load_array_ref(simd, &rest.mu);
    let area = [s[1] * s[2], s[2] * s[0], s[0] * s[1]];
    let volume = area[2] * s[2] - 1.0;
    match rest.kind {
        Kind::Ogden => ogden(simd, rest, s, area, volume, lambda, mu),
        Kind::NeoHookean => neo_hookean(simd, s, lambda, mu),
        _ => stable_neo_hookean(s, area, volume, lambda + mu, mu),
    }
}

/// `P = μσ + p A`, `p = λ' (J - 1) - μ`.
#[inline(always)]
fn stable_neo_hookean<S: Simd>(
    s: &Vec3x8<S>,
    area: Vec3x8<S>,
    volume: f64x8<S>,
    lambda: f64x8<S>,
    mu: f64x8<S>,
) -> PrincipalResponse<S> {
    let p = lambda.mul_sub(volume, mu);
    let squares = s[0].mul_add(s[0], s[1].mul_add(s[1], s[2] * s[2])) - 3.0;
    let bulk = lambda * volume * 0.5 - mu;
    PrincipalResponse {
        energy: mu * squares * 0.5 + bulk * volume,
        stress: three(
            #[inline(always)]
            |i| mu.mul_add(s[i], p * area[i]),
        ),
        diagonal: three(
            #[inline(always)]
            |i| (lambda * area[i]).mul_add(area[i], mu),
        ),
        beside: of_pairs(
            #[inline(always)]
            |[i, j]| (lambda * area[i]).mul_add(area[j], p * s[3 - i - j]),
        ),
        twist: three(
            #[inline(always)]
            |k| p.mul_add(s[k], mu),
        ),
        flip: three(
            #[inline(always)]
            |k| mu - p * s[k],
        ),
    }
}

/// The two axes beside each.
const PAIRS: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

/// `f` of each of [`PAIRS`].
#[inline(always)]
fn of_pairs<T>(f: impl Fn([usize; 2]) -> T) -> [T; 3] {
    [f(PAIRS[0]), f(PAIRS[1]), f(PAIRS[2])]
}

#[inline(always)]
fn loaded<S: Simd>(simd: S, numbers: &[[f64; LANES]; 3]) -> Vec3x8<S> {
    three(
        #[inline(always)]
        |k| f64x8::load_array_ref(simd, &numbers[k]),
    )
}

/// `P = μσ + (λ ln J - μ) / σ`, and its expansion beyond [`STRETCH_MIN`].
#[inline(always)]
fn neo_hookean<S: Simd>(
    simd: S,
    s: &Vec3x8<S>,
    lambda: f64x8<S>,
    mu: f64x8<S>,
) -> PrincipalResponse<S> {
    let least = simd.splat_f64x8(STRETCH_MIN);
    let at = three(
        #[inline(always)]
        |k| s[k].max(least),
    );
    let ln_J = (at[0] * at[1] * at[2]).to_array().map(f64::ln);
    let ln_J = f64x8::load_array(simd, ln_J);
    let one = simd.splat_f64x8(1.0);
    let inverse = three(
        #[inline(always)]
        |k| one / at[k],
    );
    let pull = lambda.mul_sub(ln_J, mu);
    let diagonal = three(
        #[inline(always)]
        |k| (lambda - pull).mul_add(inverse[k] * inverse[k], mu),
    );
    let beside = of_pairs(
        #[inline(always)]
        |[i, j]| lambda * inverse[i] * inverse[j],
    );
    let past = [s[0] - at[0], s[1] - at[1], s[2] - at[2]];
    let slope = three(
        #[inline(always)]
        |k| {
            let [i, j] = PAIRS[k];
            diagonal[k].mul_add(past[k], beside[j].mul_add(past[i], beside[i] * past[j]))
        },
    );
    let there = three(
        #[inline(always)]
        |k| mu.mul_add(at[k], pull * inverse[k]),
    );
    let stress = [there[0] + slope[0], there[1] + slope[1], there[2] + slope[2]];
    let mut energy = mu * 0.5 * (dot(&at, &at) - 3.0) + (lambda * 0.5).mul_sub(ln_J, mu) * ln_J;
    for k in 0..3 {
        energy += past[k] * slope[k].mul_add(0.5, there[k]);
    }
    let (small, zero) = (simd.splat_f64x8(ALIKE), simd.splat_f64x8(0.0));
    PrincipalResponse {
        energy,
        stress,
        diagonal,
        beside,
        twist: of_pairs(
            #[inline(always)]
            |[i, j]| {
                let sum = s[i] + s[j];
                sum.abs().simd_gt(small).select((stress[i] + stress[j]) / sum, zero)
            },
        ),
        flip: three(
            #[inline(always)]
            |k| {
                let [i, j] = PAIRS[k];
                let gap = s[i] - s[j];
                let divided = (stress[i] - stress[j]) / gap;
                gap.abs().simd_gt(small).select(divided, diagonal[i] - beside[k])
            },
        ),
    }
}

#[inline(always)]
fn ogden<S: Simd>(
    simd: S,
    rest: &RestLanes,
    s: &Vec3x8<S>,
    area: Vec3x8<S>,
    volume: f64x8<S>,
    lambda: f64x8<S>,
    mu: f64x8<S>,
) -> PrincipalResponse<S> {
    let alpha = f64x8::load_array_ref(simd, &rest.alpha);
    let over = mu * 2.0 / alpha;
    let (shape, bulk) = (over / alpha, lambda + mu * (2.0 / 3.0) + over);
    let [f, g] = powers(rest, s, volume + 1.0);
    let f = three(
        #[inline(always)]
        |i| loaded(simd, &f[i]),
    );
    let [g, slope, curvature] = loaded(simd, &g[0]);
    let sum = f[0][0] + f[1][0] + f[2][0];
    let pressure = (shape * sum).mul_add(slope, bulk * volume);
    let stiffness = (shape * sum).mul_add(curvature, bulk);
    let (around, inside) = (shape * slope, shape * g);
    let diagonal = three(
        #[inline(always)]
        |i| (stiffness * area[i]).mul_add(area[i], around * f[i][1] * area[i] * 2.0),
    );
    let beside = of_pairs(
        #[inline(always)]
        |[i, j]| {
            let mixed = f[i][1].mul_add(area[j], f[j][1] * area[i]);
            (stiffness * area[i]).mul_add(area[j], around * mixed)
        },
    );
    let small = simd.splat_f64x8(ALIKE);
    PrincipalResponse {
        energy: shape * g.mul_sub(sum, simd.splat_f64x8(3.0)) + bulk * volume * volume * 0.5,
        stress: three(
            #[inline(always)]
            |i| inside.mul_add(f[i][1], pressure * area[i]),
        ),
        diagonal: three(
            #[inline(always)]
            |i| inside.mul_add(f[i][2], diagonal[i]),
        ),
        beside: three(
            #[inline(always)]
            |k| pressure.mul_add(s[k], beside[k]),
        ),
        // f′ is odd: both are its divided differences, and what depends on J cancels but for ±p σ.
        twist: of_pairs(
            #[inline(always)]
            |[i, j]| {
                let gap = s[i] + s[j];
                let divided = (f[i][1] + f[j][1]) / gap;
                let k = gap.abs().simd_gt(small).select(divided, f[i][2]);
                inside.mul_add(k, pressure * s[3 - i - j])
            },
        ),
        flip: of_pairs(
            #[inline(always)]
            |[i, j]| {
                let gap = s[i] - s[j];
                let divided = (f[i][1] - f[j][1]) / gap;
                let k = gap.abs().simd_gt(small).select(divided, f[i][2]);
                inside.mul_add(k, -(pressure * s[3 - i - j]))
            },
        ),
    }
}

/// Value, slope and curvature of `|σ|^α` for each stretch, and of g, lane by lane.
#[inline(always)]
fn powers<S: Simd>(rest: &RestLanes, s: &Vec3x8<S>, J: f64x8<S>) -> [[[[f64; LANES]; 3]; 3]; 2] {
    let mut out = [[[[0.0; LANES]; 3]; 3]; 2];
    let (s, J) = ([s[0].to_array(), s[1].to_array(), s[2].to_array()], J.to_array());
    for lane in 0..LANES {
        let alpha = rest.alpha[lane];
        for i in 0..3 {
            let jet = power(s[i][lane], alpha, rest.power_end[lane]);
            (0..3).for_each(|n| out[0][i][n][lane] = jet[n]);
        }
        let jet = volume_factor(J[lane], alpha / 3.0);
        (0..3).for_each(|n| out[1][0][n][lane] = jet[n]);
    }
    out
}
