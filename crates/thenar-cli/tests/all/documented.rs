//! Goal: the commands that the documents write out are ones that the program takes. Method: all
//! without placeholders are given to it, with `--help` at the end: a name or an option that does
//! not exist is refused before that.

use crate::stage::{Folder, err, out};
use std::path::{Path, PathBuf};

fn documents() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let pages = std::fs::read_dir(root.join("docs")).expect("the documents");
    let mut found: Vec<_> = pages.flatten().map(|entry| entry.path()).collect();
    found.retain(|path| path.extension().is_some_and(|ending| ending == "md"));
    found.push(root.join("README.md"));
    found.sort();
    found
}

/// Commands of a page: lines of code, and words in backquotes without a placeholder.
fn commands(text: &str) -> Vec<String> {
    let joined = text.replace("\\\n", " ");
    let mut found = Vec::new();
    for line in joined.lines() {
        found.push(line.trim());
        let spans = line.split('`').skip(1).step_by(2);
        found.extend(spans.filter(|span| !span.contains(|c: char| c.is_uppercase() || c == '…')));
    }
    let named = found.into_iter().filter_map(|words| {
        let words = words.strip_prefix("target/release/").unwrap_or(words);
        let words = words.strip_prefix("thenar ")?;
        // Without what it prints into, and without the comment.
        let end = [" #", " > "].iter().filter_map(|mark| words.find(mark)).min();
        let words = words[..end.unwrap_or(words.len())].trim();
        words.starts_with(|c: char| c.is_lowercase()).then(|| words.to_owned())
    });
    named.collect()
}

/// Words of a command, as a shell parts them: quotes keep spaces.
fn words(command: &str) -> Vec<String> {
    let mut found = vec![String::new()];
    let mut is_quoted = false;
    for c in command.chars() {
        match c {
            '"' => is_quoted = !is_quoted,
            ' ' if !is_quoted => found.push(String::new()),
            _ => found.last_mut().expect("a word").push(c),
        }
    }
    found.retain(|word| !word.is_empty());
    found
}

#[test]
fn commands_are_read_as_a_shell_does() {
    let text = "text `thenar run x` and `thenar run FILE`\n\n    thenar serve \"a b\" \\\n  --lan   # so\n";
    assert_eq!(commands(text), ["run x", "serve \"a b\"    --lan"]);
    assert_eq!(words("serve \"a b\"  --lan"), ["serve", "a b", "--lan"]);
}

#[test]
fn every_documented_command_exists() {
    let folder = Folder::new("documented");
    let (mut wrong, mut count) = (Vec::new(), 0);
    for path in documents() {
        let text = std::fs::read_to_string(&path).expect("a page");
        for command in commands(&text) {
            let mut words = words(&command);
            words.push("--help".into());
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            let output = folder.thenar(&words);
            count += 1;
            // Sentences name options without their values.
            let is_known =
                out(&output).contains("Usage:") || err(&output).contains("a value is required for");
            if !is_known {
                wrong.push(format!("{}: thenar {command}\n{}", path.display(), err(&output)));
            }
        }
    }
    assert!(count > 60, "{count} commands");
    assert!(wrong.is_empty(), "{} of {count} are refused:\n{}", wrong.len(), wrong.join("\n"));
}
