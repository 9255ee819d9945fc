//! Goal: a visitor has a hand grip what is under it, and is told what cannot be had. Method: a
//! visitor at the hub of the scene with a ball, whose own grip is put off.

mod decoder;
mod visitor;

use visitor::{Visitor, start};

#[test]
fn a_visitor_has_the_hand_grip_and_open() {
    let still =
        ["hand.0.preset=paper", "duration=1000", "hand.0.grip.0.at=900", "hand.0.grip.0.open=901"];
    let (_live, hub) = start("ball-grip", &still);
    let mut one = Visitor::join(&hub, 1);
    let model = one.model();
    let rigids = model.json["rigids"].as_array().expect("bodies");
    let ball = rigids.iter().position(|rigid| rigid["name"] == "ball").expect("a ball");
    one.until("the wrist over the ball", |s| s.time > 0.9);

    // What is not there is told, and is no offence.
    one.say(r#"{"type":"grip","object":"egg"}"#);
    let (note, refusal) = one.note();
    let said = note["message"].as_str().expect("a message");
    assert!(
        said.contains("no body is named \"egg\"") && said.contains("\"ball\"") && !refusal,
        "{note}"
    );

    // The script lifts the wrist from 2.2 to 3 s; the ball goes up with it when the hand has it.
    one.say(r#"{"type":"grip","kind":"pinch","force":2}"#);
    let lifted = one.until("the ball in the air", |s| s.rigids[ball][1] > 0.1);
    assert!(lifted.time > 2.2);
    one.say(r#"{"type":"release"}"#);
    one.until("the ball on the table", |s| s.rigids[ball][1] < 0.022);
}
