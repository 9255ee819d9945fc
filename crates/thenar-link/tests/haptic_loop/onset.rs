//! Goal: the rule shows a loose hand less than what it comes to rest on, and not much less. Method: the stiffest coupling on which
//! a finger that presses a table is still, found by rehearsals, beside a late spring by theory.

use std::path::Path;
use thenar_link::haptic_loop::LoopMode;
use thenar_link::rehearsal::{Human, Rehearsal, RehearsalError};
use thenar_scene::session::Session;
use thenar_touch::{GRIP, TrackerTiming};

const TABLE: &str = include_str!("../../../../scenes/table-press.toml");

#[test]
fn the_rule_stays_below_the_onset_of_humming() {
    let what = Rehearsal {
        human: Human { mass: 0.05, damping: 1.0, stiffness: 50.0 },
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
    assert!((onset.stiffness / onset.theory).ln().abs() < 0.5, "{onset:?}");
}
