//! Goal: fingertips that a scene wants at places come there, on the usual hand, whose flesh and
//! joints resist, and on the paper's. Method: the middle of each pad, carried by its simulated
//! bone, beside its place.

use std::path::Path;
use thenar_core::Vec3;
use thenar_core::model::Digit;
use thenar_scene::session::Session;
use thenar_track::reach::{Chain, PadPlace};

/// Thumb to little finger, under a palm at a height of 0.3 m [m].
const PLACES: [[f64; 3]; 5] = [
    [-0.045, 0.255, -0.100],
    [-0.025, 0.250, -0.130],
    [0.000, 0.250, -0.135],
    [0.020, 0.250, -0.130],
    [0.035, 0.260, -0.115],
];
/// How far drives let a fingertip lag that nothing touches [m]: as far as its skin gives way under
/// 1 N. The paper's drives have no muscles beside them.
const LAG: [(&str, f64); 2] = [("touch", 2e-3), ("paper", 4e-3)];

fn scene(preset: &str) -> String {
    let [thumb, index, middle, ring, little] = PLACES;
    format!(
        r#"
        version = 1
        time_step = 0.01
        [[hand]]
        name = "hand"
        preset = "{preset}"
        [hand.motion]
        kind = "keyframes"
        [[hand.motion.key]]
        time = 0
        pose = "rest"
        wrist = {{ position = [0, 0.3, 0], fingers = [0, 0, -1], back = [0, 1, 0] }}
        [[hand.motion.key]]
        time = 0.5
        tips = {{ thumb = {thumb:?}, index = {index:?}, middle = {middle:?}, ring = {ring:?}, little = {little:?} }}
        "#
    )
}

#[test]
fn fingertips_come_to_their_places() {
    for (preset, lag) in LAG {
        let mut session =
            Session::from_text(&scene(preset), Path::new("tips.toml"), &[]).expect("a scene");
        for _ in 0..100 {
            session.step(&mut ());
        }
        let hand = &session.hands()[0];
        for (digit, place) in Digit::FINGERS.into_iter().zip(PLACES) {
            let pad = Chain::new(&hand.model, digit, PadPlace::Tip).expect("a chain").pad;
            let bone = session.world().rigid_pose(hand.handle.bones.start + pad.bone as u32);
            let there = bone.point(&(pad.centre_B + pad.normal_B * pad.radius));
            let off = (there - Vec3::from(place)).norm();
            assert!(off < lag, "{preset}: the {}'s pad is {off} m off", digit.name());
        }
    }
}
