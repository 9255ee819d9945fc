//! Goal: the real coupling code, in the loop with a device, becomes unstable and active where
//! theory says (validation E1, E3, E8). Method: simulated onsets against the published figures and
//! against eigenvalues of the loop written down independently here.

use super::*;
use crate::{CouplingDesign, Proxies};
use thenar_core::math::Mat3;
use thenar_core::random::Random;

const DEVICE: Device = Device {
    mass: 0.1,
    damping: 1.0,
    friction: 0.0,
    resolution: 0.0,
    delay_ticks: 0,
    period: 1e-3,
};

/// E1, to the published digits by eigenvalues and within 1 % in the loop (2 % are asked for).
#[test]
fn a_sampled_wall_becomes_unstable_where_theory_says() {
    let cases = [
        (DEVICE, 0.0, 2003.34),
        (Device { period: 5e-4, ..DEVICE }, 0.0, 4003.34),
        (Device { period: 2e-3, ..DEVICE }, 0.0, 1003.34),
        (Device { delay_ticks: 1, ..DEVICE }, 0.0, 668.51),
        (DEVICE, 0.5, 2990.10),
    ];
    for (device, damping, published) in cases {
        let wall = |stiffness: f64| Wall { device, proxy: Wall::plain_proxy(stiffness, damping) };
        let theory = predicted_onset(100.0, 10_000.0, wall);
        assert!((theory - published).abs() < 0.01, "{theory} against {published} N/m");
        let found = stability_onset(100.0, 10_000.0, 40.0, wall).expect("stable, then not");
        assert!((found / published - 1.0).abs() < 0.01, "{found} against {published} N/m");
    }
}

/// Other masses, dampings, rates and delays, and a real proxy between two springs.
#[test]
fn onsets_agree_with_eigenvalues_elsewhere() {
    let devices = [
        Device { mass: 0.05, damping: 0.4, ..DEVICE },
        Device { mass: 0.3, damping: 2.0, period: 2.5e-4, ..DEVICE },
        Device { damping: 0.5, delay_ticks: 3, ..DEVICE },
        Device { mass: 0.08, damping: 0.8, period: 4e-3, delay_ticks: 2, ..DEVICE },
    ];
    let inertia = Mat3::from_diagonal_element(1e-7);
    for device in devices {
        for light in [false, true] {
            let wall = |stiffness: f64| {
                let proxy = if light {
                    let design = CouplingDesign {
                        device_stiffness: 2.0 * stiffness,
                        bone_stiffness: 2.0 * stiffness,
                        damping_ratio: 0.3,
                        device_damping: 0.1,
                        ..CouplingDesign::default()
                    };
                    design.proxy(0.005, &inertia)
                } else {
                    Wall::plain_proxy(stiffness, 0.0)
                };
                Wall { device, proxy }
            };
            let theory = predicted_onset(10.0, 1e5, wall);
            assert!((20.0..9e4).contains(&theory), "{device:?}: {theory}");
            let found = stability_onset(0.5 * theory, 2.0 * theory, 60.0, wall);
            let found = found.unwrap_or_else(|| panic!("{device:?} {light}: theory {theory}"));
            assert!((found / theory - 1.0).abs() < 0.02, "{device:?} {light}: {found} {theory}");
        }
    }
}

/// Random loops: masses, dampings, rates, delays and coupling dampings drawn by a seed.
#[test]
fn onsets_agree_with_eigenvalues_at_random() {
    for seed in 1..=12 {
        let mut random = Random::new(seed);
        let mass = 0.02 * 25.0_f64.powf(random.range(0.0, 1.0));
        let device = Device {
            mass,
            damping: mass * random.range(5.0, 20.0),
            period: 2.5e-4 * 16.0_f64.powf(random.range(0.0, 1.0)),
            delay_ticks: (5.0 * random.range(0.0, 1.0)) as usize,
            ..DEVICE
        };
        let damping = device.damping * random.range(0.0, 0.3);
        let wall = |k: f64| Wall { device, proxy: Wall::plain_proxy(k, damping) };
        let theory = predicted_onset(1.0, 1e6, wall);
        assert!((2.0..5e5).contains(&theory), "seed {seed} {device:?}: {theory}");
        let seconds = 400.0 * device.mass / device.damping;
        let found = stability_onset(0.5 * theory, 2.0 * theory, seconds, wall);
        let found = found.unwrap_or_else(|| panic!("seed {seed} {device:?}: theory {theory}"));
        assert!((found / theory - 1.0).abs() < 0.02, "seed {seed} {device:?}: {found} {theory}");
    }
}

/// Against the published rules instead: passive up to the smaller of `2 (b - |B|)/T` and, with a
/// quantised sensor, `2 f_c/Δ`; stable about up to `(b + B)/(T/2 + t_d)`, which `LoopProfile` warns
/// by.
#[test]
fn onsets_agree_with_the_published_rules_at_random() {
    let mut quantised = 0;
    for seed in 101..=110 {
        let mut random = Random::new(seed);
        let mass = 0.02 * 25.0_f64.powf(random.range(0.0, 1.0));
        let device = Device {
            mass,
            damping: mass * random.range(5.0, 15.0),
            friction: random.range(0.01, 0.1),
            resolution: 5e-5 * 10.0_f64.powf(random.range(0.0, 1.0)),
            period: 5e-4 * 4.0_f64.powf(random.range(0.0, 1.0)),
            delay_ticks: 0,
        };
        // The second rule is of springs without dampers, which feel the steps themselves.
        let smooth = Device { friction: 0.0, resolution: 0.0, ..device };
        let (device, coupling) = match seed % 3 {
            0 => (smooth, device.damping * random.range(0.0, 0.5)),
            _ => (device, 0.0),
        };
        let wall = |k: f64| Wall { device, proxy: Wall::plain_proxy(k, coupling) };
        let sampled = 2.0 * (device.damping - coupling) / device.period;
        let stepped = match device.resolution > 0.0 {
            true => 2.0 * device.friction / device.resolution,
            false => f64::INFINITY,
        };
        let (want, found) = (sampled.min(stepped), passive_onset(1.0, 1e6, wall).unwrap());
        quantised += u32::from(stepped < sampled);
        assert!((found / want - 1.0).abs() < 5e-3, "seed {seed} {device:?}: {found}, {want} N/m");

        // The stable limit, of a smooth device with delay; an approximation to some percent.
        let late = (3.0 * random.range(0.0, 1.0)) as usize;
        let device = Device { friction: 0.0, resolution: 0.0, delay_ticks: late, ..device };
        let wall = |k: f64| Wall { device, proxy: Wall::plain_proxy(k, 0.0) };
        let rule = device.damping / (device.period * (0.5 + late as f64));
        let seconds = 400.0 * device.mass / device.damping;
        let found = stability_onset(0.5 * rule, 2.0 * rule, seconds, wall).unwrap();
        assert!((found / rule - 1.0).abs() < 0.05, "seed {seed} {device:?}: {found}, {rule} N/m");
    }
    assert!((2..9).contains(&quantised), "both rules must have had their turn: {quantised}");
}

/// E3 at 250 Hz to 4 kHz: a wall felt through a proxy returns less than was put in.
#[test]
fn a_wall_felt_through_a_proxy_is_passive() {
    let proxy = CouplingDesign::default().proxy(0.004, &Mat3::from_diagonal_element(1e-7));
    for period in [4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4] {
        for frequency in 1..=30 {
            let run = forced_wall(proxy, 5e-3, f64::from(frequency), 4, period).unwrap();
            let excess = run.given / run.stored_max;
            assert!(excess <= 0.01, "{period} s, {frequency} Hz: {excess} of what was stored");
            assert!(run.force_max > 1.0, "the wall must be met: {run:?}");
        }
    }
}

/// The leak that E3 looks for: without damping a sampled spring gives out K T/2 ∫ v² dt.
#[test]
fn an_undamped_sampled_spring_gives_out_what_theory_says() {
    let (stiffness, amplitude, frequency) = (800.0, 5e-3, 2.0);
    let proxy = Wall::plain_proxy(stiffness, 0.0);
    for period in [1e-3, 5e-4] {
        // A proxy that stands still at zero is a wall that pulls as well, all cycle long.
        let mut proxies = Proxies::new(vec![proxy], &[wall::on_axis(0.0, 0.0)]).unwrap();
        let place = |k: u32| {
            let phase = std::f64::consts::TAU * frequency * period * f64::from(k);
            amplitude * phase.sin()
        };
        let mut given = 0.0;
        for k in 0..(1.0 / (frequency * period)).round() as u32 {
            let hand = [wall::on_axis(place(k), 0.0)];
            proxies.step(period, &hand, &[wall::on_axis(0.0, 0.0)]);
            given += proxies.device_wrenches()[0][0].x * (place(k + 1) - place(k));
        }
        let omega = std::f64::consts::TAU * frequency;
        let square = 0.5 * (amplitude * omega).powi(2) / frequency; // ∫ v² dt over one cycle
        let want = 0.5 * stiffness * period * square;
        assert!((given / want - 1.0).abs() < 0.01, "{given} against {want} J");
    }
}

/// E8: a hand that trembles by δ across one step of the sensor wins K Δ δ per cycle and loses
/// 2 f_c δ to friction and 2 b δ²/T to damping: passive up to 2 f_c / Δ = 1000 N/m.
#[test]
fn quantisation_makes_a_wall_active_above_the_friction_bound() {
    let device = Device { friction: 0.05, resolution: 1e-4, ..DEVICE };
    let tremble = 1e-7;
    let won = |stiffness: f64| {
        let wall = Wall { device, proxy: Wall::plain_proxy(stiffness, 0.0) };
        wall.given_to_a_tremble(tremble).unwrap()
    };
    assert!(won(980.0) < 0.0 && won(1020.0) > 0.0, "{} {}", won(980.0), won(1020.0));
    let want = (4000.0 * 1e-4 - 2.0 * 0.05) * tremble;
    assert!((won(4000.0) / want - 1.0).abs() < 0.01, "{} against {want} J", won(4000.0));
    let onset = passive_onset(10.0, 1e5, |k| Wall { device, proxy: Wall::plain_proxy(k, 0.0) });
    assert!((onset.unwrap() / 1000.0 - 1.0).abs() < 2e-3, "{onset:?}");
}

/// Colgate and Schenkel's bound, `b > K T/2 + abs(B)`, at any damping of either sign and any rate.
#[test]
fn a_sampled_wall_becomes_active_where_theory_says() {
    for (period, b, coupling) in
        [(1e-3, 1.0, 0.0), (1e-3, 1.0, 0.5), (5e-4, 2.0, 0.7), (4e-3, 0.3, 0.0)]
    {
        let device = Device { period, damping: b, ..DEVICE };
        let wall = |k: f64| Wall { device, proxy: Wall::plain_proxy(k, coupling) };
        let (found, want) = (passive_onset(1.0, 1e5, wall).unwrap(), 2.0 * (b - coupling) / period);
        assert!((found / want - 1.0).abs() < 2e-3, "{found} against {want} N/m");
    }
}

/// The device itself: exact flight, friction that stops and holds, and the books.
#[test]
fn the_device_moves_exactly() {
    // Pushed against friction and damping: v(t) = (F - f)/b (1 - exp(-b t/m)).
    let device = Device { friction: 0.2, ..DEVICE };
    let mut user = VirtualUser::new(device, 0.0);
    for _ in 0..50 {
        user.advance(0.0, 1.0);
    }
    let want = 0.8 * (1.0 - (-0.5_f64).exp());
    assert!((user.velocity() - want).abs() < 1e-12);
    // Let go: it stops after m/b ln(1 + b v/f) and stays.
    let stop = 0.1 * (1.0 + want / 0.2).ln();
    let ticks = (stop / 1e-3) as u32;
    for _ in 0..ticks {
        user.advance(0.0, 0.0);
    }
    assert!(user.velocity() > 0.0);
    user.advance(0.0, 0.0);
    assert_eq!(user.velocity(), 0.0);
    let rest = user.position();
    for _ in 0..100 {
        user.advance(0.19, 0.0);
    }
    assert_eq!((user.position(), user.energy_given()), (rest, 0.0));

    // Without losses the force's work is kinetic energy; delay shifts it by whole ticks.
    let free = Device { damping: 0.0, delay_ticks: 3, ..DEVICE };
    let mut user = VirtualUser::new(free, 0.0);
    for k in 0..10 {
        user.advance(2.0, 0.0);
        assert!((user.velocity() - 0.02 * f64::from((k - 2).max(0))).abs() < 1e-12);
    }
    assert!((user.energy_given() - 0.5 * 0.1 * user.velocity().powi(2)).abs() < 1e-12);
    // Thrown against friction it turns round.
    let mut user = VirtualUser::new(device, 0.0);
    user.velocity = 0.001;
    user.advance(-1.2, 0.0);
    let stop = 0.1 * (1.0_f64 + 0.001 / 1.4).ln();
    let want = (-(1e-3 - stop) / 0.1_f64).exp() - 1.0;
    assert!((user.velocity() - want).abs() < 1e-12);
}
