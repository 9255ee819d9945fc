//! Recordings against damage that mends its checksums, from the bytes to the replayed steps:
//! whatever they say, they are replayed, or refused with a message. The same code runs under
//! `cargo fuzz`, see `fuzz/`.

use crate::recordings::{replays, seeds};
use std::panic::{AssertUnwindSafe, catch_unwind};
use thenar_core::random::Random;
use thenar_testing::damaged;

/// Numbers that fields may be replaced by, as bytes.
const WORDS: [u64; 9] = [
    0,
    1,
    u64::MAX,
    1 << 63,
    0x7ff8_0000_0000_0000,
    0x7ff0_0000_0000_0000,
    0x3ff0_0000_0000_0000,
    0x7fef_ffff_ffff_ffff,
    1_000_000_000,
];

/// A frame left as long as it was, with some of its bytes replaced.
fn overwritten(seed: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..1 + random.below(3) {
        let at = random.below(bytes.len() - 8);
        let word = WORDS[random.below(WORDS.len())].to_le_bytes();
        let n = [1, 4, 8][random.below(3)];
        bytes[at..at + n].copy_from_slice(&word[8 - n..]);
    }
    bytes
}

#[test]
fn tampered_recordings_are_replayed_or_refused() {
    let folder = std::env::temp_dir().join(format!("thenar-fuzz-rec-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (seeds, file) = (seeds(&folder), folder.join("tampered.rec"));
    let mut random = Random::new(0x5eed_0000_0000_0007);
    for (i, seed) in seeds.iter().enumerate() {
        assert_eq!(replays(seed, &file).unwrap(), [8, 10][i], "seed {i}");
        let mut stepped = 0;
        for round in 0..250 {
            let bytes = match round % 3 {
                0 => damaged(seed, &seeds[1 - i], &mut random),
                _ => overwritten(seed, &mut random),
            };
            match catch_unwind(AssertUnwindSafe(|| replays(&bytes, &file))) {
                Err(_) => {
                    let kept = std::env::temp_dir().join("thenar-fuzz-recording");
                    let kept = std::fs::write(&kept, &bytes).map(|()| kept);
                    panic!("seed {i}, round {round} panics; the input is in {kept:?}");
                }
                Ok(Ok(steps)) => stepped += usize::from(steps > 0),
                Ok(Err(error)) => {
                    let told = error.to_string();
                    assert!(!told.is_empty() && told.len() < 3000, "{told}");
                }
            }
        }
        assert!(stepped > 60, "seed {i}: {stepped}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
