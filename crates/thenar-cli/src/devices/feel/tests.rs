//! Goal: what a person feels first is what was said, on every kind of device, and the guard knows
//! how the hand moves. Method: a display and a tracker in memory, in simulated time.

use super::fake::{Display, MS};
use super::*;
use std::sync::{Arc, Mutex};
use thenar_core::Pose;
use thenar_link::HandSample;
use thenar_scene::live::LivePose;
use thenar_scene::motion::ANGLES;

/// A hand whose index finger's base bends at this rate \[rad/s\].
struct Bending {
    rate: f64,
    now_ns: Arc<Mutex<u64>>,
    sample: Option<HandSample>,
}

impl Tracker for Bending {
    fn latest(&mut self, side: Side) -> Option<&HandSample> {
        let time_ns = *self.now_ns.lock().unwrap();
        let mut angles = [0.0; ANGLES];
        angles[4] = self.rate * time_ns as f64 * 1e-9;
        let pose = Some(LivePose::Angles { wrist: Pose::identity(), angles });
        self.sample = Some(HandSample { side, time_ns, pose });
        self.sample.as_ref()
    }

    fn heard_ns(&mut self) -> Option<u64> {
        None
    }

    fn messages(&mut self) -> Vec<String> {
        Vec::new()
    }
}

/// Output on the second axis, tick by tick of a millisecond, while the finger bends at this rate.
fn trial(rendering: Rendering, rate: f64) -> (Result<(), CliError>, Vec<HandOutput>) {
    let (clock, shown) = (Arc::new(Mutex::new(0)), Arc::new(Mutex::new(Vec::new())));
    let mut display = Display { rendering, heard_ns: clock.clone(), shown: shown.clone() };
    let mut tracker: Box<dyn Tracker> =
        Box::new(Bending { rate, now_ns: clock.clone(), sample: None });
    let limits = gentle(&display.rendering().limits(display.limits()));
    let mut trial = Trial::new(&mut display, Some(&mut tracker), limits, 0.25).unwrap();
    trial.begin(limits).unwrap();
    let mut result = Ok(());
    for k in 0..1800u64 {
        let now = 1000 * MS + k * MS;
        *clock.lock().unwrap() = now;
        let axis = (k >= 300).then_some(1);
        result = result.and_then(|()| trial.tick(now, axis, k.saturating_sub(300) as f64 / 1500.0));
    }
    (result, std::mem::take(&mut *shown.lock().unwrap()))
}

/// A newton and no more, on this finger and no other.
#[test]
fn a_still_hand_feels_a_newton() {
    for rendering in [Rendering::Tendons, Rendering::Stops, Rendering::Vibration] {
        let (result, shown) = trial(rendering, 0.0);
        result.unwrap();
        let most = shown.iter().map(|output| output.digits[1].pad_force).fold(0.0, f64::max);
        assert!((0.98..=1.0).contains(&most), "{rendering:?}: {most} N");
        for output in &shown {
            for (k, digit) in output.digits.iter().enumerate() {
                assert!(k == 1 || digit.pad_force == 0.0);
                let stops = rendering == Rendering::Stops && digit.pad_force > 0.05;
                assert_eq!(digit.curl_at_contact, stops.then_some(0.25));
            }
        }
    }
    let (result, shown) = trial(Rendering::Wrench, 0.0);
    result.unwrap();
    let most = shown.iter().map(|output| output.force_W.y).fold(0.0, f64::max);
    assert!((0.98..=1.0).contains(&most), "{most} N");
    assert!(shown.iter().all(|o| o.force_W.x == 0.0 && o.force_W.z == 0.0));
}

/// A finger that its tendon opens at 0.19 m/s would take 1 N times two thirds (the sine's mean) of
/// 1.5 s times that speed: 0.18 J. The guard, which knows the speed, gives out its reserve at most
/// (1 % of the largest force times 1 m) and then releases all; a stop, which gives nothing to a
/// finger that opens, goes on.
#[test]
fn the_guard_knows_how_fast_a_finger_opens() {
    let reserve = 0.01 * Limits::cybergrasp().force_max();
    let (result, shown) = trial(Rendering::Tendons, -2.0);
    let given: f64 = shown.iter().map(|output| output.digits[1].pad_force * 0.19 * 1e-3).sum();
    assert!(given > 0.5 * reserve && given < 1.01 * reserve, "{given} J, reserve {reserve} J");
    assert!(result.unwrap_err().to_string().contains("the display gave out"));
    assert_eq!(shown.last().map(|output| output.digits[1].pad_force), Some(0.0));
    let (result, shown) = trial(Rendering::Stops, -2.0);
    result.unwrap();
    let most = shown.iter().map(|output| output.digits[1].pad_force).fold(0.0, f64::max);
    assert!(most > 0.98, "{most} N");
}

/// 60 rad/s at 0.095 m are 5.7 m/s: nobody's finger.
#[test]
fn a_finger_that_is_too_fast_releases_all() {
    let told = trial(Rendering::Tendons, 60.0).0.unwrap_err().to_string();
    assert!(told.contains("forces are released"), "{told}");
}
