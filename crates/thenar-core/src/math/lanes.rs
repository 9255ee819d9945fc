//! Eight things side by side: one number of each in the eight lanes of a vector.
//!
//! Closures over vectors are marked `#[inline(always)]` and go to functions that are too: one that
//! the compiler keeps apart is compiled without the vector instructions. `map` and `from_fn` of
//! arrays and adaptors of iterators are not such functions; [`three`] and loops take their place.

use fearless_simd::{Simd, f64x8, prelude::*};

/// Things that are evaluated together.
pub const LANES: usize = 8;
/// A vector in each lane.
pub type Vec3x8<S> = [f64x8<S>; 3];

/// Three of something.
#[inline(always)]
pub fn three<T>(f: impl Fn(usize) -> T) -> [T; 3] {
    [f(0), f(1), f(2)]
}

/// Scalar product.
#[inline(always)]
pub fn dot<S: Simd>(a: &[f64x8<S>], b: &[f64x8<S>]) -> f64x8<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// Cross product.
#[inline(always)]
pub fn cross<S: Simd>(a: &[f64x8<S>], b: &[f64x8<S>]) -> Vec3x8<S> {
    [
        a[1].mul_sub(b[2], a[2] * b[1]),
        a[2].mul_sub(b[0], a[0] * b[2]),
        a[0].mul_sub(b[1], a[1] * b[0]),
    ]
}
