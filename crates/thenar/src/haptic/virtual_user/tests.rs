//! Goal: the real coupling code, in the loop with a device, becomes unstable and active where theory
//! says (validation E1, E3, E8). Method: simulated onsets against the published figures and
//! against eigenvalues of the loop written down independently here.

use super::*;
use crate::haptic::{CouplingDesign, Proxies, Proxy};
use crate::math::Mat3;
use crate::model::Drive;
use nalgebra::DMatrix;

const DEVICE: Device = Device {
    mass: 0.1,
    damping: 1.0,
    friction: 0.0,
    resolution: 0.0,
    delay_ticks: 0,
    period: 1e-3,
};

fn drive(stiffness: f64, damping: f64) -> Drive {
    Drive { stiffness, damping, angular_stiffness: 0.0, angular_damping: 0.0 }
}

/// A proxy that stands still: the device coupling alone.
fn plain(stiffness: f64, damping: f64) -> Proxy {
    Proxy {
        mass: 1e12,
        inertia_B: Mat3::identity(),
        device: drive(stiffness, damping),
        bone: drive(0.0, 0.0),
    }
}

/// One tick of the linear loop as a matrix. State: position, velocity, position before, proxy
/// position and velocity, forces under way.
fn loop_matrix(device: &Device, proxy: &Proxy) -> DMatrix<f64> {
    let (m, b, h) = (device.mass, device.damping, device.period);
    let (kd, cd) = (proxy.device.stiffness, proxy.device.damping);
    let (kb, cb) = (proxy.bone.stiffness, proxy.bone.damping);
    let n = 5 + device.delay_ticks;
    let row = |entries: &[(usize, f64)]| {
        let mut row = nalgebra::RowDVector::zeros(n);
        entries.iter().for_each(|(i, x)| row[*i] += x);
        row
    };
    // Proxy by backward Euler, at the hand's present place and difference velocity.
    let s = proxy.mass + h * (cd + cb) + h * h * (kd + kb);
    let hand_speed = row(&[(0, 1.0 / h), (2, -1.0 / h)]);
    let spring = row(&[(0, kd), (3, -kd - kb)]);
    let v1 = (row(&[(4, proxy.mass)]) + (spring + &hand_speed * cd) * h) / s;
    let x1 = row(&[(3, 1.0)]) + &v1 * h;
    let force = (&x1 - row(&[(0, 1.0)])) * kd + (&v1 - &hand_speed) * cd;
    // Device under a held force.
    let decay = (-b * h / m).exp();
    let (to_x, to_v) = (h / b - m / (b * b) * (1.0 - decay), (1.0 - decay) / b);
    let applied = if device.delay_ticks == 0 { force.clone() } else { row(&[(n - 1, 1.0)]) };
    let mut a = DMatrix::zeros(n, n);
    a.set_row(0, &(row(&[(0, 1.0), (1, m / b * (1.0 - decay))]) + &applied * to_x));
    a.set_row(1, &(row(&[(1, decay)]) + &applied * to_v));
    a.set_row(2, &row(&[(0, 1.0)]));
    a.set_row(3, &x1);
    a.set_row(4, &v1);
    for i in 0..device.delay_ticks {
        a.set_row(5 + i, &if i == 0 { force.clone() } else { row(&[(4 + i, 1.0)]) });
    }
    // A proxy that stands still keeps its place and speed for ever, which says nothing.
    if proxy.mass > 1e9 { a.remove_rows(3, 2).remove_columns(3, 2) } else { a }
}

/// Where the largest eigenvalue leaves the unit circle.
fn predicted_onset(low: f64, high: f64, wall: impl Fn(f64) -> Wall) -> f64 {
    let (mut low, mut high) = (low, high);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        let Wall { device, proxy } = wall(middle);
        let eigenvalues = loop_matrix(&device, &proxy).complex_eigenvalues();
        if eigenvalues.iter().all(|z| z.norm() < 1.0) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

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
        let wall = |stiffness: f64| Wall { device, proxy: plain(stiffness, damping) };
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
                    plain(stiffness, 0.0)
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
    let mut proxy = plain(stiffness, 0.0);
    proxy.bone = drive(0.0, 0.0);
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
    let (tremble, middle) = (1e-7, 2.5e-4); // rounds to 0.2 mm below and 0.3 mm above
    let won = |stiffness: f64| {
        let proxy = [plain(stiffness, 0.0)];
        let mut proxies = Proxies::new(proxy.to_vec(), &[wall::on_axis(0.0, 0.0)]).unwrap();
        let mut won = 0.0;
        for k in 0..100 {
            let [from, to] = if k % 2 == 0 { [-0.5, 0.5] } else { [0.5, -0.5] };
            let measured = quantised(middle + from * tremble, device.resolution);
            proxies.step(1e-3, &[wall::on_axis(measured, 0.0)], &[wall::on_axis(0.0, 0.0)]);
            let way: f64 = (to - from) * tremble;
            won += proxies.device_wrenches()[0][0].x * way;
            won -= device.friction * way.abs() + device.damping * way * way / device.period;
        }
        won
    };
    // The wall pushes back with K times 0.2 or 0.3 mm; only the difference counts over a cycle.
    assert!(won(980.0) < 0.0 && won(1020.0) > 0.0, "{} {}", won(980.0), won(1020.0));
    let want = 50.0 * (4000.0 * 1e-4 - 2.0 * 0.05) * tremble;
    assert!((won(4000.0) / want - 1.0).abs() < 0.01, "{} against {want} J", won(4000.0));
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
