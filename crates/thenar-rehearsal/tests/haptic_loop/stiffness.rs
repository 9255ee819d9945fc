//! Goal: the stiffness that is stated is what a wearer measures, but for what gives way. Method:
//! rehearsed fingers that press a table a millimetre deeper, force by way, with the couplings as
//! they are and cut by the rule.

use std::path::Path;
use thenar_link::haptic_loop::LoopMode;
use thenar_rehearsal::{FingerImpedance, Outcome, Rehearsal};
use thenar_scene::session::Session;
use thenar_touch::TrackerTiming;

const TABLE: &str = include_str!("../../../thenar-scene/scenes/table-press.toml");

fn measured(grip: Option<f64>) -> (Outcome, [f64; 5]) {
    let what = Rehearsal {
        human: FingerImpedance { mass: 0.2, damping: 10.0, stiffness: 500.0 },
        tracker: TrackerTiming { rate: 1000.0, latency: 0.0, noise: 0.0 },
        mode: LoopMode::Shared,
        grip,
        until: 1.2,
        press: 0.008,
        sway: None,
        // The push is forgotten by then, which was felt softer for a while.
        after: 4.0,
    };
    let small = ["hand.hand.preset=paper", "hand.hand.tets=200"].map(str::to_owned);
    let session = Session::from_text(TABLE, Path::new("test.toml"), &small).expect("a scene");
    let out = what.run_and_measure(session).expect("a hand that presses");
    let measured = out.measured.expect("a hand that does not sway");
    println!("{grip:?}: stated {} N/m, measured {measured:.1?}", out.stiffness);
    (out, measured)
}

/// A bone that cannot move is felt as the couplings are, in series with the pad's flesh and the
/// finger's joints: softer, by what these give way, and the rule cuts all of it in one part, that
/// which is stated.
#[test]
fn what_is_measured_is_cut_as_is_stated() {
    let (whole, as_they_are) = measured(None);
    let (cut, by_the_rule) = measured(Some(1.0));
    let part = cut.stiffness / whole.stiffness;
    assert!(part < 0.6, "{part}");
    // Index to little press along their pads' normals.
    for k in 1..5 {
        assert!(as_they_are[k] < whole.stiffness, "{k}: {} N/m", as_they_are[k]);
        assert!(as_they_are[k] > 0.5 * whole.stiffness, "{k}: {} N/m", as_they_are[k]);
        let measured = by_the_rule[k] / as_they_are[k];
        assert!((measured / part - 1.0).abs() < 0.1, "{k}: cut to {measured}, stated {part}");
    }
}
