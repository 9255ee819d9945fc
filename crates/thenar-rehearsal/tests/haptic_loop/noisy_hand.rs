//! Goal: a loosely held hand that is seen with noise is given no energy but what noise stirs.
//! Method: rehearsals on a table with the weakest hands, and what they are given in the last second
//! of many.

use std::path::Path;
use thenar_link::haptic_loop::LoopMode;
use thenar_rehearsal::{FingerImpedance, Rehearsal};
use thenar_scene::session::Session;
use thenar_touch::TrackerTiming;

const TABLE: &str = include_str!("../../../thenar-scene/scenes/table-press.toml");

/// A millimetre of the wrist and one of each finger, 1.4 mm at a pad, are remembered for some 40 ms
/// at 90 Hz and 60 ms at 60 Hz: the rule knows, and leaves 15 to 23 N/m behind a tracker without
/// latency and 8 to 10 N/m behind one of 50 ms. Stirred by the force of noise, K times half a
/// millimetre or so, a finger of damping b takes up no more than `F²/b`, even if all of it were at
/// the finger's own frequency. That is all it is given nine seconds after it was pushed, besides
/// what it goes along with the mean force from the window's begin to its end, less than twice 1.42
/// times its sway.
#[test]
fn a_loose_hand_seen_with_noise_is_only_stirred() {
    for (mbk, [rate, latency]) in [
        ([0.05, 1.0, 50.0], [90.0, 0.0]),
        ([0.02, 1.0, 50.0], [60.0, 0.0]),
        ([0.2, 1.0, 50.0], [120.0, 0.0]),
        ([0.05, 1.0, 50.0], [60.0, 0.05]),
    ] {
        let small = ["hand.hand.preset=paper", "hand.hand.tets=200"].map(str::to_owned);
        let session = Session::from_text(TABLE, Path::new("test.toml"), &small).expect("a scene");
        let [mass, damping, stiffness] = mbk;
        let what = Rehearsal {
            human: FingerImpedance { mass, damping, stiffness },
            tracker: TrackerTiming { rate, latency, noise: 1e-3 },
            mode: LoopMode::Shared,
            grip: Some(1.0),
            until: 1.2,
            press: 0.01,
            sway: None,
            after: 9.0,
        };
        let out = what.run(session).expect("a hand that presses");
        let (worst, force) = (out.worst(), 0.6e-3 * out.stiffness);
        println!(
            "{mbk:?}, {rate} Hz {latency} s: {:.1} N/m at {:.1} ms, {worst:?} {:?}",
            out.stiffness,
            1e3 * out.delay,
            out.trips
        );
        assert!(out.trips.is_empty() && out.live && worst.mean > 0.02, "{:?}", out.trips);
        let felt = if latency > 0.0 { 8.0..10.0 } else { 15.0..23.0 };
        assert!(felt.contains(&out.stiffness), "{} N/m", out.stiffness);
        let most = force * force / damping + 2.84 * worst.motion_rms * worst.mean;
        assert!(worst.given < most, "{worst:?} at {force} N");
        // Near its own frequency a loose hand sways by more than F/k.
        assert!(worst.motion_rms < 3.0 * force / stiffness, "{worst:?} at {force} N");
    }
}
