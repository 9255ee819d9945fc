//! Goal: the glossary of ARCHITECTURE.md is that of the code. Method: read both.

use crate::root;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Rows of the table under this heading, without its head: cells of each.
fn table(heading: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("the architecture");
    let after = text.split_once(heading).unwrap_or_else(|| panic!("no {heading}")).1;
    let lines = after.lines().skip_while(|line| !line.starts_with('|'));
    let rows = lines.take_while(|line| line.starts_with('|')).skip(2);
    rows.map(|row| row.trim_matches('|').split(" | ").map(|cell| cell.trim().to_owned()).collect())
        .collect()
}

fn in_backquotes(cell: &str) -> impl Iterator<Item = &str> {
    cell.split('`').skip(1).step_by(2)
}

/// Text of a file, or of all sources in a folder.
fn text_at(path: &Path) -> String {
    if path.is_file() {
        return std::fs::read_to_string(path).unwrap_or_default();
    }
    let entries = std::fs::read_dir(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let is_source = |path: &PathBuf| path.is_dir() || path.extension().is_some_and(|e| e == "rs");
    paths.filter(is_source).map(|path| text_at(&path)).collect()
}

/// Names of the types that a text declares.
fn types(text: &str) -> BTreeSet<&str> {
    text.lines()
        .filter_map(|line| {
            let line = line.trim_start();
            let line = match line.strip_prefix("pub") {
                Some(rest) if rest.starts_with('(') => rest.split_once(") ")?.1,
                Some(rest) => rest.trim_start(),
                None => line,
            };
            let kinds = ["struct ", "enum ", "trait ", "type "];
            let name = kinds.iter().find_map(|kind| line.strip_prefix(kind))?;
            name.split(|c: char| !c.is_alphanumeric() && c != '_').next()
        })
        .collect()
}

#[test]
fn every_word_stands_where_it_is_defined() {
    let rows = table("## Glossary");
    assert!(rows.len() > 40, "{}", rows.len());
    for row in rows {
        let [words, _, path] = &row[..] else { panic!("{row:?}") };
        let path = path.trim_matches('`');
        let text = text_at(&root().join(path)).to_lowercase().replace(['-', '_'], " ");
        let plain = words.split_once(" (").map_or(words.as_str(), |(word, _)| word);
        for word in plain.split(", ") {
            let word = word.to_lowercase().replace('-', " ");
            let joined = word.replace(' ', "");
            assert!(text.contains(&word) || text.contains(&joined), "{path} says no `{word}`");
        }
    }
}

#[test]
fn every_type_of_a_hand_is_listed_where_it_is() {
    let mut listed = BTreeSet::new();
    for row in table("### Types of hands") {
        let [_, names, _, path] = &row[..] else { panic!("{row:?}") };
        let text = text_at(&root().join(path.trim_matches('`')));
        let declared = types(&text);
        for name in in_backquotes(names) {
            assert!(declared.contains(name), "{path} declares no {name}");
            listed.insert(name.to_owned());
        }
    }
    for entry in std::fs::read_dir(root().join("crates")).expect("the crates") {
        let source = entry.expect("a crate").path().join("src");
        let text = text_at(&source);
        // A handle is no hand, nor is a handshake.
        let others = |name: &str| name.replace("Handle", "").replace("Handshake", "");
        let hands = |name: &&str| others(name).contains("Hand") || *name == "HandHandle";
        for name in types(&text).into_iter().filter(hands) {
            assert!(listed.contains(name), "{}: {name} is in no list", source.display());
        }
    }
}
