//! Speeds of what a tracker told, at times of one's own, without a delay of their own.

use super::{ComparedPart, TraceSample};
use nalgebra::{Matrix3, Vector3};

/// Time from one speed to the next \[s\].
pub const STEP: f64 = 0.002;
/// A parabola is laid through what is this near, before and after \[s\] ...
const REACH: f64 = 0.06;
/// ... or, of a slow tracker, through this number of samples before and after.
const REACH_SAMPLES: f64 = 2.5;

/// Reach of a parabola for trackers of these rates \[s\].
pub fn reach(rates: [f64; 2]) -> f64 {
    rates.into_iter().fold(REACH, |reach, rate| reach.max(REACH_SAMPLES / rate))
}

/// Speed at each of `count` times `STEP` apart from `begin` on; `None` where samples are missing.
///
/// It is the slope of the parabola that fits best about each time, nearer samples counting more:
/// what it takes off quick motion it takes off before and after alike, so that it delays nothing.
pub fn speeds(
    seen: &[TraceSample],
    part: ComparedPart,
    begin: f64,
    count: usize,
    reach: f64,
) -> Vec<Option<f64>> {
    let numbers = |s: &TraceSample| match part {
        ComparedPart::Fingers => [s.flexion.iter().sum::<f64>() / s.flexion.len() as f64, 0.0, 0.0],
        ComparedPart::Wrist => [s.wrist.x, s.wrist.y, s.wrist.z],
    };
    let (mut first, mut last) = (0, 0);
    let speed = |k: usize| {
        let t = begin + k as f64 * STEP;
        while first < seen.len() && seen[first].arrived < t - reach {
            first += 1;
        }
        while last < seen.len() && seen[last].arrived <= t + reach {
            last += 1;
        }
        let near = &seen[first..last.max(first)];
        let before = near.partition_point(|s| s.arrived <= t);
        // Nothing is told beyond a gap.
        if before < 2 || near.len() - before < 2 {
            return None;
        }
        let mut normal = Matrix3::<f64>::zeros();
        let mut right = [Vector3::<f64>::zeros(); 3];
        for s in near {
            let x = (s.arrived - t) / reach;
            let (row, weight) = (Vector3::new(1.0, x, x * x), 1.0 - x.abs());
            normal += row * row.transpose() * weight;
            for (right, number) in right.iter_mut().zip(numbers(s)) {
                *right += row * (weight * number);
            }
        }
        let inverse = normal.try_inverse()?;
        let slope = right.map(|right| (inverse * right).y / reach);
        Some(match part {
            ComparedPart::Fingers => slope[0],
            ComparedPart::Wrist => slope.iter().map(|v| v * v).sum::<f64>().sqrt(),
        })
        .filter(|speed| speed.is_finite())
    };
    (0..count).map(speed).collect()
}
