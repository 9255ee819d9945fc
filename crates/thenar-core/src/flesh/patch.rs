//! Patches of tetrahedra that share one evaluation of their law.
//!
//! Linear tetrahedra lock: each is asked to keep its volume, and bends as if it were far stiffer. A
//! patch is asked once for all its tetrahedra, at their mean deformation gradient
//! `F̄ = Σ_e w_e F_e = Σ_a x_a ⊗ ḡ_a`, and what they deviate from it costs little:
//!
//! ```text
//!   E = V ψ(F̄) + ½ Σ_e V_e c_e |F_e − F̄|²,   c_e = SPREAD × Young's modulus of e
//! ```
//!
//! The first term is a tetrahedron's with more nodes, the second a constant quadratic form with one
//! number per pair of nodes. Neither changes when the patch turns, both have positive semi-definite
//! stiffness, and rigid motions are the only ones that cost nothing. The weights w_e are the
//! elements' shares of the patch's shear stiffness, so that elements the body fills in part count
//! in part.
//!
//! A patch has one memory, of its mean stress. What its elements deviate by is elastic: its modulus
//! is then that which stays for ever, `g∞ E`, so that relaxed tissue is not held by it.

use crate::flesh::element::{Response, stress};
use crate::flesh::foresight::{asked, element_foresaw, element_surprise, is_seen};
use crate::flesh::living::Living;
use crate::flesh::memory::{self, Faded, Fading, MemoryModel};
use crate::flesh::patch_lanes::{self, PatchLanes};
use crate::flesh::{PAIRS, RestTet, Tally, respond};
use crate::math::lanes::LANES;
use crate::math::{Mat3, Vec3};
use crate::model::{Law, Relaxation};
use crate::solver::BlockMatrix;
use fearless_simd::Simd;
use std::ops::Range;

/// Stiffness against what elements deviate from their patch's mean, relative to Young's modulus.
/// Measured on the bars of `tests/all/flesh/element_patches.rs`: three cubes thick they are 3 to 8
/// % stiffer than refined ones. Twice as much adds 1 to 2 %, two fifths of it take 1 % away, and
/// nothing else holds the elements of a patch in shape.
pub const SPREAD: f64 = 0.05;

/// All patches, nodes numbered through all deformable bodies.
#[derive(Clone, Debug, Default)]
pub struct Patches {
    list: Vec<Patch>,
    /// Nodes of one patch after the other.
    nodes: Vec<u32>,
    /// ḡ of each of these nodes \[1/m\].
    gradients: Vec<Vec3>,
    /// For each patch the quadratic form of its spread, row by row \[N/m\].
    spread: Vec<f64>,
    /// For each patch the places of its blocks in the system matrix, row by row.
    entries: Vec<u32>,
    /// Tetrahedra of one patch after the other.
    tets: Vec<[u32; 4]>,
    /// Corotational patches by eights, as [`Patches::arrange`] leaves them.
    lanes: Vec<PatchLanes>,
    /// The others.
    single: Vec<usize>,
}

#[derive(Clone, Debug)]
struct Patch {
    /// The first tetrahedron, which has the memory of all.
    first: usize,
    /// Volume and material on unit gradients: the tetrahedron (0, F̄ e₁, F̄ e₂, F̄ e₃).
    mean: RestTet,
    /// Stiffness-proportional damping \[s\].
    damping: f64,
    nodes: Range<usize>,
    /// First of its pairs in `spread` and `entries`.
    pairs: usize,
    tets: Range<usize>,
    /// Least `V_e c_e` of its tetrahedra \[J\].
    spread_least: f64,
}

/// A patch's tetrahedra: their nodes, rest shapes.
pub type Members<'a> = [([u32; 4], &'a RestTet)];

impl Patches {
    /// Adds a patch of tetrahedra that have one law and one relaxation; `tet` is the first of them.
    pub fn push(&mut self, tet: usize, members: &Members, relaxation: &Relaxation, damping: f64) {
        let spread_modulus = |rest: &RestTet| SPREAD * (1.0 - relaxation.weight()) * rest.young();
        let first = self.nodes.len();
        for node in members.iter().flat_map(|(tet, _)| tet) {
            if !self.nodes[first..].contains(node) {
                self.nodes.push(*node);
            }
        }
        let nodes = &self.nodes[first..];
        let volume: f64 = members.iter().map(|(_, rest)| rest.volume).sum();
        let mean_of = |f: &dyn Fn(&RestTet) -> f64| {
            members.iter().map(|(_, rest)| rest.volume * f(rest)).sum::<f64>() / volume
        };
        let (lambda, mu) = (mean_of(&|rest| rest.lambda), mean_of(&|rest| rest.mu));
        let weight = |rest: &RestTet| rest.volume * rest.mu / (volume * mu);
        // Gradient of node a in element e, zero where it is none of its corners.
        let gradient = |(tet, rest): &([u32; 4], &RestTet), node: u32| {
            tet.iter().position(|&n| n == node).map_or(Vec3::zeros(), |k| rest.gradients[k])
        };
        let mean: Vec<Vec3> = (nodes.iter())
            .map(|&n| members.iter().map(|m| gradient(m, n) * weight(m.1)).sum())
            .collect();
        let pairs = self.spread.len();
        for (&a, mean_a) in nodes.iter().zip(&mean) {
            for (&b, mean_b) in nodes.iter().zip(&mean) {
                let of = |m: &([u32; 4], &RestTet)| {
                    let deviation = (gradient(m, a) - mean_a).dot(&(gradient(m, b) - mean_b));
                    spread_modulus(m.1) * m.1.volume * deviation
                };
                self.spread.push(members.iter().map(of).sum());
            }
        }
        let tets = self.tets.len()..self.tets.len() + members.len();
        self.tets.extend(members.iter().map(|(tet, _)| *tet));
        self.gradients.extend(mean);
        let unit = [Vec3::repeat(-1.0), Vec3::x(), Vec3::y(), Vec3::z()];
        let law = members[0].1.law;
        let density = mean_of(&|rest| rest.density);
        self.list.push(Patch {
            first: tet,
            mean: RestTet { volume, gradients: unit, lambda, mu, law, density },
            damping,
            nodes: first..self.nodes.len(),
            pairs,
            tets,
            spread_least: (members.iter())
                .map(|(_, rest)| spread_modulus(rest) * rest.volume)
                .fold(f64::INFINITY, f64::min),
        });
    }

    /// Pairs of nodes that share a patch.
    pub fn pairs(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.list.iter().flat_map(|patch| {
            let nodes = &self.nodes[patch.nodes.clone()];
            nodes.iter().enumerate().flat_map(|(k, &a)| nodes[..k].iter().map(move |&b| (a, b)))
        })
    }

    /// Remembers where the blocks of node pairs lie in the system matrix.
    pub fn lay_out(&mut self, entry: impl Fn(u32, u32) -> u32) {
        self.entries.clear();
        for patch in &self.list {
            let nodes = &self.nodes[patch.nodes.clone()];
            let of = |&a: &u32| nodes.iter().map(move |&b| (a, b));
            self.entries.extend(nodes.iter().flat_map(of).map(|(a, b)| entry(a, b)));
        }
    }

    /// Lays the patches out for evaluation by eights; to be called when they are complete.
    pub fn arrange(&mut self, memory: &MemoryModel) {
        let fits = |p: &usize| {
            let Patch { first, mean, nodes, .. } = &self.list[*p];
            let elastic = memory.of(*first).is_none();
            elastic && mean.law == Law::Corotational && nodes.len() <= patch_lanes::NODES
        };
        let (fit, single): (Vec<usize>, Vec<usize>) = (0..self.list.len()).partition(fits);
        self.lanes = fit.chunks(LANES).map(|eight| self.eight(eight)).collect();
        self.single = single;
    }

    /// Adds `(h² + h β) K` to `A` and `h F` to the nodal `b`.
    #[inline(always)]
    pub fn assemble<S: Simd>(
        &self,
        simd: S,
        x: &[Vec3],
        memory: &MemoryModel,
        faded: &[Faded],
        h: f64,
        A: &mut BlockMatrix,
        b: &mut [Vec3],
        sums: &mut Tally,
    ) {
        for lanes in &self.lanes {
            let places = |p: usize| {
                let Patch { pairs, nodes, .. } = &self.list[p];
                &self.entries[*pairs..pairs + nodes.len() * nodes.len()]
            };
            let crushed = |p: usize, sums: &mut Tally| self.count_inverted(&self.list[p], x, sums);
            lanes.assemble(simd, places, x, h, A, b, sums, crushed);
        }
        let mut fading = Fading::none(h);
        for patch in self.single.iter().map(|&p| &self.list[p]) {
            let F = self.mean_gradient(patch, x);
            let response = match memory.of(patch.first) {
                Some((of, place)) => {
                    let fading = fading.of(of, patch.mean.law, h);
                    memory::respond(&patch.mean, &F, of, fading, &faded[place])
                }
                None => respond(&patch.mean, &corners(&F)),
            };
            self.add(patch, &response, x, h, A, b, sums);
        }
    }

    /// Moves what patches remember over a step of length `h` \[s\] from positions `x0` to `x1`.
    pub fn relax(
        &self,
        memory: &MemoryModel,
        x0: &[Vec3],
        x1: &[Vec3],
        fading: &mut Fading,
        h: f64,
        faded: &mut [Faded],
    ) {
        for patch in &self.list {
            let Some((relaxation, place)) = memory.of(patch.first) else { continue };
            let fading = fading.of(relaxation, patch.mean.law, h);
            let [before, after] = [x0, x1]
                .map(|x| stress(&patch.mean, &self.mean_gradient(patch, x), &fading.living));
            fading.remember(patch.mean.mu, &mut faded[place], &before, &after);
        }
    }

    /// `FleshModel::foresaw` of the patches among these tetrahedra.
    pub fn foresaw(
        &self,
        memory: &MemoryModel,
        faded: &[Faded],
        tets: &Range<usize>,
        x0: &[Vec3],
        x1: &[Vec3],
        fading: &mut Fading,
        h: f64,
    ) -> bool {
        let mut all = self.list.iter().filter(|p| tets.contains(&p.first) && asked(&p.mean));
        all.all(|patch| {
            let F = [x0, x1].map(|x| self.mean_gradient(patch, x));
            let nodes = &self.nodes[patch.nodes.clone()];
            let remembers = memory.of(patch.first).map(|(of, place)| (of, &faded[place]));
            element_foresaw(&patch.mean, F, remembers, fading, (nodes, x0, x1), h)
        })
    }

    /// `FleshModel::surprise` of the laws of patches among these tetrahedra \[J\]; their spread is
    /// foreseen.
    pub fn surprise(
        &self,
        memory: &MemoryModel,
        faded: &[Faded],
        tets: &Range<usize>,
        x: [&[Vec3]; 3],
        fading: &mut Fading,
        h: f64,
    ) -> f64 {
        let asked = |p: &&Patch| tets.contains(&p.first) && p.mean.law == Law::Corotational;
        let each = self.list.iter().filter(asked).map(|patch| {
            let [before, after] =
                [self.mean_gradient(patch, x[0]), self.mean_gradient(patch, x[1])];
            if !is_seen(&before, &after) {
                return 0.0;
            }
            let F = [before, after, self.mean_gradient(patch, x[2])];
            let remembers = memory.of(patch.first).map(|(of, place)| (of, &faded[place]));
            patch.mean.volume * element_surprise(&patch.mean, F, remembers, fading, h)
        });
        each.sum()
    }

    /// Adds energies and counts inverted tetrahedra.
    #[inline(always)]
    pub fn tally<S: Simd>(
        &self,
        simd: S,
        x: &[Vec3],
        memory: &MemoryModel,
        faded: &[Faded],
        sums: &mut Tally,
    ) {
        for lanes in &self.lanes {
            let crushed = |p: usize, sums: &mut Tally| self.count_inverted(&self.list[p], x, sums);
            lanes.tally(simd, x, sums, crushed);
        }
        for patch in self.single.iter().map(|&p| &self.list[p]) {
            let memory = memory.of(patch.first);
            let living = memory.as_ref().map_or(Living::ANY, |_| Living::of(patch.mean.law));
            let at = stress(&patch.mean, &self.mean_gradient(patch, x), &living);
            let energy = match memory {
                Some((of, place)) => memory::energy(&patch.mean, of, &at, &faded[place]),
                None => at.energy,
            };
            sums.energy += patch.mean.volume * energy;
            self.tally_spread(patch, x, sums);
        }
    }

    /// Adds the energy of the spread and counts inverted tetrahedra.
    fn tally_spread(&self, patch: &Patch, x: &[Vec3], sums: &mut Tally) {
        let nodes = &self.nodes[patch.nodes.clone()];
        let x0 = x[nodes[0] as usize];
        for (a, row) in nodes.iter().zip(self.spread_rows(patch)) {
            let pull = self.spread_force(nodes, row, x, &x0);
            sums.energy += 0.5 * pull.dot(&(x[*a as usize] - x0));
        }
        self.count_inverted(patch, x, sums);
    }

    fn eight(&self, patches: &[usize]) -> PatchLanes {
        let of = |lane: usize| patches[lane.min(patches.len() - 1)];
        let patch = |lane: usize| &self.list[of(lane)];
        let number = |f: &dyn Fn(&Patch) -> f64| std::array::from_fn(|lane| f(patch(lane)));
        // Beyond the last node of a patch: its first, without weight.
        let node = |lane: usize, a: usize| Some(a).filter(|&a| a < patch(lane).nodes.len());
        let gradient = |lane: usize, a: usize| {
            node(lane, a).map_or(Vec3::zeros(), |a| self.gradients[patch(lane).nodes.start + a])
        };
        let spread = |lane: usize, a: usize, b: usize| {
            let Patch { pairs, nodes, .. } = patch(lane);
            let pair = node(lane, a).zip(node(lane, b));
            pair.map_or(0.0, |(a, b)| self.spread[pairs + a * nodes.len() + b])
        };
        let shear = |lane: usize, a: usize, b: usize| {
            let RestTet { volume, mu, .. } = &patch(lane).mean;
            volume * mu * gradient(lane, a).dot(&gradient(lane, b))
        };
        use std::array::from_fn;
        PatchLanes {
            count: patches.len(),
            sizes: from_fn(|lane| patch(lane).nodes.len()),
            nodes: from_fn(|lane| {
                from_fn(|a| self.nodes[patch(lane).nodes.start + node(lane, a).unwrap_or(0)])
            }),
            gradients: from_fn(|a| from_fn(|k| from_fn(|lane| gradient(lane, a)[k]))),
            spread: from_fn(|a| from_fn(|b| from_fn(|lane| spread(lane, a, b)))),
            diagonal: from_fn(|lane| {
                from_fn(|a| from_fn(|b| shear(lane, a, b) + spread(lane, a, b)))
            }),
            volume: number(&|patch| patch.mean.volume),
            lambda: number(&|patch| patch.mean.lambda),
            mu: number(&|patch| patch.mean.mu),
            damping: number(&|patch| patch.damping),
            spread_least: number(&|patch| patch.spread_least),
            patches: from_fn(of),
        }
    }

    fn add(
        &self,
        patch: &Patch,
        response: &Response,
        x: &[Vec3],
        h: f64,
        A: &mut BlockMatrix,
        b: &mut [Vec3],
        sums: &mut Tally,
    ) {
        sums.energy += response.energy;
        self.count_inverted(patch, x, sums);

        let scale = h * h + h * patch.damping;
        let nodes = &self.nodes[patch.nodes.clone()];
        let gradients = &self.gradients[patch.nodes.clone()];
        let x0 = x[nodes[0] as usize];
        let [_, f1, f2, f3] = response.forces;
        let stress = Mat3::from_columns(&[f1, f2, f3]);
        let K = mean_stiffness(&response.stiffness);
        let pairs = patch.pairs..patch.pairs + nodes.len() * nodes.len();
        let rows = self.spread[pairs.clone()].chunks(nodes.len());
        let places = self.entries[pairs].chunks(nodes.len());
        for (k, (row, places)) in rows.zip(places).enumerate() {
            let pull = self.spread_force(nodes, row, x, &x0);
            sums.energy += 0.5 * pull.dot(&(x[nodes[k] as usize] - x0));
            b[nodes[k] as usize] += (stress * gradients[k] - pull) * h;
            let g = gradients[k] * scale;
            let left: [Mat3; 3] =
                std::array::from_fn(|l| K[0][l] * g[0] + K[1][l] * g[1] + K[2][l] * g[2]);
            for (l, g) in gradients.iter().enumerate() {
                let mut block = left[0] * g[0] + left[1] * g[1] + left[2] * g[2];
                (0..3).for_each(|i| block[(i, i)] += row[l] * scale);
                A.add(places[l], &block);
            }
        }
    }

    /// Mean deformation gradient F̄ of a patch.
    fn mean_gradient(&self, patch: &Patch, x: &[Vec3]) -> Mat3 {
        let nodes = &self.nodes[patch.nodes.clone()];
        let x0 = x[nodes[0] as usize];
        // Column by column, as for an element.
        let mut columns = [Vec3::zeros(); 3];
        for (n, g) in nodes.iter().zip(&self.gradients[patch.nodes.clone()]) {
            let side = x[*n as usize] - x0;
            for k in 0..3 {
                columns[k] += side * g[k];
            }
        }
        Mat3::from_columns(&columns)
    }

    fn spread_rows(&self, patch: &Patch) -> std::slice::Chunks<'_, f64> {
        let count = patch.nodes.len();
        self.spread[patch.pairs..patch.pairs + count * count].chunks(count)
    }

    /// The force by which the spread pulls a node back \[N\]; positions relative to the first node
    /// lose no digits.
    fn spread_force(&self, nodes: &[u32], row: &[f64], x: &[Vec3], x0: &Vec3) -> Vec3 {
        nodes.iter().zip(row).map(|(&n, s)| (x[n as usize] - x0) * *s).sum()
    }

    fn count_inverted(&self, patch: &Patch, x: &[Vec3], sums: &mut Tally) {
        for tet in &self.tets[patch.tets.clone()] {
            let [a, b, c, d] = tet.map(|n| x[n as usize]);
            sums.inverted += u32::from((b - a).cross(&(c - a)).dot(&(d - a)) < 0.0);
        }
    }
}

/// The corners (0, F̄ e₁, F̄ e₂, F̄ e₃).
fn corners(F: &Mat3) -> [Vec3; 4] {
    [Vec3::zeros(), F.column(0).into(), F.column(1).into(), F.column(2).into()]
}

/// The stiffness between the three corners that move with F̄, rows and columns.
fn mean_stiffness(of_pairs: &[Mat3; 10]) -> [[Mat3; 3]; 3] {
    let mut K = [[Mat3::zeros(); 3]; 3];
    for (block, (a, b)) in of_pairs.iter().zip(PAIRS) {
        if a > 0 && b > 0 {
            K[a - 1][b - 1] = *block;
            K[b - 1][a - 1] = block.transpose();
        }
    }
    K
}

#[cfg(test)]
mod tests;
