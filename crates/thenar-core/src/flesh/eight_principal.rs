//! The response of eight elements of a law in principal stretches at once, as
//! `element::hyperelastic` has it one by one, and its sum into the system.

use crate::flesh::eight::{dealt, minus_sum};
use crate::flesh::element::positive_part;
use crate::flesh::lanes::{Mat3x8, RestLanes, entries, times};
use crate::flesh::principal_lanes::{PrincipalResponse, density};
use crate::flesh::rotations::rotations;
use crate::flesh::{PAIRS, Tally};
use crate::math::lanes::{LANES, Vec3x8, dot, three};
use crate::math::{Mat3, Vec3};
use crate::solver::BlockMatrix;
use fearless_simd::{Simd, f64x8, prelude::*};

/// Most sweeps of Jacobi's iteration; three by three it settles in four.
const SWEEPS_MAX: usize = 8;
/// Entries beside the diagonal, against the largest stretch, squared: round-off.
const SETTLED: f64 = 1e-30;

/// `F = U σ Vᵀ`, with rotations U and V.
struct Stretches<S: Simd> {
    U: Mat3x8<S>,
    V: Mat3x8<S>,
    s: Vec3x8<S>,
}

/// The two other axes.
const OTHERS: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

/// From the rotation R of F and Jacobi's iteration on `S = Rᵀ F` (Jacobi 1846).
#[inline(always)]
fn stretches<S: Simd>(simd: S, F: &Mat3x8<S>) -> Stretches<S> {
    let R = rotations(simd, F);
    let (r, f) = (columns(&R), columns(F));
    let mut d = [dot(&r[0], &f[0]), dot(&r[1], &f[1]), dot(&r[2], &f[2])];
    // Entries (1, 2), (2, 0), (0, 1).
    let mut o = three(
        #[inline(always)]
        |k| {
            let [i, j] = OTHERS[k];
            (dot(&r[i], &f[j]) + dot(&r[j], &f[i])) * 0.5
        },
    );
    let (zero, one) = (simd.splat_f64x8(0.0), simd.splat_f64x8(1.0));
    let mut V = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
    let tiny = simd.splat_f64x8(f64::MIN_POSITIVE);
    for _ in 0..SWEEPS_MAX {
        let off = dot(&o, &o);
        if off.simd_le(dot(&d, &d) * SETTLED).all_true() {
            break;
        }
        for k in 0..3 {
            let [p, q] = OTHERS[k];
            // t = tan of the turn that makes entry (p, q) zero, the smaller one.
            let a = (d[q] - d[p]) * 0.5;
            let b = o[k];
            let root = a.mul_add(a, b * b).sqrt() + tiny;
            let t = b / (a.abs() + root) * one.copysign(a);
            let c = one / t.mul_add(t, one).sqrt();
            let s = t * c;
            d[p] -= t * b;
            d[q] += t * b;
            o[k] = zero;
            let (x, y) = (o[p], o[q]);
            // Entry (q, k) has index p, and (p, k) has index q.
            o[q] = c * y - s * x;
            o[p] = s * y + c * x;
            let (vp, vq) = (V[p], V[q]);
            V[p] = three(
                #[inline(always)]
                |i| c * vp[i] - s * vq[i],
            );
            V[q] = three(
                #[inline(always)]
                |i| s * vp[i] + c * vq[i],
            );
        }
    }
    let U = [times(&R, &V[0]), times(&R, &V[1]), times(&R, &V[2])];
    Stretches { U: flat(&U), V: flat(&V), s: d }
}

#[inline(always)]
fn columns<S: Simd>(m: &Mat3x8<S>) -> [Vec3x8<S>; 3] {
    [[m[0], m[1], m[2]], [m[3], m[4], m[5]], [m[6], m[7], m[8]]]
}

/// A matrix of its columns.
#[inline(always)]
fn flat<S: Simd>(c: &[Vec3x8<S>; 3]) -> Mat3x8<S> {
    [c[0][0], c[0][1], c[0][2], c[1][0], c[1][1], c[1][2], c[2][0], c[2][1], c[2][2]]
}

/// `Mᵀ v`.
#[inline(always)]
fn transpose_times<S: Simd>(m: &Mat3x8<S>, v: &Vec3x8<S>) -> Vec3x8<S> {
    [dot(&m[0..3], v), dot(&m[3..6], v), dot(&m[6..9], v)]
}

/// Adds energies and inverted elements.
#[inline(always)]
pub fn tally<S: Simd>(simd: S, rest: &RestLanes, x: &[Vec3], tally: &mut Tally) {
    let F = rest.deformation_gradients(simd, x);
    let at = stretches(simd, &F);
    count(rest, &at, density(simd, rest, &at.s).energy, tally);
}

#[inline(always)]
fn count<S: Simd>(rest: &RestLanes, at: &Stretches<S>, energy: f64x8<S>, tally: &mut Tally) {
    let (energy, det) = (energy.to_array(), (at.s[0] * at.s[1] * at.s[2]).to_array());
    for lane in 0..rest.count {
        tally.energy += energy[lane] * rest.volume[lane];
        tally.inverted += u32::from(det[lane] < 0.0);
    }
}

/// Adds `(h² + h β) K` to `A` and `h F` to the nodal `b`, lane after lane.
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
    let F = rest.deformation_gradients(simd, x);
    let at = stretches(simd, &F);
    let mut law = density(simd, rest, &at.s);
    count(rest, &at, law.energy, sums);
    keep_positive(simd, &mut law);

    let volume = f64x8::load_array_ref(simd, &rest.volume);
    let damping = f64x8::load_array_ref(simd, &rest.damping);
    let scale = (damping + h) * h * volume;
    let zero = simd.splat_f64x8(0.0);
    let (stretch, cross) = (scaled(&law.diagonal, scale), scaled(&law.beside, scale));
    let mut own = [zero; 3];
    let mut other = [zero; 3];
    for k in 0..3 {
        let (twist, flip) = (law.twist[k].max(zero), law.flip[k].max(zero));
        own[k] = (flip + twist) * scale * 0.5;
        other[k] = (flip - twist) * scale * 0.5;
    }

    let rest_gradients = rest.gradients(simd);
    let g = three(
        #[inline(always)]
        |a| transpose_times(&at.V, &rest_gradients[a]),
    );
    let pull = volume * -1.0;
    let f = three(
        #[inline(always)]
        |a| {
            let g = &g[a];
            let inside = three(
                #[inline(always)]
                |i| law.stress[i] * g[i] * pull,
            );
            times(&at.U, &inside)
        },
    );

    // Blocks between nodes 1 to 3; rows and columns of the whole matrix sum to zero.
    let axes = Axes { U: at.U, stretch, cross, own, other };
    // A loop keeps the program short: one block is some three hundred vector operations.
    let mut inner = [[zero; 9]; 6];
    for (block, (a, b)) in inner.iter_mut().zip([(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]) {
        *block = axes.block(&g[a], &g[b]);
    }
    let [k11, k22, k33, k12, k13, k23] = inner;
    let k01 = minus_three(&k11, &transpose(&k12), &transpose(&k13));
    let k02 = minus_three(&k12, &k22, &transpose(&k23));
    let k03 = minus_three(&k13, &k23, &k33);
    let k00 = minus_three(&k01, &k02, &k03);
    let blocks = [k00, k11, k22, k33, k01, k02, k03, k12, k13, k23];
    debug_assert!(PAIRS[4] == (0, 1) && PAIRS[9] == (2, 3));

    let nothing = [[0.0; LANES]; LANES];
    let mut first = [[nothing; 4]; 4];
    for (block, (a, c)) in blocks.iter().zip(PAIRS) {
        let m = block;
        first[a][c] = dealt(simd, [m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7]]);
        if a != c {
            first[c][a] = dealt(simd, [m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5]]);
        }
    }
    let [l0, l1, l2, l3, l4, l5, l6, l7, l8, l9] = {
        let b = &blocks;
        [b[0][8], b[1][8], b[2][8], b[3][8], b[4][8], b[5][8], b[6][8], b[7][8], b[8][8], b[9][8]]
    };
    let some = dealt(simd, [l0, l1, l2, l3, l4, l5, l6, l7]);
    let f0 = minus_sum(&f);
    let [f1, f2, f3] = &f;
    let lasts = dealt(simd, [l8, l9, f0[0], f0[1], f0[2], f1[0], f1[1], f1[2]]);
    let impulses = dealt(simd, [f2[0], f2[1], f2[2], f3[0], f3[1], f3[2], zero, zero]);

    for (lane, places) in places.iter().enumerate() {
        let mut corner = [[0.0; 4]; 4];
        for (i, (a, c)) in PAIRS.into_iter().enumerate() {
            let value = if i < 8 { some[lane][i] } else { lasts[lane][i - 8] };
            (corner[a][c], corner[c][a]) = (value, value);
        }
        for a in 0..4 {
            for c in 0..4 {
                let block = f64x8::load_array_ref(simd, &first[a][c][lane]);
                A.add_lanes(simd, places[a][c], block, corner[a][c]);
            }
        }
        let (l, i) = (&lasts[lane], &impulses[lane]);
        let f = [[l[2], l[3], l[4]], [l[5], l[6], l[7]], [i[0], i[1], i[2]], [i[3], i[4], i[5]]];
        for (node, f) in rest.tets[lane].iter().zip(f) {
            b[*node as usize] += Vec3::from(f) * h;
        }
    }
}

/// The derivative of P in the axes, as `element::Principal::blocks` has it.
struct Axes<S: Simd> {
    U: Mat3x8<S>,
    stretch: Vec3x8<S>,
    cross: Vec3x8<S>,
    own: Vec3x8<S>,
    other: Vec3x8<S>,
}

impl<S: Simd> Axes<S> {
    /// The block between nodes with these gradients in the axes.
    #[inline(always)]
    fn block(&self, p: &Vec3x8<S>, q: &Vec3x8<S>) -> Mat3x8<S> {
        let Self { U, stretch, cross, own, other } = self;
        let pq = [p[0] * q[0], p[1] * q[1], p[2] * q[2]];
        let local = entries(
            #[inline(always)]
            |i, k| {
                if i == k {
                    let [m, n] = OTHERS[i];
                    stretch[i].mul_add(pq[i], own[n].mul_add(pq[m], own[m] * pq[n]))
                } else {
                    let pair = 3 - i - k;
                    (cross[pair] * p[i]).mul_add(q[k], other[pair] * p[k] * q[i])
                }
            },
        );
        sandwich(U, &local)
    }
}

/// `U L Uᵀ`.
#[inline(always)]
fn sandwich<S: Simd>(U: &Mat3x8<S>, L: &Mat3x8<S>) -> Mat3x8<S> {
    let L = columns(L);
    let UL = flat(&[times(U, &L[0]), times(U, &L[1]), times(U, &L[2])]);
    entries(
        #[inline(always)]
        |r, c| UL[r].mul_add(U[c], UL[3 + r].mul_add(U[3 + c], UL[6 + r] * U[6 + c])),
    )
}

#[inline(always)]
fn scaled<S: Simd>(v: &Vec3x8<S>, by: f64x8<S>) -> Vec3x8<S> {
    [v[0] * by, v[1] * by, v[2] * by]
}

#[inline(always)]
fn transpose<S: Simd>(m: &Mat3x8<S>) -> Mat3x8<S> {
    [m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]]
}

#[inline(always)]
fn minus_three<S: Simd>(a: &Mat3x8<S>, b: &Mat3x8<S>, c: &Mat3x8<S>) -> Mat3x8<S> {
    entries(
        #[inline(always)]
        |r, k| -(a[3 * k + r] + b[3 * k + r] + c[3 * k + r]),
    )
}

/// Takes negative eigenvalues out of Hessians. Near rest there are none, which their leading minors
/// tell.
#[inline(always)]
fn keep_positive<S: Simd>(simd: S, law: &mut PrincipalResponse<S>) {
    let ([a, b, c], [f, e, d]) = (law.diagonal, law.beside);
    let zero = simd.splat_f64x8(0.0);
    let minor = a.mul_sub(b, d * d);
    let det = minor * c - a * f * f - b * e * e + d * e * f * 2.0;
    let positive = a.simd_gt(zero) & minor.simd_gt(zero) & det.simd_gt(zero);
    if !positive.all_true() {
        project_singly(simd, law, positive.to_bitmask());
    }
}

#[cold]
#[inline(never)]
fn project_singly<S: Simd>(simd: S, law: &mut PrincipalResponse<S>, sound: u64) {
    let mut numbers = [law.diagonal, law.beside].map(|v| v.map(|x| x.to_array()));
    for lane in (0..LANES).filter(|&lane| sound >> lane & 1 == 0) {
        let of = |i: usize, k: usize| match i == k {
            true => numbers[0][i][lane],
            false => numbers[1][3 - i - k][lane],
        };
        let m = positive_part(&Mat3::from_fn(of));
        for i in 0..3 {
            numbers[0][i][lane] = m[(i, i)];
            let [p, q] = OTHERS[i];
            numbers[1][i][lane] = m[(p, q)];
        }
    }
    let [diagonal, beside] = numbers;
    law.diagonal = diagonal.map(|x| f64x8::load_array(simd, x));
    law.beside = beside.map(|x| f64x8::load_array(simd, x));
}
