//! Goal: a clock that is put ahead or back makes no sample older than it is, and none younger than
//! now. Method: a device at 90 Hz, 4 ms away, whose clock steps once.

use super::*;

const MS: u64 = 1_000_000;
const WAY: u64 = 4 * MS;

/// Ages beyond the way there that samples are given after a step of `step_ms` \[ns\], and at which
/// samples jumps were reported.
fn after(step_ms: i64) -> (Vec<u64>, Vec<u64>) {
    let mut clock = SourceClock::default();
    let (mut ages, mut jumps) = (Vec::new(), Vec::new());
    for k in 0..400u64 {
        let measured = (1000 + 11 * k) * MS;
        let now = measured + WAY;
        let step = if k >= 200 { step_ms * MS as i64 } else { 0 };
        // Its clock shows something else altogether, besides.
        let carried = clock.carry(now, measured as i64 + step - 77_000 * MS as i64);
        assert!(carried.time_ns <= now, "{step_ms} ms: a sample of the future at {k}");
        if k < 200 {
            assert!(!carried.jumped && carried.time_ns == now, "{step_ms} ms: {carried:?} at {k}");
            continue;
        }
        ages.push(now - carried.time_ns);
        jumps.extend(carried.jumped.then_some(k - 200));
    }
    (ages, jumps)
}

/// Ahead: nothing arrives before it was measured, so that the first sample tells, and all are as
/// fresh as they are. Beyond a quarter of a second it is a jump, and told.
#[test]
fn a_step_ahead_is_followed_at_once() {
    for step_ms in [1, 50, 101, 150, 249, 251, 900, 10_000] {
        let (ages, jumps) = after(step_ms);
        assert!(ages.iter().all(|age| *age < MS), "{step_ms} ms: {ages:?}");
        let told: &[u64] = if step_ms > 250 { &[0] } else { &[] };
        assert_eq!(jumps, told, "{step_ms} ms");
    }
}

/// Back by so much that no datagram is: a jump at once. By 0.1 to 0.2 s samples may as well be
/// late, and are taken for that for a second, never for fresher.
#[test]
fn a_step_back_is_followed_within_a_second() {
    for step_ms in [-213, -500, -10_000] {
        let (ages, jumps) = after(step_ms);
        assert!(ages.iter().all(|age| *age < MS), "{step_ms} ms: {ages:?}");
        assert_eq!(jumps, [0], "{step_ms} ms");
    }
    for step_ms in [-101, -150, -185] {
        let (ages, jumps) = after(step_ms);
        let followed = 1 + 1000 / 11;
        assert_eq!(jumps, [followed], "{step_ms} ms");
        for (k, age) in ages.iter().enumerate() {
            let late = if (k as u64) < followed { -step_ms as u64 * MS } else { 0 };
            assert!(age.abs_diff(late) < 3 * MS, "{step_ms} ms: {age} of {late} ns at {k}");
        }
    }
}
