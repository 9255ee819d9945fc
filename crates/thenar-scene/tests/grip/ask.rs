//! What cannot be had is told: when the scene is opened, or while it runs, in one sentence that
//! names the figure.

use crate::stage::{Stage, open};
use std::path::Path;
use thenar_scene::grip::{GripHand, GripKind, Phase, Trouble};
use thenar_scene::session::{GripError, Session};

fn ball() -> Stage {
    Stage::ball("paper", GripKind::Pinch, 2.0, 5e-3)
}

/// The one error of a scene in which `from` is replaced.
fn error(from: &str, to: &str) -> String {
    let text = ball().text();
    assert!(text.contains(from), "{text}");
    let text = text.replacen(from, to, 1);
    match Session::from_text(&text, Path::new("grip.toml"), &[]) {
        Ok(_) => panic!("{to} is taken"),
        Err(e) => e.to_string(),
    }
}

#[test]
fn nonsense_is_refused_with_its_reason() {
    let said = error("object = \"thing\"", "object = \"thimg\"");
    assert!(said.contains("no body is named \"thimg\"") && said.contains("\"thing\""), "{said}");
    let said = error("object = \"thing\"", "object = \"hand\"");
    assert!(said.contains("is the hand itself"), "{said}");
    let said = error("kind = \"pinch\"", "kind = \"pinhc\"");
    assert!(said.contains("expected one of \"pinch\", \"tripod\""), "{said}");
    let said = error("force = 2", "force = -2");
    assert!(said.contains("force"), "{said}");
    let said = error("at = 0.1", "at = 0.1\nopen = 0.05");
    assert!(said.contains("`open` later than `at`"), "{said}");
    let twice = "at = 0.1\n[[hand.grip]]\nobject = \"thing\"\nkind = \"tripod\"\nat = 0.5";
    let said = error("at = 0.1", twice);
    assert!(said.contains("one thing at a time"), "{said}");
    let said = error("name = \"hand\"", "name = \"hand\"\ndriven = false");
    assert!(said.contains("`driven = false` grips nothing"), "{said}");
    let said = error("name = \"hand\"", "name = \"hand\"\nflesh = false");
    assert!(said.contains("touches nothing"), "{said}");
    let text = ball().text().replacen("kind = \"pinch\"", "kind = \"hook\"", 1);
    let text = text.replacen("object = \"thing\"\n", "", 1);
    let said =
        Session::from_text(&text, Path::new("grip.toml"), &[]).map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("a hook bends around an `object`"), "{said}");
    let plane = "name = \"floor\"\nmotion = \"fixed\"\nshape = { kind = \"plane\" }\n[[rigid]]\nname = \"peg\"";
    let text = ball().text().replacen("name = \"peg\"", plane, 1);
    let text = text.replacen("object = \"thing\"", "object = \"floor\"", 1);
    let said =
        Session::from_text(&text, Path::new("grip.toml"), &[]).map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("is a plane"), "{said}");
}

/// 300 mm is more than thumb and index finger open to, 145 mm on this hand.
#[test]
fn what_is_too_large_is_told_when_the_scene_is_opened() {
    let object =
        "[[rigid]]\nshape = { kind = \"sphere\", radius = 0.15 }\nmass = 0.5\nmotion = \"fixed\"";
    let stage = Stage { object: object.into(), drop: 0.25, ..ball() };
    let session = stage.session();
    let warnings = session.warnings();
    let said = "hand `hand`: pinch: `thing` of 300 mm across does not fit between thumb and index, which open to ";
    assert!(warnings.iter().any(|warning| warning.starts_with(said)), "{warnings:?}");
}

/// 50 g at a friction of 0.8 slip out of two pads below m g / (2 μ) = 0.31 N.
#[test]
fn what_slips_out_is_told_when_the_scene_is_opened() {
    let told = |force: f64| {
        let stage = Stage { force, ..ball() };
        stage.session().warnings().iter().find(|said| said.contains("slips out")).cloned()
    };
    let said = told(0.3).expect("a warning");
    assert!(said.starts_with("hand `hand`: pinch: `thing` slips out"), "{said}");
    assert!(
        said.contains("more than 0.31 N at a friction of 0.80") && said.contains("0.3 N"),
        "{said}"
    );
    assert_eq!(told(0.32), None);
}

/// What the grip of a stage complained of until `end` [s], each kind of complaint once.
fn complaints(stage: &Stage, adapts: bool, end: f64) -> Vec<String> {
    let text = stage.text();
    let text = if adapts { text.replace(&format!("force = {}\n", stage.force), "") } else { text };
    let mut session = open(&text);
    let mut said: Vec<String> = Vec::new();
    while session.world().time() < end {
        session.step(&mut ());
        said.extend(session.grip_trouble(0).filter(|now| said.last() != Some(now)));
    }
    said
}

/// A friction of 0.02 × that of skin holds nothing round: it is gone before it is pressed, which is
/// no lack of strength.
#[test]
fn a_ball_that_squirts_out_is_told_as_such() {
    let stage = Stage { friction: 0.02, ..Stage::ball("touch", GripKind::Pinch, 2.0, 1e-2) };
    let said = complaints(&stage, true, 4.5);
    let last = said.last().expect("a complaint");
    assert!(last.contains("`thing` slipped out of thumb and index"), "{said:?}");
    assert!(!said.iter().any(|said| said.contains("drives")), "{said:?}");
    // Numbers are as long as they are worth.
    let long = said.iter().flat_map(|said| said.split(' ')).filter(|word| word.contains('.'));
    assert!(long.clone().all(|word| word.len() < 7), "{said:?}");
}

/// A box of 200 by 50 by 200 mm lies on a table: its 50 mm are between top and table, where no
/// finger gets to, and 200 mm are more than the pads of any hand open to.
#[test]
fn a_box_that_lies_on_its_flat_side_is_too_large() {
    let object = "[[rigid]]\nname = \"table\"\nshape = { kind = \"plane\" }\nmotion = \"fixed\"\n\
                  position = [0, -0.025, 0]\n\
                  [[rigid]]\nshape = { kind = \"box\", size = [0.2, 0.05, 0.2] }\nmass = 0.3";
    let size = [0.05, 0.05];
    let stage = Stage { object: object.into(), size, drop: 0.06, ..ball() };
    let said = complaints(&stage, false, 1.5);
    let first = said.first().expect("a complaint");
    assert!(first.contains("`thing` of 200 mm across does not fit between"), "{said:?}");
}

#[test]
fn what_is_too_far_is_told_and_the_fingers_stay_sound() {
    let text =
        ball().text().replacen("name = \"thing\"", "name = \"thing\"\nposition = [0, 0, -0.5]", 1);
    let mut session = open(&text);
    while session.world().time() < 1.0 {
        assert!(!session.step(&mut ()).non_finite);
    }
    let said = session.grip_trouble(0).expect("a trouble");
    assert!(said.contains("`thing` is") && said.contains("too far for the fingers"), "{said}");
    assert!(said.contains("pinch") && said.contains(" mm "), "{said}");
}

#[test]
fn a_grip_is_asked_for_while_the_session_runs() {
    let mut session = open(&ball().text_without_grip());
    assert_eq!(session.grip_state(0), None);
    let refused = session.grip(3, None, GripKind::Pinch, None);
    assert_eq!(refused, Err(GripError::NoHand { hand: 3, count: 1 }));
    let refused = session.grip(0, Some("nothing"), GripKind::Pinch, None).unwrap_err();
    assert!(refused.to_string().contains("no body is named \"nothing\""), "{refused}");
    assert!(refused.to_string().contains("\"thing\""), "{refused}");
    assert_eq!(session.grip(0, None, GripKind::Pinch, Some(-1.0)), Err(GripError::Force(-1.0)));
    // What is under the hand is the ball, not the fixed peg.
    assert_eq!(session.grip(0, None, GripKind::Pinch, Some(2.0)), Ok("thing".into()));
    while session.world().time() < 3.5 {
        session.step(&mut ());
    }
    let state = session.grip_state(0).expect("a grip");
    assert_eq!(state.phase, Phase::Holding);
    assert!((state.force - 2.0).abs() < 0.2, "{state:?}");
    // Another kind at once: the hand opens, then grips; what it had falls.
    session.release(0).expect("a hand");
    while session.world().time() < 4.2 {
        session.step(&mut ());
    }
    assert_eq!(session.grip_state(0), None);
    let near = session.grip(0, None, GripKind::Power, None).unwrap_err();
    assert!(near.to_string().contains("nothing is within 120 mm"), "{near}");
}

#[test]
fn a_session_that_starts_over_grips_again() {
    let mut session = ball().session();
    let mut hashes = Vec::new();
    for _ in 0..2 {
        for _ in 0..200 {
            session.step(&mut ());
        }
        hashes.push(session.world().state_hash());
        session.restart();
    }
    assert_eq!(hashes[0], hashes[1]);
}

/// Whoever moves a hand live grips with it: the scene's grip lets go of a hand that poses take
/// over, and does not begin on one that they move.
#[test]
fn a_hand_that_is_moved_live_leaves_the_grips_of_the_scene() {
    for taken in [0.0, 0.4] {
        let mut session = ball().session();
        let mut live = session.live_hand(0).expect("a hand that poses move");
        while session.world().time() < 1.5 {
            let time = session.world().time();
            if time >= taken {
                let bones = session.hands()[0].handle.bones.clone();
                let pose = live
                    .pose_of(&session.input().targets[bones.start as usize..bones.end as usize]);
                session.live_pose(0, time, &pose).expect("a pose");
            }
            session.step(&mut ());
            // From 0.1 s, and until half a second after poses came; not to the step.
            let time = session.world().time();
            let held = taken > 0.1 && (0.1..taken + 0.5).contains(&time);
            if [0.1, taken + 0.5].iter().all(|edge| (time - edge).abs() > 0.02) {
                assert_eq!(session.grip_state(0).is_some(), held, "{taken}: {time} s");
            }
        }
    }
}

/// Of a pad that ends short of its place, and of a thing that is nearly too large, the sentence
/// names kind, object, digit and lengths in whole millimetres.
#[test]
fn pads_that_end_short_are_told_with_their_digit() {
    let session = open(&ball().text_without_grip());
    let hand = &session.hands()[0];
    let bodies = session.world().desc().rigids.len();
    let mut gripping = GripHand::new(hand, bodies).expect("a hand that grips");
    gripping.learn(hand, GripKind::Power).expect("a kind");
    let opposition = gripping.opposition(GripKind::Power).expect("learnt");
    let told = |trouble: Trouble| trouble.sentence(opposition, "loaf", 2.0);
    assert_eq!(
        told(Trouble::OutOfReach { pad: 2, miss: 0.0174 }),
        "power: the middle ends 17 mm short of its place on `loaf`"
    );
    assert_eq!(
        told(Trouble::Wide { width: 0.1204, opening: 0.13, pad: 0, miss: 0.021 }),
        "power: `loaf` of 120 mm across is too large from here: thumb and fingers open to 130 mm, \
         and the thumb ends 21 mm short of its place"
    );
}
