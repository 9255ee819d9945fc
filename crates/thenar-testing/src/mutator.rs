//! Text and bytes damaged at random, for tests of what reads them.

use thenar_core::random::Random;

/// Repeatable damage, from a seed on.
#[derive(Clone, Debug)]
pub struct Mutator(Random);

impl Mutator {
    /// The damage of a seed.
    pub fn new(seed: u64) -> Self {
        Self(Random::new(seed))
    }

    /// A number below `n`; 0 if `n` is 0.
    pub fn below(&mut self, n: usize) -> usize {
        self.0.below(n)
    }

    /// A copy with other digits, or with bytes or stretches changed, dropped, doubled or cut.
    pub fn damage(&mut self, bytes: &[u8]) -> Vec<u8> {
        const SPITE: &[u8] = b"0-e9.,:|=[]{}\"\n\r nNai\xff\x00\x7f\x80";
        let mut bytes = bytes.to_vec();
        if self.below(2) == 0 {
            for _ in 0..=self.below(4) {
                let at = self.below(bytes.len());
                if let Some(digit) = bytes.iter_mut().skip(at).find(|c| c.is_ascii_digit()) {
                    *digit = b'0' + self.below(10) as u8;
                }
            }
            return bytes;
        }
        for _ in 0..=self.below(4) {
            let (at, length) = (self.below(bytes.len()), 1 + self.below(30));
            let end = (at + length).min(bytes.len());
            match self.below(6) {
                0 if at < bytes.len() => bytes[at] = SPITE[self.below(SPITE.len())],
                1 => drop(bytes.drain(at..end)),
                2 => {
                    let copy = bytes[at..end].to_vec();
                    bytes.splice(at..at, copy);
                }
                3 => bytes.truncate(bytes.len() - self.below(bytes.len()) / 8),
                4 if at < bytes.len() => bytes[at] ^= 1 << self.below(8),
                _ => bytes.insert(at.min(bytes.len()), SPITE[self.below(SPITE.len())]),
            }
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::Mutator;
    use std::cmp::Ordering;

    #[test]
    fn damage_is_repeatable_and_takes_many_forms() {
        let good = b"{\"time\": 1.25, \"wrist\": [0.1, 0.2, 0.3]}";
        let copies = |seed: u64| -> Vec<_> {
            let mut mutator = Mutator::new(seed);
            (0..500).map(|_| mutator.damage(good)).collect()
        };
        let some = copies(1);
        assert_eq!(some, copies(1));
        assert_ne!(some, copies(2));
        let is_other = |copy: &&Vec<u8>| copy[..] != good[..];
        assert!(some.iter().filter(is_other).count() > 400);
        let [longer, shorter] = [Ordering::Greater, Ordering::Less]
            .map(|wanted| some.iter().filter(|copy| copy.len().cmp(&good.len()) == wanted).count());
        assert!(longer > 20 && shorter > 20, "{longer} {shorter}");
        assert_eq!(Mutator::new(1).damage(b"").len(), 0);
    }
}
