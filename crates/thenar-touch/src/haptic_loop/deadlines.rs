//! Absolute deadlines, and how a thread waits for them.

use crate::now_ns;
use std::time::Duration;

/// Waits for deadlines of [`now_ns`].
///
/// On Linux by `clock_nanosleep` with an absolute time of the monotonic clock, so that being
/// interrupted between reading the clock and sleeping costs nothing. Elsewhere it sleeps until half
/// a millisecond before the deadline and spins for the rest.
#[derive(Clone, Copy, Debug)]
pub struct DeadlineTimer {
    /// The system's monotonic clock minus ours \[ns\].
    #[cfg_attr(not(target_os = "linux"), allow(dead_code))]
    offset_ns: i128,
}

impl DeadlineTimer {
    /// Finds out how the clocks lie.
    pub fn set() -> Self {
        Self { offset_ns: offset_ns() }
    }

    /// Returns at `deadline_ns` or a little later; at once when that is past.
    pub fn wait(&self, deadline_ns: u64) {
        while now_ns() < deadline_ns {
            self.sleep(deadline_ns);
        }
    }

    #[cfg(target_os = "linux")]
    fn sleep(&self, deadline_ns: u64) {
        use rustix::thread::{ClockId, Timespec, clock_nanosleep_absolute};
        let at = i128::from(deadline_ns) + self.offset_ns;
        let until =
            Timespec { tv_sec: (at / 1_000_000_000) as i64, tv_nsec: (at % 1_000_000_000) as _ };
        // Interrupted by a signal, the loop around sleeps again.
        let _ = clock_nanosleep_absolute(ClockId::Monotonic, &until);
    }

    #[cfg(not(target_os = "linux"))]
    fn sleep(&self, deadline_ns: u64) {
        const SPIN: Duration = Duration::from_micros(500);
        let left = Duration::from_nanos(deadline_ns.saturating_sub(now_ns()));
        match left.checked_sub(SPIN) {
            Some(nap) if !nap.is_zero() => std::thread::sleep(nap),
            _ => std::hint::spin_loop(),
        }
    }
}

#[cfg(target_os = "linux")]
fn offset_ns() -> i128 {
    let system = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    let ours = now_ns();
    i128::from(system.tv_sec) * 1_000_000_000 + i128::from(system.tv_nsec) - i128::from(ours)
}

#[cfg(not(target_os = "linux"))]
fn offset_ns() -> i128 {
    0
}

/// Deadlines one period apart.
#[derive(Clone, Copy, Debug)]
pub struct Deadlines {
    period_ns: u64,
    next_ns: u64,
}

impl Deadlines {
    /// The first is one period from now.
    pub fn new(period: Duration, now_ns: u64) -> Self {
        let period_ns = period.as_nanos().max(1) as u64;
        Self { period_ns, next_ns: now_ns + period_ns }
    }

    /// The next.
    pub fn next_ns(&self) -> u64 {
        self.next_ns
    }

    /// A tick began at `now_ns`, for the next deadline, and has ended. How late it began \[ns\];
    /// and how many deadlines passed meanwhile, which are left out rather than hurried through.
    pub fn advance(&mut self, began_ns: u64, ended_ns: u64) -> (u64, u32) {
        let late = began_ns.saturating_sub(self.next_ns);
        self.next_ns += self.period_ns;
        // Always some sleep, lest an endless tick starve the machine at real-time priority.
        let floor = ended_ns + self.period_ns / 20;
        let mut missed = 0;
        if self.next_ns < floor {
            missed = (floor - self.next_ns).div_ceil(self.period_ns);
            self.next_ns += missed * self.period_ns;
        }
        (late, missed as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deadlines_stay_on_their_grid_and_are_left_out_when_they_passed() {
        let mut deadlines = Deadlines::new(Duration::from_millis(1), 500);
        assert_eq!(deadlines.next_ns(), 1_000_500);
        assert_eq!(deadlines.advance(1_030_500, 1_060_500), (30_000, 0));
        assert_eq!(deadlines.next_ns(), 2_000_500);
        // This one takes 3.2 ms: the deadlines at 3, 4 and 5 ms have passed.
        assert_eq!(deadlines.advance(2_000_500, 5_200_500), (0, 3));
        assert_eq!(deadlines.next_ns(), 6_000_500);
        // Ending at the very moment of the next leaves that one out, so that there is some sleep.
        assert_eq!(deadlines.advance(6_000_500, 6_990_500), (0, 1));
        assert_eq!(deadlines.next_ns(), 8_000_500);
    }

    #[test]
    fn the_timer_never_fires_early() {
        let timer = DeadlineTimer::set();
        for k in 0..20 {
            let deadline = now_ns() + 100_000 * k;
            timer.wait(deadline);
            assert!(now_ns() >= deadline);
        }
    }
}
