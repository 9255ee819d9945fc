//! Damages text at random, for tests of parsers.

/// Repeatable damage.
pub struct Mutator(pub u64);

impl Mutator {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % n.max(1)
    }

    /// A copy of `text` with other digits, or with up to four bytes or stretches changed, dropped, doubled or cut.
    pub fn damage(&mut self, text: &[u8]) -> Vec<u8> {
        const SPITE: &[u8] = b"0-e9.,:[]{}\"\n=nNai\xff\x00";
        let mut text = text.to_vec();
        // Half of the copies have other digits only, which often still parse.
        if self.below(2) == 0 {
            for _ in 0..=self.below(4) {
                let at = self.below(text.len());
                if let Some(digit) = text.iter_mut().skip(at).find(|c| c.is_ascii_digit()) {
                    *digit = b'0' + self.below(10) as u8;
                }
            }
            return text;
        }
        for _ in 0..=self.below(4) {
            let (at, length) = (self.below(text.len()), 1 + self.below(30));
            let end = (at + length).min(text.len());
            match self.below(5) {
                0 if at < text.len() => text[at] = SPITE[self.below(SPITE.len())],
                1 => drop(text.drain(at..end)),
                2 => {
                    let copy = text[at..end].to_vec();
                    text.splice(at..at, copy);
                }
                3 => text.truncate(text.len() - self.below(text.len()) / 8),
                _ => text.insert(at, SPITE[self.below(SPITE.len())]),
            }
        }
        text
    }
}
