//! Time from the report of a key to the stop of the finger on it, as a tracker sees it.

use super::{LatencyError, MeasuredDelay, Trace, TraceSample, trusted};

/// From a key that moves to its character in a program \[s\]: 15 to 60 ms were measured of
/// keyboards up to their cable (Luu 2017), most about 30.
pub const KEY_DELAY: f64 = 0.03;
/// Uncertainty of that delay, either way, where nobody measured it \[s\].
pub const KEY_DELAY_SPREAD: f64 = 0.015;

/// A tap is looked for from this long before its key is reported \[s\] ...
const BEFORE: f64 = 0.15;
/// ... to this long after it \[s\].
const AFTER: f64 = 0.5;
/// Speeds are taken over no less than this \[s\]: 10 mm/s of noise in a glove of 0.1 mm.
const SPAN: f64 = 0.008;
/// A finger that comes down more slowly does not tap \[m/s\].
const SLOW: f64 = 0.1;
/// One that comes less far \[m\].
const NEAR: f64 = 0.005;
/// Time for which the finger stays down, at least \[s\].
const DWELL: f64 = 0.05;
/// The stop comes so soon after the greatest speed \[s\].
const SOON: f64 = 0.1;
/// Taps that are needed.
const TAPS: usize = 10;
/// Distance from the median, in median distances, beyond which a motion is another one;
/// normal deviates exceed it once in 7000.
const STRAY: f64 = 5.7;

/// Mean time from the report of a key to the stop of `finger` as the tracker sees it, over these
/// keys \[s\]. The tracker's delay is this and the key's own ([`KEY_DELAY`]).
///
/// # Errors
/// There are too few taps, or they contradict each other.
pub fn taps(trace: &Trace, finger: usize, keys: &[f64]) -> Result<MeasuredDelay, LatencyError> {
    let late: Vec<f64> = (keys.iter())
        .filter_map(|key| Some(stop(trace.between(key - BEFORE, key + AFTER), finger)? - key))
        .collect();
    let too_few = |count| LatencyError::TooFew { what: "taps", count, wanted: TAPS };
    if late.len() < TAPS.min(keys.len()) || keys.len() < TAPS {
        return Err(too_few(late.len()));
    }
    let middle = median(&late);
    let distance = median(&late.iter().map(|x| (x - middle).abs()).collect::<Vec<_>>());
    // Of taps that are exactly alike none strays by the clock's grain.
    let near = |x: &f64| (x - middle).abs() <= (STRAY * distance).max(1e-4);
    let kept: Vec<f64> = late.into_iter().filter(near).collect();
    let odd = keys.len() - kept.len();
    if 3 * odd > keys.len() {
        let what = "keys came without a tap like the others";
        return Err(LatencyError::Odd { what, odd, count: keys.len() });
    }
    if kept.len() < TAPS {
        return Err(too_few(kept.len()));
    }
    let (first, second) = kept.split_at(kept.len() / 2);
    trusted(mean(&kept), [mean(first), mean(second)])
}

fn mean(all: &[f64]) -> MeasuredDelay {
    let n = all.len() as f64;
    let mean = all.iter().sum::<f64>() / n;
    let squares: f64 = all.iter().map(|x| (x - mean).powi(2)).sum();
    MeasuredDelay { mean, error: (squares / (n - 1.0) / n).sqrt(), events: all.len() }
}

fn median(all: &[f64]) -> f64 {
    let mut sorted = all.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

/// Time at which the finger that comes down fastest here stops \[s\]: where the straight line of
/// its greatest speed meets the level on which it stays.
fn stop(seen: &[TraceSample], finger: usize) -> Option<f64> {
    let down = |s: &TraceSample| -s.tips[finger].y;
    let stroke = |i: usize| {
        let rest = &seen[i..];
        let end = rest.iter().position(|s| s.arrived - rest[0].arrived >= SPAN)?;
        let dt = rest[end].arrived - rest[0].arrived;
        Some((i, end, (down(&rest[end]) - down(&rest[0])) / dt))
    };
    let strokes = (0..seen.len()).filter_map(stroke);
    let (first, end, speed) = strokes.max_by(|a, b| a.2.total_cmp(&b.2))?;
    let line = &seen[first..=first + end];
    let n = line.len() as f64;
    let (at, from) = line.iter().fold((0.0, 0.0), |(t, x), s| (t + s.arrived / n, x + down(s) / n));
    let later = seen[first..].iter().take_while(|s| s.arrived <= at + SOON + DWELL);
    let most = later.clone().map(down).fold(f64::MIN, f64::max);
    let before = seen[..=first].iter().map(down).fold(f64::MAX, f64::min);
    if speed < SLOW || most - before < NEAR {
        return None;
    }
    let mut held = later.skip_while(|s| down(s) < before + 0.8 * (most - before)).peekable();
    let since = held.peek()?.arrived;
    let held: Vec<f64> = held.take_while(|s| s.arrived <= since + DWELL).map(down).collect();
    let stop = at + (median(&held) - from) / speed;
    (at - SPAN..at + SOON).contains(&stop).then_some(stop)
}

#[cfg(test)]
mod tests {
    use super::super::trial::{Moment, SimulatedTracker};
    use super::*;
    use thenar_core::Vec3;
    use thenar_core::random::Random;

    /// Keys on an uneven beat: when each is down.
    fn beat(count: usize) -> Vec<f64> {
        let mut random = Random::new(5);
        (0..count).map(|k| 1.0 + k as f64 + 0.2 * random.unit()).collect()
    }

    /// The index finger comes down by 30 mm within 80 ms, ever faster, stops dead, stays for 90 ms
    /// and rises in 120 ms.
    fn tapping(downs: Vec<f64>) -> impl Fn(f64) -> Moment {
        move |t| {
            let near = downs.iter().copied().min_by(|a, b| (a - t).abs().total_cmp(&(b - t).abs()));
            let s = t - near.unwrap_or(f64::MIN);
            let depth = match s {
                s if (-0.08..0.0).contains(&s) => (1.0 + s / 0.08).powi(2),
                s if (0.0..0.09).contains(&s) => 1.0,
                s if (0.09..0.21).contains(&s) => {
                    0.5 + 0.5 * ((s - 0.09) / 0.12 * std::f64::consts::PI).cos()
                }
                _ => 0.0,
            };
            let mut moment = Moment::default();
            moment.tips[1] = -Vec3::y() * (0.03 * depth);
            moment
        }
    }

    /// The stop is seen later than a key without a delay by the tracker's delay: to 2 ms, or three
    /// stated errors.
    #[test]
    fn the_stop_of_a_finger_is_late_by_the_delay() {
        for (rate, latency, noise) in [
            (90.0, 0.045, 1e-3),
            (100.0, 0.01, 1e-4),
            (60.0, 0.1, 5e-4),
            (1000.0, 0.002, 1e-4),
            (120.0, 0.0, 2e-4),
        ] {
            let fake = SimulatedTracker { rate, latency, noise, lost: 0.02, jitter: 1e-3 };
            let downs = beat(25);
            let trace = fake.watch(7, 30.0, &tapping(downs.clone()));
            let MeasuredDelay { mean, error, events } = taps(&trace, 1, &downs).unwrap();
            let off = mean - latency;
            assert!(
                off.abs() < 0.002_f64.max(3.0 * error),
                "{rate} Hz {latency} s: {off} +- {error} s"
            );
            assert!(
                events >= 20 && error < 0.003 && off.abs() < 0.004,
                "{off} +- {error} s, {events}"
            );
        }
    }

    #[test]
    fn taps_that_are_few_or_odd_are_refused() {
        let fake =
            SimulatedTracker { rate: 100.0, latency: 0.02, noise: 1e-4, lost: 0.0, jitter: 0.0 };
        let downs = beat(20);
        let trace = fake.watch(7, 25.0, &tapping(downs.clone()));
        let told = taps(&trace, 1, &downs[..6]).unwrap_err();
        assert_eq!(told, LatencyError::TooFew { what: "taps", count: 6, wanted: 10 });
        // Another finger pressed the keys.
        assert!(matches!(
            taps(&trace, 2, &downs).unwrap_err(),
            LatencyError::TooFew { count: 0, .. }
        ));
        // Every other key came at another time.
        let odd: Vec<f64> = downs
            .iter()
            .enumerate()
            .map(|(k, t)| t - if k % 2 == 0 { 0.0 } else { 0.06 + 0.004 * k as f64 })
            .collect();
        let told = taps(&trace, 1, &odd).unwrap_err();
        assert!(matches!(told, LatencyError::Odd { .. } | LatencyError::Scatter { .. }), "{told}");
        // The keyboard becomes later by 30 ms midway.
        let late: Vec<f64> = downs.iter().map(|t| t - if *t > 11.0 { 0.03 } else { 0.0 }).collect();
        let told = taps(&trace, 1, &late).unwrap_err();
        assert!(matches!(told, LatencyError::Halves { .. } | LatencyError::Odd { .. }), "{told}");
    }
}
