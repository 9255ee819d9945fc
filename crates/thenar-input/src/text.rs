//! Quoting of what a user wrote.

/// Characters of a word or a line that a message repeats.
const WORD_MAX: usize = 80;
/// Characters that a message keeps of its beginning, and of its end.
const HEAD: usize = 600;
const TAIL: usize = 400;

/// A word in quotation marks, for a message: control characters escaped; of a long one the
/// beginning, and how long it is.
pub fn quoted(word: &str) -> String {
    match word.char_indices().nth(WORD_MAX) {
        None => format!("{word:?}"),
        Some((end, _)) => format!("{:?}… ({} bytes)", &word[..end], word.len()),
    }
}

/// A text in which nothing acts on a terminal or hides: line breaks, control characters and those
/// that turn the direction of writing are escaped as in [`quoted`]; quotation marks and backslashes
/// stay.
pub fn visible(text: &str) -> String {
    let kept = ['"', '\'', '\\'];
    let mut shown = String::with_capacity(text.len());
    for piece in text.split_inclusive(kept) {
        let body = piece.trim_end_matches(kept);
        shown.extend(body.escape_debug());
        shown.push_str(&piece[body.len()..]);
    }
    shown
}

/// A message on one line of [`visible`] characters, with its middle left out if it is long: the
/// beginning names the file and the place, the end the cause.
pub fn brief(message: &str) -> String {
    let message = &visible(message);
    let Some((head, _)) = message.char_indices().nth(HEAD + TAIL) else { return message.into() };
    let head = message[..head].char_indices().nth(HEAD).map_or(0, |(at, _)| at);
    let tail = message.char_indices().rev().nth(TAIL - 1).map_or(head, |(at, _)| at);
    format!("{} … ({} bytes left out) … {}", &message[..head], tail - head, &message[tail..])
}

/// Small and large numbers in powers of ten, others as they are.
pub fn plain(x: f64) -> String {
    if x.is_finite() && x != 0.0 && !(1e-3..1e5).contains(&x.abs()) {
        format!("{x:e}")
    } else {
        format!("{x}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_text_is_quoted_whole() {
        assert_eq!(quoted("1e\n5"), "\"1e\\n5\"");
        assert_eq!(quoted(&"x".repeat(80)).len(), 82);
        assert_eq!(brief("mesh.obj: line 3"), "mesh.obj: line 3");
        let whole = "é".repeat(1000);
        assert_eq!(brief(&whole), whole);
    }

    #[test]
    fn nothing_acts_on_a_terminal() {
        // A colour, a second line, a text that reads backwards, a bell, a byte order mark.
        let hostile = "a=\u{1b}[31mé\r\nerror: \u{202e}cod\u{7}\u{feff}";
        let shown = "a=\\u{1b}[31mé\\r\\nerror: \\u{202e}cod\\u{7}\\u{feff}";
        assert_eq!(visible(hostile), shown);
        assert_eq!(brief(hostile), shown);
        // An accent of its own is part of a name.
        let plain = "C:\\a \"b\" 'c' \\\\ x` 日本 e\u{301}";
        assert_eq!(visible(plain), plain);
        // What is escaped stays as it is.
        assert_eq!(visible(shown), shown);
    }

    #[test]
    fn long_text_keeps_its_ends() {
        assert!(quoted(&"é".repeat(5_000_000)).ends_with("é\"… (10000000 bytes)"));
        assert!(quoted(&"\u{1}".repeat(5_000_000)).len() < 500);
        let message = format!("{}{}{}", "a".repeat(600), "é".repeat(70), "z".repeat(400));
        let short = brief(&message);
        assert_eq!(
            short,
            format!("{} … (140 bytes left out) … {}", "a".repeat(600), "z".repeat(400))
        );
    }
}
