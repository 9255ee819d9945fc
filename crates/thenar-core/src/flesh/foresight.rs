//! Test of whether one linearised step was enough for flesh whose stress is not linear.
//!
//! A step goes to the least of the incremental energy `Φ = |x - x̃|²_M / (2Δt²) + ψ`, with ψ by its
//! second-order expansion about the start. There the expansion of Φ has fallen by
//! `D = ½ Δxᵀ (M/Δt² + K) Δx`, so that Φ itself has not risen as long as what the expansion did not
//! foresee, `ψ(x₁) - ψ(x₀) - ∇ψ·Δx - ½ Δxᵀ K Δx`, is not above D. Each element is asked by itself,
//! with the motion of its nodes against their mean. For one with memory ψ is the energy of which
//! the forces of the step's end are the slope (`memory::Increment`).
//!
//! Corotational elements are not asked one by one. Summed over a body, the energy of the step falls
//! as long as they rose by no more beyond `∇ψ·Δx + Δxᵀ K Δx` than `½ |v₁ - v₀|²_M`, which an
//! implicit step takes out ([`FleshModel::surprise`]).

use crate::flesh::element::{Linear, Principal};
use crate::flesh::memory::{Faded, Fading, Increment};
use crate::flesh::{FleshModel, RestTet, rotation_of};
use crate::math::{Mat3, Vec3};
use crate::model::{Law, Relaxation};
use std::ops::Range;

/// Changes of the deformation gradient below this are not looked at: of the energies of the laws
/// asked, their third order is there a small part of the second (at the exponents of tissue and
/// moderate stretch `α ΔF / 3`).
pub(super) const CHANGE_SEEN: f64 = 0.05;

impl FleshModel {
    /// False when the energy of one of these elements rose more, from positions `x0` to `x1` in a
    /// step of length `h` \[s\], than the step could take out; `faded` is what they remembered at
    /// its beginning. Corotational elements are asked by [`FleshModel::surprise`], the logarithmic
    /// law is not. Skin is.
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
            let F = [x0, x1].map(|x| rest.gradient_at(tet, x));
            let remembers = self.memory.of(t).map(|(of, place)| (of, &faded[place]));
            element_foresaw(rest, F, remembers, &mut fading, (tet, x0, x1), h)
        }) && self.patches.foresaw(&self.memory, faded, &tets, x0, x1, &mut fading, h)
            && self.skin_foresaw(&tets, x0, x1, h)
    }
}

impl FleshModel {
    /// Returns the energy that corotational elements among these gained, from positions `x₀` to
    /// `x₁` in a step of length `h` \[s\], over what the step foresaw and took out \[J\]:
    /// `ψ(x₁) - ψ(x₀) - ∇ψ·d - dᵀ K d`, with `faded` what they remembered at its beginning. The
    /// step's work is that of velocities, `d = h v₁`, along straight ways from `x₀` to the third
    /// positions; where bones turn, nodes go round to `x₁`, and what that strains of `K` is no
    /// work.
    pub fn surprise(&self, tets: Range<usize>, x: [&[Vec3]; 3], faded: &[Faded], h: f64) -> f64 {
        let mut fading = Fading::none(h);
        let shared = |range: &Range<usize>| range.start.max(tets.start)..range.end.min(tets.end);
        let mut law = self.patches.surprise(&self.memory, faded, &tets, x, &mut fading, h);
        for t in self.single.iter().flat_map(shared) {
            let (rest, tet) = (&self.rest[t], &self.tets[t]);
            let [before, after] = [rest.gradient_at(tet, x[0]), rest.gradient_at(tet, x[1])];
            if rest.law == Law::Corotational && is_seen(&before, &after) {
                let F = [before, after, rest.gradient_at(tet, x[2])];
                let remembers = self.memory.of(t).map(|(of, place)| (of, &faded[place]));
                law += rest.volume * element_surprise(rest, F, remembers, &mut fading, h);
            }
        }
        law + self.crush_surprise(tets, x)
    }
}

/// True when a step changed an element enough to be looked at.
pub(super) fn is_seen(F0: &Mat3, F1: &Mat3) -> bool {
    (F1 - F0).norm_squared() >= CHANGE_SEEN * CHANGE_SEEN
}

/// `FleshModel::surprise` of one element or patch \[J/m³\], whose deformation gradient goes from
/// the first to the second, and would on straight ways go to the third.
pub(super) fn element_surprise(
    rest: &RestTet,
    [F0, F1, straight]: [Mat3; 3],
    remembers: Option<(&Relaxation, &[Faded])>,
    fading: &mut Fading,
    h: f64,
) -> f64 {
    if remembers.is_none() && rest.law == Law::Corotational {
        return warped_surprise(rest, [F0, F1], &(straight - F0));
    }
    let [before, after] = [F0, F1].map(|F| Principal::new(rest, &F));
    let (linear, risen) = match remembers {
        None => (Linear::elastic(&before, 1.0), after.at.energy - before.at.energy),
        Some((of, faded)) => {
            let step = Increment::new(rest, &before, fading.of(of, rest.law, h), faded);
            (step.linear, step.energy(&after) - step.energy(&before))
        }
    };
    let [slope, curved] = linear.along(&(before.U.tr_mul(&(straight - F0)) * before.V));
    risen - slope - curved
}

/// Surprise of the corotational law, whose stiffness is that at rest, turned with the element, for
/// this foreseen change.
fn warped_surprise(rest: &RestTet, F: [Mat3; 2], foreseen: &Mat3) -> f64 {
    let R = F.map(|F| rotation_of(&F));
    let strain: [Mat3; 2] = std::array::from_fn(|k| R[k].tr_mul(&F[k]) - Mat3::identity());
    let along = |a: &Mat3, b: &Mat3| 2.0 * rest.mu * a.dot(b) + rest.lambda * a.trace() * b.trace();
    let turned = R[0].tr_mul(foreseen);
    let change = (turned + turned.transpose()) * 0.5;
    let [before, after] = strain.map(|strain| 0.5 * along(&strain, &strain));
    after - before - along(&strain[0], &change) - along(&change, &change)
}

/// True when the law of an element is one of those that [`FleshModel::foresaw`] asks element by
/// element.
pub fn asked(rest: &RestTet) -> bool {
    matches!(rest.law, Law::StableNeoHookean | Law::Ogden { .. })
}

/// `FleshModel::foresaw` of one element or patch, whose deformation gradient goes from the first to
/// the second; with what it remembers, and its nodes and their positions \[m\] before and after.
pub(super) fn element_foresaw(
    rest: &RestTet,
    F: [Mat3; 2],
    remembers: Option<(&Relaxation, &[Faded])>,
    fading: &mut Fading,
    (nodes, x0, x1): (&[u32], &[Vec3], &[Vec3]),
    h: f64,
) -> bool {
    if !is_seen(&F[0], &F[1]) {
        return true;
    }
    let surprise = element_surprise(rest, [F[0], F[1], F[1]], remembers, fading, h);
    let moved = || nodes.iter().map(|&n| x1[n as usize] - x0[n as usize]);
    let count = nodes.len() as f64;
    let mean = moved().sum::<Vec3>() / count;
    let apart: f64 = moved().map(|d| (d - mean).norm_squared()).sum();
    let inertia = 0.5 * rest.density * apart / (count * h * h);
    surprise <= inertia
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flesh::element::tests::{REST, rest_of};
    use crate::flesh::{PAIRS, Response, respond};
    use crate::random::Random;

    /// `ψ(x₁) - ψ(x₀) - ∇ψ·Δx - Δxᵀ K Δx` of what an element tells of itself before and after.
    fn by_blocks(before: &Response, risen: f64, d: &[Vec3; 4]) -> f64 {
        let pulled: f64 = before.forces.iter().zip(d).map(|(f, d)| f.dot(d)).sum();
        let curved: f64 = (before.stiffness.iter().zip(PAIRS))
            .map(|(K, (a, b))| d[a].dot(&(K * d[b])) * if a == b { 1.0 } else { 2.0 })
            .sum();
        risen + pulled - curved
    }

    #[test]
    fn surprise_is_against_the_forces_and_the_stiffness_of_the_step() {
        let (rest, mut random) = (rest_of(Law::Corotational), Random::new(11));
        let mut largest = 0.0_f64;
        for _ in 0..100 {
            let x = REST.map(|x| x + random.vector(0.003));
            let d = REST.map(|_| random.vector(0.004));
            let end: [Vec3; 4] = std::array::from_fn(|a| x[a] + d[a]);
            let [before, after] = [respond(&rest, &x), respond(&rest, &end)];
            let F = [x, end, end].map(|x| rest.deformation_gradient(&x));
            let got = rest.volume * element_surprise(&rest, F, None, &mut Fading::none(0.01), 0.01);
            let expected = by_blocks(&before, after.energy - before.energy, &d);
            assert!((got - expected).abs() < 1e-9 * after.energy, "{got} J, {expected} J");
            largest = largest.max(got.abs() / after.energy);
        }
        assert!(largest > 0.1, "the motions are too small to tell: {largest}");
    }

    /// A body that is turned as a whole is not strained; one that goes straight on is drawn out,
    /// and nothing foresaw it.
    #[test]
    fn turning_on_straight_ways_is_a_surprise() {
        let (rest, angle) = (rest_of(Law::Corotational), 0.3_f64);
        let turned =
            Mat3::new(angle.cos(), -angle.sin(), 0.0, angle.sin(), angle.cos(), 0.0, 0.0, 0.0, 1.0);
        let straight =
            Mat3::identity() + Mat3::new(0.0, -angle, 0.0, angle, 0.0, 0.0, 0.0, 0.0, 0.0);
        let surprise = |F: Mat3, way: Mat3| {
            let start = Mat3::identity();
            warped_surprise(&rest, [start, F], &(way - start))
        };
        // Both axes of the plane are drawn out by √(1 + θ²).
        let strain = (1.0 + angle * angle).sqrt() - 1.0;
        let stored = (2.0 * rest.mu + 2.0 * rest.lambda) * strain * strain;
        let drawn = surprise(straight, straight);
        assert!((drawn - stored).abs() < 1e-9 * stored, "{drawn}");
        // Nodes that go round store nothing, and the work of their velocities is none.
        assert!(surprise(turned, straight).abs() < 1e-9 * stored, "{}", surprise(turned, straight));
        // Taken for the way of the velocities, the turn would bend inwards, and hide as much of
        // what others gain.
        assert!(surprise(turned, turned) < -0.1 * stored, "{}", surprise(turned, turned));
    }
}
