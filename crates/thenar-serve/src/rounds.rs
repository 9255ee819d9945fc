//! Rules that the loops of a live simulation and of a recording share.

use crate::protocol::{Pace, flags};
use std::time::{Duration, Instant};

/// Longest sleep, so that the end of the program or of a scene's making is not missed.
pub const SLEEP_MAX: Duration = Duration::from_millis(50);
/// Statuses are at least so far apart: a slider changes them with every pixel.
pub const STATUS_EVERY: Duration = Duration::from_millis(40);
/// Events taken between two looks at the clock.
pub const EVENTS_AT_ONCE: usize = 256;
/// Steps may lag behind by this much and catch up; what is later is given up, so that a slow
/// machine shows slow motion and never falls further and further behind.
pub const LAG_MAX: Duration = Duration::from_millis(40);
/// Speed is measured over at least this long.
const WINDOW: Duration = Duration::from_millis(500);
/// Slower than this part of the wanted speed is called slow.
const SLOW: f64 = 0.95;
/// Least time between notices to a client whose poses move nothing.
const NOTICE_INTERVAL: Duration = Duration::from_secs(5);

/// Speed of simulated or recorded time against real time. Reads no clock itself.
#[derive(Clone, Copy, Debug)]
pub struct Speedometer {
    since: Instant,
    /// Simulated or recorded time since then \[s\].
    passed: f64,
    reached: Option<f64>,
}

impl Speedometer {
    /// Nothing has been measured before now.
    pub fn new(now: Instant) -> Self {
        Self { since: now, passed: 0.0, reached: None }
    }

    /// Counts seconds more that have passed by now.
    pub fn pass(&mut self, seconds: f64, now: Instant) {
        self.passed += seconds;
        let real = now.saturating_duration_since(self.since);
        if real >= WINDOW {
            let reached = Some(self.passed / real.as_secs_f64());
            *self = Self { reached, ..Self::new(now) };
        }
    }

    /// Simulated or recorded over real time, once it has been measured.
    pub fn speed(&self) -> Option<f64> {
        self.reached
    }
}

/// Pace of a snapshot: steps of `h` \[s\] that take `cost`, at the wanted speed and at the one that
/// is reached, as far as it is known.
pub fn pace(paused: bool, wanted: f64, reached: Option<f64>, h: f64, cost: Duration) -> Pace {
    let reached = reached.unwrap_or(wanted);
    let paused_flag = if paused { flags::PAUSED } else { 0 };
    let slow = if reached < SLOW * wanted { flags::SLOW } else { 0 };
    Pace {
        flags: paused_flag | slow,
        cost_ms: cost.as_secs_f64() * 1e3,
        budget_ms: h / wanted * 1e3,
        speed: if paused { 0.0 } else { reached },
        ..Pace::default()
    }
}

/// Notices to clients whose poses move nothing, now and then.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scold(Option<Instant>);

impl Scold {
    /// True when a notice is due, which is then given.
    pub fn is_due(&mut self, now: Instant) -> bool {
        let due = self.0.is_none_or(|last| now - last > NOTICE_INTERVAL);
        if due {
            self.0 = Some(now);
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notices_are_five_seconds_apart() {
        let (mut scold, start) = (Scold::default(), Instant::now());
        let given = (0..120).filter(|k| scold.is_due(start + Duration::from_millis(100 * k)));
        assert_eq!(given.collect::<Vec<_>>(), [0, 51, 102]);
    }

    /// Ten steps of 10 ms a tenth of a second, then five.
    #[test]
    fn pace_says_what_is_reached_of_what_is_wanted() {
        let start = Instant::now();
        let mut speed = Speedometer::new(start);
        let slow = |speed: &Speedometer| {
            let pace = pace(false, 1.0, speed.speed(), 0.01, Duration::from_millis(4));
            assert_eq!((pace.cost_ms, pace.budget_ms), (4.0, 10.0));
            (pace.flags == flags::SLOW, pace.speed)
        };
        assert_eq!(slow(&speed), (false, 1.0));
        (1..=50).for_each(|k| speed.pass(0.01, start + Duration::from_millis(10 * k)));
        let (is_slow, reached) = slow(&speed);
        assert!(!is_slow && (reached - 1.0).abs() < 1e-9, "{reached}");
        (1..=25).for_each(|k| speed.pass(0.01, start + Duration::from_millis(500 + 20 * k)));
        let (is_slow, reached) = slow(&speed);
        assert!(is_slow && (reached - 0.5).abs() < 1e-9, "{reached}");
        let paused = pace(true, 1.0, speed.speed(), 0.01, Duration::ZERO);
        assert_eq!((paused.flags, paused.speed), (flags::PAUSED | flags::SLOW, 0.0));
    }
}
