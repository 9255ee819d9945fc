//! Goal: the rule shows a loose hand less than what it comes to rest on, and not much less. Method:
//! the stiffest coupling on which a finger that presses a table is still, found by rehearsals,
//! beside a late spring by theory.

use std::path::Path;
use thenar_link::haptic_loop::LoopMode;
use thenar_rehearsal::{FingerImpedance, Rehearsal, RehearsalError};
use thenar_scene::session::Session;
use thenar_touch::{GRIP, MARGIN, TrackerTiming};

const TABLE: &str = include_str!("../../../thenar-scene/scenes/table-press.toml");

#[test]
fn the_rule_stays_below_the_onset_of_humming() {
    let what = Rehearsal {
        human: FingerImpedance { mass: 0.05, damping: 1.2, stiffness: 50.0 },
        tracker: TrackerTiming { rate: 60.0, latency: 0.05, noise: 0.0 },
        mode: LoopMode::Shared,
        grip: Some(GRIP),
        until: 1.2,
        press: 0.01,
        sway: None,
        after: 3.0,
    };
    let small = ["hand.hand.preset=paper", "hand.hand.tets=200"].map(str::to_owned);
    let open = || -> Result<Session, RehearsalError> {
        Ok(Session::from_text(TABLE, Path::new("test.toml"), &small).expect("a scene"))
    };
    let onset = what.onset(open).expect("a hand that presses");
    println!("{onset:?}");
    assert!(onset.shown < onset.stiffness, "{onset:?}");
    // Theory takes all delay for one.
    assert!(
        onset.stiffness > onset.theory / 1.6 && onset.stiffness < 1.6 * onset.theory,
        "{onset:?}"
    );
    // The loop does not know the wearer's damping: by its grip of 1 N s/m it shows b / (T/2 + t_d),
    // with what it keeps free.
    let rule = MARGIN * GRIP / (0.5e-3 + onset.delay);
    assert!((onset.shown / rule - 1.0).abs() < 1e-9, "{onset:?}, {rule} N/m by the rule");
}
