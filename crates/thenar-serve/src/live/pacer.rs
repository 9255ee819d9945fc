//! Keeps steps in time with a clock, and says how well that goes. Reads no clock itself.

use crate::rounds::{LAG_MAX, Speedometer};
use std::time::{Duration, Instant};

/// Schedule of the steps.
#[derive(Clone, Copy, Debug)]
pub struct Pacer {
    due: Instant,
    reached: Speedometer,
}

impl Pacer {
    /// A first step is due now.
    pub fn new(now: Instant) -> Self {
        Self { due: now, reached: Speedometer::new(now) }
    }

    /// Starts over after a rest: nothing is to be caught up.
    pub fn resume(&mut self, now: Instant) {
        *self = Self::new(now);
    }

    /// Time at which the next step is due.
    pub fn due(&self) -> Instant {
        self.due
    }

    /// A step of `simulated` \[s\] was begun at `begun`; the next is due `period` after it was.
    pub fn stepped(&mut self, simulated: f64, period: Duration, begun: Instant) {
        self.due += period;
        let lag_max = LAG_MAX.max(period);
        if begun > self.due + lag_max {
            self.due = begun;
        }
        self.reached.pass(simulated, begun);
    }

    /// Simulated over real time, once it has been measured.
    pub fn speed(&self) -> Option<f64> {
        self.reached.speed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs for `seconds` with steps of `h` at `speed` that cost `cost(step)`, on a made-up clock.
    fn run(h: f64, speed: f64, seconds: f64, cost: impl Fn(u32) -> f64) -> (f64, f64, Pacer) {
        let start = Instant::now();
        let mut now = start;
        let mut pacer = Pacer::new(now);
        let mut steps = 0;
        while (now - start).as_secs_f64() < seconds {
            now = now.max(pacer.due());
            pacer.stepped(h, Duration::from_secs_f64(h / speed), now);
            now += Duration::from_secs_f64(cost(steps));
            steps += 1;
        }
        (f64::from(steps) * h, (now - start).as_secs_f64(), pacer)
    }

    #[test]
    fn time_simulated_keeps_up_with_time_even_after_a_slow_step() {
        for speed in [1.0, 0.25] {
            let slow_step = |k: u32| if k == 100 { 0.03 } else { 0.004 };
            let (simulated, real, pacer) = run(0.01, speed, 5.0, slow_step);
            assert!((simulated - speed * real).abs() < 0.011, "{simulated} {real}");
            assert!((pacer.speed().unwrap() - speed).abs() < 0.05 * speed);
        }
    }

    #[test]
    fn too_slow_a_machine_shows_slow_motion_and_owes_nothing_afterwards() {
        // Steps cost twice what they may: half the speed, and no more than 40 ms to catch up.
        let (simulated, real, pacer) = run(0.01, 1.0, 4.0, |_| 0.02);
        assert!((simulated / real - 0.5).abs() < 0.02, "{simulated} {real}");
        assert!((pacer.speed().unwrap() - 0.5).abs() < 0.02);
        let fast_again = |k: u32| if k < 200 { 0.02 } else { 0.001 };
        let (simulated, real, _) = run(0.01, 1.0, 8.0, fast_again);
        let owed_and_paid = simulated - (2.0 + (real - 4.0));
        assert!((-0.02..0.06).contains(&owed_and_paid), "{owed_and_paid}");
    }
}
