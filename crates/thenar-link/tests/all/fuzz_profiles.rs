//! Profiles of all devices against damage, from the text to what the device says and does with it:
//! whatever a file says, it is played with, or refused in a line that names it. The same code runs
//! under `cargo fuzz`, see `fuzz/`.

#[path = "../../../../fuzz/src/profiles.rs"]
mod profiles;

use profiles::{DRIVERS, plays};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use thenar_core::random::Random;
use thenar_testing::damaged;

const NUMBERS: [&str; 14] = [
    "0",
    "-1",
    "1",
    "-0.0",
    "1e-300",
    "1e300",
    "nan",
    "inf",
    "9",
    "180.0",
    "4294967296",
    "\"a\"",
    "[]",
    "{}",
];

/// A profile with one to three of its values replaced, or one number of a list.
fn renumbered(text: &str, random: &mut Random) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for _ in 0..1 + random.below(3) {
        let at = random.below(lines.len());
        let Some((key, value)) = lines[at].split_once('=') else { continue };
        let number = NUMBERS[random.below(NUMBERS.len())];
        let mut parts: Vec<&str> = value.split(',').collect();
        lines[at] = match parts.len() {
            1 => format!("{key}= {number}"),
            n => {
                let k = random.below(n);
                let bracket =
                    |c: char| if parts[k].contains(c) { c.to_string() } else { String::new() };
                let part = format!("{}{number}{}", bracket('['), bracket(']'));
                parts[k] = &part;
                format!("{key}={}", parts.join(","))
            }
        };
    }
    lines.join("\n")
}

#[test]
fn damaged_profiles_play_or_are_refused() {
    let name = format!("thenar-fuzz-profile-{}.toml", std::process::id());
    let file: PathBuf = std::env::temp_dir().join(name);
    let mut random = Random::new(0x5eed_0000_0000_0006);
    for (driver, (name, shipped)) in DRIVERS.into_iter().enumerate() {
        plays(driver, b"", &file).unwrap();
        plays(driver, shipped.as_bytes(), &file).unwrap();
        let mut played = 0;
        for round in 0..400 {
            let text = match round % 4 {
                0 => damaged(shipped.as_bytes(), DRIVERS[0].1.as_bytes(), &mut random),
                _ => renumbered(shipped, &mut random).into_bytes(),
            };
            match catch_unwind(AssertUnwindSafe(|| plays(driver, &text, &file))) {
                Err(_) => panic!("{name}: a panic by:\n{}", String::from_utf8_lossy(&text)),
                Ok(Ok(())) => played += 1,
                Ok(Err(error)) => {
                    let told = error.to_string();
                    assert!(told.contains(&*file.to_string_lossy()), "{name}: {told}");
                    assert!(told.len() < 2500 && !told.contains('\n'), "{name}: {told}");
                }
            }
        }
        assert!(played > 40, "{name}: {played}");
    }
    std::fs::remove_file(&file).unwrap();
}
