//! Rotations of eight deformation gradients at once.
//!
//! Of all rotations the one sought has the largest `tr(Rᵀ F)`, and that largest trace, σ₁ + σ₂ + σ₃
//! with σ₃ < 0 for an inverted element, is the largest root of
//!
//! ```text
//!   p(λ) = λ⁴ - 2 |F|² λ² - 8 det(F) λ + |F|⁴ - 4 |cof F|²
//! ```
//!
//! (the characteristic polynomial of Davenport's quaternion matrix). Newton's iteration from the
//! upper bound √3 |F| descends to it. With λ = tr S and κ = (λ² - |F|²)/2, Cayley and Hamilton's
//! theorem for the stretch S gives the rotation without square roots of matrices,
//!
//! ```text
//!   R (FᵀF + κ I) = λ F + cof F
//! ```
//!
//! where the bracket has the eigenvalues (σᵢ+σⱼ)(σᵢ+σₖ). No start value is kept from step to step,
//! so that a state alone determines what follows.

use crate::flesh::lanes::{Mat3x8, cofactors, entries};
use crate::flesh::polar::rotation_of;
use crate::math::Mat3;
use crate::math::lanes::{LANES, Vec3x8, dot};
use fearless_simd::{Simd, f64x8, prelude::*};

/// Most Newton steps; a rotation needs about four, a strongly inverted element twelve.
const STEPS_MAX: usize = 40;
/// Relative change of λ after which its next change is round-off.
const SETTLED: f64 = 1e-9;
/// (σ₁+σ₂)(σ₂+σ₃)(σ₃+σ₁) below this part of |F|³: the rotation is nearly undetermined.
const DEGENERATE: f64 = 1e-4;
/// |RᵀR - I|² beyond which one Newton-Schulz step does not reach round-off.
const SKEWED: f64 = 1e-14;

/// The rotations of `F`, as [`rotation_of`] gives them.
#[inline(always)]
pub fn rotations<S: Simd>(simd: S, F: &Mat3x8<S>) -> Mat3x8<S> {
    let [d, o] = grams(F);
    let size2 = d[0] + d[1] + d[2];
    let cof = cofactors(F);
    let det = dot(&F[0..3], &cof[0..3]);
    let [a, b, c] = grams(&cof)[0];
    let area2 = a + b + c;

    let (c0, c1) = (size2.mul_sub(size2, area2 * 4.0), det * 8.0);
    let mut lambda = (size2 * 3.0).sqrt();
    for _ in 0..STEPS_MAX {
        let square = lambda * lambda;
        let p = (square - size2 * 2.0).mul_sub(lambda, c1).mul_add(lambda, c0);
        let slope = ((square - size2) * 4.0).mul_sub(lambda, c1);
        let step = p / slope;
        lambda -= step;
        if step.simd_le(lambda * SETTLED).all_true() {
            break;
        }
    }

    // R = (λ F + cof F) (FᵀF + κ I)⁻¹.
    let kappa = lambda.mul_sub(lambda, size2) * 0.5;
    let gap = lambda.mul_sub(kappa, det);
    let d = [d[0] + kappa, d[1] + kappa, d[2] + kappa];
    let (aa, bb, cc) = (
        d[1].mul_sub(d[2], o[0] * o[0]),
        d[2].mul_sub(d[0], o[1] * o[1]),
        d[0].mul_sub(d[1], o[2] * o[2]),
    );
    let (bc, ca, ab) = (
        o[1].mul_sub(o[2], o[0] * d[0]),
        o[2].mul_sub(o[0], o[1] * d[1]),
        o[0].mul_sub(o[1], o[2] * d[2]),
    );
    let inverse = simd.splat_f64x8(1.0) / d[0].mul_add(aa, o[2].mul_add(ab, o[1] * ca));
    let warped = entries(
        #[inline(always)]
        |r, c| lambda.mul_add(F[3 * c + r], cof[3 * c + r]) * inverse,
    );
    let rough = times_symmetric(&warped, &[aa, bb, cc], &[bc, ca, ab]);

    // One Newton-Schulz step, R (3 - RᵀR)/2, takes what round-off has left.
    let [d, o] = grams(&rough);
    let d = [d[0] - 1.0, d[1] - 1.0, d[2] - 1.0];
    let skew = dot(&d, &d) + dot(&o, &o) * 2.0;
    let more = times_symmetric(&rough, &d, &o);
    let mut R = entries(
        #[inline(always)]
        |r, c| more[3 * c + r].mul_add(-0.5, rough[3 * c + r]),
    );

    let sound = gap.simd_ge(size2 * size2.sqrt() * DEGENERATE) & skew.simd_le(SKEWED);
    if !sound.all_true() {
        rotate_singly(simd, F, &mut R, sound.to_bitmask());
    }
    R
}

/// `MᵀM`: its diagonal, and its entries (1, 2), (2, 0), (0, 1).
#[inline(always)]
fn grams<S: Simd>(m: &Mat3x8<S>) -> [Vec3x8<S>; 2] {
    let (a, b, c) = (&m[0..3], &m[3..6], &m[6..9]);
    [[dot(a, a), dot(b, b), dot(c, c)], [dot(b, c), dot(c, a), dot(a, b)]]
}

/// M times the symmetric matrix of this diagonal and these entries (1, 2), (2, 0), (0, 1).
#[inline(always)]
fn times_symmetric<S: Simd>(m: &Mat3x8<S>, d: &Vec3x8<S>, o: &Vec3x8<S>) -> Mat3x8<S> {
    let columns = [[d[0], o[2], o[1]], [o[2], d[1], o[0]], [o[1], o[0], d[2]]];
    entries(
        #[inline(always)]
        |r, c| {
            let s = &columns[c];
            m[r].mul_add(s[0], m[3 + r].mul_add(s[1], m[6 + r] * s[2]))
        },
    )
}

/// Finds the rotations for which the closed form fails: of crushed elements and those turned inside
/// out along two axes alike.
#[cold]
#[inline(never)]
fn rotate_singly<S: Simd>(simd: S, F: &Mat3x8<S>, R: &mut Mat3x8<S>, sound: u64) {
    for lane in (0..LANES).filter(|&lane| sound >> lane & 1 == 0) {
        let alone = rotation_of(&Mat3::from_fn(|r, c| F[3 * c + r].as_slice()[lane]));
        for (i, x) in R.iter_mut().enumerate() {
            let mut numbers = [0.0; LANES];
            numbers.copy_from_slice(x.as_slice());
            numbers[lane] = alone[(i % 3, i / 3)];
            *x = f64x8::load_array(simd, numbers);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flesh::signed_svd;
    use crate::random::Random;
    use fearless_simd::{Level, dispatch};

    fn all(F: &[Mat3; LANES]) -> [Mat3; LANES] {
        dispatch!(Level::new(), simd => {
            let numbers: [[f64; LANES]; 9] =
                std::array::from_fn(|i| std::array::from_fn(|lane| F[lane][(i % 3, i / 3)]));
            let lanes = entries(|r, c| f64x8::load_array(simd, numbers[3 * c + r]));
            let R = rotations(simd, &lanes).map(|x| x.to_array());
            std::array::from_fn(|lane| Mat3::from_fn(|r, c| R[3 * c + r][lane]))
        })
    }

    /// Against U Vᵀ of the singular values, for turned, stretched, inverted, tiny, huge and flat
    /// matrices. The rotation is determined no better than round-off over σ₂ + σ₃.
    #[test]
    fn are_those_of_the_singular_value_decomposition() {
        let mut random = Random::new(21);
        for round in 0..3000 {
            let size = 10.0_f64.powf(random.range(-6.0, 6.0));
            let F: [Mat3; LANES] = std::array::from_fn(|lane| {
                let any = Mat3::from_fn(|_, _| random.range(-1.0, 1.0));
                let turn = random.rotation(3.13).to_rotation_matrix();
                let F = match (round + lane) % 4 {
                    0 => turn * (Mat3::identity() + 0.3 * any),
                    1 => turn * (Mat3::identity() + 1e-7 * any),
                    2 => any,
                    _ => turn * Mat3::from_diagonal(&[1.0, 0.8, -1e-3 * any[0]].into()),
                };
                F * size
            });
            for (F, R) in F.iter().zip(all(&F)) {
                assert!((R.transpose() * R - Mat3::identity()).norm() < 1e-12);
                assert!((R.determinant() - 1.0).abs() < 1e-12);
                let S = R.transpose() * F;
                assert!((S - S.transpose()).norm() < 1e-10 * F.norm(), "{S}");
                let (U, s, V) = signed_svd(F);
                let sure = (s[1] + s[2]) / s[0];
                assert!((R - U * V.transpose()).norm() * sure < 1e-9, "{F} {R}");
            }
        }
    }

    #[test]
    fn of_nothing_and_of_a_reflection_are_rotations_too() {
        let mut F = [Mat3::zeros(); LANES];
        F[1] = -Mat3::identity();
        F[2] = Mat3::from_diagonal(&[1.0, 1.0, -1.0].into());
        F[3] = Mat3::from_diagonal(&[1.0, 0.0, 0.0].into());
        for R in all(&F) {
            assert!((R.transpose() * R - Mat3::identity()).norm() < 1e-12);
            assert!((R.determinant() - 1.0).abs() < 1e-12);
        }
    }
}
