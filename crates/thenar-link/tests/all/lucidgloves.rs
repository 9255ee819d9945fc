//! Goal: a LucidGlove is driven as its firmware wants it. Method: its simulated twin, with the
//! firmware's traps, behind a real pseudo-terminal.
#![cfg(unix)]

use crate::conformance::{self, Bench, wait};
use std::time::{Duration, Instant};
use thenar_core::model::Side;
use thenar_link::lucidgloves::{LucidGlovesDriver, LucidGlovesTwin};
use thenar_link::twin::Twin;
use thenar_track::ANGLES;

/// The shipped profile: fingers from flat to 80, 95, 55 degrees; the thumb from 0, 5, 0, 0 to
/// 15, 22, 45, 60 (flexion, spread, second and third joint).
fn expected(curls: [f64; 5]) -> [f64; ANGLES] {
    let mut degrees = [0.0; ANGLES];
    for (d, curl) in curls.into_iter().enumerate() {
        let [open, closed] = match d {
            0 => [[0.0, 5.0, 0.0, 0.0], [15.0, 22.0, 45.0, 60.0]],
            _ => [[0.0; 4], [80.0, 0.0, 95.0, 55.0]],
        };
        for k in 0..4 {
            degrees[4 * d + k] = open[k] + curl * (closed[k] - open[k]);
        }
    }
    degrees.map(f64::to_radians)
}

fn bench(name: &str, legacy: bool) -> Bench<'static, LucidGlovesTwin> {
    Bench::new(name, LucidGlovesTwin::new(legacy, false), &LucidGlovesDriver, expected)
        // A step of the glove's converter, of the finger that turns most.
        .tolerance(95.0_f64.to_radians() / 4095.0)
}

#[test]
fn it_conforms_in_the_present_encoding() {
    conformance::run(|name| bench(&format!("alpha-{name}"), false));
}

#[test]
fn it_conforms_in_the_older_encoding() {
    conformance::run(|name| bench(&format!("legacy-{name}"), true));
}

/// Unless each line is answered, the firmware says one a second. (At which pace, in simulated time,
/// is tested beside the protocol.)
#[test]
fn the_glove_never_waits_for_an_answer() {
    let bench = bench("answered", false);
    let mut device = bench.open();
    bench.sample(&mut device);
    let (lines, start) = (bench.twin.twin().lines_said, Instant::now());
    let said = || bench.twin.twin().lines_said - lines;
    wait("50 lines of the glove", || (said() >= 50).then_some(()));
    assert!(start.elapsed() < Duration::from_secs(25), "slower than two lines a second");
}

/// However often outputs change, the glove is told no more than it reads, one line for each of its
/// own; and it comes to the newest. Lines are counted, not time: a busy machine stalls either side,
/// and the driver nudges a glove that is silent, at most once in 50 ms.
#[test]
fn outputs_do_not_pile_up_in_front_of_the_glove() {
    const OUTPUTS: i64 = 1000;
    let bench = bench("piling", false);
    let mut device = bench.open();
    bench.sample(&mut device);
    let unasked = || {
        let glove = bench.twin.twin();
        glove.lines_heard as i64 - glove.lines_said as i64
    };
    let before = unasked();
    for k in 0..OUTPUTS {
        device.show([(k % 100) as f64 / 100.0; 5]);
        std::thread::sleep(Duration::from_micros(500));
    }
    let piled = unasked() - before;
    assert!(piled < OUTPUTS / 10, "{piled} lines that the glove did not ask for");
    wait("the newest stop", || {
        device.show([0.4; 5]);
        (bench.twin.twin().felt() == [0.6; 5]).then_some(())
    });
}

#[test]
fn splay_and_single_joints_move_the_hand() {
    let bench = bench("splay", false);
    {
        let mut glove = bench.twin.twin();
        glove.sensors.splay = [4095, 4095, 0, 4095, 0].map(Some);
        glove.sensors.joints[1] = [Some(4095), Some(0), Some(4095), Some(0)];
        glove.set_curls([0.0; 5]);
    }
    let mut device = bench.open();
    let angles = wait("splayed fingers", || {
        let angles = device.angles(Side::Right)?;
        (angles[6] > 1.0).then_some(angles)
    });
    let degrees = angles.map(|a| a.to_degrees().round());
    assert_eq!(degrees[..8], [0.0, 25.0, 0.0, 0.0, 0.0, 20.0, 95.0, 0.0]);
    // Splay towards the thumb brings ring and little finger nearer to the middle one.
    assert_eq!([degrees[9], degrees[13], degrees[17]], [-20.0, -20.0, 20.0]);
}
