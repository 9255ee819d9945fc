//! Eight corotational patches at once, as `flesh/eight.rs` does with tetrahedra.
//!
//! With the mean gradients in the present frame, `ḡ' = R ḡ`, the stiffness between two nodes is
//! `V (λ ḡ'_a ḡ'_bᵀ + μ ḡ'_b ḡ'_aᵀ) + s_ab I`, where `s_ab`, shear and spread together, never
//! changes.

use crate::flesh::Tally;
use crate::flesh::eight::{dealt, inner};
use crate::flesh::lanes::{Mat3x8, entries, times};
use crate::flesh::rotations::rotations;
use crate::math::Vec3;
use crate::math::lanes::{LANES, Vec3x8, dot, three};
use crate::solver::BlockMatrix;
use fearless_simd::{Simd, f64x8, prelude::*};

/// Nodes of an octahedron, the most that a patch in lanes has.
pub const NODES: usize = 6;

type Numbers = [f64; LANES];

/// Eight patches; the last is repeated where there are fewer, and a patch's first node where it has
/// fewer than six, without weight.
#[derive(Clone, Debug)]
pub struct PatchLanes {
    /// Number of patches.
    pub count: usize,
    /// Number of nodes of each.
    pub sizes: [usize; LANES],
    /// Nodes of each.
    pub nodes: [[u32; NODES]; LANES],
    /// ḡ of each node \[1/m\].
    pub gradients: [[Numbers; 3]; NODES],
    /// Spread between two nodes \[N/m\].
    pub spread: [[Numbers; NODES]; NODES],
    /// `V μ ḡ_a·ḡ_b` and spread, pair by pair \[N/m\].
    pub diagonal: [[[f64; NODES]; NODES]; LANES],
    /// Rest volume \[m³\].
    pub volume: Numbers,
    /// First Lamé parameter \[Pa\].
    pub lambda: Numbers,
    /// Shear modulus \[Pa\].
    pub mu: Numbers,
    /// Stiffness-proportional damping \[s\].
    pub damping: Numbers,
    /// Least `V_e c_e` of the patch's tetrahedra \[J\].
    pub spread_least: Numbers,
    /// Number of each patch.
    pub patches: [usize; LANES],
}

struct Evaluation<S: Simd> {
    /// `R ḡ_a`.
    gradients: [Vec3x8<S>; NODES],
    /// On each node \[N\].
    forces: [Vec3x8<S>; NODES],
    energy: f64x8<S>,
    /// At most how far the deformation gradient of any tetrahedron is from a rotation (Frobenius).
    strain_most: f64x8<S>,
}

impl PatchLanes {
    /// Adds energies; calls `crushed` with the numbers of the patches of which a tetrahedron may be
    /// inverted: a matrix nearer to a rotation than 1 is none that inverts.
    #[inline(always)]
    pub fn tally<S: Simd>(
        &self,
        simd: S,
        x: &[Vec3],
        sums: &mut Tally,
        crushed: impl FnMut(usize, &mut Tally),
    ) {
        self.count(&self.evaluate(simd, x), sums, crushed);
    }

    #[inline(always)]
    fn count<S: Simd>(
        &self,
        at: &Evaluation<S>,
        sums: &mut Tally,
        mut crushed: impl FnMut(usize, &mut Tally),
    ) {
        let (energy, strain) = (at.energy.to_array(), at.strain_most.to_array());
        for lane in 0..self.count {
            sums.energy += energy[lane];
            if strain[lane] >= 1.0 || strain[lane].is_nan() {
                crushed(self.patches[lane], sums);
            }
        }
    }

    #[inline(always)]
    fn evaluate<S: Simd>(&self, simd: S, x: &[Vec3]) -> Evaluation<S> {
        let mut arms = [[f64x8::splat(simd, 0.0); 3]; NODES];
        let mut g = arms;
        for a in 0..NODES {
            let mut at = [[0.0; LANES]; 3];
            for (lane, nodes) in self.nodes.iter().enumerate() {
                let arm = x[nodes[a] as usize] - x[nodes[0] as usize];
                (0..3).for_each(|k| at[k][lane] = arm[k]);
            }
            for k in 0..3 {
                arms[a][k] = load(simd, &at[k]);
                g[a][k] = load(simd, &self.gradients[a][k]);
            }
        }
        let F = entries(
            #[inline(always)]
            |r, c| {
                let mut sum = f64x8::splat(simd, 0.0);
                for a in 1..NODES {
                    sum = arms[a][r].mul_add(g[a][c], sum);
                }
                sum
            },
        );
        let R = rotations(simd, &F);
        let (lambda, mu, volume) =
            (load(simd, &self.lambda), load(simd, &self.mu), load(simd, &self.volume));
        let strain = entries(
            #[inline(always)]
            |r, c| F[3 * c + r] - R[3 * c + r],
        );
        let trace = inner(&R, &strain);
        let size2 = inner(&strain, &strain);
        let (shear, bulk) = (mu * volume * -2.0, lambda * trace * volume * -1.0);
        let P: Mat3x8<S> = entries(
            #[inline(always)]
            |r, c| shear.mul_add(strain[3 * c + r], bulk * R[3 * c + r]),
        );
        let mut forces = arms;
        let mut gradients = arms;
        let mut spread = f64x8::splat(simd, 0.0);
        for a in 0..NODES {
            let mut pull = [f64x8::splat(simd, 0.0); 3];
            for b in 1..NODES {
                let s = load(simd, &self.spread[a][b]);
                for k in 0..3 {
                    pull[k] = s.mul_add(arms[b][k], pull[k]);
                }
            }
            spread += dot(&pull, &arms[a]);
            let f = times(&P, &g[a]);
            forces[a] = three(
                #[inline(always)]
                |k| f[k] - pull[k],
            );
            gradients[a] = times(&R, &g[a]);
        }
        let apart = (spread.max(f64x8::splat(simd, 0.0)) / load(simd, &self.spread_least)).sqrt();
        Evaluation {
            gradients,
            forces,
            energy: volume.mul_add(mu.mul_add(size2, lambda * 0.5 * trace * trace), spread * 0.5),
            strain_most: size2.sqrt() + apart,
        }
    }

    /// Adds `(h² + h β) K` to `A` and `h F` to the nodal `b`, patch after patch; `places` has the
    /// rows of blocks of each patch in turn.
    #[inline(always)]
    pub fn assemble<'a, S: Simd>(
        &self,
        simd: S,
        places: impl Fn(usize) -> &'a [u32],
        x: &[Vec3],
        h: f64,
        A: &mut BlockMatrix,
        b: &mut [Vec3],
        sums: &mut Tally,
        crushed: impl FnMut(usize, &mut Tally),
    ) {
        let at = self.evaluate(simd, x);
        self.count(&at, sums, crushed);
        let damping = f64x8::load_array_ref(simd, &self.damping);
        let scale = (damping + h) * h;
        let volume = f64x8::load_array_ref(simd, &self.volume) * scale;
        let lambda = f64x8::load_array_ref(simd, &self.lambda) * volume;
        let mu = f64x8::load_array_ref(simd, &self.mu) * volume;

        // As in `eight::assemble`: a block is its first eight numbers, column by column, and its
        // last.
        let (g, f) = (&at.gradients, &at.forces);
        let mut down = [[[0.0; LANES]; LANES]; NODES];
        let mut across = [[[0.0; LANES]; LANES]; NODES];
        for (a, g) in g.iter().enumerate() {
            down[a] = dealt(simd, [g[0], g[1], g[2], g[0], g[1], g[2], g[0], g[1]]);
            across[a] = dealt(simd, [g[0], g[0], g[0], g[1], g[1], g[1], g[2], g[2]]);
        }
        let others = dealt(simd, [lambda, mu, scale, scale, scale, scale, scale, scale]);
        let lasts = dealt(simd, [g[0][2], g[1][2], g[2][2], g[3][2], g[4][2], g[5][2], mu, mu]);
        let halves = [
            dealt(simd, [f[0][0], f[0][1], f[0][2], f[1][0], f[1][1], f[1][2], mu, mu]),
            dealt(simd, [f[2][0], f[2][1], f[2][2], f[3][0], f[3][1], f[3][2], mu, mu]),
            dealt(simd, [f[4][0], f[4][1], f[4][2], f[5][0], f[5][1], f[5][2], mu, mu]),
        ];
        let ones = f64x8::load_array(simd, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        for lane in 0..self.count {
            let size = self.sizes[lane];
            let places = places(self.patches[lane]);
            let (lambda, mu, scale) = (others[lane][0], others[lane][1], others[lane][2]);
            let (z, both) = (&lasts[lane], lambda + mu);
            for a in 0..size {
                let down_a = f64x8::load_array_ref(simd, &down[a][lane]) * lambda;
                let across_a = f64x8::load_array_ref(simd, &across[a][lane]) * mu;
                for c in 0..size {
                    let s = self.diagonal[lane][a][c] * scale;
                    let down_c = f64x8::load_array_ref(simd, &down[c][lane]);
                    let across_c = f64x8::load_array_ref(simd, &across[c][lane]);
                    let first = down_a.mul_add(across_c, down_c.mul_add(across_a, ones * s));
                    A.add_lanes(simd, places[a * size + c], first, both * z[a] * z[c] + s);
                }
            }
            for a in 0..size {
                let f = &halves[a / 2][lane][3 * (a % 2)..];
                b[self.nodes[lane][a] as usize] += Vec3::new(f[0], f[1], f[2]) * h;
            }
        }
    }
}

#[inline(always)]
fn load<S: Simd>(simd: S, numbers: &Numbers) -> f64x8<S> {
    f64x8::load_array_ref(simd, numbers)
}
