//! The corotational response of eight elements at once, and its sum into the system.

use crate::flesh::Tally;
use crate::flesh::lanes::{Mat3x8, RestLanes, cofactors, entries, times, transposed};
use crate::flesh::rotations::rotations;
use crate::math::Vec3;
use crate::math::lanes::{LANES, Vec3x8, dot, three};
use crate::solver::BlockMatrix;
use fearless_simd::{Simd, f64x8, prelude::*};

/// Gradients in the present frame, `g' = R g`, impulses and energies.
struct Evaluation<S: Simd> {
    gradients: [Vec3x8<S>; 4],
    /// `-V P g_a` \[N\].
    forces: [Vec3x8<S>; 4],
    energy: f64x8<S>,
    det: f64x8<S>,
}

/// Evaluates as `element::corotational` does, with `P = 2μ (F - R) + λ tr(S - I) R`, which needs no
/// S.
#[inline(always)]
fn evaluate<S: Simd>(simd: S, rest: &RestLanes, x: &[Vec3]) -> Evaluation<S> {
    let F = rest.deformation_gradients(simd, x);
    let R = rotations(simd, &F);
    let g = rest.gradients(simd);
    let lambda = f64x8::load_array_ref(simd, &rest.lambda);
    let mu = f64x8::load_array_ref(simd, &rest.mu);
    let volume = f64x8::load_array_ref(simd, &rest.volume);

    let strain = entries(
        #[inline(always)]
        |r, c| F[3 * c + r] - R[3 * c + r],
    );
    let trace = inner(&R, &strain);
    let size2 = inner(&strain, &strain);
    let (shear, bulk) = (mu * volume * -2.0, lambda * trace * volume * -1.0);
    let P = entries(
        #[inline(always)]
        |r, c| shear.mul_add(strain[3 * c + r], bulk * R[3 * c + r]),
    );

    let f = [times(&P, &g[0]), times(&P, &g[1]), times(&P, &g[2])];
    let g = [times(&R, &g[0]), times(&R, &g[1]), times(&R, &g[2])];
    let cof = cofactors(&F);
    Evaluation {
        gradients: [minus_sum(&g), g[0], g[1], g[2]],
        forces: [minus_sum(&f), f[0], f[1], f[2]],
        energy: volume * mu.mul_add(size2, lambda * 0.5 * trace * trace),
        det: dot(&F[0..3], &cof[0..3]),
    }
}

/// `A : B`.
#[inline(always)]
pub fn inner<S: Simd>(a: &Mat3x8<S>, b: &Mat3x8<S>) -> f64x8<S> {
    dot(&a[0..3], &b[0..3]) + dot(&a[3..6], &b[3..6]) + dot(&a[6..9], &b[6..9])
}

/// Returns the first node's value, by which the sum over all four vanishes.
#[inline(always)]
pub fn minus_sum<S: Simd>(of: &[Vec3x8<S>; 3]) -> Vec3x8<S> {
    three(
        #[inline(always)]
        |k| -(of[0][k] + of[1][k] + of[2][k]),
    )
}

impl<S: Simd> Evaluation<S> {
    /// Adds energies and counts inverted elements, lane by lane.
    #[inline(always)]
    fn count(&self, rest: &RestLanes, tally: &mut Tally) {
        let (energy, det) = (self.energy.to_array(), self.det.to_array());
        for lane in 0..rest.count {
            tally.energy += energy[lane];
            tally.inverted += u32::from(det[lane] < 0.0);
        }
    }
}

/// Adds energies and inverted elements.
#[inline(always)]
pub fn tally<S: Simd>(simd: S, rest: &RestLanes, x: &[Vec3], tally: &mut Tally) {
    evaluate(simd, rest, x).count(rest, tally);
}

/// Adds `(h² + h β) K` to `A` and `h F` to the nodal `b`. Lane after lane, so that the order of the
/// sums is that of the elements.
#[inline(always)]
pub fn assemble<S: Simd>(
    simd: S,
    rest: &RestLanes,
    places: &[[[u32; 4]; 4]],
    x: &[Vec3],
    h: f64,
    A: &mut BlockMatrix,
    b: &mut [Vec3],
    sums: &mut Tally,
) {
    let at = evaluate(simd, rest, x);
    at.count(rest, sums);
    let damping = f64x8::load_array_ref(simd, &rest.damping);
    let scale = (damping + h) * h * f64x8::load_array_ref(simd, &rest.volume);
    let lambda = f64x8::load_array_ref(simd, &rest.lambda) * scale;
    let mu = f64x8::load_array_ref(simd, &rest.mu) * scale;

    // A block is kept as its first eight numbers, column by column, and its last. In these eight
    // places g_a is needed as xyzxyzxy and g_b as xxxyyyzz.
    let g = &at.gradients;
    let mut down = [[[0.0; LANES]; LANES]; 4];
    let mut across = [[[0.0; LANES]; LANES]; 4];
    for (a, g) in g.iter().enumerate() {
        down[a] = dealt(simd, [g[0], g[1], g[2], g[0], g[1], g[2], g[0], g[1]]);
        across[a] = dealt(simd, [g[0], g[0], g[0], g[1], g[1], g[1], g[2], g[2]]);
    }
    let [s01, s02, s03] = [mu * dot(&g[0], &g[1]), mu * dot(&g[0], &g[2]), mu * dot(&g[0], &g[3])];
    let [s12, s13, s23] = [mu * dot(&g[1], &g[2]), mu * dot(&g[1], &g[3]), mu * dot(&g[2], &g[3])];
    let [s00, s11] = [mu * dot(&g[0], &g[0]), mu * dot(&g[1], &g[1])];
    let [s22, s33] = [mu * dot(&g[2], &g[2]), mu * dot(&g[3], &g[3])];
    let shears = dealt(simd, [s00, s01, s02, s03, s11, s12, s13, s22]);
    let others = dealt(simd, [s23, s33, lambda, mu, g[0][2], g[1][2], g[2][2], g[3][2]]);
    let [f0, f1, f2, f3] = &at.forces;
    let impulses = [
        dealt(simd, [f0[0], f0[1], f0[2], f1[0], f1[1], f1[2], f2[0], f2[1]]),
        dealt(simd, [f2[2], f3[0], f3[1], f3[2], mu, mu, mu, mu]),
    ];
    let ones = f64x8::load_array(simd, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);

    for (lane, places) in places.iter().enumerate() {
        let (s, o) = (&shears[lane], &others[lane]);
        let shear = [
            [s[0], s[1], s[2], s[3]],
            [s[1], s[4], s[5], s[6]],
            [s[2], s[5], s[7], o[0]],
            [s[3], s[6], o[0], o[1]],
        ];
        let (lambda, mu, z) = (o[2], o[3], [o[4], o[5], o[6], o[7]]);
        let both = lambda + mu;
        for a in 0..4 {
            let down_a = f64x8::load_array_ref(simd, &down[a][lane]) * lambda;
            let across_a = f64x8::load_array_ref(simd, &across[a][lane]) * mu;
            for c in 0..4 {
                let down_c = f64x8::load_array_ref(simd, &down[c][lane]);
                let across_c = f64x8::load_array_ref(simd, &across[c][lane]);
                let first = down_a.mul_add(across_c, down_c.mul_add(across_a, ones * shear[a][c]));
                A.add_lanes(simd, places[a][c], first, both * z[a] * z[c] + shear[a][c]);
            }
        }
        let f = [impulses[0][lane], impulses[1][lane]];
        let f = f.as_flattened();
        for (a, node) in rest.tets[lane].iter().enumerate() {
            b[*node as usize] += Vec3::new(f[3 * a], f[3 * a + 1], f[3 * a + 2]) * h;
        }
    }
}

/// One list per element from vectors with one number per element.
#[inline(always)]
pub fn dealt<S: Simd>(simd: S, rows: [f64x8<S>; LANES]) -> [[f64; LANES]; LANES] {
    let rows = transposed(simd, rows);
    let mut out = [[0.0; LANES]; LANES];
    for lane in 0..LANES {
        out[lane] = rows[lane].to_array();
    }
    out
}
