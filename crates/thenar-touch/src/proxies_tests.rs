//! Goal: proxies obey their equations of motion. Method: statics by hand, energy at random, the
//! analytic oscillator, the free body.

use crate::{CouplingDesign, series_stiffness};
use crate::{Proxies, Proxy, ProxyError, RigidState};
use thenar_core::Pose;
use thenar_core::math::{Mat3, Quat, Vec3, rotation_vector};
use thenar_core::model::Drive;
use thenar_core::random::Random;

fn finger_bone() -> Proxy {
    let inertia = Mat3::from_diagonal(&Vec3::new(3e-7, 3e-8, 3.1e-7));
    CouplingDesign::default().proxy(0.004, &inertia)
}

fn at(x: f64) -> RigidState {
    RigidState::at_rest(Pose::translation(x, 0.0, 0.0))
}

/// Validation E2: two springs in series, bone blocked; and the same for torque and angle.
#[test]
fn the_wearer_feels_both_springs_in_series() {
    for (k1, k2, want) in [(800.0, 800.0, 400.0), (1000.0, 600.0, 375.0)] {
        let design = CouplingDesign {
            device_stiffness: k1,
            bone_stiffness: k2,
            ..CouplingDesign::default()
        };
        let proxy = design.proxy(0.004, &Mat3::from_diagonal_element(1e-7));
        let mut proxies = Proxies::new(vec![proxy], &[at(0.0)]).unwrap();
        let angle = 2.5;
        let turn = Quat::from_scaled_axis(Vec3::z() * angle);
        let glove = RigidState::at_rest(Pose::new(Vec3::x() * 0.01, turn));
        for _ in 0..2000 {
            proxies.step(1e-3, &[glove], &[at(0.0)]);
        }
        let [force, torque] = proxies.device_wrenches()[0];
        assert!((force.x + want * 0.01).abs() < 1e-9, "{force}");
        assert_eq!(series_stiffness(k1, k2), want);
        // Large turns are exact in statics: torque = k lever² θ.
        assert!((torque.z + want * 0.02 * 0.02 * angle).abs() < 1e-9, "{torque}");
        assert!((proxies.bone_wrenches()[0][0] + force).norm() < 1e-9);
    }
}

/// With ends that stand still the energy never grows, however stiff, however long the step,
/// however the proxy is turned, stretched and spun.
#[test]
fn energy_never_grows() {
    let mut random = Random::new(17);
    for trial in 0..400 {
        let drive = |random: &mut Random| Drive {
            stiffness: 10_f64.powf(random.range(0.0, 7.0)),
            damping: random.range(0.0, 5.0),
            angular_stiffness: 10_f64.powf(random.range(-3.0, 4.0)),
            angular_damping: random.range(0.0, 0.01),
        };
        let turn = random.rotation(3.0).to_rotation_matrix().into_inner();
        let moments = Vec3::new(2e-7, 1e-8, 1.9e-7);
        let proxy = Proxy {
            mass: 0.004,
            inertia_B: turn * Mat3::from_diagonal(&moments) * turn.transpose(),
            device: drive(&mut random),
            bone: if trial % 2 == 0 { drive(&mut random) } else { finger_bone().bone },
        };
        let mut state = |speed: f64| RigidState {
            pose_WB: Pose::new(random.vector(0.1), random.rotation(3.1)),
            velocity_W: random.vector(speed),
            angular_velocity_W: random.vector(100.0 * speed),
        };
        let (start, tracked, bone) = (state(2.0), state(0.0), state(0.0));
        let h = [1e-4, 1e-3, 1e-2, 0.1][trial % 4];
        let mut proxies = Proxies::new(vec![proxy], &[start]).unwrap();
        let mut before = proxies.energy(&[tracked], &[bone]);
        for step in 0..50 {
            proxies.step(h, &[tracked], &[bone]);
            let now = proxies.energy(&[tracked], &[bone]);
            assert!(now <= before * (1.0 + 1e-9), "{trial} {step}: {before} to {now} J");
            before = now;
        }
    }
}

/// Backward Euler is of first order: against the analytic oscillation about one axis, a
/// tenth of the step gives a tenth of the error.
#[test]
fn motion_converges_at_first_order() {
    let mut proxy = finger_bone();
    (proxy.device.damping, proxy.device.angular_damping) = (0.0, 0.0);
    (proxy.bone.damping, proxy.bone.angular_damping) = (0.0, 0.0);
    let errors = [1e-5, 1e-6].map(|h| {
        let turn = Quat::from_scaled_axis(Vec3::z() * 0.8);
        let start = RigidState::at_rest(Pose::new(Vec3::x() * 0.01, turn));
        let mut proxies = Proxies::new(vec![proxy], &[start]).unwrap();
        let time = 3e-3;
        for _ in 0..(time / h) as usize {
            proxies.step(h, &[at(0.0)], &[at(0.0)]);
        }
        let pose = proxies.states()[0].pose_WB;
        let slow = (1600.0_f64 / 0.004).sqrt();
        let fast = (1600.0 * 0.02 * 0.02 / 3.1e-7_f64).sqrt();
        let angle = rotation_vector(&pose.rotation).z;
        [
            (pose.position.x - 0.01 * (slow * time).cos()).abs(),
            (angle - 0.8 * (fast * time).cos()).abs(),
        ]
    });
    for i in 0..2 {
        let ratio = errors[0][i] / errors[1][i];
        assert!((8.5..11.5).contains(&ratio), "{errors:?}");
    }
}

/// Without couplings a spinning proxy tumbles as a free body does: against the integrator that
/// keeps momentum and energy, to first order in the step.
#[test]
fn a_free_proxy_tumbles() {
    let free = Drive { stiffness: 0.0, damping: 0.0, angular_stiffness: 0.0, angular_damping: 0.0 };
    let moments = Vec3::new(3e-7, 1e-7, 2e-7);
    let inertia_B = Mat3::from_diagonal(&moments);
    let proxy = Proxy { mass: 0.004, inertia_B, device: free, bone: free };
    let spin = Vec3::new(30.0, 60.0, 40.0);
    let start = RigidState { angular_velocity_W: spin, ..at(0.0) };
    let mut proxies = Proxies::new(vec![proxy], &[start]).unwrap();
    let (mut rotation, mut omega) = (Quat::identity(), spin);
    let inverse = Mat3::from_diagonal(&moments.map(f64::recip));
    let h = 1e-6;
    for _ in 0..20_000 {
        proxies.step(h, &[at(0.0)], &[at(0.0)]);
        (rotation, omega) =
            thenar_core::kernels::turn_freely(&rotation, &omega, &inertia_B, &inverse, h);
    }
    let got = proxies.states()[0];
    assert!((omega - spin).norm() > 10.0, "it must tumble: {omega}");
    assert!((got.angular_velocity_W - omega).norm() < 2e-2, "{}", got.angular_velocity_W - omega);
    assert!(got.pose_WB.rotation.angle_to(&rotation) < 1e-3);
}

/// Moving along with its ends, a proxy neither lags nor pulls.
#[test]
fn a_steadily_moving_hand_feels_nothing() {
    let start = RigidState {
        velocity_W: Vec3::new(0.3, -0.1, 0.2),
        angular_velocity_W: Vec3::new(1.0, 2.0, -0.5),
        ..at(0.0)
    };
    let mut proxies = Proxies::new(vec![finger_bone()], &[start]).unwrap();
    for k in 1..500 {
        let pose = start.pose_after(1e-3 * f64::from(k));
        let end = RigidState { pose_WB: pose, ..start };
        proxies.step(1e-3, &[end], &[end]);
        let [force, torque] = proxies.device_wrenches()[0];
        assert!(force.norm() < 1e-9, "{force}");
        // The gyroscopic torque of the bone itself is all that is left.
        assert!(torque.norm() < 3e-6, "{torque}");
    }
}

#[test]
fn bad_ends_let_go_and_bad_states_start_again() {
    let mut proxies = Proxies::new(vec![finger_bone()], &[at(0.0)]).unwrap();
    let bad = RigidState::at_rest(Pose::translation(f64::NAN, 0.0, 0.0));
    let report = proxies.step(1e-3, &[bad], &[at(0.01)]);
    assert_eq!((report.bad_tracked, report.bad_bones), (1, 0));
    assert_eq!(proxies.device_wrenches()[0], [Vec3::zeros(); 2]);
    assert!(proxies.states()[0].pose_WB.position.x > 0.0);
    let moved = proxies.states()[0].pose_WB;
    proxies.step(1e-3, &[bad], &[bad]);
    assert_eq!(proxies.states()[0], RigidState::at_rest(moved));
    let far = at(1e300);
    assert_eq!(proxies.step(1e-3, &[far], &[at(0.5)]).restarted, 1);
    assert_eq!(proxies.device_wrenches()[0], [Vec3::zeros(); 2]);
    for h in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let before = proxies.states()[0];
        proxies.step(h, &[at(0.0)], &[at(0.0)]);
        assert_eq!(proxies.states()[0], before);
    }
}

#[test]
fn senseless_proxies_are_refused() {
    let good = finger_bone();
    let refused = |proxy: Proxy| Proxies::new(vec![good, proxy], &[]).unwrap_err();
    let bad = Proxy { mass: 0.0, ..good };
    assert_eq!(refused(bad), ProxyError::Mass { proxy: 1, mass: 0.0 });
    let bad = Proxy { inertia_B: Mat3::zeros(), ..good };
    assert_eq!(refused(bad), ProxyError::Inertia { proxy: 1 });
    let device = Drive { damping: -1.0, ..good.device };
    let bad = Proxy { device, ..good };
    assert_eq!(refused(bad), ProxyError::Coupling { proxy: 1, value: -1.0 });
}

/// A hand of eleven different bones: some turned far, some whose ends are not finite, one whose own
/// state is none. Each goes as it does alone, to the bit, whatever its neighbours in the lanes do.
#[test]
fn each_of_many_proxies_goes_as_it_does_alone() {
    let mut random = Random::new(31);
    let mut any_state = |spread: f64| RigidState {
        pose_WB: Pose::new(random.vector(0.1), random.rotation(spread)),
        velocity_W: random.vector(0.5),
        angular_velocity_W: random.vector(5.0),
    };
    let starts: Vec<_> = (0..11).map(|_| any_state(0.6)).collect();
    let mut tracked: Vec<_> = (0..11).map(|_| any_state(0.6)).collect();
    let mut bones: Vec<_> = (0..11).map(|_| any_state(0.6)).collect();
    let nowhere = RigidState { velocity_W: Vec3::x() * f64::NAN, ..at(0.0) };
    (tracked[1], bones[9]) = (nowhere, nowhere);
    (tracked[4], bones[4]) = (nowhere, nowhere);
    let mut random = Random::new(32);
    let proxies: Vec<Proxy> = (0..11)
        .map(|_| {
            let turn = random.rotation(3.0).to_rotation_matrix().into_inner();
            let moments = Mat3::from_diagonal(&Vec3::new(3e-7, 1e-7, 3.1e-7));
            let inertia = turn * moments * turn.transpose();
            let mut drive = || Drive {
                stiffness: random.range(10.0, 1000.0),
                damping: random.range(0.0, 2.0),
                angular_stiffness: random.range(0.01, 1.0),
                angular_damping: random.range(0.0, 1e-3),
            };
            let (device, bone) = (drive(), drive());
            Proxy {
                mass: random.range(1e-4, 0.1),
                inertia_B: (inertia + inertia.transpose()) * 0.5,
                device,
                bone,
            }
        })
        .collect();
    let broken = RigidState { velocity_W: Vec3::y() * 1e9, ..starts[6] };
    let mut all = Proxies::new(proxies.clone(), &starts).unwrap();
    all.place(6, broken);
    let mut alone: Vec<_> = (0..11)
        .map(|i| {
            let mut one = Proxies::new(vec![proxies[i]], &starts[i..=i]).unwrap();
            if i == 6 {
                one.place(0, broken);
            }
            one
        })
        .collect();
    for tick in 0..5 {
        let report = all.step(1e-3, &tracked, &bones);
        let mut sum = [0; 3];
        for (i, one) in alone.iter_mut().enumerate() {
            let own = one.step(1e-3, &tracked[i..=i], &bones[i..=i]);
            sum[0] += own.bad_tracked;
            sum[1] += own.bad_bones;
            sum[2] += own.restarted;
            assert_eq!(all.states()[i], one.states()[0], "{i} in tick {tick}");
            assert_eq!(all.device_wrenches()[i], one.device_wrenches()[0], "{i} in tick {tick}");
            assert_eq!(all.bone_wrenches()[i], one.bone_wrenches()[0], "{i} in tick {tick}");
        }
        assert_eq!([report.bad_tracked, report.bad_bones, report.restarted], sum);
        assert_eq!(sum, [2, 2, u32::from(tick == 0)]);
        // Without both ends it stays where it is, to the bit.
        assert_eq!(all.states()[4], RigidState::at_rest(starts[4].pose_WB));
    }
}
