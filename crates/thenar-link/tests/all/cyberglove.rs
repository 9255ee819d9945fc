//! Goal: CyberGloves of three kinds are understood. Method: their simulated twins behind a real
//! pseudo-terminal.
#![cfg(unix)]

use crate::conformance::{self, Bench, wait};
use thenar_core::model::Side;
use thenar_link::cyberglove::{ClassicTwin, CyberGlove3Driver, CyberGloveDriver, ThirdTwin};
use thenar_link::twin::Twin;
use thenar_track::ANGLES;

/// Fingers bend by 80, 95 and 55 degrees, the thumb by 15, 45 and 60 and spreads by 5 to 22.
fn expected_22(curls: [f64; 5]) -> [f64; ANGLES] {
    let mut degrees = [0.0; ANGLES];
    for (d, curl) in curls.into_iter().enumerate() {
        let of_digit = match d {
            0 => [15.0 * curl, 5.0 + 17.0 * curl, 45.0 * curl, 60.0 * curl],
            _ => [80.0 * curl, 0.0, 95.0 * curl, 55.0 * curl],
        };
        degrees[4 * d..4 * d + 4].copy_from_slice(&of_digit);
    }
    degrees.map(f64::to_radians)
}

/// Without sensors there, a finger's outer joint bends by two thirds of the middle one.
fn expected_18(curls: [f64; 5]) -> [f64; ANGLES] {
    let mut angles = expected_22(curls);
    for d in 1..5 {
        angles[4 * d + 3] = angles[4 * d + 2] * 2.0 / 3.0;
    }
    angles
}

/// Half a step of a bend sensor: 254 steps over 110 degrees.
const CLASSIC_STEP: f64 = 0.51 * 110.0 / 254.0;

#[test]
fn a_glove_with_22_sensors_conforms() {
    conformance::run(|name| {
        let twin = ClassicTwin::new(22);
        Bench::new(&format!("22-{name}"), twin, &CyberGloveDriver, expected_22)
            .tolerance(CLASSIC_STEP.to_radians())
    });
}

#[test]
fn a_glove_with_18_sensors_conforms() {
    let profile = std::env::temp_dir().join(format!("thenar-cg18-{}.toml", std::process::id()));
    std::fs::write(&profile, "[glove]\nsensors = 18\n").unwrap();
    conformance::run(|name| {
        let twin = ClassicTwin::new(18);
        Bench::new(&format!("18-{name}"), twin, &CyberGloveDriver, expected_18)
            .tolerance(CLASSIC_STEP.to_radians())
            .options(&format!("?profile={}", profile.display()))
    });
    std::fs::remove_file(&profile).unwrap();
}

#[test]
fn a_glove_of_the_third_kind_conforms() {
    conformance::run(third);
}

fn third(name: &str) -> Bench<'static, ThirdTwin> {
    Bench::new(&format!("3-{name}"), ThirdTwin::default(), &CyberGlove3Driver, expected_22)
        .tolerance((0.51_f64 * 110.0 / 4095.0).to_radians())
}

/// One damaged packet is skipped; a second within two seconds means that the stream is broken, and
/// it is started again.
#[test]
fn a_stream_that_keeps_breaking_is_started_anew() {
    let bench = third("broken");
    let mut device = bench.open();
    bench.sample(&mut device);
    assert_eq!(bench.twin.twin().starts, 1);
    // Bytes between packets shift all that follow.
    bench.twin.add_noise(b"shift");
    device.told("a packet is damaged");
    bench.sample(&mut device);
    assert_eq!(bench.twin.twin().starts, 1);
    bench.twin.add_noise(b"shift");
    device.told("the stream keeps breaking; it is started anew");
    wait("the second start", || (bench.twin.twin().starts == 2).then_some(()));
    bench.sample(&mut device);
}

/// Opening it again does not restart a stream that flows.
#[test]
fn a_stream_that_flows_is_not_started_again() {
    let bench = third("flowing");
    bench.twin.twin().step(0, b"1E4010111\x001S\0", &mut |_| {});
    let mut device = bench.open();
    for _ in 0..40 {
        bench.sample(&mut device);
    }
    assert_eq!(bench.twin.twin().starts, 1);
}

#[test]
fn the_wrong_number_of_sensors_is_named() {
    let bench = Bench::new("wrong", ClassicTwin::new(18), &CyberGloveDriver, expected_22);
    let mut device = bench.open();
    device.told("the glove has 18 sensors, the profile says 22 (glove.sensors)");
    assert!(device.angles(Side::Right).is_none());
}
