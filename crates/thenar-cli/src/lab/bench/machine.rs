//! Peaks of one core of this machine: multiply-adds and reading memory.

use fearless_simd::{Level, Simd, dispatch, f32x16, f64x8, prelude::*};
use std::hint::black_box;
use std::time::Instant;

/// Peaks of one core.
#[derive(Clone, Copy, Debug)]
pub struct Peaks {
    /// Multiply-adds in f32 [Gflop/s]; one counts as two.
    pub f32_gflops: f64,
    /// Likewise in f64.
    pub f64_gflops: f64,
    /// Reading [GB/s] and the size of what is read [bytes].
    pub reading: [(f64, usize); 4],
}

/// Sizes that are read \[bytes\], in the first, second, third cache, or in none.
const SIZES: [(&str, usize); 4] =
    [("L1", 24 << 10), ("L2", 512 << 10), ("L3", 8 << 20), ("memory", 256 << 20)];
/// Number of tries, of which the best counts.
const TRIES: u32 = 7;

impl Peaks {
    /// Measures the machine.
    pub fn measure() -> Self {
        const ROUNDS: u32 = 200_000;
        let best = |work: &dyn Fn() -> f64| {
            (0..TRIES).map(|_| seconds(work)).fold(f64::INFINITY, f64::min)
        };
        let level = Level::new();
        let f64_time = best(&|| dispatch!(level, simd => adds_f64(simd, ROUNDS)));
        let f32_time = best(&|| dispatch!(level, simd => adds_f32(simd, ROUNDS)));
        let per_round = (2 * CHAINS) as f64 * f64::from(ROUNDS) * 1e-9;
        Self {
            f64_gflops: 8.0 * per_round / f64_time,
            f32_gflops: 16.0 * per_round / f32_time,
            reading: SIZES.map(|(_, bytes)| {
                let data = vec![1.0; bytes / 8];
                let times = (64 << 20) / bytes + 1;
                let read = || {
                    let one = || dispatch!(level, simd => sum(simd, black_box(&data)));
                    (0..times).map(|_| one()).sum()
                };
                ((bytes * times) as f64 * 1e-9 / best(&read), bytes)
            }),
        }
    }

    /// Bytes per second where data of this size lies.
    pub fn bandwidth(&self, bytes: f64) -> f64 {
        // What fills a cache less than by half above its tried size stays there.
        let fits = |size: usize| bytes <= 1.5 * size as f64;
        let last = self.reading[3];
        self.reading.iter().find(|(_, size)| fits(*size)).unwrap_or(&last).0 * 1e9
    }

    /// Peaks in one line.
    pub fn line(&self) -> String {
        let reading: Vec<String> = (SIZES.iter().zip(&self.reading))
            .map(|((name, _), (speed, _))| format!("{name} {speed:.0}"))
            .collect();
        format!(
            "one core: multiply-adds f32 {:.0}, f64 {:.0} Gflop/s; reading {} GB/s",
            self.f32_gflops,
            self.f64_gflops,
            reading.join(", ")
        )
    }
}

fn seconds(work: &dyn Fn() -> f64) -> f64 {
    let begun = Instant::now();
    black_box(work());
    begun.elapsed().as_secs_f64()
}

/// Chains of multiply-adds that do not wait for each other.
const CHAINS: usize = 12;

#[inline(always)]
fn adds_f64<S: Simd>(simd: S, rounds: u32) -> f64 {
    let (a, b) = (simd.splat_f64x8(black_box(0.999)), simd.splat_f64x8(black_box(0.001)));
    let mut sums: [f64x8<S>; CHAINS] = [b; CHAINS];
    for _ in 0..rounds {
        for k in 0..CHAINS {
            sums[k] = sums[k].mul_add(a, b);
        }
    }
    let mut total = sums[0];
    for k in 1..CHAINS {
        total += sums[k];
    }
    total.as_slice()[0]
}

#[inline(always)]
fn adds_f32<S: Simd>(simd: S, rounds: u32) -> f64 {
    let (a, b) = (simd.splat_f32x16(black_box(0.999)), simd.splat_f32x16(black_box(0.001)));
    let mut sums: [f32x16<S>; CHAINS] = [b; CHAINS];
    for _ in 0..rounds {
        for k in 0..CHAINS {
            sums[k] = sums[k].mul_add(a, b);
        }
    }
    let mut total = sums[0];
    for k in 1..CHAINS {
        total += sums[k];
    }
    f64::from(total.as_slice()[0])
}

#[inline(always)]
fn sum<S: Simd>(simd: S, data: &[f64]) -> f64 {
    let mut sums = [simd.splat_f64x8(0.0); 8];
    for chunk in data.as_chunks::<64>().0 {
        for k in 0..8 {
            sums[k] += f64x8::from_slice(simd, &chunk[8 * k..8 * k + 8]);
        }
    }
    let mut total = sums[0];
    for k in 1..8 {
        total += sums[k];
    }
    total.as_slice()[0]
}
