//! Times at which the moments of a recording are due. Reads no clock itself.

use crate::rounds::{LAG_MAX, Speedometer};
use std::time::{Duration, Instant};

/// Longer silences of a recording (nobody watched, or it was paused) are made so short \[s\].
const SILENCE_MAX: f64 = 1.0;

/// Joins the recording's time and ours.
#[derive(Clone, Copy, Debug)]
pub struct PlaybackClock {
    /// A moment, and when it was shown.
    last: (f64, Instant),
    reached: Speedometer,
}

impl PlaybackClock {
    /// The moment `at` \[s\] is shown now.
    pub fn new(at: f64, now: Instant) -> Self {
        Self { last: (at, now), reached: Speedometer::new(now) }
    }

    /// Time at which the next moment is due, at this speed.
    pub fn due(&self, at: f64, speed: f64) -> Instant {
        let (last, shown) = self.last;
        shown + Duration::from_secs_f64((at - last).clamp(0.0, SILENCE_MAX) / speed)
    }

    /// A moment was shown, `now` or a little late.
    pub fn shown(&mut self, at: f64, speed: f64, now: Instant) {
        let due = self.due(at, speed);
        self.reached.pass((at - self.last.0).clamp(0.0, SILENCE_MAX), now);
        self.last = (at, if now > due + LAG_MAX { now } else { due });
    }

    /// Recorded over real time, once it has been measured.
    pub fn speed(&self) -> Option<f64> {
        self.reached.speed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shows moments `step` apart, each of which takes `cost` to be made; how long all of them take
    /// \[s\].
    fn play(count: u32, step: f64, speed: f64, cost: f64) -> (f64, PlaybackClock) {
        let start = Instant::now();
        let (mut now, mut clock) = (start, PlaybackClock::new(0.0, start));
        for k in 1..=count {
            let at = f64::from(k) * step;
            now += Duration::from_secs_f64(cost);
            now = now.max(clock.due(at, speed));
            clock.shown(at, speed, now);
        }
        ((now - start).as_secs_f64(), clock)
    }

    #[test]
    fn a_recording_takes_as_long_as_it_took() {
        for speed in [1.0, 0.25] {
            let (took, clock) = play(400, 0.01, speed, 0.004);
            assert!((took - 4.0 / speed).abs() < 1e-6, "{took}");
            assert!((clock.speed().unwrap() - speed).abs() < 0.05 * speed);
        }
    }

    #[test]
    fn a_slow_machine_shows_slow_motion() {
        let (took, clock) = play(200, 0.01, 1.0, 0.02);
        assert!((took - 4.0).abs() < 0.05, "{took}");
        assert!((clock.speed().unwrap() - 0.5).abs() < 0.03);
    }

    #[test]
    fn silences_are_shortened() {
        let now = Instant::now();
        let clock = PlaybackClock::new(3.0, now);
        assert_eq!(clock.due(3.5, 1.0) - now, Duration::from_millis(500));
        assert_eq!(clock.due(3600.0, 1.0) - now, Duration::from_secs(1));
        assert_eq!(clock.due(3600.0, 0.5) - now, Duration::from_secs(2));
    }
}
