//! The noise of a hand that is held still.

use super::{LatencyError, TraceSample};

/// Noise is what remains without drift within windows of this length \[s\]: motion slower than some
/// 2 Hz is the person's.
const WINDOW: f64 = 0.5;
/// Windows that are needed.
const WINDOWS: usize = 4;
/// Samples that a window needs: a line is taken off them.
const SAMPLES: usize = 5;
/// A fingertip that goes further is not held still \[m\].
const STRAYS: f64 = 0.02;

/// Standard deviation of a fingertip that stands still, along its worst axis, all fingers together
/// \[m\]: about a straight line in each half second.
///
/// # Errors
/// There are too few samples, or the hand moved.
pub fn stillness(seen: &[TraceSample]) -> Result<f64, LatencyError> {
    for finger in 0..5 {
        for axis in 0..3 {
            let places = seen.iter().map(|s| s.tips[finger][axis]);
            let (least, most) = places.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
            if most - least > STRAYS {
                return Err(LatencyError::Moved { by: most - least });
            }
        }
    }
    let begin = seen.first().map_or(0.0, |s| s.arrived);
    let windows: Vec<&[TraceSample]> = (seen.chunk_by(|a, b| {
        ((a.arrived - begin) / WINDOW).floor() == ((b.arrived - begin) / WINDOW).floor()
    }))
    .filter(|window| window.len() >= SAMPLES)
    .collect();
    if windows.len() < WINDOWS {
        let what = "half seconds with a hand held still";
        return Err(LatencyError::TooFew { what, count: windows.len(), wanted: WINDOWS });
    }
    let worst = |finger: usize| -> f64 {
        let along = |axis: usize| {
            let (squares, free) = windows.iter().fold((0.0, 0.0), |(squares, free), window| {
                let points = window.iter().map(|s| [s.arrived, s.tips[finger][axis]]);
                (squares + off_line(points), free + window.len() as f64 - 2.0)
            });
            squares / free
        };
        [0, 1, 2].map(along).into_iter().fold(0.0, f64::max)
    };
    Ok(((0..5).map(worst).sum::<f64>() / 5.0).sqrt())
}

/// Sum of squares about the straight line that fits best.
fn off_line(points: impl Iterator<Item = [f64; 2]> + Clone) -> f64 {
    let n = points.clone().count() as f64;
    let sum = points.clone().fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    let [tt, tx, xx] = points.fold([0.0; 3], |[tt, tx, xx], [t, x]| {
        let (t, x) = (t - sum[0] / n, x - sum[1] / n);
        [tt + t * t, tx + t * x, xx + x * x]
    });
    if tt > 0.0 { (xx - tx * tx / tt).max(0.0) } else { xx }
}

#[cfg(test)]
mod tests {
    use super::super::trial::{SimulatedTracker, still};
    use super::*;

    /// White noise of a known size, at several rates, on a hand that sways by 1 mm in 5 s: found to
    /// a tenth.
    #[test]
    fn noise_is_found_beside_a_slow_sway() {
        for (rate, noise) in [(90.0, 1e-3), (100.0, 1e-4), (30.0, 2e-3), (1000.0, 3e-5)] {
            let fake = SimulatedTracker { rate, latency: 0.04, noise, lost: 0.05, jitter: 1e-3 };
            let trace = fake.watch(3, 6.0, &still(1e-3, 5.0));
            let found = stillness(&trace.seen).unwrap();
            assert!((found / noise - 1.0).abs() < 0.1, "{rate} Hz {noise} m: {found} m");
        }
    }

    #[test]
    fn a_hand_that_moves_is_not_still() {
        let fake =
            SimulatedTracker { rate: 90.0, latency: 0.04, noise: 1e-3, lost: 0.0, jitter: 0.0 };
        let told = stillness(&fake.watch(3, 6.0, &still(0.03, 2.0)).seen).unwrap_err();
        assert!(matches!(told, LatencyError::Moved { by } if by > 0.03), "{told}");
        let told = stillness(&fake.watch(3, 1.2, &still(0.0, 1.0)).seen).unwrap_err();
        assert!(matches!(told, LatencyError::TooFew { count: 3, .. }), "{told}");
        assert!(matches!(stillness(&[]).unwrap_err(), LatencyError::TooFew { count: 0, .. }));
    }
}
