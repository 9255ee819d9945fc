//! Goal: a scene chooses whether bones are solid, and what a bone bears is its finger's. Method: a hand
//! lies on a floor under a weight of 200 kg, which its flesh alone cannot bear; loads are summed up
//! from the contacts of the world.

use std::path::Path;
use thenar::model::BodyId;
use thenar_scene::session::Session;

fn load(hand: &str) -> Session {
    let text = format!(
        "version = 1
        time_step = 0.005
        duration = 0.3
        [[hand]]
        name = \"hand\"
        position = [0.0, 0.025, 0.0]
        driven = false
        {hand}
        [[rigid]]
        name = \"floor\"
        motion = \"fixed\"
        shape = {{ kind = \"plane\" }}
        [[rigid]]
        name = \"weight\"
        position = [0.0, 0.07, -0.09]
        mass = 200.0
        shape = {{ kind = \"box\", size = [0.3, 0.02, 0.3] }}"
    );
    Session::from_text(&text, Path::new("test.toml"), &[]).unwrap_or_else(|e| panic!("{e}"))
}

fn bones_with_shape(session: &Session) -> usize {
    let bones = session.hands()[0].handle.bones.clone();
    let rigids = &session.world().desc().rigids;
    bones.filter(|b| rigids[*b as usize].shape.is_some()).count()
}

#[test]
fn bones_are_solid_unless_the_scene_says_otherwise() {
    assert_eq!(bones_with_shape(&load("")), 16);
    assert_eq!(bones_with_shape(&load("bones = \"solid\"")), 16);
    assert_eq!(bones_with_shape(&load("bones = \"none\"")), 0);
    // A skeleton without flesh touches nothing.
    assert_eq!(bones_with_shape(&load("flesh = false")), 0);
}

#[test]
fn what_bones_bear_counts_for_the_hand() {
    let mut session = load("");
    for _ in 0..session.steps_wanted() {
        assert!(!session.step(&mut ()).non_finite);
    }
    let hand = &session.hands()[0];
    let [mut on_flesh, mut on_bones] = [0.0; 2];
    for contact in session.world().contacts() {
        for body in contact.bodies {
            let normal = contact.force_W.dot(&contact.normal_W);
            match body {
                BodyId::Soft(soft) if soft == hand.handle.soft => on_flesh += normal,
                BodyId::Rigid(b) if hand.handle.bones.contains(&b) => on_bones += normal,
                _ => {}
            }
        }
    }
    assert!(on_bones > 100.0, "{on_bones} N on bones, {on_flesh} N on flesh");
    let told: f64 = session.hand_loads(0).iter().map(|load| load.normal).sum();
    let all = on_flesh + on_bones;
    assert!((told / all - 1.0).abs() < 1e-9, "{told} N of {all} N");
}
