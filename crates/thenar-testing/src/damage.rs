//! Damage to the bytes of a file, of whatever kind.

use thenar_core::random::Random;

const EXTREME_WORDS: [&[u8]; 10] = [
    b"-1",
    b"0",
    b"1e999",
    b"nan",
    b"inf",
    b"4294967295",
    b"-9223372036854775808",
    b"1e-320",
    b"99999999999999999999",
    b"",
];
const EXTREME_NUMBERS: [u32; 8] =
    [0, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 0x7fc0_0000, 0x7f80_0000, 0x00ff_ffff];

/// A copy with one to four kinds of damage: cut, spliced with itself or `other`, or with numbers
/// and words in it that are extreme.
pub fn damaged(good: &[u8], other: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for _ in 0..1 + random.below(4) {
        let (n, at) = (bytes.len(), random.below(bytes.len()));
        match random.below(7) {
            0 => bytes.truncate(at),
            1 if n > 0 => bytes[at] ^= 1 << random.below(8),
            2 if n > 4 => {
                let at = at.min(n - 4) & !3;
                let number = EXTREME_NUMBERS[random.below(EXTREME_NUMBERS.len())];
                bytes[at..at + 4].copy_from_slice(&number.to_le_bytes());
            }
            3 => {
                let word = EXTREME_WORDS[random.below(EXTREME_WORDS.len())];
                let end = (at + random.below(6)).min(n);
                bytes.splice(at..end, word.iter().copied());
            }
            4 => {
                let end = (at + random.below(200)).min(n);
                let part = bytes[at..end].to_vec();
                bytes.splice(at..at, part);
            }
            5 => {
                let end = (at + random.below(200)).min(n);
                bytes.drain(at..end);
            }
            _ => {
                let from = random.below(other.len());
                let end = (from + random.below(200)).min(other.len());
                bytes.splice(at..at, other[from..end].iter().copied());
            }
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damage_is_repeatable_and_takes_from_both_files() {
        let (good, other) = (b"v 1 2 3\nf 1 2 3\n", b"solid thing\nendsolid thing\n");
        let copies = |seed: u64| -> Vec<_> {
            let mut random = Random::new(seed);
            (0..500).map(|_| damaged(good, other, &mut random)).collect()
        };
        let some = copies(1);
        assert_eq!(some, copies(1));
        assert_ne!(some, copies(2));
        let with =
            |part: &[u8]| some.iter().filter(|c| c.windows(part.len()).any(|w| w == part)).count();
        assert!(with(b"solid") > 20 && with(b"1e999") > 5, "{} {}", with(b"solid"), with(b"1e999"));
        assert!(some.iter().filter(|copy| copy.len() < good.len()).count() > 20);
    }
}
