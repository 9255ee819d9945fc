//! Long vectors of numbers: sums and products in a fixed order.

use crate::math::Vec3;
use fearless_simd::{Simd, f64x8, prelude::*};

const LANES: usize = 8;

/// The numbers of a list of vectors, one after the other.
pub fn flat(v: &[Vec3]) -> &[f64] {
    bytemuck::cast_slice(v)
}

/// Numbers of a list of vectors, to be written.
pub fn flat_mut(v: &mut [Vec3]) -> &mut [f64] {
    bytemuck::cast_slice_mut(v)
}

/// Scalar product.
#[inline(always)]
pub fn dot<S: Simd>(simd: S, a: &[f64], b: &[f64]) -> f64 {
    // Four sums side by side, so that an addition need not wait for the one before.
    let mut sums = [simd.splat_f64x8(0.0); 4];
    let (a, b) = (a.as_chunks::<{ 4 * LANES }>(), b.as_chunks::<{ 4 * LANES }>());
    for (a, b) in a.0.iter().zip(b.0) {
        let (a, b) = (a.as_chunks::<LANES>().0, b.as_chunks::<LANES>().0);
        for k in 0..4 {
            let x = f64x8::load_array_ref(simd, &a[k]);
            sums[k] = x.mul_add(f64x8::load_array_ref(simd, &b[k]), sums[k]);
        }
    }
    let rest: f64 = a.1.iter().zip(b.1).map(|(a, b)| a * b).sum();
    simd.reduce_sum_f64x8((sums[0] + sums[1]) + (sums[2] + sums[3])) + rest
}

/// `a[i] = f(a[i], b[i])`, where `f` and `one` do the same to many numbers and to one.
#[inline(always)]
fn combine<S: Simd>(
    simd: S,
    a: &mut [f64],
    b: &[f64],
    f: impl Fn(f64x8<S>, f64x8<S>) -> f64x8<S>,
    one: impl Fn(f64, f64) -> f64,
) {
    let (a, b) = (a.as_chunks_mut::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a.0.iter_mut().zip(b.0) {
        let (x, y) = (f64x8::load_array_ref(simd, a), f64x8::load_array_ref(simd, b));
        *a = f(x, y).to_array();
    }
    a.1.iter_mut().zip(b.1).for_each(|(a, b)| *a = one(*a, *b));
}

/// `a += Σ s b` of three.
#[inline(always)]
pub fn add_three<S: Simd>(simd: S, a: &mut [f64], s: [f64; 3], b: [&[f64]; 3]) {
    let a = a.as_chunks_mut::<LANES>();
    let (x, y, z) =
        (b[0].as_chunks::<LANES>(), b[1].as_chunks::<LANES>(), b[2].as_chunks::<LANES>());
    for (i, a) in a.0.iter_mut().enumerate() {
        let sum = f64x8::load_array_ref(simd, a);
        let sum = f64x8::load_array_ref(simd, &x.0[i]).mul_add(s[0], sum);
        let sum = f64x8::load_array_ref(simd, &y.0[i]).mul_add(s[1], sum);
        *a = f64x8::load_array_ref(simd, &z.0[i]).mul_add(s[2], sum).to_array();
    }
    for (i, a) in a.1.iter_mut().enumerate() {
        *a += x.1[i] * s[0] + y.1[i] * s[1] + z.1[i] * s[2];
    }
}

/// `a += s b`.
#[inline(always)]
pub fn add<S: Simd>(simd: S, a: &mut [f64], s: f64, b: &[f64]) {
    combine(
        simd,
        a,
        b,
        #[inline(always)]
        |a, b| b * s + a,
        #[inline(always)]
        |a, b| a + b * s,
    );
}

/// `a = b + s a`.
#[inline(always)]
pub fn renew<S: Simd>(simd: S, a: &mut [f64], s: f64, b: &[f64]) {
    combine(
        simd,
        a,
        b,
        #[inline(always)]
        |a, b| a * s + b,
        #[inline(always)]
        |a, b| b + a * s,
    );
}

/// The largest number without its sign; those that are not numbers are passed over.
#[inline(always)]
pub fn largest(v: &[f64]) -> f64 {
    let mut largest = [0.0_f64; 4 * LANES];
    for many in v.chunks(4 * LANES) {
        for (v, largest) in many.iter().zip(&mut largest) {
            if v.abs() > *largest {
                *largest = v.abs();
            }
        }
    }
    largest.into_iter().fold(0.0, f64::max)
}

/// The largest squared length; numbers that are not finite are passed over.
#[inline(always)]
pub fn longest2(v: &[Vec3]) -> f64 {
    let mut longest = [0.0_f64; 4];
    for four in v.chunks(4) {
        for (v, longest) in four.iter().zip(&mut longest) {
            let length2 = v.x * v.x + v.y * v.y + v.z * v.z;
            if length2 > *longest {
                *longest = length2;
            }
        }
    }
    longest.into_iter().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn agree_with_one_number_at_a_time() {
        let mut random = Random::new(31);
        for n in [0, 1, 5, 13, 40, 301] {
            let a: Vec<Vec3> = (0..n).map(|_| random.vector(1.0)).collect();
            let b: Vec<Vec3> = (0..n).map(|_| random.vector(1.0)).collect();
            let (mut more, mut new) = (a.clone(), a.clone());
            let product = dispatch!(Level::new(), simd => {
                add(simd, flat_mut(&mut more), 0.3, flat(&b));
                renew(simd, flat_mut(&mut new), 0.3, flat(&b));
                dot(simd, flat(&a), flat(&b))
            });
            let want: f64 = a.iter().zip(&b).map(|(a, b)| a.dot(b)).sum();
            assert!((product - want).abs() < 1e-12);
            for i in 0..n {
                assert!((more[i] - (a[i] + b[i] * 0.3)).norm() < 1e-15);
                assert!((new[i] - (b[i] + a[i] * 0.3)).norm() < 1e-15);
            }
            let want = a.iter().map(|a| a.norm_squared()).fold(0.0, f64::max);
            assert_eq!(longest2(&a), want);
            let want = a.iter().map(Vec3::amax).fold(0.0, f64::max);
            assert_eq!(largest(flat(&a)), want);
        }
    }
}
