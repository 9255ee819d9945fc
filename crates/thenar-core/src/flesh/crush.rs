//! Resistance of flesh to being crushed to nothing, or drawn out without end: a fibre pressed under
//! a part of its length, or drawn beyond what skin bears, resists more.
//!
//! The corotational law gives way at no thickness with finite force, and comes to rest inside out;
//! and it lets a finger that is caught by its skin draw it out to ten times its length. Its
//! tetrahedra, in patches or not, add in their signed principal stretches, with the depth
//! `c = max(s_c − σ, 0) / s_c` and the draw `t = max(σ − s_t, 0)`,
//!
//! ```text
//!   dψ/dσ = E (67 t − 432 c²)  up to c = 1,   E (67 t − 432 (2 c − 1))  beyond,
//! ```
//!
//! each principal stretch by itself: a stress that grows from nothing at `s_c` to `432 E` at no
//! thickness, with a slope that begins at nothing too, and on along its tangent where the element
//! is inside out. Shapes of which no stretch is below `s_c` or above `s_t` do not feel it. It is
//! elastic: no memory fades it, E is the modulus at once, and of damping it has the element's own
//! share of the stiffness, which elements with memory do not have. The other laws stiffen by
//! themselves, and steps look after what they store (`foresight`).

use crate::flesh::element::{Linear, Principal, Response};
use crate::flesh::principal::Density;
use crate::flesh::{FleshModel, RestTet, Tally};
use crate::math::{Mat3, Vec3};
use crate::model::Law;
use crate::solver::BlockMatrix;
use std::ops::Range;

/// Stretch below which an element resists being crushed: where a foam as dense as bread, a fifth of
/// what its walls are, is pressed solid, `1.4 ρ/ρ_s` (Gibson and Ashby 1997). Flesh has no pores
/// and is nowhere so flat.
const CRUSHED: f64 = 0.3;
/// Stress at no thickness, over Young's modulus: 21.6 MPa, with which human skin tears (± 8.4 MPa;
/// Ní Annaidh et al. 2012), in a pulp of 50 kPa. At a stretch of 0.2, a ninth of it acts: 48 E,
/// where Ogden's law, `2 μ / α (s^(α−1) − s^(−α/2−1))` with `μ = E / 3`, has 69 E for α = 6, the
/// softest of fingertips' flesh (6 to 10). Less gives way under one edge of a hard body: with 20,
/// growing in proportion, a hand pressed on a toy car by 100 N came to rest inside out.
const STRESS: f64 = 432.0;
/// Stretch beyond which an element resists being drawn out: human skin tears at 1.54 ± 0.17, with
/// 83 MPa before it does, seventy times what it has at first (Ní Annaidh et al. 2012).
const TAUT: f64 = 1.5;
/// Stiffness of what is drawn out farther, over Young's modulus: with the element's own, those
/// seventy times.
const TAUT_STIFFNESS: f64 = 67.0;

/// Changes of the deformation gradient below this are rest. What the expansion leaves out of the
/// energy is of third order, `432 E (ΔF)³ / (3 s_c²)`: here 2e-12 of E in the element's volume, two
/// hundred times its rounding.
const STILL: f64 = 1e-5;

impl FleshModel {
    /// Adds what crushed elements resist with to the system of a step of length `h` \[s\].
    pub(super) fn resist_crushing(
        &self,
        x: &[Vec3],
        h: f64,
        A: &mut BlockMatrix,
        b: &mut [Vec3],
        sums: &mut Tally,
    ) {
        for (t, (tet, rest)) in self.tets.iter().zip(&self.rest).enumerate() {
            let Some(response) = response(rest, tet, x) else { continue };
            sums.energy += response.energy;
            self.scatter(t, &response, h, A, b);
        }
    }

    /// `FleshModel::surprise` of what these elements resist with to being crushed or drawn out
    /// \[J\].
    pub(super) fn crush_surprise(
        &self,
        tets: Range<usize>,
        [x0, x1, straight]: [&[Vec3]; 3],
    ) -> f64 {
        let each = self.tets[tets.clone()].iter().zip(&self.rest[tets]);
        let crushed = each.filter_map(|(tet, rest)| {
            let F1 = suspect(rest, tet, x1)?;
            let [F0, F] = [x0, straight].map(|x| rest.gradient_at(tet, x));
            let is_still = (F1 - F0).norm_squared() < STILL * STILL;
            if is_still || ![F0, F1].iter().any(is_beyond) {
                return None;
            }
            let [before, after] = [F0, F1].map(|F| shape(rest, &F));
            let linear = Linear::elastic(&before, 1.0);
            let [slope, curved] = linear.along(&(before.U.tr_mul(&(F - F0)) * before.V));
            Some(rest.volume * (after.at.energy - before.at.energy - slope - curved))
        });
        crushed.sum()
    }

    /// Energy of crushed elements \[J\].
    pub(super) fn crush_energy(&self, x: &[Vec3]) -> f64 {
        let each = self.tets.iter().zip(&self.rest);
        let crushed = each.filter_map(|(tet, rest)| Some((rest, crushed(rest, tet, x)?)));
        crushed.map(|(rest, F)| rest.volume * shape(rest, &F).at.energy).sum()
    }
}

/// Energy, forces and stiffness of an element that is crushed, beside those of its law.
pub(super) fn response(rest: &RestTet, tet: &[u32; 4], x: &[Vec3]) -> Option<Response> {
    crushed(rest, tet, x).map(|F| respond(rest, &F))
}

/// The deformation gradient of an element that is crushed or taut.
#[inline]
fn crushed(rest: &RestTet, tet: &[u32; 4], x: &[Vec3]) -> Option<Mat3> {
    suspect(rest, tet, x).filter(is_beyond)
}

/// The deformation gradient of an element that may be crushed or taut: bounds pass over most that
/// are not. Of positive stretches with the product J and the sum of squares I the least is at least
/// `2 J / I`. If the largest is above `s_t`, then `I`, at least `σ² + 2 |J| / σ` of it, is above
/// `s_t² + 2 |J| / s_t` as this grows with σ from the cube root of |J| on; a cube root above `s_t`
/// tells by itself.
#[inline]
fn suspect(rest: &RestTet, tet: &[u32; 4], x: &[Vec3]) -> Option<Mat3> {
    if rest.law != Law::Corotational {
        return None;
    }
    let F = rest.gradient_at(tet, x);
    let (J, I) = (F.determinant(), F.norm_squared());
    let is_crushed = 2.0 * J <= CRUSHED * I;
    let is_taut = I > TAUT * TAUT + 2.0 * J.abs() / TAUT || J.abs() > TAUT.powi(3);
    (is_crushed || is_taut).then_some(F)
}

/// True where a stretch is beyond `s_c` or `s_t`, or as near as rounding: none is where the shape
/// is not inside out, and both `FᵀF - s_c² I` and `s_t² I - FᵀF` are positive definite.
fn is_beyond(F: &Mat3) -> bool {
    let squares = F.tr_mul(F);
    let above = |s: f64| squares - Mat3::from_diagonal_element(s * s);
    let is_within = F.determinant() > 0.0
        && is_positive_definite(&above(CRUSHED * ROUNDED))
        && is_positive_definite(&-above(TAUT / ROUNDED));
    !is_within
}

/// Stretches this near a bound count as beyond it: rounding moves their squares by less. Where two
/// of them are within 1e-8 of a bound, on either side, rounding decides: they bear 7e-7 E.
const ROUNDED: f64 = 1.0 + 1e-9;

/// Tells by the leading minors of a symmetric matrix if it is positive definite (Sylvester).
fn is_positive_definite(m: &Mat3) -> bool {
    let minor = m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(0, 1)];
    m[(0, 0)] > 0.0 && minor > 0.0 && m.determinant() > 0.0
}

/// The stiffness is the whole second derivative less what is negative of it.
fn respond(rest: &RestTet, F: &Mat3) -> Response {
    let shape = shape(rest, F);
    Linear::elastic(&shape, 1.0).response(rest, &shape, shape.at.energy)
}

fn shape(rest: &RestTet, F: &Mat3) -> Principal {
    Principal::of(F, |s| density(rest.young(), s))
}

/// ψ_c of an element of this modulus \[Pa\] at the signed principal stretches.
fn density(young: f64, s: [f64; 3]) -> Density {
    let along = s.map(|s| {
        let [pressed, drawn] = [crushing(s), drawing(s)];
        [0, 1, 2].map(|k| young * (pressed[k] + drawn[k]))
    });
    Density {
        energy: along.iter().map(|[energy, ..]| energy).sum(),
        stress: along.map(|[_, stress, _]| stress),
        hessian: Mat3::from_diagonal(&along.map(|[.., curvature]| curvature).into()),
    }
}

/// Energy of crushing to a stretch, over Young's modulus, and its first two derivatives.
fn crushing(s: f64) -> [f64; 3] {
    let depth = (CRUSHED - s).max(0.0) / CRUSHED;
    let beyond = (depth - 1.0).max(0.0);
    let within = depth - beyond;
    let energy = within.powi(3) / 3.0 + beyond + beyond * beyond;
    let stress = within * within + 2.0 * beyond;
    [STRESS * CRUSHED * energy, -STRESS * stress, 2.0 * STRESS / CRUSHED * within]
}

/// Energy of drawing out to a stretch, over Young's modulus, and its first two derivatives.
fn drawing(s: f64) -> [f64; 3] {
    let drawn = (s - TAUT).max(0.0);
    let curvature = if drawn > 0.0 { TAUT_STIFFNESS } else { 0.0 };
    [0.5 * TAUT_STIFFNESS * drawn * drawn, TAUT_STIFFNESS * drawn, curvature]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flesh::PAIRS;
    use crate::flesh::element::tests::{REST, YOUNG, rest_of};
    use crate::random::Random;
    use crate::testing::{assert_close, jacobian};

    fn rest() -> RestTet {
        rest_of(Law::Corotational)
    }

    fn at(rest: &RestTet, x: &[f64]) -> Response {
        let x = std::array::from_fn(|a| Vec3::new(x[3 * a], x[3 * a + 1], x[3 * a + 2]));
        respond(rest, &rest.deformation_gradient(&x))
    }

    #[test]
    fn forces_are_minus_the_gradient_of_the_energy() {
        let (rest, mut random) = (rest(), Random::new(5));
        let mut felt = 0;
        for _ in 0..200 {
            let x: Vec<f64> = REST
                .iter()
                .flat_map(|x| {
                    let x = x + random.vector(0.008);
                    [x.x, x.y, x.z]
                })
                .collect();
            let forces = at(&rest, &x).forces;
            felt += usize::from(forces[0].norm() > 1e-3);
            let flat: Vec<f64> = forces.iter().flat_map(|f| [f.x, f.y, f.z]).collect();
            let numeric = jacobian(|x| vec![-at(&rest, x).energy], &x, 1e-8);
            assert_close(&[flat], &numeric, 1e-5);
        }
        assert!(felt > 50, "{felt} of 200 shapes were crushed");
    }

    /// Shapes with a stretch beyond the bounds are looked into, and no others, some of which the
    /// cheap test before lets through. Shrunk and blown up ones are among them, and such as are
    /// inside out.
    #[test]
    fn crushed_and_taut_shapes_are_looked_into_and_no_others() {
        let (rest, mut random) = (rest(), Random::new(6));
        let (mut passed, mut spared, mut crushes, mut draws, mut inverted) = (0, 0, 0, 0, 0);
        for k in 0..6000 {
            let scale = [1.0, 0.8, 1.6][k % 3];
            let x = REST.map(|x| (x + random.vector([0.006, 0.002][k % 2])) * scale);
            let (_, stretches, _) = crate::flesh::signed_svd(&rest.deformation_gradient(&x));
            let (is_crushed, is_taut) = (stretches[2] < CRUSHED, stretches[0] > TAUT);
            let is_suspect = suspect(&rest, &[0, 1, 2, 3], &x).is_some();
            let is_looked_into = crushed(&rest, &[0, 1, 2, 3], &x).is_some();
            assert_eq!(is_looked_into, is_crushed || is_taut, "{stretches:?}");
            inverted += usize::from(stretches[2] < 0.0);
            crushes += usize::from(is_crushed);
            draws += usize::from(is_taut);
            spared += usize::from(is_suspect && !is_looked_into);
            passed += usize::from(!is_suspect);
        }
        let counts = [passed, spared, crushes, draws, inverted];
        assert!(counts.iter().all(|count| *count > 150), "{counts:?}");
        assert!(crushed(&rest, &[0, 1, 2, 3], &REST).is_none());
    }

    /// Under a dead load of a hundred Young's moduli a linear fibre between rigid sides would end
    /// at `s = 1 − 100 (1 + ν)(1 − 2ν) / (1 − ν)`, far inside out; with what resists beside it,
    /// where `M (1 − s) + 432 E ((s_c − s) / s_c)² = 100 E`.
    #[test]
    fn a_load_that_would_turn_an_element_inside_out_flattens_it() {
        let rest = rest();
        let modulus = rest.lambda + 2.0 * rest.mu;
        let load = 100.0 * YOUNG;
        assert!(1.0 - load / modulus < -2.0);
        let excess =
            |s: f64| modulus * (1.0 - s) + 432.0 * YOUNG * ((0.3 - s) / 0.3).powi(2) - load;
        // Falls from 0 to 0.3.
        let (mut low, mut high) = (0.0, 0.3);
        assert!(excess(low) > 0.0 && excess(high) < 0.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if excess(middle) > 0.0 { low = middle } else { high = middle }
        }
        let flat = Mat3::from_diagonal(&Vec3::new(1.0, 1.0, low));
        let x = REST.map(|x| flat * x);
        let [law, crush] =
            [crate::flesh::respond(&rest, &x), respond(&rest, &rest.deformation_gradient(&x))];
        // Of a homogeneous stress, the force on a node is its gradient times it.
        for (g, (a, b)) in rest.gradients.iter().zip(law.forces.iter().zip(&crush.forces)) {
            let got = (a + b).z;
            let expected = rest.volume * load * g.z;
            assert!((got - expected).abs() < 1e-9 * rest.volume * load * 100.0, "{got} {expected}");
        }
    }

    /// Between a quarter and three twentieths of its length an element bears what Ogden's law of
    /// flesh does within a factor of three, and no more: `2 μ / α (s^(α−1) − s^(−α/2−1))` with α =
    /// 6, `μ = E / 3`.
    #[test]
    fn what_is_crushed_stiffens_as_soft_tissue_does() {
        let ogden = |s: f64| 2.0 / 18.0 * (s.powi(5) - s.powi(-4));
        for s in [0.24, 0.22, 0.2, 0.18, 0.15] {
            let part = crushing(s)[1] / ogden(s);
            assert!((1.0 / 3.0..1.0).contains(&part), "{part} at {s}");
        }
    }

    /// Stress and stiffness have no steps where crushing begins and where the element has no
    /// thickness.
    #[test]
    fn crushing_begins_and_goes_on_smoothly() {
        for s in [0.3, 0.0] {
            let [above, below] = [s + 1e-9, s - 1e-9].map(crushing);
            for k in 0..3 {
                let scale = [0.1, 1.0, 10.0][k] * STRESS;
                assert!((above[k] - below[k]).abs() < 1e-6 * scale, "{s}: {above:?} {below:?}");
            }
        }
    }

    /// Under a dead load of five Young's moduli a linear fibre between rigid sides would be drawn
    /// out to `s = 1 + 5 (1 + ν)(1 − 2ν) / (1 − ν)`; with what resists beside it, to
    /// `s = (M + k s_t + 5 E) / (M + k)`.
    #[test]
    fn a_load_that_would_draw_an_element_out_makes_it_taut() {
        let rest = rest();
        let modulus = rest.lambda + 2.0 * rest.mu;
        let load = 5.0 * YOUNG;
        assert!(1.0 + load / modulus > 2.0);
        let k = 67.0 * YOUNG;
        let s = (modulus + k * 1.5 + load) / (modulus + k);
        assert!(s > 1.5 && s < 1.6);
        let drawn = Mat3::from_diagonal(&Vec3::new(1.0, 1.0, s));
        let x = REST.map(|x| drawn * x);
        let F = crushed(&rest, &[0, 1, 2, 3], &x).unwrap();
        let [law, taut] = [crate::flesh::respond(&rest, &x), respond(&rest, &F)];
        for (g, (a, b)) in rest.gradients.iter().zip(law.forces.iter().zip(&taut.forces)) {
            let got = (a + b).z;
            let expected = -rest.volume * load * g.z;
            assert!((got - expected).abs() < 1e-9 * rest.volume * load * 100.0, "{got} {expected}");
        }
    }

    /// Stiffness that is left pushes no motion on.
    #[test]
    fn the_stiffness_has_no_negative_direction() {
        let (rest, mut random) = (rest(), Random::new(7));
        for _ in 0..200 {
            let x = REST.map(|x| x + random.vector(0.008));
            let response = respond(&rest, &rest.deformation_gradient(&x));
            let d = REST.map(|_| random.vector(1.0));
            let curved: f64 = (response.stiffness.iter().zip(PAIRS))
                .map(|(K, (a, b))| d[a].dot(&(K * d[b])) * if a == b { 1.0 } else { 2.0 })
                .sum();
            assert!(curved >= -1e-9 * YOUNG, "{curved}");
        }
    }
}
