//! Marks that a merge leaves where two sides differ.

use super::{files, root};

/// Endings of what people write here.
const WRITTEN: [&str; 12] =
    ["md", "rs", "toml", "ts", "css", "html", "py", "pyi", "json", "yml", "c", "cs"];

/// Whether a line is one of the marks around the two sides.
fn is_mark(line: &str) -> bool {
    ["<<<<<<< ", ">>>>>>> ", "||||||| "].iter().any(|mark| line.starts_with(mark))
}

#[test]
fn no_merge_is_left_half_done() {
    assert!(is_mark("<<<<<<< HEAD") && is_mark(">>>>>>> theirs") && !is_mark("======="));
    let mut read = 0;
    for file in WRITTEN.iter().flat_map(|ending| files("", &format!(".{ending}"))) {
        let bytes = std::fs::read(root().join(&file)).unwrap_or_else(|e| panic!("{file}: {e}"));
        for (i, line) in String::from_utf8_lossy(&bytes).lines().enumerate() {
            assert!(!is_mark(line), "{file}:{}: {line}", i + 1);
        }
        read += 1;
    }
    assert!(read > 1000, "{read} files");
}
