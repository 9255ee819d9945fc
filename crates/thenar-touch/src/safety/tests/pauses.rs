//! Pauses of forces, and how forces come back while something is held on to.

use super::*;

/// Longest that news may be late before forces pause, times 4/3; then they rise for half a second.
const CALM_MS: usize = 200;
const RETURN_MS: usize = 500;

/// At full force under a wish of 5 N.
fn pulling(limits: Limits, now: &mut u64) -> Guard<1> {
    let mut guard = engaged(limits, now);
    let ramp = (1e3 * limits.ramp) as u64;
    for _ in 0..ramp + 100 {
        *now += MS;
        guard.tick(*now, &signal(*now, [5.0], [0.0]));
    }
    assert_eq!(guard.status(), Status::Live);
    guard
}

/// Forces that are sent in this many milliseconds under a wish of 5 N, while `poor` spoils what
/// comes in.
fn forces(
    guard: &mut Guard<1>,
    now: &mut u64,
    ms: usize,
    mut poor: impl FnMut(&mut Signal<1>, usize),
) -> Vec<f64> {
    let each = |k| {
        *now += MS;
        let mut wanted = signal(*now, [5.0], [0.0]);
        poor(&mut wanted, k);
        guard.tick(*now, &wanted)[0]
    };
    (0..ms).map(each).collect()
}

/// Forces that return under a wish of 5 N: nothing for 0.2 s, then half a second's even rise, no
/// faster.
fn is_return(forces: &[f64]) -> bool {
    let rise = 5.0 / RETURN_MS as f64;
    forces[..CALM_MS - 1].iter().all(|force| *force == 0.0)
        && forces.windows(2).all(|pair| (-1e-12..rise + 1e-9).contains(&(pair[1] - pair[0])))
        && forces[CALM_MS + RETURN_MS + 1..].iter().all(|force| *force == 5.0)
}

/// A tracker, a simulation and a device that are silent for half a second, and a hand that was
/// elsewhere, while the wearer holds on to something: no hand has to open, and nothing jumps.
#[test]
fn what_is_held_is_felt_again_once_the_cause_is_over() {
    type Poor = fn(&mut Signal<1>, &mut Guard<1>, u64);
    let causes: [Poor; 4] = [
        |signal, _, since| signal.tracking_ns = since,
        |signal, _, since| signal.simulation_ns = since,
        |signal, _, since| signal.device_ns = since,
        |_, guard, _| guard.see_away(true),
    ];
    for poor in causes {
        let mut now = MS;
        let mut guard = pulling(Limits { ramp: 2.0, ..quick() }, &mut now);
        let since = now;
        for _ in 0..500 {
            now += MS;
            let mut wanted = signal(now, [5.0], [0.0]);
            poor(&mut wanted, &mut guard, since);
            guard.tick(now, &wanted);
        }
        assert!(matches!(guard.status(), Status::Waiting { pause: Some(_), .. }));
        guard.see_away(false);
        let back = forces(&mut guard, &mut now, 1000, |_, _| ());
        assert!(is_return(&back), "{back:?}");
        assert_eq!(guard.status(), Status::Live);
    }
}

/// 25 ms without a tick, in which the device was let go.
#[test]
fn a_short_stall_of_the_loop_returns() {
    let mut now = MS;
    let mut guard = pulling(Limits { ramp: 2.0, ..quick() }, &mut now);
    now += 24 * MS;
    let back = forces(&mut guard, &mut now, 1000, |_, _| ());
    assert!(is_return(&back), "{back:?}");
}

/// Armed, stopped, or held by a dead-man switch anew: a person opens the hand. So does one whose
/// forces never began.
#[test]
fn whoever_arms_opens_the_hand() {
    let mut now = MS;
    let limits = Limits { ramp: 0.5, ..quick() };
    let still_waits = |guard: &mut Guard<1>, now: &mut u64| {
        // What was sent before falls within the slew limit.
        assert!(forces(guard, now, 1500, |_, _| ())[20..].iter().all(|force| *force == 0.0));
        forces(guard, now, 5, |signal, _| signal.force = [0.1]);
        assert!(forces(guard, now, 600, |_, _| ())[599] == 5.0);
    };
    let mut guard = pulling(limits, &mut now);
    guard.arm();
    still_waits(&mut guard, &mut now);
    guard.trip(Trip::Requested);
    guard.arm();
    still_waits(&mut guard, &mut now);
    forces(&mut guard, &mut now, 50, |signal, _| signal.enabled = false);
    still_waits(&mut guard, &mut now);
    let mut guard = Guard::new(limits, 0).unwrap();
    guard.arm();
    let since = now;
    forces(&mut guard, &mut now, 400, |signal, _| signal.tracking_ns = since);
    still_waits(&mut guard, &mut now);
}

/// A ramp of arming that was cut short begins anew, as long as it was.
#[test]
fn a_pause_is_no_short_cut_through_the_ramp() {
    let mut now = MS;
    let mut guard = engaged(Limits { ramp: 2.0, ..quick() }, &mut now);
    let since = now;
    forces(&mut guard, &mut now, 400, |signal, k| {
        if k >= 200 {
            signal.tracking_ns = since + 200 * MS;
        }
    });
    let back = forces(&mut guard, &mut now, 2400, |_, _| ());
    let want = |ms: usize| 5.0 * (ms.saturating_sub(CALM_MS) as f64 / 2000.0).min(1.0);
    for (ms, force) in back.iter().enumerate() {
        assert!((force - want(ms)).abs() < 0.02, "{ms} ms: {force} of {} N", want(ms));
    }
}

/// A simulation of 8, 5 and 3 frames a second, a tracker of 5 samples a second, a loop that stands
/// still ten times a second: each of them pauses forces again and again, and none of that is felt
/// as knocking.
#[test]
fn what_pauses_again_and_again_does_not_knock() {
    for (every, tracker) in [(125, false), (200, false), (333, false), (200, true)] {
        let mut now = MS;
        let mut guard = pulling(quick(), &mut now);
        let mut made = now;
        let sent = forces(&mut guard, &mut now, 3000, |signal, ms| {
            made = if ms % every == 0 { signal.simulation_ns } else { made };
            *(if tracker { &mut signal.tracking_ns } else { &mut signal.simulation_ns }) = made;
        });
        assert!(sent[every + 200..].iter().all(|force| *force == 0.0), "every {every} ms");
    }
    let mut now = MS;
    let mut guard = pulling(quick(), &mut now);
    for _ in 0..20 {
        now += 25 * MS;
        let sent = forces(&mut guard, &mut now, 75, |_, _| ());
        assert!(sent.iter().all(|force| *force == 0.0));
    }
}

/// From the tick on in which the hand is on its way elsewhere force falls as fast as the slew lets
/// it, whatever is wanted; what it did so long ago as motion is seen late goes into the account.
/// Without force, the way may be fast.
#[test]
fn a_hand_on_its_way_is_let_go_at_once() {
    let mut now = MS;
    let mut guard = pulling(quick(), &mut now);
    guard.see_late(0.03);
    let account = guard.energy();
    guard.see_away(true);
    let change = guard.limits().change_max(1e-3);
    let mut before = 5.0;
    for ms in 0..200_u64 {
        now += MS;
        // What it wants grows, and it opens.
        let [force] = guard.tick(now, &signal(now, [6.0], [0.1]));
        assert!(force <= (before - change).max(0.0) + 1e-9, "{ms} ms: {force} N after {before} N");
        before = force;
    }
    // 30 ms at full force, and the fall of 8 ms.
    let given = account - guard.energy();
    let theory = 0.1 * 5.0 * (0.03 + 0.5 * 5.0 / 600.0);
    assert!((given / theory - 1.0).abs() < 0.05, "{given} of {theory} J");
    for _ in 0..100 {
        now += MS;
        assert_eq!(guard.tick(now, &signal(now, [6.0], [4.0])), [0.0]);
    }
    assert!(matches!(guard.status(), Status::Waiting { pause: Some(Pause::Away), .. }));
}
