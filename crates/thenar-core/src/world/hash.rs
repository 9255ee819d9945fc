//! A hash of the state's bits, at memory speed.
//!
//! Words go to four lanes in turn: `m = (lane ⊕ word) · K`, `lane ← m ⊕ (m >> 32)`, so that one
//! multiplication need not wait for the one before. Each turn is one-to-one in the lane, so a
//! single word that differs always changes the result. Recordings keep this hash: it stays as it
//! is.

use crate::math::Vec3;
use crate::random::GOLDEN as K;

/// Hashes words in order.
#[derive(Clone, Copy, Debug)]
pub struct Hasher {
    lanes: [u64; 4],
    words: u64,
}

impl Default for Hasher {
    fn default() -> Self {
        Self { lanes: [1, 2, 3, 4].map(|k: u64| k.wrapping_mul(K)), words: 0 }
    }
}

fn turn(lane: u64, word: u64) -> u64 {
    let mixed = (lane ^ word).wrapping_mul(K);
    mixed ^ (mixed >> 32)
}

impl Hasher {
    /// Takes in a word.
    pub fn word(&mut self, word: u64) {
        let lane = &mut self.lanes[(self.words % 4) as usize];
        *lane = turn(*lane, word);
        self.words += 1;
    }

    /// Takes in the bits of a number.
    pub fn number(&mut self, x: f64) {
        self.word(x.to_bits());
    }

    /// Takes in vectors: component after component, as [`Hasher::word`] would.
    pub fn vectors(&mut self, vectors: &[Vec3]) {
        let numbers: &[f64] = bytemuck::cast_slice(vectors);
        let ahead = (self.words.wrapping_neg() % 4) as usize;
        let (first, rest) = numbers.split_at(ahead.min(numbers.len()));
        first.iter().for_each(|x| self.number(*x));
        let fours = rest.chunks_exact(4);
        let last = fours.remainder();
        for four in fours {
            for (lane, x) in self.lanes.iter_mut().zip(four) {
                *lane = turn(*lane, x.to_bits());
            }
            self.words += 4;
        }
        last.iter().for_each(|x| self.number(*x));
    }

    /// The hash of all words so far.
    pub fn finish(&self) -> u64 {
        let mut hash = self.words;
        for lane in self.lanes {
            hash = turn(hash, lane);
        }
        hash ^= hash >> 32;
        hash = hash.wrapping_mul(K);
        hash ^ (hash >> 29)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(words: &[u64]) -> u64 {
        let mut hasher = Hasher::default();
        words.iter().for_each(|w| hasher.word(*w));
        hasher.finish()
    }

    #[test]
    fn vectors_hash_as_their_words_at_every_place() {
        let vectors: Vec<Vec3> =
            (0..7).map(|k| Vec3::new(f64::from(k), -0.0, 1.0 / f64::from(k + 1))).collect();
        for before in 0..6_u64 {
            for count in 0..vectors.len() {
                let mut hasher = Hasher::default();
                (0..before).for_each(|w| hasher.word(w));
                hasher.vectors(&vectors[..count]);
                let mut all: Vec<u64> = (0..before).collect();
                all.extend(vectors[..count].iter().flat_map(|v| v.iter().map(|x| x.to_bits())));
                assert_eq!(hasher.finish(), words(&all), "{before} {count}");
            }
        }
    }

    #[test]
    fn every_bit_counts_and_so_do_place_and_number() {
        let base = [3_u64, 1 << 40, 0, 7, 9, u64::MAX];
        let mut seen = std::collections::BTreeSet::from([words(&base)]);
        for place in 0..base.len() {
            for bit in 0..64 {
                let mut other = base;
                other[place] ^= 1 << bit;
                assert!(seen.insert(words(&other)), "{place} {bit}");
            }
        }
        assert!(seen.insert(words(&base[..5])));
        assert!(seen.insert(words(&[0, 3, 1 << 40, 0, 7, 9])));
        assert_ne!(words(&[]), words(&[0]));
    }

    #[test]
    fn it_stays_as_recordings_have_it() {
        // By the definition above, worked out apart.
        assert_eq!(words(&[]), EMPTY);
        assert_eq!(words(&[1, 2, 3, 4, 5]), FIVE);
    }

    const EMPTY: u64 = 0xc5ba_4500_5222_53a3;
    const FIVE: u64 = 0x4399_c065_36b2_379b;
}
