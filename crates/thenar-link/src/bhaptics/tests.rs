//! Goal: gloves vibrate with what the pads feel, ten times a second at most, and stop.

use super::*;
use crate::testing::{collect, tick};
use thenar_testing::Mutator;

const MS: u64 = 1_000_000;

fn press(side: Side, force: f64, slip: f64) -> HandOutput {
    let mut output = HandOutput::released(side, 0);
    output.digits[1] = DigitOutput { pad_force: force, slip_speed: slip, ..Default::default() };
    output
}

/// Position and intensities of a frame, read as the player would.
fn read(bytes: &[u8]) -> (String, Vec<u64>) {
    let json: serde_json::Value = serde_json::from_slice(bytes).unwrap();
    let submit = json["Submit"].as_array().unwrap();
    assert_eq!((submit.len(), submit[0]["type"].as_str()), (1, Some("frame")));
    assert_eq!(json["Register"], serde_json::json!([]));
    let frame = &submit[0]["Frame"];
    assert_eq!(frame["durationMillis"], 100);
    assert_eq!(frame["pathPoints"], serde_json::json!([]));
    let dots = frame["dotPoints"].as_array().unwrap();
    assert!(dots.iter().enumerate().all(|(k, dot)| dot["index"] == k));
    let intensities = dots.iter().map(|dot| dot["intensity"].as_u64().unwrap()).collect();
    (frame["position"].as_str().unwrap().to_owned(), intensities)
}

#[test]
fn a_frame_is_what_the_player_takes() {
    assert_eq!(
        frame(Side::Right, &[60, 0, 0, 0, 100]),
        "{\"Register\":[],\"Submit\":[{\"type\":\"frame\",\"key\":\"thenar-right\",\"Frame\":\
         {\"durationMillis\":100,\"position\":\"GloveR\",\"dotPoints\":[\
         {\"index\":0,\"intensity\":60},{\"index\":1,\"intensity\":0},\
         {\"index\":2,\"intensity\":0},{\"index\":3,\"intensity\":0},\
         {\"index\":4,\"intensity\":100}],\"pathPoints\":[]}}]}"
    );
}

#[test]
fn intensity_grows_with_force_and_slip() {
    let feel = IntensityMap::default();
    let of = |force: f64, slip_speed: f64| {
        feel.intensity(&DigitOutput { pad_force: force, slip_speed, ..Default::default() })
    };
    assert_eq!([of(0.0, 1.0), of(0.04, 1.0), of(-3.0, 1.0)], [0; 3], "no touch, no slip");
    assert_eq!([of(2.5, 0.0), of(5.0, 0.0), of(50.0, 0.0)], [30, 60, 60]);
    assert_eq!([of(5.0, 0.1), of(5.0, 9.0), of(2.5, 0.1)], [80, 100, 50]);
    assert_eq!([of(f64::NAN, 1.0), of(f64::INFINITY, 1.0), of(5.0, f64::NAN)], [0, 0, 60]);
}

/// A touch of 350 ms: shown at once, then every 100 ms, then a frame of zeros.
#[test]
fn frames_are_ten_a_second_and_end_with_zeros() {
    let mut player = Bhaptics::default();
    let mut frames = Vec::new();
    for ms in 1000..2000u64 {
        let force = if (1103..1453).contains(&ms) { 5.0 } else { 0.0 };
        for bytes in tick(&mut player, ms * MS, Some(&press(Side::Right, force, 0.0))) {
            frames.push((ms, read(&bytes)));
        }
    }
    let right = |index| ("GloveR".to_owned(), vec![0, index, 0, 0, 0]);
    // The frame due at 1503 shows what came since the last one, then the pad is free.
    let want = [
        (1103, right(60)),
        (1203, right(60)),
        (1303, right(60)),
        (1403, right(60)),
        (1503, right(60)),
        (1504, right(0)),
    ];
    assert_eq!(frames, want);
}

#[test]
fn a_short_tap_between_frames_is_felt() {
    let mut player = Bhaptics::default();
    let mut told = Vec::new();
    for ms in 0..400u64 {
        let force = match ms {
            10 => 2.5,
            40 => 5.0,
            _ => 0.0,
        };
        for bytes in tick(&mut player, ms * MS, Some(&press(Side::Left, force, 0.0))) {
            told.push((ms, read(&bytes).1[1]));
        }
    }
    assert_eq!(told, [(10, 30), (110, 60), (111, 0)]);
}

#[test]
fn silence_of_the_loop_ends_vibration() {
    let mut player = Bhaptics::default();
    assert_eq!(tick(&mut player, MS, Some(&press(Side::Left, 5.0, 0.0))).len(), 1);
    let mut last = None;
    for ms in 2..200 {
        for bytes in tick(&mut player, ms * MS, None) {
            last = Some((ms, read(&bytes).1));
        }
    }
    assert_eq!(last, Some((22, vec![0; 5])));
    let mut words = Vec::new();
    player.stop(&mut |bytes| words.push(read(bytes)));
    let zeros = |glove: &str| (glove.to_owned(), vec![0; 5]);
    assert_eq!(words, [zeros("GloveL"), zeros("GloveR")]);
}

#[test]
fn the_players_gloves_are_told_once() {
    let status = |gloves: &str| {
        format!("{{\"ActiveKeys\":[],\"ConnectedPositions\":[{gloves}],\"Status\":{{\"a\":[1]}}}}")
    };
    let mut player = Bhaptics::default();
    let mut told = |text: String| -> Vec<String> {
        (collect(&mut player, MS, &[text.as_bytes()]).into_iter())
            .filter_map(|event| match event {
                Event::Note(text) => Some(text),
                _ => None,
            })
            .collect()
    };
    assert_eq!(told(status("")), ["the player has no glove"]);
    assert_eq!(
        told(status("\"Vest\",\"GloveR\",\"GloveL\"")),
        ["the player has GloveL and GloveR"]
    );
    assert!(told(status("\"GloveL\",\"GloveR\"")).is_empty());
    assert!(told("{\"RegisteredKeys\":[]}".into()).is_empty());
}

#[test]
fn damaged_statuses_do_no_harm() {
    let good = br#"{"RegisteredKeys":[],"ActiveKeys":["x"],"ConnectedDeviceCount":1,"ConnectedPositions":["GloveL"],"Status":{"GloveL":[0,0,0,0,0,0]}}"#;
    let (mut mutator, mut player) = (Mutator::new(9), Bhaptics::default());
    let (mut alive, mut refused) = (0, 0);
    for _ in 0..5000 {
        for event in collect(&mut player, MS, &[&mutator.damage(good)]) {
            match event {
                Event::Alive => alive += 1,
                Event::Refused(_) => refused += 1,
                Event::Note(text) => assert!(text.starts_with("the player has ")),
                Event::Sample(_) => panic!("a player tracks nothing"),
            }
        }
    }
    assert!(alive > 500 && refused > 500, "{alive} {refused}");
}
