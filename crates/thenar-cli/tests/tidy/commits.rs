//! Subjects of commits, where the tree has a history.

use super::root;
use std::process::Command;

/// Longest subject of a commit, in characters.
const SUBJECT_MAX: usize = 72;
/// Commits of the branch that are looked at, the last ones: what is older stays as it is.
const COMMITS: &str = "50";

/// Subjects of the last commits. A tree without a history, as out of an archive, has none, nor has
/// one without git; a shallow clone has those that it was given.
fn subjects() -> Vec<String> {
    let root = root();
    if !root.join(".git").exists() {
        return Vec::new();
    }
    let log = ["log", "--no-merges", "--max-count", COMMITS, "--format=%h %s"];
    match Command::new("git").arg("-C").arg(root).args(log).output() {
        Ok(output) if output.status.success() => {
            String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect()
        }
        _ => Vec::new(),
    }
}

/// What is wrong with a line of hash and subject, if anything is.
fn fault(line: &str) -> Option<String> {
    let (_, subject) = line.split_once(' ').unwrap_or((line, ""));
    let length = subject.chars().count();
    (length > SUBJECT_MAX).then(|| format!("{length} characters: {line}"))
}

#[test]
fn subjects_of_commits_fit_in_a_line() {
    let wrong: Vec<String> = subjects().iter().filter_map(|line| fault(line)).collect();
    assert!(wrong.is_empty(), "more than {SUBJECT_MAX} characters:\n{}", wrong.join("\n"));
}

#[test]
fn characters_of_a_subject_are_counted_and_not_bytes() {
    let line = |subject: String| fault(&format!("0a1b2c3d {subject}"));
    assert_eq!(line("µ".repeat(SUBJECT_MAX)), None);
    let long = "x".repeat(SUBJECT_MAX + 1);
    assert_eq!(line(long.clone()), Some(format!("73 characters: 0a1b2c3d {long}")));
    assert_eq!(fault("0a1b2c3d"), None);
}
