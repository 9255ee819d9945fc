//! "Did you mean ...?"

/// Characters of a word that are compared: time grows by the product of two words' lengths.
const CHARACTERS_MAX: usize = 64;

/// The candidate most like `word`, when one is near enough to be a slip.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = (word.chars().count() / 3).clamp(1, 4);
    known
        .into_iter()
        .map(|k| (edits(word, k), k))
        .filter(|(d, _)| *d <= limit)
        .min_by_key(|(d, _)| *d)
        .map(|(_, k)| k)
}

/// Levenshtein distance, in characters, of at most the first [`CHARACTERS_MAX`].
fn edits(a: &str, b: &str) -> usize {
    let head = |text: &str| text.chars().take(CHARACTERS_MAX).collect::<String>();
    strsim::levenshtein(&head(a), &head(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_slips_but_not_strangers() {
        let known = ["mass", "friction", "density"];
        assert_eq!(nearest("mas", known), Some("mass"));
        assert_eq!(nearest("frction", known), Some("friction"));
        assert_eq!(nearest("colour", known), None);
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(edits("", "abc"), 3);
        // Letters, not bytes; of long words the beginning.
        assert_eq!(edits("größe", "grösse"), 2);
        assert_eq!(edits(&"x".repeat(100_000), &"x".repeat(64)), 0);
    }
}
