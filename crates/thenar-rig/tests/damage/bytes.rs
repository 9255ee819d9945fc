//! Damage to bytes, in a seeded sequence.

/// Numbers in a seeded sequence (xorshift, Marsaglia 2003).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

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

/// One to four kinds of damage.
pub fn damaged(seed: &[u8], other: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = seed.to_vec();
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
