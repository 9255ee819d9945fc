//! Lag of one tracker behind another that sees the same motion.

use super::moving::{STEP, reach, speeds};
use super::{ComparedPart, LatencyError, MeasuredDelay, Trace, trusted};

/// Lags that are looked at \[s\]: a device may be earlier than its reference, and webcams are late
/// by a fifth of a second.
const FROM: f64 = -0.3;
/// The largest \[s\].
const TO: f64 = 0.6;
/// Half of the width in which a part of a session is looked at, about the lag of all of it \[s\].
const ABOUT: f64 = 0.06;
/// An event is so much motion without a rest \[s\].
const EVENT: f64 = 1.0;
/// Events that are needed.
const EVENTS: usize = 8;
/// A hand that is slower on average over an event does not move: fingers \[rad/s\], of which a hand
/// that closes within two seconds has 2 ...
const FINGERS_MOVE: f64 = 0.5;
/// ... and wrist \[m/s\], of which a hand that goes a forearm's length in two seconds has 0.15.
const WRIST_MOVES: f64 = 0.1;
/// Speeds that match less are of different motions.
const ALIKE: f64 = 0.8;
/// Another peak that is as high as this part of the best is as good ...
const AS_GOOD: f64 = 0.9;
/// ... if it stands apart from it by more than this \[s\].
const APART: f64 = 0.1;

/// Measured lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lag {
    /// By how much the device is later than its reference.
    pub measured: MeasuredDelay,
    /// Correlation of the speeds at that lag.
    pub correlation: f64,
}

/// Sums over the pairs of speeds of an event at one lag.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    n: f64,
    a: f64,
    b: f64,
    aa: f64,
    bb: f64,
    ab: f64,
}

impl Sums {
    fn add(&mut self, a: f64, b: f64) {
        let more = Self { n: 1.0, a, b, aa: a * a, bb: b * b, ab: a * b };
        *self = self.with(&more, 1.0);
    }

    fn with(&self, other: &Self, times: f64) -> Self {
        Self {
            n: self.n + times * other.n,
            a: self.a + times * other.a,
            b: self.b + times * other.b,
            aa: self.aa + times * other.aa,
            bb: self.bb + times * other.bb,
            ab: self.ab + times * other.ab,
        }
    }

    fn correlation(&self) -> f64 {
        let (va, vb) = (self.aa - self.a * self.a / self.n, self.bb - self.b * self.b / self.n);
        let c = (self.ab - self.a * self.b / self.n) / (va * vb).sqrt();
        if c.is_finite() { c } else { 0.0 }
    }
}

/// An event: its sums at every lag.
type Event = Vec<Sums>;

/// By how much `device` sees motion later than `reference`, from the correlation of their speeds
/// over all events; the standard error is the jackknife's over events.
///
/// # Errors
/// The motion is too little, too regular or not the same, or its parts contradict each other.
pub fn lag(device: &Trace, reference: &Trace, part: ComparedPart) -> Result<Lag, LatencyError> {
    let events = events(device, reference, part);
    if events.len() < EVENTS {
        let what = "seconds of motion that both trackers see";
        return Err(LatencyError::TooFew { what, count: events.len(), wanted: EVENTS });
    }
    let all = sum(&events);
    let curve: Vec<f64> = all.iter().map(Sums::correlation).collect();
    let best = (0..curve.len()).max_by(|i, j| curve[*i].total_cmp(&curve[*j])).unwrap_or(0);
    let correlation = curve[best];
    if correlation < ALIKE {
        return Err(LatencyError::Unlike { correlation });
    }
    if best == 0 || best + 1 == curve.len() {
        return Err(LatencyError::OutOfRange { from: FROM, to: TO });
    }
    let peaks = 1..curve.len() - 1;
    let other = peaks
        .filter(|k| curve[*k] >= curve[k - 1] && curve[*k] >= curve[k + 1])
        .filter(|k| k.abs_diff(best) as f64 * STEP > APART)
        .find(|k| curve[*k] > AS_GOOD * correlation);
    if let Some(other) = other {
        return Err(LatencyError::Ambiguous { best: lag_of(best), other: lag_of(other) });
    }
    let (first, second) = events.split_at(events.len() / 2);
    let halves = [jackknife(first, best), jackknife(second, best)];
    let measured = trusted(jackknife(&events, best), halves)?;
    Ok(Lag { measured, correlation })
}

fn lag_of(index: usize) -> f64 {
    FROM + index as f64 * STEP
}

fn sum(events: &[Event]) -> Event {
    let lags = events.first().map_or(0, Vec::len);
    (0..lags)
        .map(|j| events.iter().fold(Sums::default(), |all, event| all.with(&event[j], 1.0)))
        .collect()
}

/// Lag of the highest point of the parabola through the largest correlation and its neighbours
/// \[s\].
fn peak(sums: &[Sums], near: usize) -> f64 {
    let about = (ABOUT / STEP) as usize;
    let range = near.saturating_sub(about).max(1)..(near + about).min(sums.len() - 1);
    let at = |k: usize| sums[k].correlation();
    let Some(k) = range.max_by(|i, j| at(*i).total_cmp(&at(*j))) else { return lag_of(near) };
    let [before, here, after] = [at(k - 1), at(k), at(k + 1)];
    let bend = before - 2.0 * here + after;
    let off = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
    lag_of(k) + off.clamp(-1.0, 1.0) * STEP
}

/// Lag of these events, with the standard error that leaving out each of them tells.
fn jackknife(events: &[Event], near: usize) -> MeasuredDelay {
    let (all, n) = (sum(events), events.len() as f64);
    let mean = peak(&all, near);
    let without = |event: &Event| {
        let rest: Event = all.iter().zip(event).map(|(all, one)| all.with(one, -1.0)).collect();
        peak(&rest, near)
    };
    let lags: Vec<f64> = events.iter().map(without).collect();
    let middle = lags.iter().sum::<f64>() / n;
    let squares: f64 = lags.iter().map(|lag| (lag - middle).powi(2)).sum();
    MeasuredDelay { mean, error: ((n - 1.0) / n * squares).sqrt(), events: events.len() }
}

/// Seconds in which the hand moves, each with its sums at every lag.
fn events(device: &Trace, reference: &Trace, part: ComparedPart) -> Vec<Event> {
    let [Some(a_rate), Some(b_rate)] = [device.rate(), reference.rate()] else { return Vec::new() };
    let start = |trace: &Trace| trace.seen.first().map_or(0.0, |s| s.arrived);
    let end = |trace: &Trace| trace.seen.last().map_or(0.0, |s| s.arrived);
    let begin = start(device).max(start(reference));
    let seconds = end(device).min(end(reference)) - begin;
    if seconds.is_nan() || seconds < EVENT {
        return Vec::new();
    }
    let (count, reach) = ((seconds / STEP) as usize, reach([a_rate, b_rate]));
    let a = speeds(&device.seen, part, begin, count, reach);
    let b = speeds(&reference.seen, part, begin, count, reach);
    let moves = match part {
        ComparedPart::Fingers => FINGERS_MOVE,
        ComparedPart::Wrist => WRIST_MOVES,
    };
    let (first, lags) = ((FROM / STEP).round() as isize, ((TO - FROM) / STEP).round() as usize + 1);
    let length = (EVENT / STEP) as usize;
    let event = |window: usize| -> Option<Event> {
        let range = window * length..(window + 1) * length;
        let known: Vec<f64> = a[range.clone()].iter().flatten().copied().collect();
        let mean_square = known.iter().map(|v| v * v).sum::<f64>() / known.len() as f64;
        // Half of it known, and in motion.
        if 2 * known.len() < length || mean_square.is_nan() || mean_square.sqrt() < moves {
            return None;
        }
        let sums = |j: usize| {
            let mut sums = Sums::default();
            for k in range.clone() {
                let before = k as isize - (first + j as isize);
                let other = usize::try_from(before).ok().and_then(|k| *b.get(k)?);
                if let (Some(a), Some(b)) = (a[k], other) {
                    sums.add(a, b);
                }
            }
            sums
        };
        let event: Event = (0..lags).map(sums).collect();
        // What the reference did not see at most of the lags is no event.
        let whole = event.iter().filter(|sums| 2.0 * sums.n >= length as f64).count();
        (2 * whole >= lags).then_some(event)
    };
    (0..count / length).filter_map(event).collect()
}

#[cfg(test)]
mod tests {
    use super::super::trial::{Moment, SimulatedTracker, still, wander};
    use super::*;

    fn pair(
        device: SimulatedTracker,
        reference: SimulatedTracker,
        seconds: f64,
        motion: &dyn Fn(f64) -> Moment,
    ) -> [Trace; 2] {
        [device.watch(11, seconds, motion), reference.watch(12, seconds, motion)]
    }

    const GLOVE: SimulatedTracker =
        SimulatedTracker { rate: 100.0, latency: 0.01, noise: 1e-4, lost: 0.0, jitter: 5e-4 };
    const HEADSET: SimulatedTracker =
        SimulatedTracker { rate: 90.0, latency: 0.045, noise: 1e-3, lost: 0.02, jitter: 2e-3 };

    /// Devices whose delay, rate and noise are known: the difference of the delays is found to 2
    /// ms, or within three of its stated errors, and the stated error is worth something.
    #[test]
    fn the_lag_between_two_trackers_is_found() {
        let slow =
            SimulatedTracker { rate: 30.0, latency: 0.1, noise: 2e-3, lost: 0.05, jitter: 4e-3 };
        let quick =
            SimulatedTracker { rate: 1000.0, latency: 0.002, noise: 2e-5, lost: 0.0, jitter: 2e-4 };
        let late =
            SimulatedTracker { rate: 60.0, latency: 0.25, noise: 1e-3, lost: 0.0, jitter: 1e-3 };
        let at_once =
            SimulatedTracker { rate: 120.0, latency: 0.0, noise: 5e-4, lost: 0.0, jitter: 0.0 };
        for part in [ComparedPart::Fingers, ComparedPart::Wrist] {
            for (device, reference) in [
                (HEADSET, GLOVE),
                (GLOVE, HEADSET),
                (slow, GLOVE),
                (slow, quick),
                (late, quick),
                (at_once, HEADSET),
                (GLOVE, quick),
            ] {
                let [seen, by] = pair(device, reference, 20.0, &wander);
                let found = lag(&seen, &by, part).unwrap();
                let MeasuredDelay { mean, error, events } = found.measured;
                let off = mean - (device.latency - reference.latency);
                assert!(off.abs() < 0.002_f64.max(3.0 * error), "{device:?} {off} +- {error} s");
                assert!(
                    error < 0.003 && off.abs() < 0.004 && events >= 15,
                    "{off} +- {error} s, {events}"
                );
                assert!(
                    (seen.rate().unwrap() / (device.rate * (1.0 - device.lost)) - 1.0).abs() < 0.02
                );
            }
        }
    }

    /// Errors of many sessions are as large as stated, rms, give or take: the statement is neither
    /// boast nor alarm.
    #[test]
    fn the_stated_error_is_one() {
        let (mut squares, mut stated) = (0.0, 0.0);
        let sessions = 24_u32;
        for k in 0..sessions {
            let motion = |t: f64| wander(t + 37.3 * f64::from(k));
            let (seed, other) = (100 + 2 * u64::from(k), 101 + 2 * u64::from(k));
            let seen = HEADSET.watch(seed, 16.0, &motion);
            let found = lag(&seen, &GLOVE.watch(other, 16.0, &motion), ComparedPart::Fingers)
                .unwrap()
                .measured;
            squares += (found.mean - 0.035).powi(2);
            stated += found.error.powi(2);
        }
        let ratio = (squares / stated).sqrt();
        assert!((0.5..2.0).contains(&ratio), "off by {ratio} stated errors, rms");
    }

    #[test]
    fn too_little_and_contradictory_motion_is_refused() {
        let [seen, by] = pair(HEADSET, GLOVE, 6.0, &wander);
        let told = lag(&seen, &by, ComparedPart::Fingers).unwrap_err();
        assert!(matches!(told, LatencyError::TooFew { wanted: 8, .. }), "{told}");
        let [seen, by] = pair(HEADSET, GLOVE, 20.0, &still(1e-3, 3.0));
        assert!(matches!(
            lag(&seen, &by, ComparedPart::Fingers),
            Err(LatencyError::TooFew { count: 0, .. })
        ));
        assert!(matches!(
            lag(&Trace::default(), &by, ComparedPart::Wrist),
            Err(LatencyError::TooFew { .. })
        ));
        // Each its own motion.
        let by = GLOVE.watch(3, 20.0, &|t| wander(t + 531.7));
        let seen = HEADSET.watch(4, 20.0, &wander);
        let told = lag(&seen, &by, ComparedPart::Fingers).unwrap_err();
        assert!(
            matches!(told, LatencyError::Unlike { correlation } if correlation < 0.8),
            "{told}"
        );
        // As even as a metronome at 2.5 Hz.
        let even = |t: f64| Moment::bent(0.5 * (15.0 * t).sin());
        let [seen, by] = pair(HEADSET, GLOVE, 20.0, &even);
        let told = lag(&seen, &by, ComparedPart::Fingers).unwrap_err();
        assert!(matches!(told, LatencyError::Ambiguous { .. }), "{told}");
        // A tracker that becomes later by 40 ms midway.
        let mut seen = HEADSET.watch(5, 20.0, &wander);
        seen.seen.iter_mut().filter(|s| s.arrived > 10.0).for_each(|s| s.arrived += 0.04);
        let told = lag(&seen, &GLOVE.watch(6, 20.0, &wander), ComparedPart::Fingers).unwrap_err();
        assert!(
            matches!(told, LatencyError::Halves { .. } | LatencyError::Scatter { .. }),
            "{told}"
        );
    }
}
