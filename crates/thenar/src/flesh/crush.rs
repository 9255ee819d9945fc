//! Resistance of flesh to being crushed to nothing, or drawn out without end: a fibre pressed under a part of its length, or
//! drawn beyond what skin bears, resists more.
//!
//! The corotational law gives way at no thickness with finite force, and comes to rest inside out; and it lets a finger
//! that is caught by its skin draw it out to ten times its length. Its tetrahedra, in patches or not, add in their
//! signed principal stretches
//!
//! ```text
//!   ψ_c = ½ k Σ (max(s_c − σᵢ, 0)² + max(σᵢ − s_t, 0)²),   k = 20 E / s_c,
//! ```
//!
//! a stress that grows from nothing at `s_c` to `20 E` at no thickness, and on in proportion, where the element is inside
//! out: however far, no faster than the corotational law's; and so from `s_t` up. Shapes of which no stretch is
//! below `s_c` or above `s_t` do not feel it. It
//! is elastic: no memory fades it, E is the modulus at once, and of damping it has the element's own share of the stiffness, which elements
//! with memory do not have. The other laws stiffen by themselves, and steps look after what they store (`foresight`).

use crate::flesh::element::{Linear, Principal, Response};
use crate::flesh::foresight::is_seen;
use crate::flesh::principal::Density;
use crate::flesh::{FleshModel, RestTet, Tally};
use crate::math::{Mat3, Vec3};
use crate::model::Law;
use crate::solver::BlockMatrix;
use std::ops::Range;

/// Stretch below which an element resists being crushed: where a foam as dense as bread, a fifth of what its walls are, is
/// pressed solid, `1.4 ρ/ρ_s` (Gibson and Ashby 1997). Flesh has no pores and is nowhere so flat.
const CRUSHED: f64 = 0.3;
/// Stress at no thickness, over Young's modulus: 1 MPa in a pulp of 50 kPa, or 200 N on the 2 cm² of a fingertip between
/// plates.
const STRESS: f64 = 20.0;
/// Stretch beyond which an element resists being drawn out: human skin tears at 1.54 ± 0.17, with 83 MPa before it does, seventy
/// times what it has at first (Ní Annaidh et al. 2012); `k` is 67 E.
const TAUT: f64 = 1.5;

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

    /// `FleshModel::surprise` of what these elements resist with to being crushed or drawn out \[J\].
    pub(super) fn crush_surprise(&self, tets: Range<usize>, x0: &[Vec3], x1: &[Vec3]) -> f64 {
        let each = self.tets[tets.clone()].iter().zip(&self.rest[tets]);
        let crushed = each.filter_map(|(tet, rest)| {
            let F1 = crushed(rest, tet, x1)?;
            let F0 = rest.deformation_gradient(&tet.map(|n| x0[n as usize]));
            is_seen(&F0, &F1).then(|| {
                let [before, after] = [F0, F1].map(|F| shape(rest, &F));
                let linear = Linear::elastic(&before, 1.0);
                let [slope, curved] = linear.along(&(before.U.tr_mul(&(F1 - F0)) * before.V));
                rest.volume * (after.at.energy - before.at.energy - slope - curved)
            })
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

/// The deformation gradient of an element that may be crushed or taut. Of positive stretches with the product J and the sum of
/// squares I the least is at least `2 J / I`. If the largest is above `s_t`, then `I`, at least `σ² + 2 |J| / σ` of it, is
/// above `s_t² + 2 |J| / s_t` as this grows with σ from the cube root of |J| on; a cube root above `s_t` tells by itself.
#[inline]
fn crushed(rest: &RestTet, tet: &[u32; 4], x: &[Vec3]) -> Option<Mat3> {
    if rest.law != Law::Corotational {
        return None;
    }
    let F = rest.deformation_gradient(&tet.map(|n| x[n as usize]));
    let (J, I) = (F.determinant(), F.norm_squared());
    let is_crushed = 2.0 * J <= CRUSHED * I;
    let is_taut = I > TAUT * TAUT + 2.0 * J.abs() / TAUT || J.abs() > TAUT.powi(3);
    (is_crushed || is_taut).then_some(F)
}

/// The stiffness is the whole second derivative less what is negative of it.
fn respond(rest: &RestTet, F: &Mat3) -> Response {
    let shape = shape(rest, F);
    Linear::elastic(&shape, 1.0).response(rest, &shape, shape.at.energy)
}

fn shape(rest: &RestTet, F: &Mat3) -> Principal {
    Principal::of(F, |s| density(STRESS * rest.young() / CRUSHED, s))
}

/// ψ_c of modulus k \[Pa\] at the signed principal stretches.
fn density(k: f64, s: [f64; 3]) -> Density {
    // How far beyond the bounds; of one sign with the stress.
    let beyond = s.map(|s| (s - TAUT).max(0.0) + (s - CRUSHED).min(0.0));
    let felt = beyond.map(|beyond| if beyond == 0.0 { 0.0 } else { k });
    Density {
        energy: 0.5 * k * beyond.iter().map(|beyond| beyond * beyond).sum::<f64>(),
        stress: beyond.map(|beyond| k * beyond),
        hessian: Mat3::from_diagonal(&felt.into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flesh::PAIRS;
    use crate::flesh::element::tests::{REST, YOUNG, rest_of};
    use crate::testing::{Random, assert_close, jacobian};

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
                    let x = x + random.vec3(0.008);
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

    /// Shapes that are passed over have no stretch beyond the bounds, shrunk and blown up ones among them.
    #[test]
    fn no_crushed_or_taut_shape_is_passed_over() {
        let (rest, mut random) = (rest(), Random::new(6));
        let (mut passed, mut caught, mut taut) = (0, 0, 0);
        for k in 0..6000 {
            let scale = [1.0, 0.8, 1.6][k % 3];
            let x = REST.map(|x| (x + random.vec3([0.006, 0.002][k % 2])) * scale);
            let (_, stretches, _) = crate::flesh::signed_svd(&rest.deformation_gradient(&x));
            match crushed(&rest, &[0, 1, 2, 3], &x) {
                None => {
                    let within = stretches[2] >= CRUSHED && stretches[0] <= TAUT;
                    assert!(within, "{stretches:?}");
                    passed += 1;
                }
                Some(_) => {
                    caught += usize::from(stretches[2] < CRUSHED);
                    taut += usize::from(stretches[0] > TAUT);
                }
            }
        }
        let counts = [passed, caught, taut];
        assert!(counts.iter().all(|count| *count > 200), "{counts:?} passed, crushed, taut");
        assert!(crushed(&rest, &[0, 1, 2, 3], &REST).is_none());
    }

    /// Under a dead load of ten Young's moduli a linear fibre between rigid sides would end at
    /// `s = 1 − 10 (1 + ν)(1 − 2ν) / (1 − ν)`, which is far inside out; with what resists beside it, at
    /// `s = (M + k s_c − 10 E) / (M + k)`.
    #[test]
    fn a_load_that_would_turn_an_element_inside_out_flattens_it() {
        let rest = rest();
        let modulus = rest.lambda + 2.0 * rest.mu;
        let load = 10.0 * YOUNG;
        assert!(1.0 - load / modulus < -2.0);
        let k = 20.0 * YOUNG / 0.3;
        let s = (modulus + k * 0.3 - load) / (modulus + k);
        assert!(s > 0.0 && s < 0.3);
        let flat = Mat3::from_diagonal(&Vec3::new(1.0, 1.0, s));
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

    /// Under a dead load of five Young's moduli a linear fibre between rigid sides would be drawn out to
    /// `s = 1 + 5 (1 + ν)(1 − 2ν) / (1 − ν)`; with what resists beside it, to `s = (M + k s_t + 5 E) / (M + k)`.
    #[test]
    fn a_load_that_would_draw_an_element_out_makes_it_taut() {
        let rest = rest();
        let modulus = rest.lambda + 2.0 * rest.mu;
        let load = 5.0 * YOUNG;
        assert!(1.0 + load / modulus > 2.0);
        let k = 20.0 * YOUNG / 0.3;
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
            let x = REST.map(|x| x + random.vec3(0.008));
            let response = respond(&rest, &rest.deformation_gradient(&x));
            let d = REST.map(|_| random.vec3(1.0));
            let curved: f64 = (response.stiffness.iter().zip(PAIRS))
                .map(|(K, (a, b))| d[a].dot(&(K * d[b])) * if a == b { 1.0 } else { 2.0 })
                .sum();
            assert!(curved >= -1e-9 * YOUNG, "{curved}");
        }
    }
}
