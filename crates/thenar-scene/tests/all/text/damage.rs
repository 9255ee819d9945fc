//! Goal: no damaged scene makes the reader panic. Method: valid scenes are cut, spliced and
//! sprinkled with hostile values at random (the seed is printed); whatever is still accepted must
//! step to finite numbers or say that it did not.

use std::path::Path;
use thenar_scene::session::{Random, Session, builtins};

const HOSTILE: [&str; 22] = [
    "nan",
    "inf",
    "-inf",
    "-1",
    "0",
    "1e308",
    "1e-320",
    "9223372036854775807",
    "\"\"",
    "\"*\"",
    "[]",
    "[[]]",
    "{}",
    "true",
    "1979-05-27",
    "\"\u{0}\"",
    "[1, 2, 3]",
    "\"palm\"",
    "=",
    "\n[[joint]]\n",
    "[",
    "]]",
];

fn damaged(text: &str, random: &mut Random) -> String {
    let mut lines: Vec<String> = text.lines().map(String::from).collect();
    for _ in 0..=random.below(3) {
        let i = random.below(lines.len());
        match random.below(6) {
            0 => {
                lines.remove(i);
            }
            1 => {
                let j = random.below(lines.len());
                lines.swap(i, j);
            }
            2 => lines.insert(i, lines[i].clone()),
            3 => {
                let cut = random.below(lines[i].chars().count() + 1);
                lines[i] = lines[i].chars().take(cut).collect();
            }
            _ => {
                let value = HOSTILE[random.below(HOSTILE.len())];
                if let Some((key, _)) = lines[i].clone().split_once('=') {
                    lines[i] = format!("{key}= {value}");
                }
            }
        }
        if lines.is_empty() {
            break;
        }
    }
    lines.join("\n")
}

#[test]
fn damaged_scenes_are_refused_or_run() {
    let seed = 20_261_121;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let (mut refused, mut ran) = (0, 0);
    for round in 0..1500 {
        let scenes: Vec<_> = builtins()
            .iter()
            .filter(|s| !["[[hand]]", "[[figure]]"].iter().any(|body| s.text.contains(body)))
            .collect();
        let text = damaged(scenes[round % scenes.len()].text, &mut random);
        match Session::from_text(&text, Path::new("damaged.toml"), &[]) {
            Err(error) => {
                assert!(!error.to_string().is_empty());
                refused += 1;
            }
            Ok(mut session) if session.world().state().x.len() < 2000 => {
                let report = session.step(&mut ());
                let finite = session.world().state().x.iter().all(|x| x.norm().is_finite());
                assert!(finite, "{report:?}\n{text}");
                ran += 1;
            }
            Ok(_) => ran += 1,
        }
    }
    assert!(refused > 300 && ran > 100, "{refused} refused, {ran} ran");
}
