//! Goal: the safety module in the loop tames a coupling that is too stiff for its device. Method: a
//! virtual user before a wall 1.5 times as stiff as stability allows (validation E1), with and
//! without a guard between force and motor.

use thenar_core::model::Drive;
use thenar_core::{Mat3, Pose};
use thenar_touch::safety::{Guard, Limits, Signal, Status};
use thenar_touch::virtual_user::{Device, VirtualUser, Wall};
use thenar_touch::{Proxies, Proxy, RigidState};

const MS: u64 = 1_000_000;

const DEVICE: Device = Device {
    mass: 0.1,
    damping: 1.0,
    friction: 0.0,
    resolution: 0.0,
    delay_ticks: 0,
    period: 1e-3,
};

/// A proxy that stands still behind a spring.
fn proxy(stiffness: f64) -> Proxy {
    let device = Drive { stiffness, damping: 0.0, angular_stiffness: 0.0, angular_damping: 0.0 };
    let bone = Drive { stiffness: 0.0, ..device };
    Proxy { mass: 1e12, inertia_B: Mat3::identity(), device, bone }
}

fn at(x: f64) -> RigidState {
    RigidState::at_rest(Pose::translation(x, 0.0, 0.0))
}

struct Run {
    status: Status,
    /// Largest excursion in the first and in the last second \[m\].
    first: f64,
    last: f64,
    /// Net energy that the motor gave \[J\].
    given: f64,
    least: f64,
}

fn guarded(limits: Limits) -> Run {
    let mut guard = Guard::<1>::new(limits, 0).unwrap();
    guard.arm();
    let mut proxies = Proxies::new(vec![proxy(3000.0)], &[at(0.0)]).unwrap();
    let mut user = VirtualUser::new(DEVICE, 0.0);
    let mut run = Run { status: Status::Off, first: 0.0, last: 0.0, given: 0.0, least: 0.0 };
    for k in 1..=20_000u64 {
        let now = k * MS;
        proxies.step(1e-3, &[at(user.measured_position())], &[at(0.0)]);
        let signal = Signal {
            force: [proxies.device_wrenches()[0][0].x],
            velocity: [user.measured_velocity()],
            simulation_ns: now,
            tracking_ns: now,
            device_ns: now,
            enabled: true,
        };
        let [force] = guard.tick(now, &signal);
        // A tap of 1 N for 20 ms, once the ramp is over.
        let push = if (3000..3020).contains(&k) { 1.0 } else { 0.0 };
        user.advance(force, push);
        let second = if (3000..4000).contains(&k) { Some(&mut run.first) } else { None };
        let second = if k > 19_000 { Some(&mut run.last) } else { second };
        if let Some(largest) = second {
            *largest = largest.max(user.position().abs());
        }
        run.least = run.least.min(guard.energy());
    }
    run.status = guard.status();
    run.given = user.energy_given();
    run
}

#[test]
fn a_wall_that_is_too_stiff_is_damped_until_it_rests() {
    let wall = Wall { device: DEVICE, proxy: proxy(3000.0) };
    assert!(!wall.is_stable(10.0), "unguarded it must run away");
    let run = guarded(Limits { ramp: 0.5, ..Limits::rated(12.0) });
    assert_eq!(run.status, Status::Live);
    assert!(run.last < 0.1 * run.first, "{} m, then {} m", run.first, run.last);
    // The controller takes force away and never turns it round, so that it has a stroke's energy
    // back with the next one: on balance the motor gave less than the tap, which moved the device
    // by its impulse of 20 mN s.
    let tap = 0.5 * 0.02 * 0.02 / DEVICE.mass;
    assert!(run.given < tap && run.least > -tap, "{} J, {} J", run.given, run.least);
}

/// Without the controller the oscillation grows until the reserve is spent, and stops.
#[test]
fn without_its_controller_it_is_stopped() {
    let limits =
        Limits { ramp: 0.5, damping_max: 0.0, energy_reserve: 0.02, ..Limits::rated(12.0) };
    let run = guarded(limits);
    assert!(matches!(run.status, Status::Tripped(_)), "{:?}", run.status);
    assert!(run.given < 0.02 + 12.0 * 1.2 * 1e-3, "{} J", run.given);
}
