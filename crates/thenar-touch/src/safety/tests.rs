//! Goal: what `mod.rs` guarantees, whatever comes in. Method: seeded hostile signals with an
//! independent ledger, and one scripted test per stage.

mod pauses;

use super::*;
use thenar_core::random::Random;

const MS: u64 = 1_000_000;

fn signal<const N: usize>(now_ns: u64, force: [f64; N], velocity: [f64; N]) -> Signal<N> {
    Signal {
        force,
        velocity,
        simulation_ns: now_ns,
        tracking_ns: now_ns,
        device_ns: now_ns,
        enabled: true,
    }
}

fn norm<const N: usize>(v: &[f64; N]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Armed, and past the small-force wait at `now_ns`.
fn engaged(limits: Limits, now_ns: &mut u64) -> Guard<1> {
    let mut guard = Guard::new(limits, 64).unwrap();
    guard.arm();
    for _ in 0..=limits.engage_ticks {
        *now_ns += MS;
        assert_eq!(guard.tick(*now_ns, &signal(*now_ns, [0.0], [0.0])), [0.0]);
    }
    assert!(matches!(guard.status(), Status::Ramping { .. } | Status::Live));
    guard
}

fn quick() -> Limits {
    Limits { ramp: 0.0, ..Limits::rated(12.0) }
}

fn one_in(random: &mut Random, n: u64) -> bool {
    random.bits().is_multiple_of(n)
}

/// A number that is mostly sane, sometimes huge, seldom none at all.
fn number(random: &mut Random, size: f64) -> f64 {
    match random.bits() % 20_000 {
        0 => f64::NAN,
        1 => f64::INFINITY,
        2 => -f64::INFINITY,
        3..=40 => random.range(-1e250, 1e250),
        _ => random.range(-size, size),
    }
}

struct Seen {
    live: u32,
    waiting: u32,
    trips: std::collections::HashSet<std::mem::Discriminant<Trip>>,
}

/// Drives one guard with `ticks` hostile ticks and checks every guarantee after each.
fn attack<const N: usize>(seed: u64, limits: Limits, ticks: u32, seen: &mut Seen) {
    let mut random = Random::new(seed);
    let mut guard = Guard::<N>::new(limits, 16).unwrap();
    let (mut now, mut last) = (10_000 * MS, None::<u64>);
    let mut stamps = [now; 3];
    let mut before = [0.0; N];
    let mut ledger = 0.0; // taken in minus given out since armed
    let (mut calm, mut push, mut stale) = (true, 0.0, [false; 3]);
    for tick in 0..ticks {
        let context = || format!("seed {seed}, axes {N}, tick {tick}");
        if one_in(&mut random, 150) {
            calm = !one_in(&mut random, 3);
            push = random.range(-30.0, 30.0);
            stale = [0; 3].map(|_| one_in(&mut random, 12));
        }
        now = match random.bits() % 4000 {
            0 => now.saturating_sub(random.bits() % (50 * MS)),
            1 => now + random.bits() % (1000 * MS),
            2..=100 => now,
            _ => now + MS / 2 + random.bits() % MS,
        };
        for (stamp, stale) in stamps.iter_mut().zip(stale) {
            *stamp = match random.bits() % 4000 {
                0 => random.bits(),
                _ if stale => *stamp,
                _ => now.saturating_sub(random.bits() % (4 * MS)),
            };
        }
        if one_in(&mut random, 700) {
            let at_rest = matches!(guard.status(), Status::Off | Status::Tripped(_));
            guard.arm();
            // What is armed already is held to its past.
            if at_rest {
                (before, ledger, last) = ([0.0; N], 0.0, None);
            }
        }
        let force = if calm { 0.15 / (N as f64).sqrt() } else { 40.0 };
        let signal = Signal {
            force: [0.0; N].map(|_| number(&mut random, force) + if calm { 0.0 } else { push }),
            velocity: [0.0; N].map(|_| number(&mut random, if calm { 0.02 } else { 0.4 })),
            simulation_ns: stamps[0],
            tracking_ns: stamps[1],
            device_ns: stamps[2],
            enabled: !one_in(&mut random, 500),
        };
        let was_tripped = matches!(guard.status(), Status::Tripped(_));
        let was_off = guard.status() == Status::Off;
        let output = guard.tick(now, &signal);
        let size = norm(&output);

        assert!(output.iter().all(|f| f.is_finite()), "{}", context());
        assert!(size <= limits.force_max() * (1.0 + 1e-12), "{}: {size} N", context());
        if limits.unilateral {
            assert!(output.iter().all(|f| *f >= 0.0), "{}: {output:?}", context());
        }
        if was_tripped || was_off {
            assert_eq!(size, 0.0, "{}", context());
        }
        let dt =
            last.filter(|_| !was_off).map_or(0.0, |last: u64| (now as f64 - last as f64) * 1e-9);
        let power: f64 = before.iter().zip(&signal.velocity).map(|(f, v)| f * v).sum();
        // A watchdog sends zeros after this time, and what can only hold gives nothing.
        let booked = if limits.passive { power.min(0.0) } else { power } * dt.min(limits.gap_hold);
        if let Status::Tripped(reason) = guard.status() {
            assert_eq!(size, 0.0, "{}", context());
            seen.trips.insert(std::mem::discriminant(&reason));
        } else if dt > limits.gap_hold {
            assert_eq!(size, 0.0, "{}", context());
            ledger -= booked;
        } else {
            let change = norm(&std::array::from_fn::<f64, N, _>(|i| output[i] - before[i]));
            let most = limits.change_max(dt) + limits.quantum * (N as f64).sqrt();
            assert!(change <= most + 1e-9, "{}: {change} N in {dt} s", context());
            ledger -= booked;
        }
        if size > 0.0 {
            assert!(ledger >= -limits.energy_reserve - 1e-9, "{}: {ledger} J", context());
        }
        seen.live += u32::from(guard.status() == Status::Live && size > 0.0);
        seen.waiting += u32::from(matches!(guard.status(), Status::Waiting { .. }));
        (before, last) = (output, if was_off { None } else { Some(now) });
    }
}

#[test]
fn whatever_comes_in_the_guarantees_hold() {
    let mut seen = Seen { live: 0, waiting: 0, trips: Default::default() };
    for seed in 1..=40 {
        let ramp = [0.0, 0.02, 0.2, 2.0][seed as usize % 4];
        let calm = Limits { ramp, engage_ticks: 2, ..Limits::rated(12.0) };
        let tendon = Limits { unilateral: true, quantum: 0.05, user_fraction: 0.33, ..calm };
        attack::<1>(seed, tendon, 20_000, &mut seen);
        attack::<1>(seed, calm, 20_000, &mut seen);
        let frail = Limits {
            energy_reserve: 1e-3,
            damping_max: 0.0,
            speed_max: 5.0,
            quantum: 0.07,
            ..calm
        };
        let stop = Limits { passive: true, energy_reserve: 1e-3, ..tendon };
        attack::<1>(seed, stop, 20_000, &mut seen);
        attack::<3>(seed, calm, 20_000, &mut seen);
        attack::<3>(seed, frail, 20_000, &mut seen);
        // The handle of an arm, and what turns it: wishes are far beyond this torque.
        let twist = Limits { ramp, engage_ticks: 2, engage_force: 0.2, ..Limits::torque(0.5) };
        attack::<3>(seed, twist, 20_000, &mut seen);
    }
    // The attack must have got through to where there is something to guard.
    assert!(seen.live > 10_000 && seen.waiting > 10_000, "{} {}", seen.live, seen.waiting);
    // Not finite, backwards, stalled, too fast, energy; stuck clocks and what turns too fast have
    // their own tests.
    seen.trips.remove(&std::mem::discriminant(&Trip::Overspin { rate: 0.0, limit: 0.0 }));
    assert_eq!(seen.trips.len(), 5, "{:?}", seen.trips);
}

#[test]
fn force_waits_for_a_small_wish_then_ramps_up_over_two_seconds() {
    let limits = Limits::rated(12.0);
    let mut guard = Guard::new(limits, 0).unwrap();
    let mut now = MS;
    assert_eq!(guard.tick(now, &signal(now, [0.0], [0.0])), [0.0]);
    assert_eq!(guard.status(), Status::Off);
    guard.arm();
    for _ in 0..500 {
        now += MS;
        assert_eq!(guard.tick(now, &signal(now, [3.0], [0.0])), [0.0], "a large wish waits");
    }
    for _ in 0..4 {
        now += MS;
        guard.tick(now, &signal(now, [0.1], [0.0]));
    }
    let (start, mut before) = (now, 0.0);
    for _ in 0..2100 {
        now += MS;
        let [force] = guard.tick(now, &signal(now, [3.0], [0.0]));
        let want = 3.0 * ((now - start) as f64 * 1e-9 / 2.0).min(1.0);
        assert!(force >= before, "the ramp is monotone");
        // 20 ms is what the slew limit takes at the start.
        assert!(force <= want + 1e-9 && force >= want - 0.03, "{force} N, ramp {want} N");
        before = force;
    }
    assert_eq!((before, guard.status()), (3.0, Status::Live));
}

/// Arming what is live is felt as a fade, not as a drop, and does not forget what was given out.
#[test]
fn arming_again_is_no_kick_and_no_pardon() {
    let mut now = MS;
    let mut guard = engaged(quick(), &mut now);
    let mut before = 0.0;
    for _ in 0..100 {
        now += MS;
        [before] = guard.tick(now, &signal(now, [5.0], [0.05]));
    }
    // 5 N at 50 mm/s for some 90 ms, less what damping took back.
    let (full, spent) = (before, guard.energy());
    assert!(full > 4.8 && spent < -0.01, "{full} N, {spent} J");
    guard.arm();
    assert_eq!(guard.energy(), spent);
    assert_eq!(guard.status(), Status::Waiting { small_ticks: 0, pause: None });
    for tick in 1..=20 {
        now += MS;
        let [force] = guard.tick(now, &signal(now, [5.0], [0.0]));
        // 12 N in 20 ms, and no slower.
        let want = (full - 0.6 * f64::from(tick)).max(0.0);
        assert!((force - want).abs() < 1e-9, "tick {tick}: {force} N, {want} N");
        before = force;
    }
    assert_eq!(before, 0.0);
}

#[test]
fn an_old_simulation_is_held_then_fades_and_comes_back_by_itself() {
    let mut now = MS;
    let mut guard = engaged(quick(), &mut now);
    for _ in 0..100 {
        now += MS;
        guard.tick(now, &signal(now, [4.0], [0.0]));
    }
    let frame = now;
    for age in 1..=400u64 {
        now += MS;
        let stale = Signal { simulation_ns: frame, ..signal(now, [4.0], [0.0]) };
        let [force] = guard.tick(now, &stale);
        let want = 4.0 * (1.0 - (age as f64 - 50.0) / 50.0).clamp(0.0, 1.0);
        assert!((force - want).abs() < 1e-9, "{age} ms: {force} N");
    }
    let Status::Waiting { pause: Some(Pause::Simulation { age_s }), .. } = guard.status() else {
        panic!("{:?}", guard.status())
    };
    assert!((age_s - 0.4).abs() < 1e-9);
    for _ in 0..=201 {
        now += MS;
        guard.tick(now, &signal(now, [4.0], [0.0]));
    }
    assert_eq!(guard.status(), Status::Live);
}

/// A clock that runs ahead must not make old news look fresh for ever.
#[test]
fn stamps_from_the_future_are_no_news() {
    let mut now = MS;
    let mut guard = engaged(quick(), &mut now);
    for _ in 0..200 {
        now += MS;
        let ahead = Signal { simulation_ns: 3600 * 1000 * MS, ..signal(now, [4.0], [0.0]) };
        guard.tick(now, &ahead);
    }
    assert!(matches!(
        guard.status(),
        Status::Waiting { pause: Some(Pause::Simulation { .. }), .. }
    ));
}

/// Commands are whole steps of the device, on the side of zero.
#[test]
fn commands_are_rounded_towards_zero() {
    for (wanted, want) in [(1.99, 1.5), (-1.99, -1.5), (0.49, 0.0), (2.5, 2.5)] {
        let mut now = MS;
        let mut guard = engaged(Limits { quantum: 0.5, ..quick() }, &mut now);
        let mut force = [0.0];
        for _ in 0..100 {
            now += MS;
            force = guard.tick(now, &signal(now, [wanted], [0.0]));
        }
        assert_eq!(force, [want]);
    }
}

#[test]
fn lost_tracking_a_silent_device_and_a_released_switch_pause_within_the_slew_limit() {
    type Lose = fn(&mut Signal<1>, u64);
    let cases: [(u64, Lose); 3] = [
        (151, |s, lost| s.tracking_ns = lost),
        (71, |s, lost| s.device_ns = lost),
        (1, |s, _| s.enabled = false),
    ];
    for (limit_ms, lose) in cases {
        let mut now = MS;
        let mut guard = engaged(quick(), &mut now);
        for _ in 0..100 {
            now += MS;
            guard.tick(now, &signal(now, [6.0], [0.0]));
        }
        let (lost, mut before) = (now, 6.0);
        for _ in 0..limit_ms + 20 {
            now += MS;
            let mut poor = signal(now, [6.0], [0.0]);
            lose(&mut poor, lost);
            let [force] = guard.tick(now, &poor);
            assert!(before - force <= guard.limits().change_max(1e-3) + 1e-9);
            before = force;
        }
        assert_eq!(before, 0.0, "limit {limit_ms} ms");
        assert!(matches!(guard.status(), Status::Waiting { pause: Some(_), .. }));
    }
}

/// A device that is silent for 25 ms now and then, as a busy machine makes it: 20 ms are held, the
/// next 5 fade by a tenth, which comes back within a tenth of what trust takes. No wait, no ramp of
/// two seconds.
#[test]
fn short_silences_fade_and_come_back_without_the_ramp() {
    let mut now = MS;
    let limits = Limits { ramp: 2.0, ..quick() };
    let mut guard = engaged(limits, &mut now);
    for _ in 0..2500 {
        now += MS;
        guard.tick(now, &signal(now, [5.0], [0.0]));
    }
    let (mut least, mut back) = (5.0_f64, 0);
    for _ in 0..10 {
        let lost = now;
        for ms in 1..=200 {
            now += MS;
            let heard = if ms <= 25 { lost } else { now };
            let wanted = Signal { device_ns: heard, ..signal(now, [5.0], [0.0]) };
            let [force] = guard.tick(now, &wanted);
            least = least.min(force);
            assert_eq!(guard.status(), Status::Live, "{ms} ms");
            if force < 5.0 {
                back = back.max(ms);
            }
        }
    }
    let fallen = 5.0 / (1e3 * limits.fade);
    assert!((5.0 - 5.0 * fallen..5.0).contains(&least), "{least} N");
    assert!(back <= 25 + (100.0 * limits.regain) as u64 + 1, "{back} ms");
}

/// The controller damps by less force, never by more than is wanted, whatever noise the velocity
/// has.
#[test]
fn damping_never_raises_the_force() {
    let mut now = MS;
    let mut guard = engaged(Limits { energy_reserve: 10.0, ..quick() }, &mut now);
    let mut random = Random::new(3);
    let mut damped = 0;
    for k in 0..5000 {
        now += MS;
        let wanted = 1.0 + (0.01 * f64::from(k)).sin();
        // It opens on the whole, so that there is a deficit to damp away, and shakes.
        let velocity = 0.02 + random.range(-0.3, 0.3);
        let [force] = guard.tick(now, &signal(now, [wanted], [velocity]));
        assert!(k < 20 || force <= wanted + 1e-12, "{force} N for {wanted} N");
        damped += u32::from(force < wanted - 1e-6);
    }
    assert!(damped > 1000, "{damped} ticks damped");
}

#[test]
fn trips_are_zero_at_once_and_latched_with_their_numbers() {
    let trip = |change: &dyn Fn(&mut Signal<1>), step_ns: i64| {
        let mut now = 1000 * MS;
        let mut guard = engaged(quick(), &mut now);
        for _ in 0..100 {
            now += MS;
            guard.tick(now, &signal(now, [5.0], [0.0]));
        }
        now = now.checked_add_signed(step_ns).unwrap();
        let mut bad = signal(now, [5.0], [0.0]);
        change(&mut bad);
        assert_eq!(guard.tick(now, &bad), [0.0]);
        let Status::Tripped(reason) = guard.status() else { panic!("{:?}", guard.status()) };
        for _ in 0..3000 {
            now += MS;
            assert_eq!(guard.tick(now, &signal(now, [0.0], [0.0])), [0.0]);
        }
        assert_eq!(guard.status(), Status::Tripped(reason));
        let records: Vec<_> = guard.log().iter().collect();
        assert_eq!(records.len(), 64);
        assert_eq!(records[63].status, Status::Tripped(reason), "the trip is the last record");
        assert!(records.windows(2).all(|w| w[0].time_ns < w[1].time_ns || step_ns < 0));
        assert!(records[..63].iter().all(|r| r.output == [5.0] && r.status == Status::Live));
        reason
    };
    let ms = MS as i64;
    assert_eq!(trip(&|s| s.force = [f64::NAN], ms), Trip::NotFinite(Quantity::Force));
    let fast = trip(&|s| s.velocity = [-1.5], ms);
    assert_eq!(fast, Trip::Overspeed { speed: 1.5, limit: 1.2 });
    assert_eq!(fast.to_string(), "speed 1.5 m/s is above 1.2 m/s");
    assert_eq!(trip(&|s| s.velocity = [f64::INFINITY], ms), Trip::NotFinite(Quantity::Velocity));
    let Trip::ClockBackwards { by_s } = trip(&|_| (), -ms) else { panic!() };
    assert!((by_s - 1e-3).abs() < 1e-12);
    let Trip::LoopStalled { gap_s } = trip(&|_| (), 600 * ms) else { panic!() };
    assert!((gap_s - 0.6).abs() < 1e-12);
}

/// After a gap force begins anew, from zero: it ramps once the gap is 0.2 s ago, whatever is
/// wanted.
#[test]
fn a_loop_that_stood_still_begins_anew() {
    let mut now = MS;
    let mut guard = engaged(Limits { ramp: 0.5, ..quick() }, &mut now);
    let tick = |guard: &mut Guard<1>, now: &mut u64, ms: u64, force: f64| {
        *now += ms * MS;
        guard.tick(*now, &signal(*now, [force], [-0.01]))[0]
    };
    for _ in 0..1000 {
        tick(&mut guard, &mut now, 1, 5.0);
    }
    let account = guard.energy();
    assert_eq!(tick(&mut guard, &mut now, 20, 5.0), 5.0, "as long as it may be");
    assert!((guard.energy() - account - 20e-3 * 5.0 * 0.01).abs() < 1e-12);
    assert_eq!(tick(&mut guard, &mut now, 55, 5.0), 0.0);
    let pause = Some(Pause::Loop { gap_s: 0.055 });
    assert_eq!(guard.status(), Status::Waiting { small_ticks: 0, pause });
    // The watchdog let go after 20 of the 55 ms.
    assert!((guard.energy() - account - 40e-3 * 5.0 * 0.01).abs() < 1e-12);
    assert!((0..200).all(|_| tick(&mut guard, &mut now, 1, 5.0) == 0.0));
    // 5 N within half a second.
    let forces: Vec<f64> = (0..501).map(|_| tick(&mut guard, &mut now, 1, 5.0)).collect();
    assert!((forces[250] - 2.5).abs() < 0.03 && forces[500] == 5.0, "{forces:?}");
    assert_eq!(guard.status(), Status::Live);
}

/// Frames every 80 ms are 30 ms older than they may be, six tenths of the fade, when the next one
/// comes: four to six tenths of the force are left, where following each frame's age it would buzz
/// between four and ten at 12 Hz.
#[test]
fn a_simulation_below_20_hz_weakens_force_and_does_not_make_it_buzz() {
    let mut now = MS;
    let mut guard = engaged(quick(), &mut now);
    let mut made = now;
    let mut forces = Vec::new();
    for ms in 0..2000 {
        now += MS;
        if ms % 80 == 0 {
            made = now;
        }
        let late = Signal { simulation_ns: made, ..signal(now, [5.0], [0.0]) };
        forces.push(guard.tick(now, &late)[0]);
    }
    let [least, most] =
        [f64::min, f64::max].map(|f| forces[1000..].iter().copied().reduce(f).unwrap());
    // 79 ms is the oldest: 1 - 29/50. From there 2 per mille come back in a millisecond, until an
    // age a with 0.42 + 0.002 a = 1 - (a - 50)/50, 71.8 ms, when the next fade begins.
    assert!((least - 5.0 * 0.42).abs() < 0.05, "{least} N");
    assert!((most - 5.0 * 0.5636).abs() < 0.05, "{most} N");
    // Slower than 10 Hz nothing is left, and it says why.
    for _ in 0..=100 {
        now += MS;
        guard.tick(now, &Signal { simulation_ns: made, ..signal(now, [5.0], [0.0]) });
    }
    let Status::Waiting { pause: Some(Pause::Simulation { .. }), .. } = guard.status() else {
        panic!("{:?}", guard.status())
    };
}

/// Five newtons wanted of a finger that opens by 0.1 m/s, half a watt: a motor has spent its
/// reserve of 60 mJ after 0.12 s; a stop lets the finger go.
#[test]
fn a_stop_gives_out_no_energy() {
    let run = |passive: bool| {
        let mut now = MS;
        let mut guard = engaged(Limits { passive, damping_max: 0.0, ..quick() }, &mut now);
        let ticks = (0..2000).take_while(|_| {
            now += MS;
            guard.tick(now, &signal(now, [5.0], [0.1]));
            guard.status() == Status::Live
        });
        (ticks.count(), guard.energy())
    };
    let (ticks, _) = run(false);
    // Force is there 17 ms after it is wanted: 5 N at 600 N/s is 9 ms on the way.
    assert!((120..135).contains(&ticks), "{ticks} ms");
    assert_eq!(run(true), (2000, 0.0));
}

/// A torque is clamped, slewed and stopped as a force is, by figures of its own.
#[test]
fn torques_have_their_own_limits_and_units() {
    let limits = Limits { ramp: 0.0, ..Limits::torque(0.4) };
    let mut now = MS;
    let mut guard = Guard::<3>::new(limits, 8).unwrap();
    guard.arm();
    for _ in 0..=limits.engage_ticks {
        now += MS;
        assert_eq!(guard.tick(now, &signal(now, [0.0; 3], [0.0; 3])), [0.0; 3]);
    }
    let mut before = 0.0;
    for tick in 1..=40 {
        now += MS;
        let out = guard.tick(now, &signal(now, [3.0, 4.0, 0.0], [0.0; 3]));
        // 0.4 N m in 20 ms, up to half of it.
        let want = (0.02 * f64::from(tick)).min(0.2);
        assert!((norm(&out) - want).abs() < 1e-9, "{out:?}, {want} N m");
        assert!((out[1] * 3.0 - out[0] * 4.0).abs() < 1e-9, "its direction stays: {out:?}");
        before = norm(&out);
    }
    assert!((before - 0.2).abs() < 1e-9);
    now += MS;
    assert_eq!(guard.tick(now, &signal(now, [0.1; 3], [0.0, 0.0, 25.0])), [0.0; 3]);
    let Status::Tripped(reason) = guard.status() else { panic!("{:?}", guard.status()) };
    assert_eq!(reason.to_string(), "turning at 25 rad/s is above 20 rad/s");
}

#[test]
fn a_clock_that_stands_still_trips() {
    let mut now = MS;
    let mut guard = engaged(quick(), &mut now);
    for _ in 0..200 {
        guard.tick(now, &signal(now, [5.0], [0.0]));
    }
    assert_eq!(guard.status(), Status::Tripped(Trip::ClockStuck { ticks: 101 }));
}

/// A display with negative damping, moved to and fro: the controller makes it passive; without one
/// the reserve is spent, and that trips.
#[test]
fn an_active_display_is_damped_or_stopped() {
    let run = |damping_max: f64| {
        let mut now = MS;
        let mut guard = engaged(Limits { damping_max, ..quick() }, &mut now);
        let mut least = 0.0_f64;
        for k in 0..5000 {
            now += MS;
            let v = 0.2 * (0.001 * std::f64::consts::TAU * 2.0 * f64::from(k)).sin();
            guard.tick(now, &signal(now, [2.0 * v], [v]));
            least = least.min(guard.energy());
        }
        (guard.status(), least)
    };
    let (status, least) = run(5.0);
    assert_eq!(status, Status::Live);
    assert!(least > -2e-3, "{least} J");
    // 2 v² is 40 mW on average; the reserve of 60 mJ lasts a second and a half.
    let (status, _) = run(0.0);
    let Status::Tripped(Trip::Energy { given_out, reserve }) = status else { panic!("{status:?}") };
    assert!(reserve == 0.06 && given_out > reserve && given_out < reserve + 1e-3);
}

#[test]
fn one_actuator_stops_all() {
    let limits = Limits { engage_ticks: 1, ..quick() };
    let mut bank = Bank::<1>::new(&[limits; 5], 8).unwrap();
    bank.arm();
    let mut forces = [[0.0]; 5];
    let mut now = 0;
    for force in [0.0, 0.0, 0.5, 0.5, 0.5] {
        now += MS;
        bank.tick(now, &[signal(now, [force], [0.0]); 5], &mut forces);
    }
    assert_eq!(forces, [[0.5]; 5]);
    now += MS;
    let mut signals = [signal(now, [0.5], [0.0]); 5];
    signals[3].force = [f64::NAN];
    bank.tick(now, &signals, &mut forces);
    assert_eq!(forces, [[0.0]; 5]);
    assert_eq!(bank.tripped(), Some((3, Trip::NotFinite(Quantity::Force))));
    assert_eq!(bank.guards()[0].status(), Status::Tripped(Trip::Companion { actuator: 3 }));
    bank.arm();
    assert_eq!(bank.tripped(), None);
    bank.trip(Trip::Requested);
    assert_eq!(bank.tripped(), Some((0, Trip::Requested)));
}

#[test]
fn senseless_limits_are_refused() {
    let refused = |limits: Limits| Guard::<1>::new(limits, 0).unwrap_err().to_string();
    let good = Limits::cybergrasp();
    assert_eq!(good.force_max(), 6.0);
    assert_eq!(
        refused(Limits { user_fraction: 1.5, ..good }),
        "safety limit user_fraction = 1.5 must be between 0 and 1"
    );
    assert_eq!(
        refused(Limits { rated: f64::NAN, ..good }),
        "safety limit rated = NaN must be positive and finite"
    );
    assert!(refused(Limits { fade: -1.0, ..good }).contains("fade"));
    // What limits nothing.
    assert_eq!(
        refused(Limits { slew: 1e9, ..good }),
        "safety limit slew = 1000000000 must be at most a rating a millisecond"
    );
    for (limits, name) in [
        (Limits { step_max: 12.1, ..good }, "step_max"),
        (Limits { speed_max: 1e9, ..good }, "speed_max"),
        (Limits { ramp: 1e9, ..good }, "ramp"),
        (Limits { gap_hold: 61.0, ..good }, "gap_hold"),
        (Limits { tracking_hold: 1e3, ..good }, "tracking_hold"),
    ] {
        assert!(refused(limits).contains(name), "{name}");
    }
}

/// Behind 30 ms, a guard that trips while it pushes and is armed anew: the force of before the trip
/// did its work before, and motion that is seen now does not meet it.
#[test]
fn forces_of_before_a_trip_are_forgotten() {
    let mut now = 0;
    let limits = Limits { engage_ticks: 0, ..quick() };
    let mut guard = engaged(limits, &mut now);
    guard.see_late(0.03);
    for _ in 0..60 {
        now += MS;
        guard.tick(now, &signal(now, [4.0], [0.0]));
    }
    assert_eq!(guard.energy(), 0.0);
    guard.trip(Trip::Requested);
    now += MS;
    assert_eq!(guard.tick(now, &signal(now, [0.0], [0.0])), [0.0]);
    guard.arm();
    for _ in 0..60 {
        now += MS;
        guard.tick(now, &signal(now, [0.0], [0.5]));
        assert_eq!((guard.energy(), guard.hidden()), (0.0, 0.0));
    }
}
