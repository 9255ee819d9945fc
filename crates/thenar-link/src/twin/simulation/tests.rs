//! Goal: whatever can be simulated opens with its driver, moves, and is felt. Method: each of them
//! at a place of its own.

use super::*;
use crate::{HandOutput, Rendering, now_ns};
use std::time::{Duration, Instant};
use thenar_core::Vec3;
use thenar_core::model::Side;
use thenar_track::live::LivePose;

/// A number that changes as the hand closes.
fn shape(pose: &LivePose) -> f64 {
    match pose {
        LivePose::Angles { angles, wrist } => angles[4] + wrist.position.x,
        LivePose::Joints { joints, .. } => joints[0].inverse_point(&joints[9].position).norm(),
    }
}

fn wait<T>(what: &str, mut f: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = f() {
            return found;
        }
        assert!(start.elapsed() < Duration::from_secs(30), "{what} never came");
        std::thread::sleep(Duration::from_micros(300));
    }
}

/// All at once: each mostly waits.
#[test]
fn everything_that_is_simulated_opens_moves_and_is_felt() {
    std::thread::scope(|scope| {
        SIMULATIONS.iter().for_each(|kind| _ = scope.spawn(|| opens_moves_and_is_felt(kind)));
    });
}

fn opens_moves_and_is_felt(kind: &SimulatedDevice) {
    let name = kind.name;
    let place = match kind.place {
        Some(default) => {
            assert!(default.parse::<std::net::SocketAddr>().is_ok(), "{default}");
            format!("127.0.0.1:{}", thenar_testing::free_port())
        }
        None => {
            let file = format!("thenar-simulate-{name}-{}", std::process::id());
            std::env::temp_dir().join(file).display().to_string()
        }
    };
    // An 18-sensor glove opens with another profile: what it says is refused by name.
    let mut opened = crate::open(&format!("{}:{place}", kind.driver)).unwrap();
    let device = kind.start(&place).unwrap();
    if name == "cyberglove-18" {
        let tracker = opened.tracker.as_mut().unwrap();
        wait("its refusal", || tracker.messages().into_iter().find(|m| m.contains("18")));
        return;
    }
    if let Some(tracker) = &mut opened.tracker {
        let mut seen = |curls: [f64; 5], mut right: Box<dyn FnMut(f64) -> bool>| {
            device.set_curls(curls);
            wait(name, || {
                let told = shape(tracker.latest(Side::Right)?.pose.as_ref()?);
                right(told).then_some(told)
            })
        };
        let open = seen([0.0; 5], Box::new(|_| true));
        seen([1.0; 5], Box::new(move |told| (told - open).abs() > 0.05));
    }
    let Some(display) = &mut opened.display else { return };
    let free = device.felt();
    let mut output = HandOutput::released(Side::Right, 0);
    output.digits[1].pad_force = 4.0;
    output.digits[1].curl_at_contact = Some(0.25);
    output.force_W = Vec3::new(0.0, 1.0, 0.0);
    let expected = match display.rendering() {
        Rendering::Stops => "index 75%",
        Rendering::Tendons => "index 4.0 N",
        Rendering::Vibration => "right thumb 0%, index 48%",
        Rendering::Wrench => "0.0 1.0 0.0 N",
    };
    wait(expected, || {
        output.time_ns = now_ns();
        display.show(&output);
        device.felt().contains(expected).then_some(())
    });
    wait("release", || (device.felt() == free).then_some(()));
}
