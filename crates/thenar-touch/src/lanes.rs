//! Eight bones side by side, as in [`thenar_core::math::lanes`]. A tick needs some hundreds
//! of turns, nearly all of them small, which series without roots and arc tangents find for eight
//! bones at once.

use crate::RigidState;
use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};
use thenar_core::math::lanes::{LANES, Vec3x8, cross, dot, three};
use thenar_core::math::{Quat, Vec3};

/// A quaternion in each lane, its scalar last.
pub(crate) type Quatx8<S> = [f64x8<S>; 4];

/// Squared sine, or square, of half an angle up to which series are used: half a radian.
const NEAR: f64 = 1.0 / 16.0;
/// Terms of each series; the first one left out is below round-off at [`NEAR`].
const TERMS: usize = 12;
/// `asin(s)/s` by powers of s²: (2k)! / (4ᵏ k!² (2k + 1)).
const ARC: [f64; TERMS] = {
    let mut terms = [1.0; TERMS];
    let mut k = 1;
    while k < TERMS {
        let odd = (2 * k - 1) as f64;
        terms[k] = terms[k - 1] * odd * odd / ((2 * k) as f64 * (2 * k + 1) as f64);
        k += 1;
    }
    terms
};

/// The reciprocals of 1, 3!, 5! and so on (`first` is 2), or of 1, 2!, 4! (`first` is 1), with
/// alternating signs.
const fn alternating(first: usize) -> [f64; TERMS] {
    let mut terms = [1.0; TERMS];
    let mut k = 1;
    while k < TERMS {
        let n = 2 * (k - 1) + first;
        terms[k] = -terms[k - 1] / (n * (n + 1)) as f64;
        k += 1;
    }
    terms
}

/// `sin(x)/x` and `cos x` by powers of x².
const SINE: [f64; TERMS] = alternating(2);
const COSINE: [f64; TERMS] = alternating(1);

/// The lists of numbers of some bones, one list of each in each lane. Lanes without a bone repeat
/// the last.
#[inline(always)]
pub(crate) fn load<S: Simd, const N: usize>(
    simd: S,
    bones: usize,
    of: impl Fn(usize) -> [f64; N],
) -> [f64x8<S>; N] {
    let mut lists = [[0.0; LANES]; N];
    for lane in 0..LANES {
        let of = of(lane.min(bones - 1));
        for k in 0..N {
            lists[k][lane] = of[k];
        }
    }
    let mut all = [simd.splat_f64x8(0.0); N];
    for k in 0..N {
        all[k] = f64x8::load_array_ref(simd, &lists[k]);
    }
    all
}

/// The list of numbers in this lane.
#[inline(always)]
pub(crate) fn lane<S: Simd, const N: usize>(all: &[f64x8<S>; N], lane: usize) -> [f64; N] {
    let mut list = [0.0; N];
    for k in 0..N {
        list[k] = all[k].as_slice()[lane];
    }
    list
}

/// The numbers of a quaternion, its scalar last.
#[inline(always)]
pub(crate) fn numbers(q: &Quat) -> [f64; 4] {
    q.coords.into()
}

/// The quaternion of these numbers, its scalar last.
#[inline(always)]
pub(crate) fn quaternion([x, y, z, w]: [f64; 4]) -> Quat {
    Quat::new_unchecked(nalgebra::Quaternion::new(w, x, y, z))
}

/// The inverse rotation.
#[inline(always)]
pub(crate) fn inverse<S: Simd>([x, y, z, w]: Quatx8<S>) -> Quatx8<S> {
    [-x, -y, -z, w]
}

/// The rotation by `b` and then by `a`.
#[inline(always)]
pub(crate) fn product<S: Simd>(a: &Quatx8<S>, b: &Quatx8<S>) -> Quatx8<S> {
    let (u, v) = ([a[0], a[1], a[2]], [b[0], b[1], b[2]]);
    let across = cross(&u, &v);
    let [x, y, z] = three(
        #[inline(always)]
        |k| a[3].mul_add(v[k], b[3].mul_add(u[k], across[k])),
    );
    [x, y, z, a[3].mul_sub(b[3], dot(&u, &v))]
}

/// A vector turned by `q`.
#[inline(always)]
pub(crate) fn rotate<S: Simd>(q: &Quatx8<S>, v: &Vec3x8<S>) -> Vec3x8<S> {
    let u = [q[0], q[1], q[2]];
    let t = cross(&u, v);
    let t = [t[0] * 2.0, t[1] * 2.0, t[2] * 2.0];
    let more = cross(&u, &t);
    three(
        #[inline(always)]
        |k| q[3].mul_add(t[k], v[k] + more[k]),
    )
}

/// The rotation of this quaternion.
#[inline(always)]
pub(crate) fn normalized<S: Simd>(q: Quatx8<S>) -> Quatx8<S> {
    let [x, y, z, w] = q;
    let scale = (w.mul_add(w, dot(&[x, y, z], &[x, y, z]))).sqrt();
    [x / scale, y / scale, z / scale, w / scale]
}

/// The sum of a series in `x`.
#[inline(always)]
fn series<S: Simd>(simd: S, terms: &[f64; TERMS], x: f64x8<S>) -> f64x8<S> {
    let mut sum = simd.splat_f64x8(terms[TERMS - 1]);
    for k in (0..TERMS - 1).rev() {
        sum = sum.mul_add(x, simd.splat_f64x8(terms[k]));
    }
    sum
}

/// Rotation vectors \[rad\], the shorter way round, as
/// [`rotation_vector`](thenar_core::math::rotation_vector) has them.
#[inline(always)]
pub(crate) fn rotation_vectors<S: Simd>(simd: S, q: &Quatx8<S>) -> Vec3x8<S> {
    let v = [q[0], q[1], q[2]];
    let s2 = dot(&v, &v);
    let scale = (series(simd, &ARC, s2) * 2.0).copysign(q[3]);
    let mut vectors = [v[0] * scale, v[1] * scale, v[2] * scale];
    let near = s2.simd_le(simd.splat_f64x8(NEAR)) & q[3].abs().simd_gt(simd.splat_f64x8(0.5));
    if !near.all_true() {
        one_by_one(simd, near.to_bitmask(), &mut vectors, |i| {
            thenar_core::math::rotation_vector(&quaternion(lane(q, i))).into()
        });
    }
    vectors
}

/// The rotations of these rotation vectors \[rad\].
#[inline(always)]
pub(crate) fn rotations<S: Simd>(simd: S, v: &Vec3x8<S>) -> Quatx8<S> {
    let x = dot(v, v) * 0.25;
    let half = series(simd, &SINE, x) * 0.5;
    let mut turns = [v[0] * half, v[1] * half, v[2] * half, series(simd, &COSINE, x)];
    let near = x.simd_le(simd.splat_f64x8(NEAR));
    if !near.all_true() {
        one_by_one(simd, near.to_bitmask(), &mut turns, |i| {
            numbers(&Quat::from_scaled_axis(Vec3::from(lane(v, i))))
        });
    }
    turns
}

/// Computes the lanes beyond the series one by one; `known` marks the others.
#[cold]
#[inline(never)]
fn one_by_one<S: Simd, const N: usize>(
    simd: S,
    known: u64,
    all: &mut [f64x8<S>; N],
    of: impl Fn(usize) -> [f64; N],
) {
    for lane in (0..LANES).filter(|lane| known >> lane & 1 == 0) {
        let of = of(lane);
        for k in 0..N {
            let mut numbers = all[k].to_array();
            numbers[lane] = of[k];
            all[k] = f64x8::load_array(simd, numbers);
        }
    }
}

/// Finds the rotation vectors \[rad\] from the second to the first of two rotations of each bone.
pub(crate) fn turns_between(of: impl Fn(usize) -> [Quat; 2], turns: &mut [Vec3]) {
    dispatch!(Level::new(), simd => all_turns_between(simd, &of, turns));
}

#[inline(always)]
fn all_turns_between<S: Simd>(simd: S, of: &impl Fn(usize) -> [Quat; 2], turns: &mut [Vec3]) {
    for (pack, turns) in turns.chunks_mut(LANES).enumerate() {
        let both = load(
            simd,
            turns.len(),
            #[inline(always)]
            |lane| {
                let [to, from] = of(LANES * pack + lane);
                let ([a, b, c, d], [e, f, g, h]) = (numbers(&to), numbers(&from));
                [a, b, c, d, e, f, g, h]
            },
        );
        let [a, b, c, d, e, f, g, h] = both;
        let vectors = rotation_vectors(simd, &product(&[a, b, c, d], &inverse([e, f, g, h])));
        for (i, turn) in turns.iter_mut().enumerate() {
            *turn = lane(&vectors, i).into();
        }
    }
}

/// Gives each bone the rotation from `of`, turned by the rotation vector beside it, in the world
/// \[rad\].
pub(crate) fn turn_by(bones: &mut [RigidState], of: impl Fn(usize, &RigidState) -> (Vec3, Quat)) {
    dispatch!(Level::new(), simd => all_turn_by(simd, bones, &of));
}

#[inline(always)]
fn all_turn_by<S: Simd>(
    simd: S,
    bones: &mut [RigidState],
    of: &impl Fn(usize, &RigidState) -> (Vec3, Quat),
) {
    for (pack, bones) in bones.chunks_mut(LANES).enumerate() {
        let [x, y, z, a, b, c, d] = load(
            simd,
            bones.len(),
            #[inline(always)]
            |lane| {
                let (by, was) = of(LANES * pack + lane, &bones[lane]);
                let [a, b, c, d] = numbers(&was);
                [by.x, by.y, by.z, a, b, c, d]
            },
        );
        let all = product(&rotations(simd, &[x, y, z]), &[a, b, c, d]);
        for (i, bone) in bones.iter_mut().enumerate() {
            bone.pose_WB.rotation = quaternion(lane(&all, i));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_core::math::Pose;
    use thenar_core::random::Random;

    /// Angles from nothing to half a turn, and both sides of where series end.
    const ANGLES: [f64; 11] =
        [0.0, 1e-12, 1e-4, 0.01, 0.3, 0.499_999, 0.500_001, 0.505_3, 0.505_4, 1.0, 3.1];

    fn any_vectors(random: &mut Random) -> Vec<Vec3> {
        ANGLES.iter().map(|angle| random.vector(1.0).normalize() * *angle).collect()
    }

    /// Eleven bones, so that one vector is full and another is not: what turned them is found
    /// again, with either sign of the quaternions.
    #[test]
    fn turns_between_rotations_are_those_that_made_them() {
        let mut random = Random::new(11);
        for sign in [1.0, -1.0] {
            for _ in 0..50 {
                let (turns, was) = (any_vectors(&mut random), random.rotation(3.0));
                let to = |i: usize| {
                    let q = Quat::from_scaled_axis(turns[i]) * was;
                    Quat::new_unchecked(q.into_inner() * sign)
                };
                let mut found = vec![Vec3::zeros(); turns.len()];
                turns_between(|i| [to(i), was], &mut found);
                for (found, turn) in found.iter().zip(&turns) {
                    assert!((found - turn).norm() < 2e-15, "{found} of {turn}");
                }
            }
        }
    }

    /// A bone turned by a vector is turned by that vector's rotation.
    #[test]
    fn bones_turn_by_their_vectors() {
        let mut random = Random::new(12);
        for _ in 0..50 {
            let (turns, was) = (any_vectors(&mut random), random.rotation(3.0));
            let mut bones = vec![RigidState::at_rest(Pose::new(Vec3::zeros(), was)); turns.len()];
            turn_by(&mut bones, |i, bone| (turns[i], bone.pose_WB.rotation));
            for (bone, turn) in bones.iter().zip(&turns) {
                let found = bone.pose_WB.rotation;
                let want = Quat::from_scaled_axis(*turn) * was;
                assert!((found.coords - want.coords).norm() < 1e-15, "{found} by {turn}");
            }
        }
    }

    /// A bone whose rotation is none has no turn, and changes no other bone's.
    #[test]
    fn what_is_not_finite_stays_with_its_bone() {
        let turns = [0.0, 0.1, f64::NAN, 0.3, 0.4].map(|angle| Vec3::x() * angle);
        let mut found = [Vec3::zeros(); 5];
        turns_between(|i| [Quat::from_scaled_axis(turns[i]), Quat::identity()], &mut found);
        for i in [0, 1, 3, 4] {
            assert!((found[i] - turns[i]).norm() < 1e-15, "{i}: {}", found[i]);
        }
        assert_eq!(found[2], Vec3::zeros());
        let mut bones = [RigidState::at_rest(Pose::identity()); 5];
        turn_by(&mut bones, |i, bone| (turns[i], bone.pose_WB.rotation));
        for i in [0, 1, 3, 4] {
            let want = Quat::from_scaled_axis(turns[i]);
            assert!((bones[i].pose_WB.rotation.coords - want.coords).norm() < 1e-15, "{i}");
        }
    }
}
