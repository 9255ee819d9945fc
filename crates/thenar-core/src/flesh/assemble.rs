//! Eq. 5: `A_f = M_f + Δt D_f + Δt² K_f` and `b_f = M_f v_0 + Δt F_f`, over all deformable bodies.

use crate::flesh::lanes::{Kind, RestLanes};
use crate::flesh::living::Living;
use crate::flesh::memory::{self, Faded, Fading, MemoryModel};
use crate::flesh::{
    Membranes, PAIRS, Patches, Response, RestTet, eight, eight_principal, foresight, respond,
};
use crate::math::Vec3;
use crate::math::lanes::LANES;
use crate::solver::BlockMatrix;
use fearless_simd::{Level, Simd, dispatch};
use std::ops::Range;

/// Elements and masses of all deformable bodies, nodes numbered through.
#[derive(Clone, Debug, Default)]
pub struct FleshModel {
    /// Nodes of each element.
    pub tets: Vec<[u32; 4]>,
    /// Rest shape and material of each element.
    pub rest: Vec<RestTet>,
    /// Stiffness-proportional damping of each element \[s\].
    pub stiffness_damping: Vec<f64>,
    /// Places of each element's 4×4 blocks in the system matrix.
    pub entries: Vec<[[u32; 4]; 4]>,
    /// Lumped mass of each node \[kg\].
    pub mass: Vec<f64>,
    /// Mass-proportional damping of each node \[1/s\].
    pub mass_damping: Vec<f64>,
    /// Elements evaluated by patches, of which none is in `lanes`.
    pub patches: Patches,
    /// Tetrahedra of bodies that have patches.
    pub patched: Vec<Range<usize>>,
    /// Skin of all bodies.
    pub membranes: Membranes,
    /// Memory of the elements' stress; of a patch, its first tetrahedron for all.
    pub memory: MemoryModel,
    /// True when there are elements whose steps are looked at (`foresight`).
    pub(crate) asks_foresight: bool,
    /// Tetrahedra of bodies without patches, as [`FleshModel::arrange`] leaves them.
    pub(super) single: Vec<Range<usize>>,
    /// Tetrahedra of bodies without patches by eights, each with the number of its first.
    lanes: Vec<(usize, RestLanes)>,
}

/// Sums over elements.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Elastic energy \[J\].
    pub energy: f64,
    /// Elements of negative volume.
    pub inverted: u32,
}

impl FleshModel {
    /// Adds the flesh to `A` and `b`; `row0` is the block row of node 0, `x` and `v` are nodal,
    /// `faded` is what elements with memory remember.
    pub fn assemble(
        &self,
        x: &[Vec3],
        v: &[Vec3],
        faded: &[Faded],
        h: f64,
        row0: usize,
        A: &mut BlockMatrix,
        b: &mut [Vec3],
    ) -> Tally {
        debug_assert_eq!([x.len(), v.len()], [self.mass.len(); 2], "places and rates, of nodes");
        debug_assert_eq!(
            b.len(),
            row0 + self.mass.len(),
            "right-hand sides, rows to the last node"
        );
        debug_assert_eq!(faded.len(), self.memory.len(), "faded stresses, elements with memory");
        debug_assert!(h > 0.0 && h.is_finite(), "a time step of {h} s");
        for (n, &mass) in self.mass.iter().enumerate() {
            A.add_scalar(A.diagonal[row0 + n], mass * (1.0 + h * self.mass_damping[n]));
            b[row0 + n] += v[n] * mass;
        }
        let mut sums = Tally::default();
        let b = &mut b[row0..];
        dispatch!(Level::new(), simd => {
            self.add_elements(simd, x, faded, h, A, b, &mut sums);
            self.patches.assemble(simd, x, &self.memory, faded, h, A, b, &mut sums);
        });
        self.resist_crushing(x, h, A, b, &mut sums);
        self.stretch_skin(x, h, A, b, &mut sums);
        sums
    }

    /// Elastic energy \[J\] (of elements with memory, what they can give back) and inverted
    /// elements at these positions.
    pub fn tally(&self, x: &[Vec3], faded: &[Faded]) -> Tally {
        let mut sums = Tally::default();
        dispatch!(Level::new(), simd => {
            for (first, rest) in &self.lanes {
                match rest.kind {
                    Kind::Corotational => eight::tally(simd, rest, x, &mut sums),
                    Kind::Apart => {
                        each(*first, rest).for_each(|t| self.count(t, x, faded, &mut sums));
                    }
                    _ => eight_principal::tally(simd, rest, x, &mut sums),
                }
            }
            self.patches.tally(simd, x, &self.memory, faded, &mut sums);
        });
        sums.energy += self.crush_energy(x);
        sums.energy += self.skin_energy(x);
        sums
    }

    /// Moves what elements remember over a step of length `h` \[s\] from positions `x0` to `x1`.
    pub fn relax(&self, x0: &[Vec3], x1: &[Vec3], h: f64, faded: &mut [Faded]) {
        debug_assert_eq!([x0.len(), x1.len()], [self.mass.len(); 2], "places at either end, nodes");
        debug_assert_eq!(faded.len(), self.memory.len(), "faded stresses, elements with memory");
        if self.memory.is_empty() {
            return;
        }
        let mut fading = Fading::none(h);
        self.patches.relax(&self.memory, x0, x1, &mut fading, h, faded);
        for t in self.single.iter().cloned().flatten() {
            let Some((relaxation, place)) = self.memory.of(t) else { continue };
            let (rest, tet) = (&self.rest[t], &self.tets[t]);
            let fading = fading.of(relaxation, rest.law, h);
            let [before, after] = [x0, x1].map(|x| memory::stress_at(rest, tet, x, &fading.living));
            fading.remember(rest.mu, &mut faded[place], &before, &after);
        }
    }

    /// Lays the elements out for evaluation by eights; to be called when they are complete.
    pub fn arrange(&mut self) {
        self.memory.arrange(self.tets.len());
        self.asks_foresight = self.rest.iter().any(foresight::asked) || !self.membranes.is_empty();
        self.patches.arrange(&self.memory);
        self.single = singles(self.tets.len(), &self.patched);
        let eights = self.single.iter().cloned().flat_map(|range| {
            let end = range.end;
            range.step_by(LANES).map(move |first| first..(first + LANES).min(end))
        });
        self.lanes = eights
            .map(|t| {
                let damping = &self.stiffness_damping[t.clone()];
                let alone = self.memory.any(t.clone());
                (t.start, RestLanes::new(&self.tets[t.clone()], &self.rest[t], damping, alone))
            })
            .collect();
    }

    #[inline(always)]
    fn add_elements<S: Simd>(
        &self,
        simd: S,
        x: &[Vec3],
        faded: &[Faded],
        h: f64,
        A: &mut BlockMatrix,
        b: &mut [Vec3],
        sums: &mut Tally,
    ) {
        let mut fading = Fading::none(h);
        for (first, rest) in &self.lanes {
            let each = each(*first, rest);
            let places = &self.entries[each.clone()];
            match rest.kind {
                Kind::Corotational => eight::assemble(simd, rest, places, x, h, A, b, sums),
                Kind::Apart => {
                    each.for_each(|t| self.add_element(t, x, faded, &mut fading, h, A, b, sums));
                }
                _ => eight_principal::assemble(simd, rest, places, x, h, A, b, sums),
            }
        }
    }

    /// One element, whatever its law.
    #[inline(never)]
    fn add_element(
        &self,
        t: usize,
        x: &[Vec3],
        faded: &[Faded],
        fading: &mut Fading,
        h: f64,
        A: &mut BlockMatrix,
        b: &mut [Vec3],
        sums: &mut Tally,
    ) {
        let (rest, tet) = (&self.rest[t], &self.tets[t]);
        let x = tet.map(|n| x[n as usize]);
        let response = match self.memory.of(t) {
            Some((relaxation, place)) => {
                let (F, fading) =
                    (rest.deformation_gradient(&x), fading.of(relaxation, rest.law, h));
                memory::respond(rest, &F, relaxation, fading, &faded[place])
            }
            None => respond(rest, &x),
        };
        sums.add(&response);
        self.scatter(t, &response, h, A, b);
    }

    /// Adds an element's forces and stiffness to the system of a step.
    #[inline(always)]
    pub(super) fn scatter(
        &self,
        t: usize,
        response: &Response,
        h: f64,
        A: &mut BlockMatrix,
        b: &mut [Vec3],
    ) {
        let scale = h * h + h * self.stiffness_damping[t];
        for (&node, force) in self.tets[t].iter().zip(&response.forces) {
            b[node as usize] += force * h;
        }
        for (block, (a, c)) in response.stiffness.iter().zip(PAIRS) {
            let block = block * scale;
            A.add(self.entries[t][a][c], &block);
            if a != c {
                A.add(self.entries[t][c][a], &block.transpose());
            }
        }
    }

    /// Energy and volume of one element, whatever its law.
    fn count(&self, t: usize, x: &[Vec3], faded: &[Faded], sums: &mut Tally) {
        let rest = &self.rest[t];
        let memory = self.memory.of(t);
        let living = memory.as_ref().map_or(Living::ANY, |_| Living::of(rest.law));
        let at = memory::stress_at(rest, &self.tets[t], x, &living);
        sums.energy += rest.volume
            * match memory {
                Some((relaxation, place)) => memory::energy(rest, relaxation, &at, &faded[place]),
                None => at.energy,
            };
        let F = rest.gradient_at(&self.tets[t], x);
        sums.inverted += u32::from(F.determinant() < 0.0);
    }
}

impl Tally {
    fn add(&mut self, response: &Response) {
        self.energy += response.energy;
        self.inverted += u32::from(response.inverted);
    }
}

/// Elements of an eight.
fn each(first: usize, rest: &RestLanes) -> Range<usize> {
    first..first + rest.count
}

/// The parts of `0..count` outside these ranges, which ascend.
fn singles(count: usize, patched: &[Range<usize>]) -> Vec<Range<usize>> {
    let starts = std::iter::once(0).chain(patched.iter().map(|range| range.end));
    let ends = patched.iter().map(|range| range.start).chain([count]);
    starts.zip(ends).map(|(start, end)| start..end).filter(|range| !range.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flesh::crush;
    use crate::math::Mat3;
    use crate::model::{Law, Material};
    use crate::random::Random;

    #[test]
    fn eights_sum_to_the_same_as_single_elements() {
        let ogden = Law::Ogden { alpha: 7.3 };
        let laws = [Law::Corotational, Law::StableNeoHookean, ogden];
        let inverted: u32 = (41..61).map(|seed| check_eights(seed, &laws, 0.004, 1e-12)).sum();
        assert!(inverted > 30, "{inverted} of 700");
        let law = [Law::NeoHookean];
        (61..71).for_each(|seed| {
            check_eights(seed, &law, 0.001, 1e-12);
        });
        // The stiffness of inverted elements of this law grows without bound where two stretches
        // cancel, and round-off with it: of these only forces, energy and count are compared.
        (71..81).for_each(|seed| {
            check_eights(seed, &law, 0.004, f64::INFINITY);
        });
    }

    /// Thirty-five elements around eight nodes, eights of each law and three of several, deformed
    /// at random by so much \[m\], so that some may be inverted: eight at a time they make what
    /// they make one by one, the blocks within `tolerance` of the largest. Returns how many are
    /// inverted.
    fn check_eights(seed: u64, laws: &[Law], moved: f64, tolerance: f64) -> u32 {
        let mut random = Random::new(seed);
        let corner =
            |i: usize| Vec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64) * 0.01;
        let nodes: Vec<Vec3> = (0..8).map(|i| corner(i) + random.vector(0.002)).collect();
        let mut model = FleshModel { mass: vec![1e-3; 8], ..FleshModel::default() };
        model.mass_damping = vec![2.0; 8];
        while model.tets.len() < 35 {
            let tet: [u32; 4] = std::array::from_fn(|_| random.below(8) as u32);
            let t = model.tets.len();
            let law = laws[if t < 32 { t / 8 } else { t } % laws.len()];
            let material = Material { law, young: 5e4, poisson: 0.43, density: 1000.0 };
            let rest = RestTet::new(&tet.map(|n| nodes[n as usize]), &material);
            if let Some(rest) = rest.filter(|rest| rest.volume > 5e-8) {
                model.stiffness_damping.push(1e-3 * model.tets.len() as f64);
                model.tets.push(tet);
                model.rest.push(rest);
            }
        }
        let all = (0..8).flat_map(|i| (0..i).map(move |j| (i, j)));
        let mut A = BlockMatrix::with_pattern(8, all);
        model.entries = model.tets.iter().map(|t| t.map(|a| t.map(|c| A.entry(a, c)))).collect();
        model.arrange();

        let h = 0.005;
        let x: Vec<Vec3> = nodes.iter().map(|x| x + random.vector(moved)).collect();
        let v: Vec<Vec3> = nodes.iter().map(|_| random.vector(0.1)).collect();
        let mut b = vec![Vec3::zeros(); 8];
        let sums = model.assemble(&x, &v, &[], h, 0, &mut A, &mut b);

        let mut want = vec![Mat3::zeros(); 64];
        let mut forces: Vec<Vec3> = v.iter().map(|v| v * 1e-3).collect();
        (0..8).for_each(|n| want[9 * n].fill_diagonal(1e-3 * (1.0 + 2.0 * h)));
        let (mut energy, mut inverted) = (0.0, 0);
        for (t, tet) in model.tets.iter().enumerate() {
            let law = respond(&model.rest[t], &tet.map(|n| x[n as usize]));
            inverted += u32::from(law.inverted);
            let crushed = crush::response(&model.rest[t], tet, &x);
            let tet = tet.map(|n| n as usize);
            let scale = h * h + h * model.stiffness_damping[t];
            for response in std::iter::once(law).chain(crushed) {
                (0..4).for_each(|a| forces[tet[a]] += response.forces[a] * h);
                for (block, (a, c)) in response.stiffness.iter().zip(PAIRS) {
                    want[8 * tet[a] + tet[c]] += block * scale;
                    if a != c {
                        want[8 * tet[c] + tet[a]] += block.transpose() * scale;
                    }
                }
                energy += response.energy;
            }
        }
        let size = want.iter().map(|m| m.norm()).fold(0.0, f64::max);
        for i in 0..8 {
            for j in 0..8 {
                let block = A.get(A.entry(i, j));
                let error = (block - want[8 * i as usize + j as usize]).norm();
                assert!(error < tolerance * size, "{i} {j}: {error} of {size}");
            }
            let (force, got) = (forces[i as usize], b[i as usize]);
            assert!((force - got).norm() < 1e-11 * force.norm().max(1e-6));
        }
        assert_eq!(sums.inverted, inverted);
        assert!((sums.energy - energy).abs() < 1e-11 * energy);
        assert!((model.tally(&x, &[]).energy - energy).abs() < 1e-11 * energy);
        inverted
    }
}
