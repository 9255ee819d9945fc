//! Scenes and motions against damage, from the text to the simulated step: whatever it says, it
//! runs, or is refused with a message. The same code runs under `cargo fuzz`, see `fuzz/`.

use crate::scenes;
use std::panic::{AssertUnwindSafe, catch_unwind};
use thenar_core::model::{HandModel, Side};
use thenar_core::random::Random;
use thenar_testing::damaged;

/// Small scenes with most of what a scene can hold.
const SCENES: [&str; 4] = [
    include_str!("../../../scenes/falling-box.toml"),
    include_str!("../../../scenes/finger-pendulum.toml"),
    include_str!("../../../../thenar-cli/scenes/validation/b01-patch.toml"),
    r#"version = 1
duration = 0.01
time_step = 0.002
[[rigid]]
name = "table"
motion = "fixed"
shape = { kind = "plane" }
[[rigid]]
name = "thing"
mass = 0.1
position = [0, 0.02, 0]
shape = { kind = "compound", parts = [{ shape = { kind = "sphere", radius = 0.02 } }] }
[[soft]]
name = "cube"
position = [0, 0.08, 0]
self_contact = true
shape = { kind = "lattice", size = [0.04, 0.04, 0.04], cells = [2, 2, 2], jitter = 0.1 }
fixed = [{ nodes = { side = "y-max" }, axes = "xz" }]
[[soft]]
name = "ball"
position = [0.1, 0.02, 0]
shape = { kind = "ball", radius = 0.02, frequency = 2, layers = 2 }
[[load]]
kind = "force"
body = "thing"
force = [0, -1, 0]
"#,
];

/// Replacements for the numbers of a scene.
const NUMBERS: [&str; 12] =
    ["0", "-1", "1", "1e-300", "1e300", "1e-9", "1e9", "4294967295", "0.5", "100", "nan", "inf"];

/// A scene with some of its numbers replaced.
fn renumbered(text: &str, random: &mut Random) -> String {
    let digit = |i: usize| text.as_bytes()[i].is_ascii_digit();
    let starts: Vec<usize> = (1..text.len())
        .filter(|&i| digit(i) && b" [=-".contains(&text.as_bytes()[i - 1]))
        .collect();
    let mut out = text.to_owned();
    let mut places: Vec<usize> =
        (0..1 + random.below(3)).map(|_| random.below(starts.len())).collect();
    places.sort_unstable();
    places.dedup();
    for &place in places.iter().rev() {
        let start = starts[place];
        let number = |c: u8| c.is_ascii_alphanumeric() || b".-+_".contains(&c);
        let length = text.as_bytes()[start..].iter().take_while(|&&c| number(c)).count();
        out.replace_range(start..start + length, NUMBERS[random.below(NUMBERS.len())]);
    }
    out
}

fn endures<T, E: ToString>(text: &str, run: impl FnOnce(&str) -> Result<T, E>) -> bool {
    match catch_unwind(AssertUnwindSafe(|| run(text).map_err(|e| e.to_string()))) {
        Err(_) => panic!("a panic by:\n{text}"),
        Ok(Err(message)) => {
            assert!(!message.trim().is_empty() && message.len() < 3000, "{message}");
            false
        }
        Ok(Ok(_)) => true,
    }
}

#[test]
fn damaged_scenes_endure() {
    let mut random = Random::new(0x5eed_0000_0000_0004);
    for (i, scene) in SCENES.iter().enumerate() {
        assert!(scenes::steps(scene).unwrap(), "scene {i} steps");
        let mut stepped = 0;
        for round in 0..150 {
            let text = match round % 3 {
                0 => {
                    let other = SCENES[(i + 1) % SCENES.len()].as_bytes();
                    let bytes = damaged(scene.as_bytes(), other, &mut random);
                    String::from_utf8_lossy(&bytes).into_owned()
                }
                _ => renumbered(scene, &mut random),
            };
            stepped += usize::from(endures(&text, scenes::steps));
        }
        assert!(stepped > 8, "{stepped} of scene {i}");
    }
}

fn hand() -> HandModel {
    thenar_rig::uniform_hand(Side::Right, 600).unwrap()
}

const KEYFRAMES: &str = r#"limits = "clamp"
[[key]]
time = 0
pose = "open"
wrist = { position = [0, 0.1, 0], fingers = [0, 0, -1], back = [0, 1, 0] }
[[key]]
time = 0.5
pose = "fist"
curl = { index = 0.2 }
[[key]]
time = 1
joints = { index-mcp = { flexion_deg = 30, spread_deg = 5 } }
"#;

#[test]
fn damaged_motions_endure() {
    let mut random = Random::new(0x5eed_0000_0000_0005);
    let hand = hand();
    for _ in 0..400 {
        let text = renumbered(KEYFRAMES, &mut random);
        endures(&text, |text| scenes::keyframes(text, &hand));
        let bytes = damaged(KEYFRAMES.as_bytes(), KEYFRAMES.as_bytes(), &mut random);
        let text = String::from_utf8_lossy(&bytes);
        endures(&text, |text| scenes::keyframes(text, &hand));
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../thenar-link/tests/data/hands.jsonl");
    let whole = std::fs::read_to_string(path).unwrap();
    let part: String = whole.split_inclusive('\n').take(12).collect();
    let (mut moved, read) = (0, |text: &str| scenes::recorded(text.as_bytes(), &hand));
    for round in 0..300 {
        let text = match round % 2 {
            0 => renumbered(&part, &mut random),
            _ => {
                let bytes = damaged(part.as_bytes(), part.as_bytes(), &mut random);
                String::from_utf8_lossy(&bytes).into_owned()
            }
        };
        moved += usize::from(endures(&text, read));
    }
    assert!(moved > 10, "{moved}");
}

/// A radius is no hand's, or there are too few: told with the line.
#[test]
fn radii_of_recorded_motions_are_looked_at() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../thenar-link/tests/data/hands.jsonl");
    let whole = std::fs::read_to_string(path).unwrap();
    let head: String = whole.split_inclusive('\n').take(2).collect();
    let hand = hand();
    let with = |radius: &str| {
        let line = head.trim_end().strip_suffix('}').unwrap();
        let line = line.split(",\"radius\"").next().unwrap();
        assert!(line.contains("\"quat\":[[") && !line.ends_with("radius"));
        format!("{line},\"radius\":{radius}}}\n")
    };
    let error =
        |radius: &str| scenes::recorded(with(radius).as_bytes(), &hand).unwrap_err().to_string();
    let one = |x: &str| format!("[{}{x}]", "0.01,".repeat(24));
    assert!(error("[0.01]").contains("fuzz.jsonl:2: radius has 1 entries, expected 25"));
    for odd in ["-0.1", "0.6", "1e300"] {
        assert!(error(&one(odd)).contains("m, expected 0 to 0.5"), "{}", error(&one(odd)));
    }
    let fine = scenes::recorded(with(&one("0.5")).as_bytes(), &hand);
    assert!(fine.is_ok() || !fine.as_ref().unwrap_err().to_string().contains("radius"), "{fine:?}");
}
